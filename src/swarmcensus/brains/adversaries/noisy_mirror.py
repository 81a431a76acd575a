"""Noisy mirror: it repeats the mean of what it heard in the round before, plus or minus up to `noise`."""

PARAMETERS = {"noise": 0.1}
MEMORY = {"heard": 0.0, "sum": 0.0, "said": -1.0}  # said is below 0 until it has heard something


def hear(me, x):
    me.heard += 1.0
    me.sum += x


def lie(me, x):
    return x if me.said < 0.0 else me.said


def plot(me):
    if me.heard > 0.0:  # otherwise it repeats its last value
        me.said = min(max(me.sum / me.heard + me.noise * (2.0 * me.luck - 1.0), 0.0), 1.0)
        me.heard = 0.0
        me.sum = 0.0
