"""Bayes Bots on a floor that may change: evidence is limited, doubt resets, or changes are detected and announced.

Pfister and Hamann, 2022 and 2023, after the Bayes Bots of Ebert, Gauci, Mallmann-Trenn and Nagpal, 2020, whose
functions are repeated here because a brain is one file. `I_x(a, b)` is the Beta distribution function, and a0 the
prior's count of each colour.

    p      = I_0.5(a + a0, b + a0), the probability that f < 0.5
    decide   if undecided: white if p > threshold, black if p < 1 - threshold
    2022     limit: while one side has a probability above 0.99, no more evidence for it is counted
             doubt: a robot whose decision has a probability below 0.55 returns to the prior, undecided
    2023     a robot that detects a change in its own observations returns to the prior, undecided, and announces the
             change for 50 s; a robot that hears this from three distinct robots returns to the prior too

As published: the above, a0 = 10, threshold = 0.95, an observation every 20 s (200 rounds). The estimate
(a + a0) / (a + b + 2 a0) is ours.

Deviations:
- The detector is a CUSUM in place of PELT, whose memory would grow. With z the share of black of an observation and m
  that of all earlier ones since the last change, up = max(0, up + z - m - slack), down = max(0, down + m - z - slack),
  from the eleventh observation on; there is an alarm if up or down is above `alarm`. It uses raw readings in any case.
- `detect` = 1 adds detection to limit and doubt; `limit` = 2 and `doubt` = 0 switch those off.
- The limit is checked once a round: all evidence of a round is counted or not by the state at the end of the last one.
- A robot that resets because of others does not announce it, and ignores announcements for 50 s after a change, so that
  a wave of resets ends. Of the announcing robots the three lowest names are kept, until 50 s after the first.
- Feedback (`feedback` = 1: decided robots send their decision) is off, because a swarm that repeats itself sees no
  change.
- As in `bayes-bots`: names are sent, and remembered in 128 places; an observation is sent for `every` rounds; it
  consists of all readings of its round; `debiased` = 1 corrects for the robot's own sensor.
"""

import math

PARAMETERS = {
    "detect": 0.0,  # 1: changes are detected
    "doubt": 0.55,  # a decision with a lower probability is dropped
    "limit": 0.99,  # a side with a higher probability gets no more evidence
    "slack": 0.1,  # of the detector: differences that are ignored
    "alarm": 4.0,  # of the detector: the sum of differences beyond the slack that is a change
    "tell": 500.0,  # rounds for which a change is announced
    "feedback": 0.0,  # 1: decisions are sent in place of observations
    "prior": 10.0,  # a0
    "threshold": 0.95,  # how sure a decision is
    "every": 200.0,  # rounds from one observation to the next
    "debiased": 0.0,  # 1: corrected for the sensor
}
NEEDS = {
    "rounds": "2 * prior * every",  # a robot alone has then as many observations as its prior counts
    "perfect_sensors": "not debiased",
    "binary": "feedback + (not limit // 1)",  # with a limit below 1, evidence stops where it is met
}
MEMORY = {
    "black": 0.0,  # black observations, own and heard, since the last reset
    "white": 0.0,  # white observations
    "full": -1.0,  # the colour for which no more evidence is counted
    "number": 0.0,  # of the last own observation
    "seen": 0.0,  # its black readings
    "size": 1.0,  # all its readings
    "fresh": 0.0,  # 1 if it was made in this round
    "wait": 0.0,  # rounds until the next observation
    "now": 0.0,  # completed rounds
    "news": 1.0,  # 1 if counts have changed since p was computed
    "p": 0.5,  # the probability that f < 0.5
    "decision": -1.0,
    "t": 0.0,  # own observations since the last change
    "n": 0.0,  # the sum of their shares of black
    "up": 0.0,  # the detector's two sums
    "down": 0.0,
    "telling": 0.0,  # remaining rounds of announcing a change
    "deaf": 0.0,  # remaining rounds of ignoring announcements
    "tellers": (1e30,) * 3,  # the lowest names that announced a change, rising
    "since": 0.0,  # rounds since the first of them
    "who": (-1.0,) * 128,  # per place: the name whose observation was counted last
    "last": (0.0,) * 128,  # its number
    "said": (0.0,) * 128,  # its value
    "when": (-1e9,) * 128,  # the round in which it was counted, less 0.5 if the place was free before
}
MESSAGE = ("value", "number", "name", "changed")
ROLES = {"value": "opinion", "name": "name"}

PLACES = 128
ENOUGH = 3  # robots that announce a change
NOBODY = 1e30
EARLY = 10.0  # observations before the detector looks
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
    count(me, blacks, looks - blacks)


