"""A brain whose message says all that there is to lie about, and adversaries made for tests."""

from pathlib import Path

from swarmcensus import brains
from swarmcensus.brains import adversary
from tests.support.second import changed

RICH = '''"""Says all that a message may mean, now and then nothing, and has names that an adversary has too."""

from math import sqrt

OPTIONS = 4
ROLES = {
    "who": "name",
    "x": "estimate",
    "vote": "opinion",
    "bin": "option",
    "belief": "belief",
    "sure": "confidence",
    "known": "information",
}
MEMORY = {"t": 0.0, "n": 0.0, "said": 0.5, "mood": 0.0, "sum": 0.0, "heard": 0.0, "belief": (0.25,) * 4}
MESSAGE = {"who": 0.0, "x": 0.0, "vote": 0.0, "bin": 0.0, "belief": (0.0,) * 4, "sure": 0.0, "known": 0.0, "t": 0.0}


def lie(plot):  # a helper and an argument that are called as functions of adversaries are
    return sqrt(plot)


def observe(me, blacks, looks):
    me.t += looks
    me.n += blacks


def message(me):
    if me.mood > 0.7:
        return None
    x = seen(me)
    vote = 1.0 if x >= 0.5 else 0.0
    return me.name, x, vote, float(min(int(4.0 * x), 3)), me.belief, lie(me.t), x * lie(me.t), me.t


def broadcast(me):
    return message(me) if me.t > 0.0 else None


def seen(me):
    return me.n / me.t if me.t > 0.0 else 0.5


def receive(me, message):
    me.heard += 1.0
    me.sum += message[1] + 0.5 * message[2] + 0.25 * message[3] + message[4][0] - message[6] / (1.0 + message[5])


def fuse(me):
    me.mood = me.luck
    if me.heard > 0.0:
        me.said = 0.5 + 0.1 * me.sum / me.heard
    me.heard = 0.0
    me.sum = 0.0
    for k in range(4):
        me.belief[k] = 4.0 if k == int(3.999 * seen(me)) else 0.0


def estimate(me):
    return min(max(me.said, 0.0), 1.0)


def decide(me):
    return int(3.999 * seen(me))
'''


def adversary_of(source, name="liar.py"):
    """An adversary of this source."""
    return adversary.parse(source, name, Path(name))


def wrapped(name, by="minimalistic", **parameters):
    """The brain of a shipped adversary and a brain."""
    used = brains.load(by) if isinstance(by, str) else by
    return brains.lying_brain(adversary.load(name).with_parameters(parameters), used)


CONSTANT = changed(  # a liar that says one number to everybody, from the first round on
    ("MEMORY =", 'PARAMETERS = {"says": 1.0}\nMEMORY ='),
    ('("x",)', '("x", "name")'),
    ("return (estimate(me),)", "return me.says, me.name"),
)


def liars(name, robots=2, **parameters):
    return [{"robots": robots, "brain": {"file": name, **parameters}, "honest": False}]


def robot(used, blacks, looks, b=0.9, w=0.8):
    """A state that has made these readings."""
    me = used.robot(b, w, 3.0)
    used.functions.observe(me, float(blacks), float(looks))
    return me
