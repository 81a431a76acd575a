"""Robots correct their assumed sensor accuracy if their local estimate differs from their neighbours' (ASDF).

Chin and Pinciroli, arXiv 2410.21546. Local and informed estimates are those of Chin, Khaluf and Pinciroli,
"Minimalistic Collective Perception with Imperfect Sensors", Eqs. 4 to 8, repeated here because a brain is one file.
Every F rounds, a robot that heard m > 1 local estimates, with mean v and standard deviation sd, tests whether its own
differs from them:

    |v - x_hat| >= sd (T / sqrt(m) + 1),    T the quantile of Student's t, m degrees of freedom, upper tail (1 - p)/2

If so, it sets b = w to the accuracy that would explain its readings: clip((n/t + x_bar - 1)/(2 x_bar - 1), 1e-6,
1 - 1e-6). After that x_hat = x_bar, so its own evidence is overwritten; the exceptions are a clipped accuracy, and an
accuracy of 1/2, with which a sensor tells nothing.

As published: the test, the correction, the message. Deviations: m, v and sd are those of the last round with messages;
each message counts once, and sd uses m - 1. T is not computed: the test holds if the probability of a smaller |t| than
sqrt(m) (|v - x_hat|/sd - 1) is p or more, and that probability is a finite sum (Abramowitz and Stegun, 26.7.3 and
26.7.4). Nothing is corrected at x_bar = 1/2, where the correction divides by 0, or without readings. F and p are the
first values of the paper's grids.
"""

import math

LEAST = 1e-6  # a corrected accuracy, and its distance from 1

PARAMETERS = {
    "every": 1000.0,  # F, rounds between two tests
    "p": 0.05,  # the probability inside the quantile
}
MEMORY = {
    "t": 0.0,  # observations made
    "n": 0.0,  # black ones among them
    "mended": 0.0,  # the number of corrections
    "accuracy": 0.5,  # b = w, once corrected
    "x_hat": 0.5,  # local estimate
    "alpha": 0.0,  # local confidence
    "x_bar": 0.5,  # social estimate
    "beta": 0.0,  # social confidence
    "x": 0.5,  # informed estimate
    "rounds": 0.0,  # since the last test
    "m": 0.0,  # the number of local estimates heard in the last round with messages
    "mean": 0.5,  # their mean
    "variance": 0.0,  # their variance
    "heard": 0.0,  # messages since the last round
    "heard_alpha": 0.0,  # the sum of their confidences
    "heard_x": 0.0,  # the sum of their estimates, each times its confidence
    "heard_off": 0.0,  # the sum of their estimates, each minus 1/2
    "heard_squares": 0.0,  # the sum of the squares of these differences
}
MESSAGE = ("x_hat", "alpha")
SUMS = ("heard", "heard_alpha", "heard_x", "heard_off", "heard_squares")


def observe(me, blacks, looks):
    """Count readings, and estimate."""
    me.t += looks
    me.n += blacks
    estimate_alone(me)


def estimate_alone(me):
    """Local estimate (Eq. 4) and its Fisher information (Eq. 5), with the believed accuracies."""
    t = me.t
    n = me.n
    b = me.b
    w = me.w
    if me.mended > 0.0:
        b = me.accuracy
        w = me.accuracy
    slope = b + w - 1.0  # how much more often black tiles read black than white tiles do
    if t == 0.0 or abs(slope) < 1e-12:  # no reading, or a sensor that tells nothing
        me.x_hat = 0.5
        me.alpha = 0.0
        return
    q = slope * slope
    low = (1.0 - w) * t  # expected black readings on an all-white floor
    high = b * t  # and on an all-black one
    if slope > 0.0:
        white = n <= low
        black = n >= high
    else:
        white = n >= low
        black = n <= high
    if white:  # Eqs. 4 and 5, first case, in a form that is defined at w = 1 too
        me.x_hat = 0.0
        me.alpha = q * (share(n, (1.0 - w) * (1.0 - w)) + share(t - n, w * w))
    elif black:  # third case, likewise at b = 1
        me.x_hat = 1.0
        me.alpha = q * (share(n, b * b) + share(t - n, (1.0 - b) * (1.0 - b)))
    else:
        me.x_hat = min(max((n / t + w - 1.0) / slope, 0.0), 1.0)  # rounding may exceed [0, 1]
        me.alpha = q * t * t * t / (n * (t - n))


def share(count, variance):
    """The confidence from `count` readings of one colour; 0 without readings."""
    if count == 0.0:
        return 0.0
    return count / variance


def broadcast(me):
    """The local values."""
    return me.x_hat, me.alpha


def receive(me, message):
    """One neighbour's term of the sums in Eqs. 7 and 8, and of the plain mean and variance."""
    x_hat, alpha = message
    me.heard += 1.0
    me.heard_alpha += alpha
    me.heard_x += alpha * x_hat
    me.heard_off += x_hat - 0.5
    me.heard_squares += (x_hat - 0.5) * (x_hat - 0.5)


def fuse(me):
    """Social estimate (Eqs. 7 and 8) and informed estimate (Eq. 6); then, every F rounds, the test."""
    if me.heard > 0.0:  # without neighbours, the last social values stay
        me.beta = me.heard_alpha
        if me.beta > 0.0:
            me.x_bar = me.heard_x / me.beta
        keep_spread(me)
        me.heard = 0.0
        me.heard_alpha = 0.0
        me.heard_x = 0.0
        me.heard_off = 0.0
        me.heard_squares = 0.0
    total = me.alpha + me.beta
    if total > 0.0:
        me.x = (me.alpha * me.x_hat + me.beta * me.x_bar) / total
    me.rounds += 1.0
    if me.rounds >= me.every:
        me.rounds = 0.0
        if is_apart(me):
            mend(me)


def keep_spread(me):
    """Keep the number, mean and variance of the local estimates heard."""
    me.m = me.heard
    me.mean = 0.5 + me.heard_off / me.m
    me.variance = 0.0
    if me.m > 1.0:
        me.variance = max(me.heard_squares - me.heard_off * me.heard_off / me.m, 0.0) / (me.m - 1.0)


def is_apart(me):
    """Whether the own local estimate differs from those heard."""
    if me.m <= 1.0:
        return False
    sd = math.sqrt(me.variance)
    off = abs(me.mean - me.x_hat)
    if off < sd:
        return False
    if sd < 1e-9:  # all are equal
        return True
    return within(math.sqrt(me.m) * (off / sd - 1.0), me.m) >= me.p


def within(t, m):
    """The probability that Student's t with m degrees of freedom, a whole number, is within [-t, t]."""
    square = m / (m + t * t)  # the squared cosine of the angle atan(t / sqrt(m))
    sine = t / math.sqrt(m + t * t)
    odd = m % 2.0
    k = 1.0 + odd
    term = math.sqrt(square) if odd > 0.0 else 1.0
    total = 0.0
    while k < m and term > 1e-17:
        total += term
        term *= square * k / (k + 1.0)
        k += 2.0
    if odd > 0.0:
        return (math.atan(t / math.sqrt(m)) + sine * total) * 2.0 / math.pi
    return sine * total


def mend(me):
    """Set b = w so that the own readings give x_bar."""
    slope = 2.0 * me.x_bar - 1.0
    if me.t == 0.0 or abs(slope) < 1e-12:
        return
    me.accuracy = min(max((me.n / me.t + me.x_bar - 1.0) / slope, LEAST), 1.0 - LEAST)
    me.mended += 1.0
    estimate_alone(me)


def estimate(me):
    """The informed estimate."""
    return me.x
