"""Bayes Bots: each robot pools its own and its neighbours' observations in a Beta posterior, and decides once sure.

Ebert, Gauci, Mallmann-Trenn and Nagpal, "Bayes Bots", 2020; soft feedback as in arXiv 2404.08390. `I_x(a, b)` is the
Beta distribution function; a and b count black and white observations, and a0 is the prior's count of each colour.

    p      = I_0.5(a + a0, b + a0), the probability that f < 0.5
    decide   if undecided: white if p > threshold, black if p < 1 - threshold; a decision is final
    say      (value, number): value is the last observation C; with positive feedback the decision, once there is one;
             with soft feedback Bernoulli(d (1 - p) + (1 - d) C), d = exp(-1250 Var) (0.5 - p)^2, Var the posterior's
    hear     a value counts as an observation if its number is new for that sender

As published: the above, a0 = 10, threshold = 0.95, an observation every 20 s (200 rounds). Soft feedback is published
with a0 = 1, every = 10 and patience = 401. The estimate (a + a0) / (a + b + 2 a0) is ours.

Deviations:
- The message contains the sender's name, and numbers are remembered in 128 places, at the name modulo 128. A place
  whose observation is no longer sent is free for the next sender, in the same round for the lowest name; while it is
  taken, other robots with that place are not heard. Up to 128 robots are distinguished without loss.
- An observation is sent for `every` rounds and then no more, even if the next reading is late. So a free place never
  counts anything twice, if all robots have the same `every`. Values are clipped to [0, 1].
- An observation consists of all readings of its round: R on fixed networks, one if robots move. Its value is their
  share of black, and observations of others count as many readings as the robot's own last one. With one reading, this
  changes nothing; soft feedback rounds R times its probability up or down at random, which for R = 1 is the Bernoulli
  draw.
- The random number of soft feedback is drawn once per observation, not once per message.
- A program of the first author from 2018 ignores a known sender for 900 s. Here, as in the paper of 2020, each new
  observation of a sender counts.
- With `debiased` = 1, f < 0.5 is tested as "the share of black readings is below (b + 1 - w) / 2", and the estimate is
  clip((share + w - 1) / (b + w - 1), 0, 1), with the robot's own b and w for all observations.
"""

import math

PARAMETERS = {
    "feedback": 0.0,  # 0 off, 1 positive, 2 soft
    "prior": 10.0,  # a0
    "threshold": 0.95,  # how sure a decision is
    "every": 200.0,  # rounds from one observation to the next
    "patience": 0.0,  # the observations that are heard before a decision
    "debiased": 0.0,  # 1: corrected for the sensor
}
NEEDS = {
    "rounds": "2 * prior * every",  # a robot alone has then as many observations as its prior counts
    "perfect_sensors": "not debiased",
    "binary": "feedback",
}
MEMORY = {
    "black": 0.0,  # black observations, own and heard
    "white": 0.0,  # white observations
    "number": 0.0,  # of the last own observation
    "seen": 0.0,  # its black readings
    "size": 1.0,  # all its readings
    "fresh": 0.0,  # 1 if it was made in this round
    "wait": 0.0,  # rounds until the next observation
    "now": 0.0,  # completed rounds
    "heard": 0.0,  # observations of others that counted
    "news": 1.0,  # 1 if counts have changed since p was computed
    "p": 0.5,  # the probability that f < 0.5, as long as it is needed
    "pull": 0.0,  # d of soft feedback
    "lot": 0.5,  # a uniform number for the next message of soft feedback
    "decision": -1.0,
    "who": (-1.0,) * 128,  # per place: the name whose observation was counted last
    "last": (0.0,) * 128,  # its number
    "said": (0.0,) * 128,  # its value
    "when": (-1e9,) * 128,  # the round in which it was counted, less 0.5 if the place was free before
}
MESSAGE = ("value", "number", "name")
ROLES = {"value": "opinion", "name": "name"}

PLACES = 128
SOFT = 1250.0  # how fast soft feedback sets in as the posterior narrows
HALF_LOG_2PI = 0.9189385332046727


def observe(me, blacks, looks):
    """Use the readings of a round in which an observation is due, and no others."""
    if me.wait > 0.0:
        return
    if me.fresh == 0.0:
        me.fresh = 1.0
        me.number += 1.0
        me.seen = 0.0
        me.size = 0.0
    me.seen += blacks
    me.size += looks
    me.black += blacks
    me.white += looks - blacks
    me.news = 1.0


def broadcast(me):
    """The last observation, altered by feedback, for `every` rounds."""
    if me.fresh == 0.0 and me.wait <= 0.0:
        return None
    return value(me), me.number, me.name


def value(me):
    """The value that is sent for an observation."""
    if me.feedback == 1.0 and me.decision >= 0.0:
        return me.decision
    if me.feedback == 2.0:
        black = me.pull * (1.0 - me.p) * me.size + (1.0 - me.pull) * me.seen
        return min(math.floor(black + me.lot) / me.size, 1.0)
    return me.seen / me.size


