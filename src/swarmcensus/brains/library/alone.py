"""A robot alone: the paper's local estimate without any communication. It is the lower bound for brains that talk.

Local estimate as in Chin, Khaluf and Pinciroli, "Minimalistic Collective Perception with Imperfect Sensors", Eq. 4. The
function is repeated here because a brain is one file.

Deviations: none in the local estimate; its confidence (Eq. 5) is left out because it is not used.
"""

MEMORY = {
    "t": 0.0,  # observations made
    "n": 0.0,  # black ones among them
    "x": 0.5,  # local estimate
}
MESSAGE = ("x",)


def observe(me, blacks, looks):
    """Local estimate (Eq. 4)."""
    me.t += looks
    me.n += blacks
    slope = me.b + me.w - 1.0  # how much more often black tiles read black than white tiles do
    if me.t == 0.0 or abs(slope) < 1e-12:
        return  # no reading, or a sensor that tells nothing
    me.x = min(max((me.n / me.t + me.w - 1.0) / slope, 0.0), 1.0)


def broadcast(me):
    """Nothing."""
    return None


def receive(me, message):
    """Messages are ignored."""


def fuse(me):
    """Nothing to fuse."""


def estimate(me):
    """The local estimate."""
    return me.x
