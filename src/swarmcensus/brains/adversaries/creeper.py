"""Creeper: it says a little more than it believes, `step` from its honest value towards `goal`."""

PARAMETERS = {"step": 0.01, "goal": 1.0}


def lie(me, x):
    return x + min(max(me.goal - x, -me.step), me.step)
