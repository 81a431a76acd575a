"""Small swarms in every kind of world, and what the reference needs to know of them."""

import functools

import numba
import numpy as np

import swarmcensus as sc
from swarmcensus import brains
from swarmcensus.engine.addresses import address
from tests.reference import rounds as reference

# one brain of each family: the paper's, sums that are mixed, intervals and ends, opinions, Bayesian votes, consensus
FAMILIES = ("minimalistic", "commons", "sure", "voter", "bayes-bots", "w-msr")
GO = np.zeros(1, np.uint8)
SEED = 29
SWITCH = {"from": 0.85, "to": 0.25, "at": 31}
SLOW = SWITCH | {"until": 71}
FAULTS = [
    {"at": 3, "robots": 2, "stop": "sensing"},
    {"at": 5, "robots": 0.4, "stop": "talking"},
    {"at": 2, "robots": 1, "stop": ["talking", "sensing"]},
]

PASSING = [  # some come late, and some are twice away
    {"at": 1, "robots": 2, "stop": ["sensing", "talking"], "until": 4},
    {"at": 3, "robots": 0.6, "stop": "talking", "until": 5},
    {"at": 6, "robots": 1, "stop": "sensing"},
]


@functools.cache
def called(function):
    """A function that only machine code can call, for CPython."""
    return numba.njit(lambda *given: function(*given))


def study_of(brain="minimalistic", robots=5, accuracy=0.7, rounds=8, looks=10, trials=3, seed=SEED, ticks=None,
             body=None, members=(), faults=(), measure=None, **world):  # fmt: skip
    """A study in few words, on a ring unless the world says otherwise; `ticks` are for robots that move."""
    swarm = {"robots": robots, "brain": brain, "accuracy": accuracy}
    swarm |= {key: world.pop(key) for key in ("assumed_accuracy", "precision") if key in world}
    schedule = {"rounds": rounds, "observations_per_round": looks}
    if ticks is not None:
        schedule = {"ticks": ticks}
        world = {"topology": "moving", "density": 8, "body": {"tile": 0.05} | (body or {})} | world
    world = {"topology": "ring", "fill_ratio": 0.55} | world
    return sc.Study(trials=trials, seed=seed, swarm=swarm, world=world, schedule=schedule, members=list(members),
                    faults=list(faults), measure=measure or {})  # fmt: skip


def settings_of(robots=5, brain="minimalistic", accuracy=0.7, looks=1, **given):
    """The settings of a study on fixed networks."""
    return study_of(brain, robots, accuracy, looks=looks, **given).settings()


def moving_of(robots=6, brain="minimalistic", accuracy=0.7, ticks=12, **given):
    """The one setting of a study of robots that move."""
    (setting,) = study_of(brain, robots, accuracy, ticks=ticks, **given).settings()
    return setting


def failing(setting, trial):
    """When parts fail, in the reference."""
    keys = [address(SEED, "faults", number=k, robots=setting.robots) for k in range(len(setting.faults))]
    return reference.failures(setting, keys, trial)


def heard_in(setting, trial):
    """Who hears whom in the reference."""
    content = setting.topology.content
    return reference.hearers(setting, address(SEED, "topology", topology=content, robots=setting.robots), trial)


def changing(fill_ratio=SLOW, accuracy=0.9, world=(), **tables):
    """A study of 100 rounds whose fill ratio changes, on a ring unless `world` says otherwise."""
    moves = dict(world).get("topology") == "moving"
    schedule = {"ticks": 100} if moves else {"rounds": 100, "observations_per_round": 3}
    given = {"trials": 3, "seed": 7, "swarm": {"robots": 8, "accuracy": accuracy}, "schedule": schedule}
    return sc.Study(**given | {"world": {"topology": "ring", "fill_ratio": fill_ratio} | dict(world)} | tables)


SMALL = """
name = "small"
seed = 7
trials = 4
swarm = {robots = [5, 12], accuracy = [0.675, "U(0.525, 0.975)"]}
world = {topology = ["full", "ring", "line", "scale-free"], fill_ratio = [0.55, 0.95]}
schedule = {rounds = 60, observations_per_round = 10}
measure = {checkpoints = [10, 60]}
"""


# the shipped brain, which now and then divides by zero after 600 readings: of one source, so as to be compiled once
FAILS = brains.load("minimalistic").source.replace(
    "    me.t += looks\n",
    "    me.t += looks\n    if me.t == 600.0 and me.n > 275.0:\n        me.x = 1.0 / (me.t - me.t)\n",
    1,
)


RING = {"topology": "ring", "fill_ratio": 0.5}


MOVING = {"topology": "moving", "fill_ratio": 0.5, "density": 1}


BOTH = MOVING | {"topology": ["ring", "moving"]}
