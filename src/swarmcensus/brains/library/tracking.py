"""Tracking: commons on a floor that may change; short and long sums are compared, and both restart if they differ.

Two pairs of the sums of `commons` are fed and mixed alike. The long ones, S and V, forget nothing. The short ones, s
and v, are scaled down, keeping their ratio, to a quarter of V, but not below 10 and not above `memory`, in readings of
a perfect sensor per robot. So they forget as fast as the swarm learns. With n voices in a round, including the own:

    if (S/V - s/v)^2 > z^2 (1/v - 1/V) / (4 n):    S, V, s, v <- s/v, 1, s/v, 1        f = S / V

Bound: for unmixed readings with weight 1 in S and w <= 1 in s, sum w^2 <= v, so that on a floor that does not change
Var(S/V - s/v) = q(1 - q) (sum w^2 / v^2 - 1/V) <= (1/v - 1/V) / 4, as q(1 - q) <= 1/4. Mixing divides it by the number
of robots that contribute to v, which a robot does not know; the robots that it hears in one round are nearly always
fewer. So chance stays well within z, the more so the more of the swarm is mixed. It does not in a star: what the hub
hears is mostly its own, so that it begins again by chance.

As in `commons`, a robot remembers what rounding took of the long sums, so that they bear single precision. The short
ones are never that large.

After a restart, what the short sums still hold of the old floor weighs no more than one reading. A robot that restarts
by mistake gets the long sums back from its neighbours within a few rounds.
"""

from math import isfinite

LARGE = 8192.0  # times new evidence: the sum of which rounding takes too much of it
LEAST = 10.0  # evidence that the short sums may always hold
KEPT = 1.0  # the weight of the estimate after a restart

PARAMETERS = {
    "memory": 100.0,  # the most evidence in the short sums, in readings of a perfect sensor
    "z": 2.5,  # standard deviations, by the bound, beyond which the sums differ
}
MEMORY = {
    "s": 0.0,  # short: evidence for black
    "v": 0.0,  # and evidence
    "long_s": 0.0,  # S
    "long_v": 0.0,  # V
    "s_rest": 0.0,  # what rounding took of S
    "v_rest": 0.0,  # and of V
    "heard": 0.0,  # messages since the last round
    "heard_s": 0.0,  # the sums in them
    "heard_v": 0.0,
    "heard_long_s": 0.0,
    "heard_long_v": 0.0,
}
MESSAGE = ("s", "v", "long_s", "long_v")
ROLES = {"s": "information", "v": "confidence", "long_s": "information", "long_v": "confidence"}
SUMS = ("heard", "heard_s", "heard_v", "heard_long_s", "heard_long_v")


def observe(me, blacks, looks):
    """Add unbiased evidence, weighted by how much the sensor tells."""
    slope = me.b + me.w - 1.0
    s = slope * (blacks - looks * (1.0 - me.w))
    v = slope * slope * looks
    me.s += s
    me.v += v
    if me.long_v < LARGE * v:
        me.long_s += s
        me.long_v += v
        return
    me.long_s, me.s_rest = added(me.long_s, me.s_rest + s)
    me.long_v, me.v_rest = added(me.long_v, me.v_rest + v)


def added(total, more):
    """A sum with more added, and what rounding took of it."""
    larger = total + more
    return larger, more - (larger - total)


def lost(mean, own, heard, messages):
    """What rounding took of the mean of an own number and those in messages, whose sum is `heard`."""
    return ((heard - mean * messages) + (own - mean)) / (1.0 + messages)


def broadcast(me):
    """All sums."""
    return me.s, me.v, me.long_s, me.long_v


def receive(me, message):
    """A neighbour's sums."""
    s, v, long_s, long_v = message
    me.heard += 1.0
    me.heard_s += s
    me.heard_v += v
    me.heard_long_s += long_s
    me.heard_long_v += long_v


def fuse(me):
    """Average all voices; then forget, and check whether the sums differ."""
    voices = 1.0 + me.heard
    s = (me.s + me.heard_s) / voices
    v = (me.v + me.heard_v) / voices
    long_s = (me.long_s + me.heard_long_s) / voices
    long_v = (me.long_v + me.heard_long_v) / voices
    if isfinite(s) and isfinite(v) and isfinite(2.0 * long_s) and isfinite(2.0 * long_v):  # else liars overdo it
        if me.v_rest != 0.0:  # of sums that are large
            me.s_rest += lost(long_s, me.long_s, me.heard_long_s, me.heard)
            me.v_rest += lost(long_v, me.long_v, me.heard_long_v, me.heard)
        me.s = s
        me.v = v
        me.long_s = long_s
        me.long_v = long_v
    me.heard = 0.0
    me.heard_s = 0.0
    me.heard_v = 0.0
    me.heard_long_s = 0.0
    me.heard_long_v = 0.0
    cut_short(me, min(me.memory, max(LEAST, 0.25 * me.long_v)))
    if has_changed(me, voices):
        cut_short(me, KEPT)
        me.long_s = me.s
        me.long_v = me.v
        me.s_rest = 0.0
        me.v_rest = 0.0


def has_changed(me, voices):
    """Whether short and long sums differ by more than chance explains."""
    if me.v <= 0.0 or me.long_v <= 1.01 * me.v:  # both have nearly the same readings
        return False
    off = me.long_s / me.long_v - me.s / me.v
    return off * off > me.z * me.z * (1.0 / me.v - 1.0 / me.long_v) / (4.0 * voices)


def cut_short(me, most):
    """Forget: limit the evidence in the short sums."""
    if me.v > most:
        me.s *= most / me.v
        me.v = most


def estimate(me):
    """The ratio of the long sums, with the prior of commons, in [0, 1]."""
    if me.long_v <= 0.0:
        return 0.5
    prior = min(0.25, 0.0625 / me.long_v)
    return min(max((me.long_s + 0.5 * prior) / (me.long_v + prior), 0.0), 1.0)
