"""Sure: eight copies of commons, whose spread tells each robot how sure the swarm is, and when to stop looking.

Readings go into eight pairs of sums in turn, one block of rounds each, and each pair is mixed as in commons. For a
given network, their ratios are independent and differ only by chance, so they show the error of the overall ratio:

    f = sum s_k / V,  V = sum v_k,  se^2 = sum (s_k - f v_k)^2 / (V^2 - sum v_k^2),  f +- max(t se, ln(1/alpha) / (n k))

with t the two-sided quantile of Student's t with 7 degrees of freedom at alpha, n the readings of a neighbourhood, and
k the swarm's mean of b + w - 1, derived from v. No robot needs to know the number of robots, the network, or its
losses. These are batch means; the block length doubles after every eight blocks, so that correlated readings end up in
one block. The last term is for sensors so good that all readings may be equal: if a share ln(1/alpha)/n of the floor
differs, n readings miss it with a probability below alpha.

After the j-th eight blocks, the robot checks whether half the width of its interval is at most `within`, at alpha_j =
4 alpha/((j + 3)(j + 4)), and if so is done; all alpha_j sum up to alpha. It goes on sending. The interval is for the
ground that robots see: on a floor that is seen over and over, for its own share of black. On a floor whose black lies
in clusters wider than the distance that robots have driven, it is too narrow.

As in `commons`, a robot remembers what rounding took of the sums of the present stream, so that they bear single
precision.
"""

import math

STREAMS = 8
LARGE = 8192.0  # times new evidence: the sum of which rounding takes too much of it

PARAMETERS = {
    "within": 0.02,  # the accuracy that the mission needs
    "alpha": 0.05,  # the share of intervals that may miss f, and of robots that may stop too far from it
}
MEMORY = {
    "s": (0.0,) * 8,  # evidence for black, mixed, in each stream
    "v": (0.0,) * 8,  # evidence, mixed
    "s_rest": 0.0,  # what rounding took of s in the present stream
    "v_rest": 0.0,  # and of v
    "heard": 0.0,  # messages since the last round
    "heard_s": (0.0,) * 8,  # the sums in them
    "heard_v": (0.0,) * 8,
    "stream": 0.0,  # that of the present block
    "block": 1.0,  # the rounds of a block
    "left": 1.0,  # the rounds of it that are left
    "look": 0.0,  # j
    "looks": 0.0,  # own readings
    "voices": 0.0,  # the own and those heard, summed over rounds
    "rounds": 0.0,
    "sure": 0.0,  # 1: done
}
MESSAGE = ("s", "v")
ROLES = {"s": "information", "v": "confidence"}
SUMS = ("heard", "heard_s", "heard_v")


def observe(me, blacks, looks):
    """Add unbiased evidence to the present stream, weighted by how much the sensor tells."""
    slope = me.b + me.w - 1.0
    k = int(me.stream)
    s = slope * (blacks - looks * (1.0 - me.w))
    v = slope * slope * looks
    me.looks += looks
    if me.v[k] < LARGE * v:
        me.s[k] += s
        me.v[k] += v
        return
    me.s[k], me.s_rest = added(me.s[k], me.s_rest + s)
    me.v[k], me.v_rest = added(me.v[k], me.v_rest + v)


def added(total, more):
    """A sum with more added, and what rounding took of it."""
    larger = total + more
    return larger, more - (larger - total)


def lost(mean, own, heard, messages):
    """What rounding took of the mean of an own number and those in messages, whose sum is `heard`."""
    return ((heard - mean * messages) + (own - mean)) / (1.0 + messages)


def broadcast(me):
    """All sums."""
    return me.s, me.v


def receive(me, message):
    """A neighbour's sums."""
    s, v = message
    me.heard += 1.0
    for k in range(STREAMS):
        me.heard_s[k] += s[k]
        me.heard_v[k] += v[k]


def fuse(me):
    """Average all voices; at the end of eight blocks, look at the interval."""
    voices = 1.0 + me.heard
    if me.v_rest != 0.0:  # of sums that are large
        k = int(me.stream)
        me.s_rest += lost((me.s[k] + me.heard_s[k]) / voices, me.s[k], me.heard_s[k], me.heard)
        me.v_rest += lost((me.v[k] + me.heard_v[k]) / voices, me.v[k], me.heard_v[k], me.heard)
    for k in range(STREAMS):
        me.s[k] = (me.s[k] + me.heard_s[k]) / voices
        me.v[k] = (me.v[k] + me.heard_v[k]) / voices
        me.heard_s[k] = 0.0
        me.heard_v[k] = 0.0
    me.heard = 0.0
    me.voices += voices
    me.rounds += 1.0
    me.left -= 1.0
    if me.left == 0.0:
        me.stream += 1.0
        me.s_rest = 0.0
        me.v_rest = 0.0
        if me.stream == STREAMS:
            me.stream = 0.0
            me.block *= 2.0
            me.look += 1.0
            if half(me, 4.0 * me.alpha / ((me.look + 3.0) * (me.look + 4.0))) <= me.within:
                me.sure = 1.0
        me.left = me.block


def half(me, alpha):
    """Half the width of the interval that misses f with probability alpha; 1 while a stream has no evidence."""
    s = 0.0
    v = 0.0
    for k in range(STREAMS):
        if me.v[k] <= 0.0:
            return 1.0
        s += me.s[k]
        v += me.v[k]
    if me.looks == 0.0 or alpha <= 0.0:  # without permitted errors, the interval is everything
        return 1.0
    off = 0.0
    weights = v * v
    for k in range(STREAMS):
        off += (me.s[k] - s / v * me.v[k]) ** 2
        weights -= me.v[k] * me.v[k]
    slope = math.sqrt(min(v / me.looks, 1.0))
    if weights <= 0.0:  # up to rounding, one stream has all evidence
        return 1.0
    least = math.log(1.0 / alpha) * me.rounds / (me.looks * me.voices * slope)
    return max(quantile(alpha) * math.sqrt(off / weights), least)


def quantile(alpha):
    """The two-sided quantile of Student's t with 7 degrees of freedom at alpha, by bisection."""
    low = 0.0
    high = 0.5 * math.pi
    for _ in range(60):  # the angle atan(t / sqrt(7)): Abramowitz and Stegun, 26.7.3
        angle = 0.5 * (low + high)
        c = math.cos(angle)
        inside = 2.0 / math.pi * (angle + math.sin(angle) * c * (1.0 + c * c * (2.0 / 3.0 + c * c * 8.0 / 15.0)))
        if inside < 1.0 - alpha:
            low = angle
        else:
            high = angle
    return math.sqrt(7.0) * math.tan(0.5 * (low + high))


def estimate(me):
    """The ratio of all sums, with the prior of commons, in [0, 1]."""
    s = 0.0
    v = 0.0
    for k in range(STREAMS):
        s += me.s[k]
        v += me.v[k]
    if v <= 0.0:
        return 0.5
    prior = min(0.25, 0.0625 / v)
    return min(max((s + 0.5 * prior) / (v + prior), 0.0), 1.0)


def interval(me):
    """The interval at alpha, clipped to [0, 1]; all of [0, 1] while a stream has no evidence."""
    s = 0.0
    v = 0.0
    for k in range(STREAMS):
        s += me.s[k]
        v += me.v[k]
    near = half(me, me.alpha)
    if v <= 0.0 or near >= 1.0:
        return 0.0, 1.0
    return min(max(s / v - near, 0.0), 1.0), min(max(s / v + near, 0.0), 1.0)


def done(me):
    """Whether the interval was narrow enough at a look."""
    return me.sure > 0.0
