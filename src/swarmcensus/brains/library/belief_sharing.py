"""Belief sharing: each robot weighs ten fill ratios by its readings, and by the belief of one neighbour at a time.

Shan and Mostaghim, discrete collective estimation by distributed Bayesian belief sharing (DBBS), 2020 to 2024. Of the
hypotheses h = 0.05, 0.15 ... 0.95 a robot holds s, what its own readings say, and n, what it has heard.

    reading    s *= h if black else 1 - h; normalised; at least 0.001 / 10
    each step  of one random neighbour j:  n = normalise(n^lambda s_j n_j^mu)
    say        s n^mu
    estimate   the mean of s n, the decision its largest

As published: the above, a step every second (10 rounds), lambda = 0.8 (0.7 in 2024), mu = 0.4. lambda is `forget` here.

Deviations:
- All robots step at once, with what was said one step before (the source updates one robot after the other), and speak
  in the first round after a step alone: more is not listened to.
- The readings of a step are folded into s together, and the floor under s holds after them all.
- All readings count, not only those of robots that go straight on.
- n is kept above 1e-30, and as it was where that and the message exclude each other, where the source has logarithms.
- Noise-aware (`debiased` = 1), a reading is black with probability b h + (1 - w)(1 - h); if b + w = 1 it says nothing.
- Of hypotheses that are level, to nine digits, the lowest is decided for; while all are, none is.
"""

import math

H = 10
OPTIONS = 10

PARAMETERS = {
    "forget": 0.8,  # lambda: what is left of what was heard before
    "mu": 0.4,  # how much of what a neighbour has heard is told on
    "every": 10.0,  # rounds from step to step
    "least": 0.001,  # the floor under s, times H
    "debiased": 0.0,  # 1: noise-aware
}
MEMORY = {
    "readings": 0.0,  # readings since the last step
    "black": 0.0,  # of which said black
    "clock": 0.0,  # rounds since the last step
    "steps": 0.0,  # so far
    "heard": 0.0,  # messages since the last step
    "kept": (0.0,) * 10,  # one of them
    "s": (0.1,) * 10,  # what the own readings say
    "n": (0.1,) * 10,  # what was heard
    "belief": (0.1,) * 10,  # what is told
    "x": 0.5,  # the mean of both
    "choice": -1.0,  # the best of both
}
MESSAGE = ("belief",)

TINY = 1e-30


def observe(me, blacks, looks):
    """Readings are kept for the next step."""
    me.readings += looks
    me.black += blacks


def broadcast(me):
    """What is believed, once a step."""
    if me.steps == 0.0 or me.clock > 0.0:
        return None
    return (me.belief,)


def receive(me, message):
    """Keep the k-th message of a step with probability 1/k: each of them is then as likely to be kept."""
    me.heard += 1.0
    if me.luck * me.heard < 1.0:
        for k in range(H):
            me.kept[k] = message[0][k]


def fuse(me):
    """The end of a round, and at times of a step."""
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
    """s by Bayes' rule, in logarithms while it is formed: many readings are unlikely under any hypothesis."""
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
    """n, by what one neighbour said."""
    total = 0.0
    for k in range(H):
        me.kept[k] = me.n[k] ** me.forget * max(me.kept[k], 0.0)
        total += me.kept[k]
    for k in range(H):
        if total > 0.0:
            me.n[k] = max(me.kept[k] / total, TINY)
        me.kept[k] = 0.0


def conclude(me):
    """What to tell, to estimate and to decide, of s and n."""
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
    """The mean of all that is believed."""
    return me.x


def decide(me):
    """The hypothesis that is believed most, as the bin of which it is the middle."""
    return me.choice
