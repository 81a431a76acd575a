"""Steadfast: commons among liars, where what a robot has seen by itself bounds for good what all others can do to it.

Sums s, v of evidence are mixed as in commons, k = b + w - 1, x = s / v. Beside them a robot keeps what it alone has
seen, n black of t readings: q = (n + 2) / (t + 4), with the standard error e = sqrt(q (1 - q) / (t + 4)). It counts a
message (s_j, v_j), which claims x_j = s_j / v_j, if

    |k x_j + 1 - w - q| <= sure e    it may be true, by what the robot has seen, and
    |x_j - x| <= near d              it is not far from most voices, whose typical distance d follows all m of a round:

    d <- (8 d + sum min(|x_j - x|, 2 d)) / (8.5 + m)    so that fewer than half of them cannot open it

with a weight of `cap` v at the most. Then

    s, v <- means of own and counted;    s, v += min(1, lean fresh / t) (own sums - s, v)

so that a lie told at t0 has faded to (t0 / t)^(1 + lean) at t; what was seen does not fade, for the own sums keep it.
At last the estimate of commons is cut to what the own readings allow:

    |x - f| <= |own - f| + sure e / |k|,    own = (q + w - 1) / k

whatever is said and by however many, which falls as 1 / sqrt(t). Where most of those whom a robot hears lie, as beside
a lying hub of a tree, this is all that is left. Gates look at readings, so x is not quite unbiased; where black lies in
clusters e is too small, and honest robots lock each other out. Anonymous: there are no names to forge.
"""

VOICES = 8.0  # over how many voices the typical distance is a mean
LEAST = 1e-6  # typical distance: below it agreement is rounding

PARAMETERS = {
    "sure": 2.0,  # own standard errors from what is seen to what is believed
    "near": 4.0,  # typical distances from the own ratio to what is counted
    "lean": 3.0,  # towards the own sums, in shares of what is fresh
    "cap": 2.0,  # the most that a message may weigh, in own weights
}
MEMORY = {
    "s": 0.0,  # evidence for black, mixed
    "v": 0.0,  # evidence, mixed
    "n": 0.0,  # own black readings
    "t": 0.0,  # own readings
    "fresh": 0.0,  # of which since the last round
    "typical": 0.25,  # distance of a voice, d
    "voices": 0.0,  # messages since the last round
    "apart": 0.0,  # the sum of their distances, each cut to 2 d
    "heard": 0.0,  # messages that count
    "heard_s": 0.0,  # the sums in them
    "heard_v": 0.0,
}
MESSAGE = ("s", "v")
ROLES = {"s": "information", "v": "confidence"}


def observe(me, blacks, looks):
    """Unbiased evidence, by how much the sensor tells; and what the robot alone has seen."""
    slope = me.b + me.w - 1.0
    me.s += slope * (blacks - looks * (1.0 - me.w))
    me.v += slope * slope * looks
    me.n += blacks
    me.t += looks
    me.fresh += looks


def broadcast(me):
    """The mixed sums."""
    return me.s, me.v


def black(me):
    """The share of black readings that the robot takes for its own; 1/2 at first."""
    return (me.n + 2.0) / (me.t + 4.0)


def error(me):
    """Its standard error."""
    q = black(me)
    return (q * (1.0 - q) / (me.t + 4.0)) ** 0.5


def receive(me, message):
    """A neighbour's sums, if they may be true."""
    s, v = message
    if v <= 0.0:
        return
    x = s / v
    share = 1.0
    me.voices += 1.0
    if me.v > 0.0:
        distance = abs(x - me.s / me.v)
        me.apart += min(distance, 2.0 * me.typical)
        if distance > me.near * me.typical:
            return
        share = min(1.0, me.cap * me.v / v)
    slope = me.b + me.w - 1.0
    if me.t > 0.0 and abs(slope * x + 1.0 - me.w - black(me)) > me.sure * error(me):
        return
    me.heard += 1.0
    me.heard_s += share * s
    me.heard_v += share * v


def fuse(me):
    """The mean of all voices that count, leaning to the own sums."""
    if me.voices > 0.0 and me.v > 0.0:
        me.typical = max((VOICES * me.typical + me.apart) / (VOICES + 0.5 + me.voices), LEAST)
    voices = 1.0 + me.heard
    me.s = (me.s + me.heard_s) / voices
    me.v = (me.v + me.heard_v) / voices
    if me.t > 0.0:
        slope = me.b + me.w - 1.0
        lean = min(1.0, me.lean * me.fresh / me.t)
        me.s += lean * (slope * (me.n - me.t * (1.0 - me.w)) - me.s)
        me.v += lean * (slope * slope * me.t - me.v)
    me.fresh = 0.0
    me.voices = 0.0
    me.apart = 0.0
    me.heard = 0.0
    me.heard_s = 0.0
    me.heard_v = 0.0


def estimate(me):
    """The ratio of the sums with the prior of commons, cut to what the own readings allow, in [0, 1]."""
    if me.v <= 0.0:
        return 0.5
    prior = min(0.25, 0.0625 / me.v)
    x = (me.s + 0.5 * prior) / (me.v + prior)
    slope = me.b + me.w - 1.0
    if me.t > 0.0 and abs(slope) > 1e-12:
        middle = (black(me) + me.w - 1.0) / slope
        half = me.sure * error(me) / abs(slope)
        x = min(max(x, middle - half), middle + half)
    return min(max(x, 0.0), 1.0)
