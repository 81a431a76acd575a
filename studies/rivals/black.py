"""A liar that tells everybody that all is black, in words of those who agree on a number."""

MEMORY = {"t": 0.0}  # observations made, for nothing
MESSAGE = ("x", "name")


def observe(me, blacks, looks):
    """Count."""
    me.t += looks


def broadcast(me):
    """All is black, says this robot."""
    return 1.0, me.name


def receive(me, message):
    """Not listen."""


def fuse(me):
    """Not learn."""


def estimate(me):
    """What it says."""
    return 1.0
