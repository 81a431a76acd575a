"""Steadfast: commons among liars, where a robot's own readings bound the influence of all others for good.

Sums s, v of evidence are mixed as in commons, with k = b + w - 1 and x = s / v. In addition, a robot keeps its own
evidence, n black of t readings: q = (n + 2) / (t + 4), with the standard error e = sqrt(q (1 - q) / (t + 4)). It counts
a message (s_j, v_j), which claims x_j = s_j / v_j, if

    |k x_j + 1 - w - q| <= sure e    it is compatible with the robot's own readings, and
    |x_j - x| <= near d              it is not far from most voices, whose typical distance d follows all m of a round:

    d <- (8 d + sum min(|x_j - x|, 2 d)) / (8.5 + m)    so that fewer than half of them cannot increase it

with a weight of at most `cap` v. Then

    s, v <- means of own and counted;    s, v += min(1, lean fresh / t) (own sums - s, v)

so that the effect of a lie at t0 has faded to (t0 / t)^(1 + lean) at t; readings do not fade, because the own sums keep
them. Finally, the estimate of commons is clipped to what the own readings allow:

    |x - f| <= |own - f| + sure e / |k|,    own = (q + w - 1) / k

This bound holds for any number of liars, and falls as 1 / sqrt(t). It is the only protection if most of a robot's
neighbours lie, as next to a lying hub of a tree. Because the gates depend on readings, x is not quite unbiased; if
black lies in clusters, e is too small, and honest robots exclude each other. Anonymous: there are no names to forge.

As in `commons`, a robot remembers what rounding took of s, v, so that they bear single precision. The own sums are made
of counts, which float32 holds to 2^24 readings.
"""

LARGE = 16384.0  # own readings: the sums of which rounding takes too much of a reading
VOICES = 8.0  # the number of voices over which the typical distance is averaged
LEAST = 1e-6  # typical distance; smaller ones are rounding

PARAMETERS = {
    "sure": 2.0,  # own standard errors: the largest distance of a compatible message
    "near": 4.0,  # typical distances: the largest distance of a counted message from the own ratio
    "lean": 3.0,  # the pull towards the own sums, in shares of new readings
    "cap": 2.0,  # the largest weight of a message, in own weights
}
MEMORY = {
    "s": 0.0,  # evidence for black, mixed
    "v": 0.0,  # evidence, mixed
    "s_rest": 0.0,  # what rounding took of s
    "v_rest": 0.0,  # and of v
    "n": 0.0,  # own black readings
    "t": 0.0,  # own readings
    "fresh": 0.0,  # readings since the last round
    "typical": 0.25,  # distance of a voice, d
    "voices": 0.0,  # messages since the last round
    "apart": 0.0,  # the sum of their distances, each clipped to 2 d
    "heard": 0.0,  # messages that count
    "heard_s": 0.0,  # the sums in them
    "heard_v": 0.0,
}
MESSAGE = ("s", "v")
ROLES = {"s": "information", "v": "confidence"}


def observe(me, blacks, looks):
    """Add unbiased evidence, weighted by how much the sensor tells, count the own readings."""
    slope = me.b + me.w - 1.0
    add(me, slope * (blacks - looks * (1.0 - me.w)), slope * slope * looks)
    me.n += blacks
    me.t += looks
    me.fresh += looks


def add(me, s, v):
    """Add to the mixed sums, and what rounding took before if they are large."""
    if me.t < LARGE:
        me.s += s
        me.v += v
        return
    me.s, me.s_rest = added(me.s, me.s_rest + s)
    me.v, me.v_rest = added(me.v, me.v_rest + v)


def added(total, more):
    """A sum with more added, and what rounding took of it."""
    larger = total + more
    return larger, more - (larger - total)


def lost(mean, own, heard, messages):
    """What rounding took of the mean of an own number and those in messages, whose sum is `heard`."""
    return ((heard - mean * messages) + (own - mean)) / (1.0 + messages)


def broadcast(me):
    """The mixed sums."""
    return me.s, me.v


def black(me):
    """The shrunk share of the own black readings; 1/2 at first."""
    return (me.n + 2.0) / (me.t + 4.0)


def error(me):
    """Its standard error."""
    q = black(me)
    return (q * (1.0 - q) / (me.t + 4.0)) ** 0.5


def receive(me, message):
    """A neighbour's sums, if they pass the gates."""
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
    """The mean of all counted voices, pulled towards the own sums."""
    if me.voices > 0.0 and me.v > 0.0:
        me.typical = max((VOICES * me.typical + me.apart) / (VOICES + 0.5 + me.voices), LEAST)
    voices = 1.0 + me.heard
    s = (me.s + me.heard_s) / voices
    v = (me.v + me.heard_v) / voices
    if me.v_rest != 0.0:  # of sums that are large
        me.s_rest += lost(s, me.s, me.heard_s, me.heard)
        me.v_rest += lost(v, me.v, me.heard_v, me.heard)
    me.s = s
    me.v = v
    if me.t > 0.0:
        slope = me.b + me.w - 1.0
        lean = min(1.0, me.lean * me.fresh / me.t)
        own_s = slope * (me.n - me.t * (1.0 - me.w))
        own_v = slope * slope * me.t
        add(me, lean * (own_s - me.s), lean * (own_v - me.v))
    me.fresh = 0.0
    me.voices = 0.0
    me.apart = 0.0
    me.heard = 0.0
    me.heard_s = 0.0
    me.heard_v = 0.0


def estimate(me):
    """The ratio of the sums with the prior of commons, clipped to what the own readings allow and to [0, 1]."""
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
