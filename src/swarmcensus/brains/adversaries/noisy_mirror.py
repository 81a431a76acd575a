"""Noisy mirror: it repeats the mean of what it heard in the round before, up to `noise` more or less."""

PARAMETERS = {"noise": 0.1}
MEMORY = {"heard": 0.0, "sum": 0.0, "said": -1.0}  # said below 0: it has heard nothing yet


def hear(me, x):
    me.heard += 1.0
    me.sum += x


def lie(me, x):
    return x if me.said < 0.0 else me.said


def plot(me):
    if me.heard > 0.0:  # else it says again what it said
        me.said = min(max(me.sum / me.heard + me.noise * (2.0 * me.luck - 1.0), 0.0), 1.0)
        me.heard = 0.0
        me.sum = 0.0
