"""Tracking: commons on a floor that may change; short sums stand beside long ones, which begin anew where both part.

Two pairs of the sums of `commons` are fed and mixed alike. The long ones, S and V, forget nothing. The short ones, s
and v, are cut back, their ratio kept, to a quarter of V, but no lower than to 10 and no higher than to `memory`, in
readings of a perfect sensor a robot: so they forget as fast as the swarm learns. With n voices in a round, the own too:

    where (S/V - s/v)^2 > z^2 (1/v - 1/V) / (4 n):    S, V, s, v <- s/v, 1, s/v, 1        f = S / V

Bound: of readings that weigh 1 in S and w <= 1 in s, none mixed, sum w^2 <= v, so that on a floor that stays
Var(S/V - s/v) = q(1 - q) (sum w^2 / v^2 - 1/V) <= (1/v - 1/V) / 4, as q(1 - q) <= 1/4. Mixing divides it by how many
robots stand behind v, which a robot does not know: those that it hears in one round are as good as never more. So
chance stays well within z, and the more so the more of the swarm is mixed.

What the short ones still hold of the old floor weighs no more than one reading after that. A robot that begins anew by
mistake is given the long sums back by its neighbours within a few rounds.
"""

LEAST = 10.0  # evidence that the short sums may hold at any time
KEPT = 1.0  # evidence that what a robot believes is worth when it begins anew

PARAMETERS = {
    "memory": 100.0,  # evidence that the short sums hold at the most, in readings of a perfect sensor
    "z": 2.5,  # standard deviations, by the bound, from which on the sums have parted
}
MEMORY = {
    "s": 0.0,  # short: evidence for black
    "v": 0.0,  # and evidence
    "long_s": 0.0,  # S
    "long_v": 0.0,  # V
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
    """Unbiased evidence, by how much the sensor tells."""
    slope = me.b + me.w - 1.0
    s = slope * (blacks - looks * (1.0 - me.w))
    v = slope * slope * looks
    me.s += s
    me.v += v
    me.long_s += s
    me.long_v += v


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
    """The mean of all voices; then forget, and see whether the sums have parted."""
    voices = 1.0 + me.heard
    me.s = (me.s + me.heard_s) / voices
    me.v = (me.v + me.heard_v) / voices
    me.long_s = (me.long_s + me.heard_long_s) / voices
    me.long_v = (me.long_v + me.heard_long_v) / voices
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


def has_changed(me, voices):
    """Whether short and long sums differ by more than chance explains."""
    if me.v <= 0.0 or me.long_v <= 1.01 * me.v:  # they have all but the same readings
        return False
    off = me.long_s / me.long_v - me.s / me.v
    return off * off > me.z * me.z * (1.0 / me.v - 1.0 / me.long_v) / (4.0 * voices)


def cut_short(me, most):
    """Forget: the short sums hold no more than so much evidence."""
    if me.v > most:
        me.s *= most / me.v
        me.v = most


def estimate(me):
    """The ratio of the long sums, with the prior of commons, in [0, 1]."""
    if me.long_v <= 0.0:
        return 0.5
    prior = min(0.25, 0.0625 / me.long_v)
    return min(max((me.long_s + 0.5 * prior) / (me.long_v + prior), 0.0), 1.0)
