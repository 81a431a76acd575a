"""A brain whose best parameters are known, and studies of it: what tuning is tried on.

Its estimate is f = 1/2 drawn towards, or away from, by `weight`: 1/2 + weight (n / t - 1/2), plus a bias that is 0 at
a = 0.6 and pair = (0.25, 0.5), plus `noise` times a uniform number in [-1/2, 1/2), which `shift` makes another one.
All tests share one source, so as to compile once.
"""

from pathlib import Path

import swarmcensus as sc

SOURCE = '''"""What tuning is tried on."""

import math

PARAMETERS = {"weight": 0.0, "a": 0.6, "pair": (0.25, 0.5), "noise": 0.0, "shift": 0.0, "idle": 1.0, "many": 3.0}
MEMORY = {"t": 0.0, "n": 0.0, "z": 0.0}
MESSAGE = ("n",)

def observe(me, blacks, looks):
    me.t += looks
    me.n += blacks
    me.z = me.luck * (1.0 + 999.0 * me.shift) % 1.0

def broadcast(me):
    return (me.n,)

def receive(me, message):
    pass

def fuse(me):
    if me.many > 90.0:
        me.n = 1.0 / (me.many - me.many)

def estimate(me):
    off = (me.a - 0.6) * (me.a - 0.6)
    off += (me.pair[0] - 0.25) * (me.pair[0] - 0.25) + (me.pair[1] - 0.5) * (me.pair[1] - 0.5)
    off += 0.01 * (me.many - 3.0) * (me.many - 3.0)
    if me.t > 0.0:
        off += me.weight * (me.n / me.t - 0.5)
    off += me.noise * (me.z - 0.5)
    if abs(off) > 0.4:  # far off, it nears 0 or 1
        off = math.copysign(0.5 - 0.04 / abs(off), off)
    return 0.5 + off
'''
STUDY = """
name = "tunable"
seed = {seed}
trials = {trials}
swarm.brain = [{{file = "tunable.py", {given}}}{others}]
swarm.robots = {robots}
swarm.accuracy = {accuracy}
world = {{topology = "ring", fill_ratio = {fill}}}
schedule = {{rounds = {rounds}, observations_per_round = {looks}}}
"""


def text_of(given, seed=1, trials=20, robots=5, accuracy=1.0, fill=0.5, rounds=1, looks=1, others=""):
    return STUDY.format(
        given=given, seed=seed, trials=trials, robots=robots, accuracy=accuracy, fill=fill, rounds=rounds, looks=looks,
        others=others,
    )  # fmt: skip


def study_of(folder, given, **other):
    (Path(folder) / "tunable.py").write_text(SOURCE)
    return sc.Study.parse(text_of(given, **other), context={"base": Path(folder)})
