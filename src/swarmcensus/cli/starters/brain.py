"""Mine: the mean of all readings, the own and the neighbours', each corrected for the sensor that made it."""

# The line above is what `swarmcensus list` shows. Change what you like: `swarmcensus brains --check THIS_FILE` tells
# whether it still is a brain, docs/brain-contract.md what one may do.

# What a study may set, as brain = {file = "THIS_FILE", trust = [0.5, 1.0]}; read as me.trust. May be left out.
PARAMETERS = {
    "trust": 1.0  # what a neighbour's readings count beside one's own
}

# All that a robot remembers, and what it begins with: numbers, or tuples of a fixed length.
MEMORY = {
    "t": 0.0,  # observations made
    "n": 0.0,  # of which said black
    "heard_t": 0.0,  # the neighbours' in the last round
    "heard_n": 0.0,
    "x": 0.5,  # the estimate
}

# What a message holds, in order. Fewer numbers need less of the radio.
MESSAGE = ("t", "n")

# What these mean, for liars and for small message formats: n is t times an estimate. May be left out.
ROLES = {"t": "confidence", "n": "information"}

# Fields that `receive` only adds to: with this promise large swarms run much faster. May be left out.
SUMS = ("heard_t", "heard_n")


def observe(me, blacks, looks):
    """So many of these looks at the floor said black; me.b and me.w are how often this sensor is right."""
    slope = me.b + me.w - 1.0
    if abs(slope) < 1e-12:
        return  # a sensor that says the same of black and white tells nothing
    me.t += looks
    me.n += (blacks - looks * (1.0 - me.w)) / slope


def broadcast(me):
    """What a robot says in each round, to all that hear it."""
    return me.t, me.n


def receive(me, message):
    """One neighbour's message; messages come in no order."""
    t, n = message
    me.heard_t += t
    me.heard_n += n


def fuse(me):
    """The end of a round: what was heard becomes an estimate, and the sums begin anew."""
    t = me.t + me.trust * me.heard_t
    if t > 0.0:
        me.x = min(max((me.n + me.trust * me.heard_n) / t, 0.0), 1.0)
    me.heard_t = 0.0
    me.heard_n = 0.0


def estimate(me):
    """The fill ratio that a robot believes in, from 0 to 1; it may be asked at any time, and changes nothing."""
    return me.x
