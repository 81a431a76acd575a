"""A robot alone: the paper's local estimate, and nobody says anything. The lower bound of what talking is worth.

Local estimate as in Chin, Khaluf and Pinciroli, "Minimalistic Collective Perception with Imperfect Sensors", Eq. 4. The
function stands here again because a brain is one file: it goes onto the robot alone.

Deviations: none of the local estimate; its confidence (Eq. 5) is left out, as nobody asks for it.
"""

MEMORY = {
    "t": 0.0,  # observations made
    "n": 0.0,  # of which said black
    "x": 0.5,  # local estimate
}
MESSAGE = ("x",)


def observe(me, blacks, looks):
    """Local estimate (Eq. 4)."""
    me.t += looks
    me.n += blacks
    slope = me.b + me.w - 1.0  # how much more often black says black than white does
    if me.t == 0.0 or abs(slope) < 1e-12:
        return  # nothing seen, or a sensor that says the same of black and white
    me.x = min(max((me.n / me.t + me.w - 1.0) / slope, 0.0), 1.0)


def broadcast(me):
    """Nothing."""
    return None


def receive(me, message):
    """Nobody is heard either."""


def fuse(me):
    """Nothing to fuse."""


def estimate(me):
    """The local estimate."""
    return me.x
