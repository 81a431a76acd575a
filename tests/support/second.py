"""Brains that use the contract's optional functions, and small swarms of them."""

from pathlib import Path

import numpy as np

from swarmcensus import brains
from tests.support.small import moving_of, settings_of

ALL = '''"""All of it at once: parameters, vectors, luck, silence, decisions, an end, an interval, a name."""

PARAMETERS = {"weights": (0.2, 0.3, 0.5), "step": 0.08, "enough": 6.0}
OPTIONS = 3
MEMORY = {
    "t": 0.0,
    "n": 0.0,
    "x": 0.5,
    "said": 0.5,
    "heard": 0.0,
    "kept": 0.5,
    "teller": -1.0,
    "tally": (0.0, 0.0, 0.25),
}
MESSAGE = {"who": 0.0, "x": 0.0, "tally": (0.0, 0.0, 0.0)}

def observe(me, blacks, looks):
    me.t += looks
    me.n += blacks
    me.tally[int(3.0 * me.luck)] += looks

def news(me):
    return abs(me.x - me.said) > me.step

def broadcast(me):
    if news(me):
        return me.name, me.x, me.tally
    return None

def receive(me, message):
    me.heard += 1.0
    if me.luck * me.heard < 1.0:
        me.teller, me.kept = message[0], message[1]
    for k in range(3):
        me.tally[k] += 0.125 * message[2][k]

def fuse(me):
    if news(me):
        me.said = me.x
    seen = me.n / me.t if me.t > 0.0 else 0.5
    me.x = me.weights[0] * me.luck + me.weights[1] * me.kept + me.weights[2] * seen
    me.heard = 0.0
    for k in range(len(me.tally)):
        me.tally[k] *= 0.5

def decide(me):
    if me.t < me.enough:
        return -1
    best = 0
    for k in range(1, 3):
        if me.tally[k] > me.tally[best]:
            best = k
    return best

def done(me):
    return me.t >= 2.0 * me.enough and me.x > 0.45

def interval(me):
    half = me.step + 1.0 / (2.0 + me.t)
    return max(0.0, me.x - half), min(1.0, me.x + half)

def estimate(me):
    return me.x
'''
ADDS = '''"""What it hears it only adds up: with parameters, vectors, luck and silence."""

PARAMETERS = {"weight": 0.5, "weights": (1.0, 0.25)}
MEMORY = {"t": 0.0, "n": 0.0, "x": 0.5, "mood": 0.0, "heard": 0.0, "pile": (0.0, 0.0)}
MESSAGE = ("x", "t")
SUMS = ("heard", "pile")

def observe(me, blacks, looks):
    me.t += looks
    me.n += blacks
    me.mood = me.luck

def broadcast(me):
    return None if me.mood > 0.6 else (me.x, me.t)

def receive(me, message):
    me.heard += 1.0
    for k in range(2):
        me.pile[k] += me.weights[k] * message[0]

def fuse(me):
    own = me.n / me.t if me.t > 0.0 else 0.5
    talk = (me.pile[0] + me.pile[1]) / (1.25 * me.heard) if me.heard > 0.0 else me.luck
    me.x = me.weight * own + (1.0 - me.weight) * talk
    me.mood = 0.5 * (me.mood + me.luck)
    me.heard = 0.0
    for k in range(2):
        me.pile[k] = 0.0

def decide(me):
    return -1 if me.t < 4.0 else 0 if me.x < 0.5 else 1

def done(me):
    return me.t > 9.0

def interval(me):
    return (0, 1) if me.t < 2.0 else (0.5 * me.x, min(1.0, me.x + 0.125))

def estimate(me):
    return me.x
'''
TALKS = '''"""Says what ALL says, and is otherwise another."""

OPTIONS = 3
MEMORY = {"t": 0.0, "tally": (0.5, 0.25), "x": 0.25}
MESSAGE = {"who": 0.0, "x": 0.0, "tally": (0.0, 0.0, 0.0)}

def observe(me, blacks, looks):
    me.t += looks
    me.tally[0] = blacks / looks

def broadcast(me):
    return me.t, me.x, (me.tally[0], 0.0, 1.0)

def receive(me, message):
    me.x += 0.25 * (message[1] - me.x)

def fuse(me):
    me.tally[1] += me.tally[0]

def decide(me):
    return 2.0

def estimate(me):
    return me.x
'''
STEER = """

def steer(me):
    if me.luck < 0.2:
        return None
    return 0.1 * me.luck, 2.0 * me.luck - 1.0
"""
MEANS = '''"""The mean of its own readings, and it tells it."""

MEMORY = {"t": 0.0, "n": 0.0}
MESSAGE = ("x",)


def observe(me, blacks, looks):
    me.t += looks
    me.n += blacks


def broadcast(me):
    return (estimate(me),)


def receive(me, message):
    pass


def fuse(me):
    pass


def estimate(me):
    return me.n / me.t if me.t > 0.0 else 0.5
'''  # the first edition: to be changed by tests
WALD = (
    MEANS.replace("MEMORY", 'import math\n\nPARAMETERS = {"z": 1.96, "enough": 0.0}\nMEMORY', 1)
    + '''

def interval(me):
    """Of its own readings, as Wald, and as Agresti and Coull for few of them; then through b and w."""
    if me.t == 0.0:
        return 0, 1
    q = (me.n + 2.0) / (me.t + 4.0)
    half = me.z * math.sqrt(q * (1.0 - q) / (me.t + 4.0))
    low = min(max((q - half + me.w - 1.0) / (me.b + me.w - 1.0), 0.0), 1.0)
    return low, min(max((q + half + me.w - 1.0) / (me.b + me.w - 1.0), 0.0), 1.0)


def done(me):
    low, high = interval(me)
    return high - low < me.enough
'''
)
SAYS = (
    MEANS.replace("MEMORY", 'PARAMETERS = {"low": 0.0, "high": 1.0, "big": 0.0, "since": 0.0}\nMEMORY', 1)
    + '''

def interval(me):
    """What it is told to say, from some reading on; NaN where it is told something big."""
    return (me.low + (me.big * me.big - me.big * me.big), me.high) if me.t >= me.since else (0.0, 1.0)
'''
)


