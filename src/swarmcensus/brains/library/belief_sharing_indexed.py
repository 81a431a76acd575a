"""Belief sharing by a single number: a neighbour only says which of ten fill ratios it believes most.

This is our own proposal, to measure what the ten numbers of `belief-sharing` are worth. The rest is as in Shan
and Mostaghim's distributed Bayesian belief sharing (DBBS), whose functions are repeated here because a brain is one
file.

    reading    s *= h if black else 1 - h; normalised; at least 0.001 / 10
    each step  of one random neighbour's best i:  n_k = normalise(n_k^lambda exp(-(h_k - h_i)^2 / (2 width^2)))
    say        the k of the largest s_k n_k
    estimate   the mean of s n, the decision its largest

Deviations from belief-sharing, and from Shan's indexed form:
- A Gaussian replaces the neighbour's belief. Its width is that of two hypotheses, about as accurately
  as a neighbour knows the best one.
- Shan's own indexed belief sharing skips neighbours that were heard lately. Robots have no names here, and any
  neighbour may be heard in any step.
- A robot for which all hypotheses are equal is silent. There is no mu.
"""

import math

H = 10
OPTIONS = 10

PARAMETERS = {
    "forget": 0.8,  # lambda: the exponent of what was heard before
    "width": 0.2,  # the assumed error of a neighbour's best, as a fill ratio
    "every": 10.0,  # rounds per step
    "least": 0.001,  # the lower bound of s, times the number of hypotheses
    "debiased": 0.0,  # 1: readings are corrected for the sensor
}
NEEDS = {"silent": "every", "steps": 10, "perfect_sensors": "not debiased"}
MEMORY = {
    "readings": 0.0,  # readings since the last step
    "black": 0.0,  # black ones among them
    "clock": 0.0,  # rounds since the last step
    "heard": 0.0,  # messages since the last step
    "kept": 0.0,  # one of them
    "s": (0.1,) * 10,  # evidence of the own readings
    "n": (0.1,) * 10,  # evidence heard
    "x": 0.5,  # the mean of s n
    "choice": -1.0,  # the largest of s n
}
MESSAGE = ("option",)

TINY = 1e-30


def observe(me, blacks, looks):
    """Keep readings for the next step."""
    me.readings += looks
    me.black += blacks


def broadcast(me):
    """The most believed hypothesis, once per step."""
    if me.choice < 0.0 or me.clock > 0.0:
        return None
    return (me.choice,)


def receive(me, message):
    """Keep the k-th message of a step with probability 1/k, so that each is equally likely to be kept."""
    me.heard += 1.0
    if me.luck * me.heard < 1.0:
        me.kept = message[0]


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
    me.readings = 0.0
    me.black = 0.0
    me.heard = 0.0
    me.kept = 0.0


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
    """Update n by the best hypothesis of one neighbour."""
    total = 0.0
    for k in range(H):
        off = (hypothesis(k) - hypothesis(me.kept)) / me.width
        me.n[k] = max(me.n[k] ** me.forget * math.exp(-0.5 * off * off), TINY)
        total += me.n[k]
    for k in range(H):
        me.n[k] = max(me.n[k] / total, TINY)


def conclude(me):
    """Compute estimate and decision from s and n."""
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
    me.x = min(max(mean / both, 0.0), 1.0)
    me.choice = best if most > least * (1.0 + 1e-9) else -1.0


def estimate(me):
    """The mean of the belief."""
    return me.x


def decide(me):
    """The most believed hypothesis, as the number of its bin."""
    return me.choice
