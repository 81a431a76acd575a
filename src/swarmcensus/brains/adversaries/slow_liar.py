"""Slow liar: in each round, it moves `pace` farther from its honest value towards `goal`."""

PARAMETERS = {"pace": 0.001, "goal": 1.0}
MEMORY = {"far": 0.0}


def lie(me, x):
    return x + min(max(me.goal - x, -me.far), me.far)


def plot(me):
    me.far = min(me.far + me.pace, 1.0)