def brain(source, name="brain.py"):
    """A brain of this source."""
    return brains.parse(source, name, Path(name))


def changed(*changes, source=MEANS):
    """The source with these changes; what is to be changed is there."""
    for old, new in changes:
        assert old in source, old
        source = source.replace(old, new)
    return source


def fixed(used, members=(), **given):
    """A study's settings on fixed networks, of 3 trials with the seed of `small`."""
    return settings_of(brain=used, members=members, **given)


def moving(used, members=(), ticks=25, **given):
    """The one setting of a study of robots that move."""
    return moving_of(brain=used, members=members, ticks=ticks, **given)


def agreed(decisions):
    """The first option that all robots agree on, and the round; -1 and infinity where they never do (round, robot)."""
    for k, row in enumerate(decisions, start=1):
        if len(set(row)) == 1 and row[0] >= 0:
            return row[0], k
    return -1.0, np.inf


def first(values, holds):
    """The round, from 1 on, of the first value that holds (round, robot), for each robot."""
    found = np.array([[holds(one) for one in row] for row in values])
    return np.where(found.any(axis=0), found.argmax(axis=0) + 1.0, np.inf)


RANDOM = changed(
    ("MEMORY = {", 'MEMORY = {"seen": 0.0, "heard": 0.0, "fused": 0.0, '),
    ("me.n += blacks", "me.n += blacks\n    me.seen = me.luck"),
    ("def receive(me, message):\n    pass", "def receive(me, message):\n    me.heard = me.luck"),
    ("def fuse(me):\n    pass", "def fuse(me):\n    me.fused = me.luck"),
)


OURS = ("seen", "heard", "fused")
