"""Bayes Bots on a floor that may change: evidence is limited, doubt resets, or a change is detected and told.

Pfister and Hamann, 2022 and 2023, after the Bayes Bots of Ebert, Gauci, Mallmann-Trenn and Nagpal, 2020, whose
functions stand here again because a brain is one file. `I_x(a, b)` is the Beta distribution function, a0 the prior's
count of either colour.

    p      = I_0.5(a + a0, b + a0), the probability that f < 0.5
    decide   undecided: white where p > threshold, black where p < 1 - threshold
    2022     limit: once one side is believed with 0.99, nothing more is counted for it, until it is believed less
             doubt: who believes the own decision with less than 0.55 goes back to the prior, undecided
    2023     who detects a change in the own observations goes back to the prior, undecided, and tells so for 50 s;
             who hears three distinct robots tell so goes back too

As published: the above, a0 = 10, threshold = 0.95, an observation every 20 s (200 rounds). The estimate
(a + a0) / (a + b + 2 a0) is ours.

Deviations:
- The detector is a CUSUM in place of PELT, whose memory would grow: with z the share of black of an observation and m
  that of all earlier ones since the last change, up = max(0, up + z - m - slack), down = max(0, down + m - z - slack),
  from the eleventh observation on; an alarm is up or down above `alarm`. It sees raw readings, de-biased or not.
- `detect` = 1 adds detection to limit and doubt; `limit` = 2 and `doubt` = 0 switch those off.
- The limit is looked at once a round: what one round brings is counted or not as the last one ended.
- Who goes back because of others does not tell, and nobody listens to tellers for 50 s after a change, so that a wave
  ends. Of tellers the three lowest names are kept, until 50 s after the first.
- Feedback (`feedback` = 1: decided robots tell their decision) is off, as a swarm that repeats itself sees no change.
- As in `bayes-bots`: names are told, and remembered in 128 places; an observation is on the air for `every` rounds; it
  is all the readings of its round; `debiased` = 1 corrects for the own sensor.
"""

import math

PARAMETERS = {
    "detect": 0.0,  # 1: changes are detected
    "doubt": 0.55,  # a decision that is believed less is dropped
    "limit": 0.99,  # a side that is believed so much gets no more evidence
    "slack": 0.1,  # of the detector: what is no change
    "alarm": 4.0,  # of the detector: how much beyond the slack is a change, in observations
    "tell": 500.0,  # rounds for which a change is told
    "feedback": 0.0,  # 1: decisions are told in place of observations
    "prior": 10.0,  # a0
    "threshold": 0.95,  # how sure a decision is
    "every": 200.0,  # rounds from one observation to the next
    "debiased": 0.0,  # 1: corrected for the sensor
}
MEMORY = {
    "black": 0.0,  # black observations, own and heard, since the last reset
    "white": 0.0,  # white ones
    "full": -1.0,  # the colour for which no more is counted
    "number": 0.0,  # of the last own observation
    "seen": 0.0,  # its black readings
    "size": 1.0,  # all its readings
    "fresh": 0.0,  # 1 if it was made in this round
    "wait": 0.0,  # rounds until the next is due
    "now": 0.0,  # rounds lived
    "news": 1.0,  # 1 if counts are not as p knows them
    "p": 0.5,  # the probability that f < 0.5
    "decision": -1.0,
    "t": 0.0,  # own observations since the last change
    "n": 0.0,  # the sum of their shares of black
    "up": 0.0,  # the detector's two sums
    "down": 0.0,
    "telling": 0.0,  # rounds for which a change is still told
    "deaf": 0.0,  # rounds for which tellers are not listened to
    "tellers": (1e30,) * 3,  # the lowest names that told a change, in order
    "since": 0.0,  # rounds since the first of them did
    "who": (-1.0,) * 128,  # by place: whose observation was counted last
    "last": (0.0,) * 128,  # its number
    "said": (0.0,) * 128,  # its value
    "when": (-1e9,) * 128,  # the round in which it was counted, less 0.5 if the place was free before
}
MESSAGE = ("value", "number", "name", "changed")
ROLES = {"value": "opinion", "name": "name"}

