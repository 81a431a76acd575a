"""The rules for opinions with phases of a few rounds, and lives of single robots in CPython."""

import functools

from swarmcensus import brains

QUICK = {  # phases of a few rounds, so that short histories hold many
    "voter": {"explore": 3.0, "disseminate": 6.0, "listen": 2.0},
    "majority": {"explore": 3.0, "disseminate": 6.0, "listen": 2.0, "senders": 3.0},
    "direct-comparison": {"explore": 3.0, "disseminate": 6.0, "listen": 2.0},
    "cross-inhibition": {
        "explore": 3.0, "disseminate": 6.0, "uncommitted": 2.0, "miscommunication": 0.15, "asocial": 0.1,
    },
    "direct-switching": {"explore": 3.0, "disseminate": 6.0, "miscommunication": 0.15, "asocial": 0.1},
    "three-state": {"every": 1.0, "dance": 5.0, "patience": 3.0},
    "weighted-voter": {"every": 1.0, "dance": 5.0, "patience": 3.0},
}  # fmt: skip
TELLERS = ["voter", "majority", "direct-comparison"]
SWITCHERS = ["cross-inhibition", "direct-switching"]
DANCERS = ["three-state", "weighted-voter"]
BINARY = [*TELLERS, *SWITCHERS]


def quick(name, **parameters):
    return brains.load(name).with_parameters(QUICK[name] | parameters)


known = functools.cache(lambda name, parameters: quick(name, **dict(parameters)))  # reading a file takes milliseconds


def robot(name, number=0, b=1.0, w=1.0, **parameters):
    """A state before the first round, and its functions."""
    brain = known(name, tuple(parameters.items()))
    return brain.robot(b, w, float(number)), brain.functions


def rounds(me, rule, heard=(), draws=0.5, count=1, blacks=1.0, looks=1.0):
    """Some rounds, in each of which it makes readings and hears all of these messages."""
    for _ in range(count):
        me.luck = draws
        if looks:
            rule.observe(me, blacks, looks)
        for message in heard:
            me.luck = draws
            rule.receive(me, message)
        me.luck = draws
        rule.fuse(me)


def telling(name, number=0, **parameters):
    """A state in the last round of telling: what it hears now, it decides by."""
    me, rule = robot(name, number, **parameters)
    rounds(me, rule)
    me.left = 1.0
    rounds(me, rule)
    assert rule.broadcast(me) is not None
    me.left = 1.0
    return me, rule
