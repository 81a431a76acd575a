"""Sure: eight copies of commons, whose spread tells each robot how sure the swarm is, and when to stop looking.

Readings go into one of eight pairs of sums, and each pair is mixed as in commons. A robot begins with the pair of its
name, modulo eight, and feeds all in turn: for one round each, then for two, for four, and so on. So the ratios of the
pairs differ only by chance, and show the error of the overall ratio:

    f = sum s_k / V,  V = sum v_k,  se^2 = sum (s_k - f v_k)^2 / (V^2 - sum v_k^2) + c^2 / (f (1 - f))

    f +- max(t se, ln(1/alpha) / (n k))

with n the readings of a neighbourhood, and k the swarm's mean of b + w - 1, derived from v. No robot needs to know the
number of robots, the network, or its losses. t is the two-sided quantile of Student's t at alpha, whose degrees of
freedom are fewer the more the shares h_k = v_k / V differ (Satterthwaite, 1946); equal shares give 7:

    degrees = (1 - sum h_k^2)^2 / (sum h_k^2 - 2 sum h_k^3 + (sum h_k^2)^2)

The last term is for sensors so good that all readings may be equal: if a share ln(1/alpha)/n of the floor differs, n
readings miss it with a probability below alpha.

Patches. On a coarse floor all robots may read the same few patches, and then the pairs agree on a wrong ratio. So
robots also mix the product of each reading with the mean of about 16 readings of the same robot before it. Its mean is
f^2 + c, where c is the covariance of readings that are near in time: 0 on independent ground, f (1 - f) within a patch.
No robot knows how few patches the arena holds, or how often others have read them. So the part c / (f (1 - f)) of all
evidence counts as one patch, however long it is read. This part may be off by the root of f (1 - f), which is the
second term of se^2. All of c counts that is above 0: what chance adds to it makes intervals wider only.

Looks. After 8, 24, 56, 120, ... rounds, the robot checks whether half the width of its interval is at most `within`, at
alpha_j = 4 alpha/((j + 3)(j + 4)) in the j-th look, and is done if so; all alpha_j sum up to alpha. It goes on sending,
and its later intervals are at the same alpha_j. An interval that would hold 0 or 1 is all of [0, 1], and no robot is
done with it: ground of one colour may be one patch of a coarse floor. Intervals are for the floor's own share of black.

As in `commons`, a robot remembers what rounding took of the sums of the present stream, and of the products, so that
they bear single precision.
"""

import math

STREAMS = 8
WINDOW = 16.0  # readings whose mean a new one is compared with
LEAST = 1.0 / 64.0  # the variance of ground that seems to be all of one colour
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
    "product": 0.0,  # evidence times the products of readings and the mean of those just before, mixed
    "product_rest": 0.0,  # what rounding took of it
    "heard": 0.0,  # messages since the last round
    "heard_s": (0.0,) * 8,  # the sums in them
    "heard_v": (0.0,) * 8,
    "heard_product": 0.0,
    "fresh": 0.0,  # readings since the last round
    "fresh_s": 0.0,  # and their evidence for black
    "own": 0.5,  # the share of black in the own readings just before
    "before": 0.5,  # the estimate at the end of the last round
    "block": 1.0,  # the rounds for which a stream is fed
    "left": 8.0,  # rounds until all have been, and until the next look
    "look": 0.0,  # j
    "looks": 0.0,  # own readings
    "voices": 0.0,  # the own and those heard, summed over rounds
    "rounds": 0.0,
    "sure": 0.0,  # 1: done
}
MESSAGE = ("s", "v", "product")
ROLES = {"s": "information", "v": "confidence"}
SUMS = ("heard", "heard_s", "heard_v", "heard_product")
NEEDS = {"robots": 5, "even": 1}  # fewer see too little of each other's ground


