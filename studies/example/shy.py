"""A brain with two parameters: it doubts what it has seen, and leans on what it hears.

It estimates as `my_brain.py` does, but mixes `prior` readings into its own that never were, half of them black, and
takes a share `trust` of its neighbours' mean estimate.
"""

PARAMETERS = {
    "prior": 100.0,  # readings that never were
    "trust": 0.1,  # the weight of the neighbours
}
MEMORY = {
    "t": 0.0,  # observations made
    "n": 0.0,  # of which said black
    "own": 0.5,  # what it would believe alone
    "x": 0.5,  # its estimate
    "heard": 0.0,  # messages in this round
    "heard_x": 0.0,  # the sum of their estimates
}
MESSAGE = ("x",)
SUMS = ("heard", "heard_x")


def observe(me, blacks, looks):
    """Count, correct for the sensor, and draw towards one half."""
    me.t += looks
    me.n += blacks
    if me.b + me.w != 1.0:
        seen = min(max((me.n / me.t + me.w - 1.0) / (me.b + me.w - 1.0), 0.0), 1.0)
        me.own = (me.t * seen + me.prior * 0.5) / (me.t + me.prior)


def broadcast(me):
    """Tell the estimate."""
    return (me.x,)


def receive(me, message):
    """Add up what neighbours say."""
    me.heard += 1.0
    me.heard_x += message[0]


def fuse(me):
    """Lean on them as far as it trusts them."""
    me.x = me.own
    if me.heard > 0.0:
        me.x += me.trust * (me.heard_x / me.heard - me.own)
    me.heard = 0.0
    me.heard_x = 0.0


def estimate(me):
    """The mixture."""
    return min(max(me.x, 0.0), 1.0)