def count(me, blacks, whites):
    """Add evidence, or remove it again, except for a side that has enough."""
    me.news = 1.0
    if me.full != 1.0:
        me.black += blacks
    if me.full != 0.0:
        me.white += whites


def broadcast(me):
    """The last observation, or with feedback the decision, and whether a change is announced, for `every` rounds."""
    if me.fresh == 0.0 and me.wait <= 0.0:
        return None
    changed = 1.0 if me.telling > 0.0 else 0.0
    if me.feedback == 1.0 and me.decision >= 0.0:
        return me.decision, me.number, me.name, changed
    return me.seen / me.size, me.number, me.name, changed


def receive(me, message):
    """Count a new observation; of several for one place in a round, one that does not depend on their order."""
    told, number, name, changed = message
    told = min(max(told, 0.0), 1.0)
    if changed > 0.0 and me.detect == 1.0 and me.deaf <= 0.0:
        note(me, name)
    k = int(name) % PLACES
    age = me.now - me.when[k]
    if age < 1.0:  # one was counted in this round, and may be replaced
        newer = name == me.who[k] and (number, told) > (me.last[k], me.said[k])
        lower = age > 0.0 and name < me.who[k]
        if not (newer or lower):
            return
        count(me, -me.size * me.said[k], -me.size * (1.0 - me.said[k]))
    elif age >= math.ceil(me.every):
        me.when[k] = me.now - 0.5
    elif name == me.who[k] and number > me.last[k]:
        me.when[k] = me.now
    else:
        return
    me.who[k] = name
    me.last[k] = number
    me.said[k] = told
    count(me, me.size * told, me.size * (1.0 - told))


def note(me, name):
    """Keep the lowest distinct names, in order."""
    for k in range(ENOUGH):
        if name == me.tellers[k]:
            return
        if name < me.tellers[k]:
            higher = me.tellers[k]
            me.tellers[k] = name
            name = higher


def fuse(me):
    """React to a change, detected or announced, or else update the decision."""
    detected = me.detect == 1.0 and me.fresh > 0.0 and detects(me)
    if detected or me.tellers[ENOUGH - 1] < NOBODY:
        reset(me)
        forget_tellers(me)
        me.t = 0.0
        me.n = 0.0
        me.up = 0.0
        me.down = 0.0
        me.deaf = me.tell + 1.0
        if detected:
            me.telling = me.tell + 1.0
    elif me.news > 0.0:
        weigh(me)
    pass_time(me)


def detects(me):
    """Compare the new observation with the mean of the earlier ones."""
    z = me.seen / me.size
    if me.t >= EARLY:
        off = z - me.n / me.t
        me.up = max(0.0, me.up + off - me.slack)
        me.down = max(0.0, me.down - off - me.slack)
    me.t += 1.0
    me.n += z
    return max(me.up, me.down) > me.alarm


def reset(me):
    """Return to the prior, undecided."""
    me.black = 0.0
    me.white = 0.0
    me.full = -1.0
    me.decision = -1.0
    me.p = 0.5
    me.news = 1.0


def weigh(me):
    """Update the probability: decide, drop the decision, or count no more for one side."""
    me.news = 0.0
    me.p = below_half(me, me.black + me.prior, me.white + me.prior)
    if me.decision < 0.0:
        if me.p > me.threshold:
            me.decision = 0.0
        elif me.p < 1.0 - me.threshold:
            me.decision = 1.0
    elif (me.p if me.decision == 0.0 else 1.0 - me.p) < me.doubt:
        reset(me)
    me.full = -1.0
    if max(me.p, 1.0 - me.p) >= me.limit:
        white = me.p > 0.5
        lies = me.debiased == 1.0 and me.b + me.w < 1.0  # black readings then suggest white
        me.full = 1.0 if white == lies else 0.0


def pass_time(me):
    """Count rounds."""
    me.now += 1.0
    if me.fresh > 0.0:
        me.fresh = 0.0
        me.wait = me.every
    me.wait = max(me.wait - 1.0, 0.0)
    me.telling = max(me.telling - 1.0, 0.0)
    me.deaf = max(me.deaf - 1.0, 0.0)
    if me.tellers[0] < NOBODY:
        me.since += 1.0
        if me.since >= me.tell:
            forget_tellers(me)


def forget_tellers(me):
    """Forget all announcements."""
    me.since = 0.0
    for k in range(ENOUGH):
        me.tellers[k] = NOBODY


def below_half(me, a, b):
    """The probability that f < 0.5 under Beta(a, b), raw or corrected for the sensor."""
    if me.debiased == 0.0:
        return beta_below(0.5, a, b)
    slope = me.b + me.w - 1.0
    if abs(slope) < 1e-12:
        return 0.5
    p = beta_below((me.b + 1.0 - me.w) / 2.0, a, b)
    return p if slope > 0.0 else 1.0 - p


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