def stream(me):
    """The stream that the robot feeds."""
    return int((me.name + (STREAMS * me.block - me.left) // me.block) % STREAMS)


def observe(me, blacks, looks):
    """Add unbiased evidence to the present stream, weighted by how much the sensor tells."""
    slope = me.b + me.w - 1.0
    k = stream(me)
    s = slope * (blacks - looks * (1.0 - me.w))
    v = slope * slope * looks
    me.looks += looks
    me.fresh += looks
    me.fresh_s += s
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
    return me.s, me.v, me.product + fresh_products(me)


def receive(me, message):
    """A neighbour's sums."""
    s, v, product = message
    me.heard += 1.0
    for k in range(STREAMS):
        me.heard_s[k] += s[k]
        me.heard_v[k] += v[k]
    me.heard_product += product


def fuse(me):
    """Average all voices, and look at the interval after all streams were fed."""
    if not is_bearable(me):  # liars exaggerate without end: hear nobody
        me.heard = 0.0
        me.heard_product = 0.0
        for k in range(STREAMS):
            me.heard_s[k] = 0.0
            me.heard_v[k] = 0.0
    voices = 1.0 + me.heard
    mix_products(me, voices)
    if me.v_rest != 0.0:  # of sums that are large
        k = stream(me)
        me.s_rest += lost((me.s[k] + me.heard_s[k]) / voices, me.s[k], me.heard_s[k], me.heard)
        me.v_rest += lost((me.v[k] + me.heard_v[k]) / voices, me.v[k], me.heard_v[k], me.heard)
    for k in range(STREAMS):
        me.s[k] = (me.s[k] + me.heard_s[k]) / voices
        me.v[k] = (me.v[k] + me.heard_v[k]) / voices
        me.heard_s[k] = 0.0
        me.heard_v[k] = 0.0
    me.heard = 0.0
    me.before = estimate(me)
    me.voices += voices
    me.rounds += 1.0
    me.left -= 1.0
    if me.left % me.block == 0.0:  # the next stream
        me.s_rest = 0.0
        me.v_rest = 0.0
    if me.left == 0.0:
        me.block *= 2.0
        me.left = STREAMS * me.block
        if me.sure == 0.0:
            look(me)


def is_bearable(me):
    """Whether sums with all that was heard are finite, and those of a few more readings."""
    total = abs(me.product + me.heard_product)
    for k in range(STREAMS):
        total += abs(me.s[k] + me.heard_s[k]) + abs(me.v[k] + me.heard_v[k])
    return math.isfinite(2.0 * total)


def fresh_products(me):
    """What fresh readings add, and former rounding. The mean of `apart` is 0: it only takes noise away."""
    slope = me.b + me.w - 1.0
    apart = me.fresh_s - slope * slope * me.fresh * me.own
    return me.fresh_s * me.own + me.before * apart + me.product_rest


def mix_products(me, voices):
    """Average the products of all voices, and count fresh readings as earlier ones."""
    slope = me.b + me.w - 1.0
    own, me.product_rest = added(me.product, fresh_products(me))
    me.product = (own + me.heard_product) / voices
    me.product_rest += lost(me.product, own, me.heard_product, me.heard)
    me.heard_product = 0.0
    if me.fresh > 0.0 and slope != 0.0:
        me.own += (me.fresh_s / (slope * slope) - me.fresh * me.own) / max(min(me.looks, WINDOW), me.fresh)
    me.fresh = 0.0
    me.fresh_s = 0.0


def look(me):
    """Be done if the interval is narrow."""
    me.look += 1.0
    if half(me, spent(me)) <= min(me.within, 0.5):
        me.sure = 1.0


def spent(me):
    """The part of alpha for this look."""
    return 4.0 * me.alpha / ((me.look + 3.0) * (me.look + 4.0))


def half(me, alpha):
    """Half the width of the interval that misses f with probability alpha; 1 if it would hold 0 or 1."""
    s, v = sums(me)
    for k in range(STREAMS):
        if me.v[k] <= 0.0:
            return 1.0
    if me.looks == 0.0 or alpha <= 0.0:  # without permitted errors, the interval is everything
        return 1.0
    f = s / v
    off = 0.0
    squares = 0.0
    cubes = 0.0
    for k in range(STREAMS):
        h = me.v[k] / v
        apart = me.s[k] / v - f * h
        off += apart * apart
        squares += h * h
        cubes += h * h * h
    if squares > 0.99:  # nearly all evidence is in one stream
        return 1.0
    degrees = (1.0 - squares) * (1.0 - squares) / (squares - 2.0 * cubes + squares * squares)
    slope = math.sqrt(min(v / me.looks, 1.0))
    least = math.log(1.0 / alpha) * me.rounds / (me.looks * me.voices * slope)
    variance = off / (1.0 - squares)
    c = max(me.product / v - f * f, 0.0)
    error = math.sqrt(variance + c * c / max(f * (1.0 - f), LEAST))
    near = max(quantile(alpha, max(degrees, 1.0)) * error, least)
    return near if near * v < s < v - near * v else 1.0


def quantile(alpha, degrees):
    """The two-sided quantile of Student's t at alpha, by bisection; between whole degrees slightly too large."""
    whole = math.floor(degrees)
    more = (degrees - whole) * (whole + 1.0) / degrees  # linear in 1 / degrees
    low = 0.0
    high = 0.5 * math.pi
    for _ in range(60):  # the angle atan(t)
        angle = 0.5 * (low + high)
        t = math.tan(angle)
        if inside(t, whole) + more * (inside(t, whole + 1.0) - inside(t, whole)) < 1.0 - alpha:
            low = angle
        else:
            high = angle
    return math.tan(0.5 * (low + high))


def inside(t, degrees):
    """The probability of values from -t to t, for whole degrees of freedom: Abramowitz and Stegun, 26.7.3 and 4."""
    c = degrees / (degrees + t * t)  # the squared cosine of the angle there
    odd = degrees % 2.0
    term = t / math.sqrt(degrees + t * t) * (math.sqrt(c) if odd > 0.0 else 1.0)
    total = 0.0
    k = 1.0 + odd
    while k < degrees:
        total += term
        term *= c * k / (k + 1.0)
        k += 2.0
    return 2.0 / math.pi * (math.atan(t / math.sqrt(degrees)) + total) if odd > 0.0 else total


def sums(me):
    """The sums of all streams."""
    s = 0.0
    v = 0.0
    for k in range(STREAMS):
        s += me.s[k]
        v += me.v[k]
    return s, v


def estimate(me):
    """The ratio of all sums, with the prior of commons, in [0, 1]."""
    s, v = sums(me)
    prior = 0.0625 / max(v, 0.25)
    return min(max((s + 0.5 * prior) / max(v + prior, 0.25), 0.0), 1.0)


def interval(me):
    """The interval at alpha; all of [0, 1] if the robot cannot tell."""
    s, v = sums(me)
    near = half(me, spent(me) if me.sure > 0.0 else me.alpha)
    if near >= 1.0:
        return 0.0, 1.0
    return min(max(s / v - near, 0.0), 1.0), min(max(s / v + near, 0.0), 1.0)


def done(me):
    """Whether the interval was narrow enough at a look."""
    return me.sure > 0.0
