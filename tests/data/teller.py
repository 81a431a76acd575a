"""Tells everyone that all is black: kept as it was for results that name it."""

MEMORY = {"x": 1.0, "all": (1.0, 1.0, 1.0)}
MESSAGE = {"x": 0.0, "recent": (0.0,) * 3}


def observe(me, blacks, looks):
    pass


def broadcast(me):
    return me.x, me.all


def receive(me, message):
    pass


def fuse(me):
    pass


def estimate(me):
    return me.x