def receive(me, message):
    """Count a new observation; of several for one place in a round, one that does not depend on their order."""
    told, number, name = message
    told = min(max(told, 0.0), 1.0)
    k = int(name) % PLACES
    age = me.now - me.when[k]
    if age < 1.0:  # one was counted in this round, and may be replaced
        newer = name == me.who[k] and (number, told) > (me.last[k], me.said[k])
        lower = age > 0.0 and name < me.who[k]
        if not (newer or lower):
            return
        count(me, me.said[k], -1.0)
    elif age >= math.ceil(me.every):
        me.when[k] = me.now - 0.5
    elif name == me.who[k] and number > me.last[k]:
        me.when[k] = me.now
    else:
        return
    me.who[k] = name
    me.last[k] = number
    me.said[k] = told
    count(me, told, 1.0)


def count(me, told, times):
    """Add an observation, or remove it again."""
    me.news = 1.0
    me.heard += times
    me.black += times * me.size * told
    me.white += times * me.size * (1.0 - told)


def fuse(me):
    """Update the probability, and decide if it is high enough."""
    if me.news > 0.0 and (me.decision < 0.0 or me.feedback == 2.0):
        me.news = 0.0
        a = me.black + me.prior
        b = me.white + me.prior
        me.p = below_half(me, a, b)
        me.pull = math.exp(-SOFT * variance(a, b)) * (0.5 - me.p) * (0.5 - me.p)
        if me.decision < 0.0 and me.heard >= me.patience:
            if me.p > me.threshold:
                me.decision = 0.0
            elif me.p < 1.0 - me.threshold:
                me.decision = 1.0
    me.now += 1.0
    if me.fresh > 0.0:
        me.fresh = 0.0
        me.wait = me.every
    if me.wait > 0.0:
        me.wait -= 1.0
    if me.wait <= 0.0:
        me.lot = me.luck


def below_half(me, a, b):
    """The probability that f < 0.5 under Beta(a, b), raw or corrected for the sensor."""
    if me.debiased == 0.0:
        return beta_below(0.5, a, b)
    slope = me.b + me.w - 1.0
    if abs(slope) < 1e-12:
        return 0.5
    p = beta_below((me.b + 1.0 - me.w) / 2.0, a, b)
    return p if slope > 0.0 else 1.0 - p


def variance(a, b):
    """The variance of Beta(a, b)."""
    total = a + b
    if total <= 0.0:
        return 1.0
    return a * b / (total * total * (total + 1.0))


def beta_below(x, a, b):
    """I_x(a, b), by the continued fraction on the side on which it converges fast."""
    if a <= 0.0 or b <= 0.0:  # no prior, and no observation of one colour
        return 0.5 if a == b else (1.0 if a < b else 0.0)
    total = a + b
    off = x * total - a if x < 0.5 else b - (1.0 - x) * total
    # logarithms of ratios near 1, because differences of lgamma lose nine digits at counts of a million
    log_front = a * log_above_one(off / a) + b * log_above_one(-off / b) + beyond(total) - beyond(a) - beyond(b)
    front = math.exp(log_front) * math.sqrt(a * b / (2.0 * math.pi * total))
    if x * (total + 2.0) < a + 1.0:
        return front * fraction(x, off, a, b) / a
    return 1.0 - front * fraction(1.0 - x, -off, b, a) / b


def log_above_one(x):
    """ln(1 + x), also for an x so small that 1 + x keeps few of its digits: the quotient takes the loss back."""
    y = 1.0 + x
    if y == 1.0:
        return x
    return math.log(y) * (x / (y - 1.0))


def beyond(z):
    """The difference between ln(gamma(z)) and Stirling's formula."""
    if z < 10.0:
        return math.lgamma(z) - (z - 0.5) * math.log(z) + z - HALF_LOG_2PI
    y = 1.0 / (z * z)
    return (1.0 / 12.0 - y * (1.0 / 360.0 - y * (1.0 / 1260.0 - y * (1.0 / 1680.0 - y / 1188.0)))) / z


def fraction(x, off, a, b):
    """The continued fraction of I_x(a, b), by Lentz's method, in about sqrt(a + b) steps."""
    c = 1.0
    d = (a + 1.0) / (1.0 - off)  # which is 1 / (1 - (a + b) x / (a + 1))
    f = d
    for m in range(1, 100_000):
        even = m * (b - m) * x / ((a + 2.0 * m - 1.0) * (a + 2.0 * m))
        d = 1.0 / (1.0 + even * d)
        c = 1.0 + even / c
        f *= c * d
        odd = -(a + m) * (a + b + m) * x / ((a + 2.0 * m) * (a + 2.0 * m + 1.0))
        d = 1.0 / (1.0 + odd * d)
        c = 1.0 + odd / c
        f *= c * d
        if abs(c * d - 1.0) < 1e-15:
            break
    return f


def estimate(me):
    """The posterior's mean."""
    total = me.black + me.white + 2.0 * me.prior
    if total <= 0.0:
        return 0.5
    share = min(max((me.black + me.prior) / total, 0.0), 1.0)
    if me.debiased == 0.0:
        return share
    slope = me.b + me.w - 1.0
    if abs(slope) < 1e-12:
        return 0.5
    return min(max((share + me.w - 1.0) / slope, 0.0), 1.0)


def decide(me):
    """White, black, or no decision yet."""
    return me.decision
