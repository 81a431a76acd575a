"""Belief sharing: each robot weighs ten fill ratios by its readings and by the belief of one neighbour at a time.

Shan and Mostaghim, discrete collective estimation by distributed Bayesian belief sharing (DBBS), 2020 to 2024. For the
hypotheses h = 0.05, 0.15 ... 0.95, a robot holds s, the evidence of its own readings, and n, what it has heard.

    reading    s *= h if black else 1 - h; normalised; at least 0.001 / 10
    each step  of one random neighbour j:  n = normalise(n^lambda s_j n_j^mu)
    say        s n^mu
    estimate   the mean of s n, the decision its largest

As published: the above, a step every second (10 rounds), lambda = 0.8 (0.7 in 2024), mu = 0.4. lambda is `forget` here.

Deviations:
- All robots step at once, with the messages of the step before; the source updates one robot after the other. They only
  speak in the first round after a step, because later messages would not be used.
- The readings of a step are multiplied into s together, and the lower bound of s is applied after them.
- All readings count, not only those of robots that go straight on.
- n is kept above 1e-30, and stays as it was if it and the message exclude each other; the source has logarithms.
- With `debiased` = 1, a reading is black with probability b h + (1 - w)(1 - h); if b + w = 1 it says nothing.
- If several hypotheses are equal to nine digits, the decision is for the lowest; if all are, there is none.
"""

import math

H = 10
OPTIONS = 10

PARAMETERS = {
    "forget": 0.8,  # lambda: the exponent of what was heard before
    "mu": 0.4,  # the exponent of what a neighbour has heard in its message
    "every": 10.0,  # rounds per step
    "least": 0.001,  # the lower bound of s, times the number of hypotheses
    "debiased": 0.0,  # 1: readings are corrected for the sensor
}
NEEDS = {"silent": "every", "steps": 10, "perfect_sensors": "not debiased"}
MEMORY = {
    "readings": 0.0,  # readings since the last step
    "black": 0.0,  # black ones among them
    "clock": 0.0,  # rounds since the last step
    "steps": 0.0,  # so far
    "heard": 0.0,  # messages since the last step
    "kept": (0.0,) * 10,  # one of them
    "s": (0.1,) * 10,  # evidence of the own readings
    "n": (0.1,) * 10,  # evidence heard
    "belief": (0.1,) * 10,  # what is sent
    "x": 0.5,  # the mean of s n
    "choice": -1.0,  # the largest of s n
}
MESSAGE = ("belief",)

TINY = 1e-30


def observe(me, blacks, looks):
    """Keep readings for the next step."""
    me.readings += looks
    me.black += blacks


def broadcast(me):
    """The belief, once per step."""
    if me.steps == 0.0 or me.clock > 0.0:
        return None
    return (me.belief,)


def receive(me, message):
    """Keep the k-th message of a step with probability 1/k, so that each is equally likely to be kept."""
    me.heard += 1.0
    if me.luck * me.heard < 1.0:
        for k in range(H):
            me.kept[k] = message[0][k]


def fuse(me):
    """The end of a round, and sometimes of a step."""
    me.clock += 1.0
    if me.clock < me.every:
        return
    if me.readings > 0.0:
        fold_readings(me)
    if me.heard > 0.0:
        fold_message(me)
    conclude(me)
    me.clock = 0.0
    me.steps += 1.0
    me.readings = 0.0
    me.black = 0.0
    me.heard = 0.0


def hypothesis(k):
    """The k-th fill ratio."""
    return (k + 0.5) / H


def fold_readings(me):
    """Update s by Bayes' rule, in logarithms, because many readings are unlikely under any hypothesis."""
    slope = me.b + me.w - 1.0
    if me.debiased == 1.0 and abs(slope) < 1e-12:
        return
    top = -1e300
    for k in range(H):
        black = hypothesis(k)
        if me.debiased == 1.0:
            black = me.b * black + (1.0 - me.w) * (1.0 - black)
        me.s[k] = math.log(me.s[k]) + me.black * math.log(black) + (me.readings - me.black) * math.log(1.0 - black)
        top = max(top, me.s[k])
    total = 0.0
    for k in range(H):
        me.s[k] = math.exp(me.s[k] - top)
        total += me.s[k]
    for k in range(H):
        me.s[k] = max(me.s[k] / total, me.least / H, TINY)


def fold_message(me):
    """Update n by the message of one neighbour."""
    total = 0.0
    for k in range(H):
        me.kept[k] = me.n[k] ** me.forget * max(me.kept[k], 0.0)
        total += me.kept[k]
    for k in range(H):
        if total > 0.0:
            me.n[k] = max(me.kept[k] / total, TINY)
        me.kept[k] = 0.0


def conclude(me):
    """Compute message, estimate and decision from s and n."""
    said = 0.0
    both = 0.0
    mean = 0.0
    best = 0
    least = me.s[0] * me.n[0]
    most = least
    for k in range(H):
        weight = me.s[k] * me.n[k]
        both += weight
        mean += weight * hypothesis(k)
        least = min(least, weight)
        if weight > most * (1.0 + 1e-9):
            most = weight
            best = k
        me.belief[k] = me.s[k] * me.n[k] ** me.mu
        said += me.belief[k]
    for k in range(H):
        me.belief[k] /= said
    me.x = min(max(mean / both, 0.0), 1.0)
    me.choice = best if most > least * (1.0 + 1e-9) else -1.0


def estimate(me):
    """The mean of the belief."""
    return me.x


def decide(me):
    """The most believed hypothesis, as the number of its bin."""
    return me.choice
