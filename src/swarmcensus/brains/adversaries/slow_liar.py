"""Slow liar: each round it goes `pace` farther from what it would honestly say, towards `goal`."""

PARAMETERS = {"pace": 0.001, "goal": 1.0}
MEMORY = {"far": 0.0}


def lie(me, x):
    return x + min(max(me.goal - x, -me.far), me.far)


def plot(me):
    me.far = min(me.far + me.pace, 1.0)
