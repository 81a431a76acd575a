"""Pooled evidence with a prior: what was expected beforehand counts as so many good readings; studies sweep both."""

PARAMETERS = {
    "prior": 10.0,  # how many perfect readings the expectation is worth
    "expected": 0.5,  # the fill ratio that is expected before any reading
}
MEMORY = {
    "t": 0.0,  # observations made
    "n": 0.0,  # of which said black
    "worth": 0.0,  # how many perfect readings they are worth
    "black": 0.0,  # of which black
    "heard_worth": 0.0,  # the same of all neighbours together, in this round
    "heard_black": 0.0,
    "x": 0.5,  # the fill ratio believed in, before `fuse` is first called
}
MESSAGE = ("worth", "black")
SUMS = ("heard_worth", "heard_black")


def observe(me, blacks, looks):
    """A reading of a sensor that is right with b and w is worth (b + w - 1)^2 perfect ones, near enough."""
    me.t += looks
    me.n += blacks
    slope = me.b + me.w - 1.0
    me.worth = slope * slope * me.t
    me.black = slope * (me.n - (1.0 - me.w) * me.t)  # what white tiles said wrongly is taken off


def broadcast(me):
    return me.worth, me.black


def receive(me, message):
    me.heard_worth += message[0]
    me.heard_black += message[1]


def fuse(me):
    worth = me.prior + me.worth + me.heard_worth
    if worth > 0.0:
        black = me.prior * me.expected + me.black + me.heard_black
        me.x = min(max(black / worth, 0.0), 1.0)
    me.heard_worth = 0.0
    me.heard_black = 0.0


def estimate(me):
    return me.x