PLACES = 128
ENOUGH = 3  # tellers
NOBODY = 1e30
EARLY = 10.0  # observations before the detector looks
HALF_LOG_2PI = 0.9189385332046727


def observe(me, blacks, looks):
    """Readings of a round in which an observation is due: other readings are not used."""
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
    """Add evidence, or take it off again, but for a side that has enough."""
    me.news = 1.0
    if me.full != 1.0:
        me.black += blacks
    if me.full != 0.0:
        me.white += whites


def broadcast(me):
    """The last observation, or the decision with feedback, and whether a change was detected, while on the air."""
    if me.fresh == 0.0 and me.wait <= 0.0:
        return None
    changed = 1.0 if me.telling > 0.0 else 0.0
    if me.feedback == 1.0 and me.decision >= 0.0:
        return me.decision, me.number, me.name, changed
    return me.seen / me.size, me.number, me.name, changed


def receive(me, message):
    """Count an observation that is new; of several for one place in a round the best, so that order means nothing."""
    told, number, name, changed = message
    told = min(max(told, 0.0), 1.0)
    if changed > 0.0 and me.detect == 1.0 and me.deaf <= 0.0:
        note(me, name)
    k = int(name) % PLACES
    age = me.now - me.when[k]
    if age < 1.0:  # one was counted in this round: it may give way
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
    """A change, own or told, or else what the evidence says."""
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
    """Hold the new observation against the mean of those before."""
    z = me.seen / me.size
    if me.t >= EARLY:
        off = z - me.n / me.t
        me.up = max(0.0, me.up + off - me.slack)
        me.down = max(0.0, me.down - off - me.slack)
    me.t += 1.0
    me.n += z
    return max(me.up, me.down) > me.alarm


def reset(me):
    """Back to the prior, undecided."""
    me.black = 0.0
    me.white = 0.0
    me.full = -1.0
    me.decision = -1.0
    me.p = 0.5
    me.news = 1.0


def weigh(me):
    """How sure the robot is: enough to decide, too little to stay decided, or so much that one side is full."""
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
        lies = me.debiased == 1.0 and me.b + me.w < 1.0  # black readings then speak for white
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
    """None has told a change."""
    me.since = 0.0
    for k in range(ENOUGH):
        me.tellers[k] = NOBODY


def below_half(me, a, b):
    """The probability that f < 0.5 under Beta(a, b), raw or of the share of black readings."""
    if me.debiased == 0.0:
        return beta_below(0.5, a, b)
    slope = me.b + me.w - 1.0
    if abs(slope) < 1e-12:
        return 0.5
    p = beta_below((me.b + 1.0 - me.w) / 2.0, a, b)
    return p if slope > 0.0 else 1.0 - p


def beta_below(x, a, b):
    """I_x(a, b), by its continued fraction on the side where that converges fast."""
    if a <= 0.0 or b <= 0.0:  # no prior, and one colour never seen
        return 0.5 if a == b else (1.0 if a < b else 0.0)
    total = a + b
    off = x * total - a if x < 0.5 else b - (1.0 - x) * total
    # logarithms of ratios near 1: differences of lgamma lose nine digits at counts of a million
    log_front = a * math.log1p(off / a) + b * math.log1p(-off / b) + beyond(total) - beyond(a) - beyond(b)
    front = math.exp(log_front) * math.sqrt(a * b / (2.0 * math.pi * total))
    if x * (total + 2.0) < a + 1.0:
        return front * fraction(x, off, a, b) / a
    return 1.0 - front * fraction(1.0 - x, -off, b, a) / b


def beyond(z):
    """What ln(gamma(z)) is beyond Stirling's formula."""
    if z < 10.0:
        return math.lgamma(z) - (z - 0.5) * math.log(z) + z - HALF_LOG_2PI
    y = 1.0 / (z * z)
    return (1.0 / 12.0 - y * (1.0 / 360.0 - y * (1.0 / 1260.0 - y * (1.0 / 1680.0 - y / 1188.0)))) / z


def fraction(x, off, a, b):
    """The continued fraction of I_x(a, b), by Lentz's method: about the root of the counts in steps."""
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
    """White, black, or none yet."""
    return me.decision
