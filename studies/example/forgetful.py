"""Pooled evidence that fades: what was seen long ago counts less, so that a swarm notices when the world changes."""

PARAMETERS = {
    "half": 100.0,  # rounds after which a reading counts half; above 0
}
MEMORY = {
    "t": 0.0,  # observations made, faded
    "n": 0.0,  # of which said black
    "heard_worth": 0.0,  # the neighbours' evidence in this round, in perfect readings
    "heard_black": 0.0,  # of which black
    "x": 0.5,  # the fill ratio believed in
}
MESSAGE = ("worth", "black")
ROLES = {"worth": "confidence", "black": "information"}  # for whoever lies in its place
SUMS = ("heard_worth", "heard_black")


def observe(me, blacks, looks):
    me.t += looks
    me.n += blacks


def broadcast(me):
    """A reading of a sensor that is right with b and w is worth (b + w - 1)^2 perfect ones, near enough."""
    slope = me.b + me.w - 1.0
    return slope * slope * me.t, slope * (me.n - (1.0 - me.w) * me.t)


def receive(me, message):
    me.heard_worth += message[0]
    me.heard_black += message[1]


def fuse(me):
    slope = me.b + me.w - 1.0
    worth = slope * slope * me.t + me.heard_worth
    if worth > 0.0:
        black = slope * (me.n - (1.0 - me.w) * me.t) + me.heard_black
        me.x = min(max(black / worth, 0.0), 1.0)
    kept = 0.5 ** (1.0 / me.half)
    me.t *= kept
    me.n *= kept
    me.heard_worth = 0.0
    me.heard_black = 0.0


def estimate(me):
    return me.x
