"""Sure: eight copies of commons, whose spread tells each robot how sure the swarm is, and when to stop looking.

Robots form eight groups by their names. Readings of a group go into one of eight pairs of sums, and each pair is mixed
as in commons. Readings of different robots are independent for a given floor and network, however long those of one
robot hang together. So the ratios of the pairs differ only by chance, and show the error of the overall ratio:

    f = sum s_k / V,  V = sum v_k,  se^2 = sum (s_k - f v_k)^2 / (V^2 - sum v_k^2),  f +- max(t se, ln(1/alpha) / (n k))

with n the readings of a neighbourhood, and k the swarm's mean of b + w - 1, derived from v. No robot needs to know the
number of robots, the network, or its losses. t is the two-sided quantile of Student's t at alpha, whose degrees of
freedom are fewer the more the shares h_k = v_k / V differ (Satterthwaite, 1946); equal shares give 7:

    degrees = (1 - sum h_k^2)^2 / (sum h_k^2 - 2 sum h_k^3 + (sum h_k^2)^2)

The last term is for sensors so good that all readings may be equal: if a share ln(1/alpha)/n of the floor differs, n
readings miss it with a probability below alpha.

Moving on. Groups may be few or unequal, so a robot feeds all pairs in turn, one block of rounds each, once its blocks
are long against the time in which its own readings hang together. It measures r, the correlation of the ground in
successive rounds, and moves on after LONG r / (1 - r) rounds, with r larger by ERRORS standard errors. So it stays
while it knows nothing. Blocks also have a least length, which doubles after every eight: ground may hang together for
longer than successive rounds show. With fewer than eight robots, nobody is sure before all pairs are fed.

Looks. After 8, 24, 56, 120, ... rounds, the robot checks whether half the width of its interval is at most `within`, at
alpha_j = 4 alpha/((j + 3)(j + 4)) in the j-th look, and if so is done; all alpha_j sum up to alpha. It goes on sending.
The interval is for the ground that robots see: on a floor that is seen over and over, for its own share of black.

As in `commons`, a robot remembers what rounding took of the sums of the present stream, so that they bear single
precision.
"""

import math

STREAMS = 8
LONG = 30.0  # a block, in times in which the readings of a robot hang together
ERRORS = 2.0  # standard errors by which the measured correlation may be too small
LEAST = 1.0 / 64.0  # the variance of ground that seems to be all of one colour
MANY = 1048576.0  # the most rounds in the mean that measures it, for single precision
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
    "moved": 0.0,  # how often it has moved on, modulo eight
    "block": 1.0,  # the least rounds of a block
    "stayed": 0.0,  # the rounds of the present one
    "fresh_blacks": 0.0,  # readings since the last round that say black
    "fresh": 0.0,  # and all of them
    "last": 0.0,  # the share of black in those before, less its mean
    "pairs": 0.0,  # successive rounds with readings
    "product": 0.0,  # the mean product of their shares, less their mean: the covariance
    "left": 8.0,  # rounds until the next look
    "look": 0.0,  # j
    "looks": 0.0,  # own readings
    "voices": 0.0,  # the own and those heard, summed over rounds
    "rounds": 0.0,
    "sure": 0.0,  # 1: done
}
MESSAGE = ("s", "v")
ROLES = {"s": "information", "v": "confidence"}
SUMS = ("heard", "heard_s", "heard_v")


def stream(me):
    """The stream that the robot feeds."""
    return int((me.name + me.moved) % 8.0)


def observe(me, blacks, looks):
    """Add unbiased evidence to the present stream, weighted by how much the sensor tells."""
    slope = me.b + me.w - 1.0
    k = stream(me)
    s = slope * (blacks - looks * (1.0 - me.w))
    v = slope * slope * looks
    me.looks += looks
    me.fresh_blacks += blacks
    me.fresh += looks
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
    """Average all voices, move on at the end of a block, and look at the interval if it is time."""
    voices = 1.0 + me.heard
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
    me.voices += voices
    me.rounds += 1.0
    me.stayed += 1.0
    compare(me)
    r = alike(me)
    if me.stayed >= me.block and (1.0 - r) * me.stayed >= LONG * r:
        move_on(me)
    me.left -= 1.0
    if me.left == 0.0:
        me.left = me.rounds + 8.0
        me.look += 1.0
        if half(me, 4.0 * me.alpha / ((me.look + 3.0) * (me.look + 4.0))) <= me.within:
            me.sure = 1.0


def compare(me):
    """Learn how readings of successive rounds vary together."""
    if me.fresh <= 0.0:
        return
    now = me.fresh_blacks / me.fresh - ((me.b + me.w - 1.0) * estimate(me) + 1.0 - me.w)
    if me.looks > me.fresh:
        me.pairs += 1.0
        me.product += (now * me.last - me.product) / min(me.pairs, MANY)
    me.last = now
    me.fresh_blacks = 0.0
    me.fresh = 0.0


def alike(me):
    """The most that the ground of successive rounds may be correlated; 1 while that is not known."""
    slope = me.b + me.w - 1.0
    if me.pairs == 0.0 or slope == 0.0:
        return 1.0
    f = estimate(me)
    q = slope * f + 1.0 - me.w
    ground = max(f * (1.0 - f), LEAST)
    noise = q * (1.0 - q) * (me.pairs + 1.0) / (me.looks * slope * slope * ground)
    error = math.sqrt((noise * noise + 0.25 / ground) / min(me.pairs, MANY))
    return min(max(me.product / (slope * slope * ground) + ERRORS * error, 0.0), 1.0)


def move_on(me):
    """Feed the next stream."""
    me.moved += 1.0
    me.stayed = 0.0
    me.s_rest = 0.0
    me.v_rest = 0.0
    if me.moved == 8.0:
        me.moved = 0.0
        me.block *= 2.0


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
    squares = 0.0
    cubes = 0.0
    for k in range(STREAMS):
        h = me.v[k] / v
        apart = me.s[k] / v - s / v * h
        off += apart * apart
        squares += h * h
        cubes += h * h * h
    if squares > 0.99:  # nearly all evidence is in one stream
        return 1.0
    degrees = (1.0 - squares) * (1.0 - squares) / (squares - 2.0 * cubes + squares * squares)
    slope = math.sqrt(min(v / me.looks, 1.0))
    least = math.log(1.0 / alpha) * me.rounds / (me.looks * me.voices * slope)
    return max(quantile(alpha, max(degrees, 1.0)) * math.sqrt(off / (1.0 - squares)), least)


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
