"""Self-taught: commons for robots whose assumed accuracies may be wrong; outliers withdraw their evidence.

With k = b + w - 1, as assumed, a robot with n of t readings black has the estimate x = (n/t - 1 + w)/k of its own, with
a variance of at most e = 1/(4 k^2 t). It adds three numbers to sums that are mixed as in `commons`:

    g, g x, g (x^2 - e)    with    g = 1/(e + d);    f = s/v;    d <- max(0, m/v - f^2), smoothed

d is the variance between robots beyond chance, as in a random-effects mean (DerSimonian, Laird, 1986). If all robots
agree, d is 0 and this is commons. If not, no robot has a weight above 1/d, however much it has seen. A robot remembers
what it has added and renews it: all sums fade by 1/memory per round, and the difference is added or withdrawn in small
steps, because a large step would leave the others' x behind and mislead robots that look.

    is an outlier    if (x - f)^2 > z^2 e + apart d,  or x lies outside [0, 1] by more than z sqrt(e)
    fits again       if (x - f)^2 and the squared distance from [0, 1] are below a quarter of that, or f has no weight

An outlier reduces its g to 0 in steps; b = w = (n/t + f - 1)/(2 f - 1) is its accuracy according to the swarm. If a
share p of robots is wrong by the same D, (x - f)^2 = (1 - p)^2 D^2 and d = p (1 - p) D^2: they withdraw if (1 - p)/p is
above `apart`, and the others then stay. If about half are wrong in the same way, nothing can be known.

Single precision bears this for long: the sums fade, so that they stay small against what a round adds. The counts t and
n are exact up to 2^24 readings.
"""

from math import isfinite

STEP = 0.02  # the share of its evidence that a robot withdraws or adds per round
LEAST = 1e-6  # of the own weight; with less in total, f has no weight

PARAMETERS = {
    "z": 4.0,  # standard deviations explained by chance
    "apart": 1.2,  # in units of d: the limit beyond which a robot is an outlier
    "memory": 1000.0,  # rounds in which evidence fades
}
MEMORY = {
    "t": 0.0,  # observations made
    "n": 0.0,  # black ones among them
    "out": 0.0,  # 1: it is an outlier
    "part": 1.0,  # the share of its evidence that counts: falls to 0 while out, otherwise rises to 1
    "accuracy": 0.5,  # b = w according to the swarm, while out
    "s": 0.0,  # mixed: weights times estimates
    "v": 0.0,  # weights
    "m": 0.0,  # weights times squares, minus their variance by chance
    "x": 0.5,  # estimate
    "spread": 0.0,  # d, smoothed
    "given_s": 0.0,  # what it has added to these itself
    "given_v": 0.0,
    "given_m": 0.0,
    "heard": 0.0,  # messages since the last round
    "heard_s": 0.0,  # the sums in them
    "heard_v": 0.0,
    "heard_m": 0.0,
}
MESSAGE = ("s", "v", "m")
ROLES = {"s": "information", "v": "confidence"}
SUMS = ("heard", "heard_s", "heard_v", "heard_m")


def observe(me, blacks, looks):
    """Count readings."""
    me.t += looks
    me.n += blacks


def broadcast(me):
    """The sums."""
    return me.s, me.v, me.m


def receive(me, message):
    """A neighbour's sums."""
    s, v, m = message
    me.heard += 1.0
    me.heard_s += s
    me.heard_v += v
    me.heard_m += m


def fuse(me):
    """Average all voices with fading; then check whether it is an outlier, and add or withdraw evidence."""
    keep = 1.0 - 1.0 / max(me.memory, 1.0)
    share = keep / (1.0 + me.heard)
    s = share * (me.s + me.heard_s)
    v = share * (me.v + me.heard_v)
    m = share * (me.m + me.heard_m)
    if isfinite(2.0 * s) and isfinite(2.0 * v) and isfinite(2.0 * m):  # otherwise liars exaggerate without end
        me.s = s
        me.v = v
        me.m = m
    me.given_s *= keep
    me.given_v *= keep
    me.given_m *= keep
    me.heard = 0.0
    me.heard_s = 0.0
    me.heard_v = 0.0
    me.heard_m = 0.0
    me.x = ratio(me)
    slope = me.b + me.w - 1.0
    if me.t == 0.0 or abs(slope) < 1e-12:
        return
    x = (me.n / me.t - 1.0 + me.w) / slope
    chance = 0.25 / (slope * slope * me.t)
    alone = me.v <= 0.0
    if not alone:
        f = me.s / me.v
        spread = max(me.m / me.v - f * f, 0.0)
        if not isfinite(spread):
            return
        me.spread += STEP * (spread - me.spread)
        judge(me, x, chance, f, max(spread, me.spread))
        me.part = min(max(me.part + STEP * (1.0 - 2.0 * me.out), 0.0), 1.0)
    give(me, x, chance)
    if alone:
        me.x = ratio(me)


def judge(me, x, chance, f, spread):
    """Withdraw or return, and learn the accuracy according to the swarm."""
    most = me.z * me.z * chance
    limit = most + me.apart * spread
    off = (x - f) * (x - f)
    beyond = max(x - 1.0, -x, 0.0)
    if me.v * (chance + me.spread) < LEAST and beyond * beyond <= most:
        me.out = 0.0
    elif off > limit or beyond * beyond > most:
        me.out = 1.0
    elif off < 0.25 * limit and beyond * beyond < 0.25 * most:
        me.out = 0.0
    me.accuracy = 0.5 * (me.b + me.w)
    if me.out > 0.0 and abs(2.0 * f - 1.0) > 1e-12:
        me.accuracy = min(max((me.n / me.t + f - 1.0) / (2.0 * f - 1.0), 0.0), 1.0)


def give(me, x, chance):
    """Add a part of the missing own evidence, or withdraw a part of the surplus."""
    weight = me.part / (chance + me.spread)
    s = weight * x - me.given_s
    v = weight - me.given_v
    m = weight * (x * x - chance) - me.given_m
    part = 1.0
    most = min(STEP * me.given_v, 0.5 * me.v)
    if v < -most:
        part = most / -v
    me.s += part * s
    me.v += part * v
    me.m += part * m
    me.given_s += part * s
    me.given_v += part * v
    me.given_m += part * m


def ratio(me):
    """The ratio of the sums, with the prior of commons, in [0, 1]."""
    if me.v <= 0.0:
        return 0.5
    prior = min(1.0, 1.0 / me.v)
    return min(max((me.s + 0.5 * prior) / (me.v + prior), 0.0), 1.0)


def estimate(me):
    """The ratio without this round's own readings, whose weight is too large until they are mixed."""
    return me.x
