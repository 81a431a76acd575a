"""Robots whose sensors degrade estimate their accuracy by a Kalman filter on the swarm's consensus (BayesCPF).

arXiv 2504.04774. Local and informed estimates are those of Chin, Khaluf and Pinciroli, "Minimalistic Collective
Perception with Imperfect Sensors", Eqs. 4 to 8, repeated here because a brain is one file. A robot's belief about its
accuracy b = w is normal, with mean mu and variance P. Every T rounds, with n of the last m readings black and an older
consensus x':

    predict    mu += T B,  P += T R
    correct    p = x' mu + (1 - x')(1 - mu),  C = m (2 x' - 1),  K = P C / (C^2 P + m p (1 - p))
               mu += K (n - m p),  P = (1 - K C) P,   only if m mu >= 5 and m (1 - mu) >= 5

As published: these equations, T, R, the first P, and B; of its three published values, 1e-5 per tick is the middle one.
Deviations, because the original keeps two windows of its past and a brain has fixed memory: n and m lose a share of
1/window at each reading. x' is not a mean of up to 1,000 past informed estimates with the largest weight on the oldest,
but a running mean of a running mean, each a plain mean for the first 333 updates. In the end an estimate of age k has
weight k l^k, and the mean age is the same two thirds of 1,000. The length of the window was not found: here it is 1,000
readings. mu is kept within [0, 1], and the believed accuracy within [1/2, 1]: a robot whose sensor is wrong more often
than right gives its readings no weight once it learns. If the assumed b and w differ, the filter begins at their mean.
At x' = 1/2, C is 0 and nothing is learnt. The variance of exponentially forgotten readings is half of m p (1 - p), and
each update uses readings again; both are treated as in a window.

Limit of the published filter: B must be the true drift. The consensus is made with the believed accuracies, so where
all robots have the same mu, right or wrong, p tends to the share of black readings, n - m p to 0, and mu follows B
alone. If sensors do not degrade, `drift` should be 0: with the default, 20 robots with b = w = 0.8 on a ring at f =
0.55 err by 0.03 after 20,000 readings, 0.1 after 50,000 and 0.43 after 100,000; with 0, by about 0.01 throughout.
"""

import math

LEAST = 5.0  # black and white readings from which a count is nearly normal
FORGOTTEN = 1e-9  # the share of readings below which those of a colour are forgotten
LEVEL = 1e-12  # the probability of [1/2, 1] below which its nearer end is used

PARAMETERS = {
    "every": 5.0,  # T, rounds between two updates
    "drift": -1e-5,  # B, of the accuracy in a round
    "noise": 1e-8,  # R, variance of the drift in a round
    "doubt": 1e-4,  # P before the first reading
    "window": 1000.0,  # readings that count
    "past": 333.0,  # updates: the length of each of two running means of the informed estimate
    "truncated": 0.0,  # 1: the believed accuracy is the mean of the normal truncated to [1/2, 1], not mu
}
NEEDS = {"equal_sensors": 1}
MEMORY = {
    "t": 0.0,  # m: observations, with less weight for older ones
    "n": 0.0,  # black ones among them
    "mu": 0.5,  # the accuracy, once learnt
    "variance": -1.0,  # P; below 0 until learnt
    "updates": 0.0,  # so far
    "recent": 0.5,  # a running mean of the informed estimate
    "past_x": 0.5,  # x': a running mean of `recent`
    "x_hat": 0.5,  # local estimate
    "alpha": 0.0,  # local confidence
    "x_bar": 0.5,  # social estimate
    "beta": 0.0,  # social confidence
    "x": 0.5,  # informed estimate
    "rounds": 0.0,  # since the last update
    "heard": 0.0,  # messages since the last round
    "heard_alpha": 0.0,  # the sum of their confidences
    "heard_x": 0.0,  # the sum of their estimates, each times its confidence
}
MESSAGE = ("x_hat", "alpha")
SUMS = ("heard", "heard_alpha", "heard_x")


def observe(me, blacks, looks):
    """Count readings, forget, and estimate."""
    share = 1.0 / max(me.window, 1.0)
    keep = (1.0 - share) ** looks
    fresh = (1.0 - keep) / share  # the weight of `looks` readings after the last of them
    me.t = keep * me.t + fresh
    me.n = keep * me.n + fresh * (blacks / looks)
    if me.n < FORGOTTEN * me.t:  # the last black, or white, reading is forgotten
        me.n = 0.0
    elif me.t - me.n < FORGOTTEN * me.t:
        me.n = me.t
    estimate_alone(me)


def believed(me):
    """The believed accuracy b = w."""
    if me.variance < 0.0:  # nothing is learnt yet
        return 0.5 * (me.b + me.w)
    if me.truncated == 0.0 or me.variance == 0.0:
        return min(max(me.mu, 0.5), 1.0)
    sd = math.sqrt(2.0 * me.variance)
    low = (0.5 - me.mu) / sd
    high = (1.0 - me.mu) / sd
    likely = 0.5 * (math.erf(high) - math.erf(low))
    if likely < LEVEL:
        return min(max(me.mu, 0.5), 1.0)
    moved = math.exp(-low * low) - math.exp(-high * high)
    return min(max(me.mu + 0.5 * sd / math.sqrt(math.pi) * moved / likely, 0.5), 1.0)


def estimate_alone(me):
    """Local estimate (Eq. 4) and its Fisher information (Eq. 5), with the believed accuracies."""
    t = me.t
    n = me.n
    b = me.b
    w = me.w
    if me.variance >= 0.0:
        b = believed(me)
        w = b
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
    """One neighbour's term of the sums in Eqs. 7 and 8."""
    x_hat, alpha = message
    me.heard += 1.0
    me.heard_alpha += alpha
    me.heard_x += alpha * x_hat


def fuse(me):
    """Social estimate (Eqs. 7 and 8) and informed estimate (Eq. 6); then, every T rounds, the filter."""
    if me.heard > 0.0:  # without neighbours, the last social values stay
        me.beta = me.heard_alpha
        if me.beta > 0.0:
            me.x_bar = me.heard_x / me.beta
        me.heard = 0.0
        me.heard_alpha = 0.0
        me.heard_x = 0.0
    total = me.alpha + me.beta
    if total > 0.0:
        me.x = (me.alpha * me.x_hat + me.beta * me.x_bar) / total
    me.rounds += 1.0
    if me.rounds >= me.every:
        me.rounds = 0.0
        remember(me)
        learn(me)
        estimate_alone(me)


def remember(me):
    """An older consensus: a running mean of a running mean, in which the latest estimates count least.

    Plain means at first: what the first few readings said would else be remembered for too long, and believed.
    """
    me.updates += 1.0
    share = 1.0 / min(me.updates, max(me.past, 1.0))
    me.recent += share * (me.x - me.recent)
    me.past_x += share * (me.recent - me.past_x)


def learn(me):
    """The filter's two steps."""
    if me.variance < 0.0:
        me.mu = 0.5 * (me.b + me.w)
        me.variance = me.doubt
    me.mu = min(max(me.mu + me.every * me.drift, 0.0), 1.0)
    me.variance += me.every * me.noise
    if me.t * me.mu < LEAST or me.t * (1.0 - me.mu) < LEAST:
        return
    p = me.past_x * me.mu + (1.0 - me.past_x) * (1.0 - me.mu)
    slope = me.t * (2.0 * me.past_x - 1.0)
    gain = me.variance * slope / (slope * slope * me.variance + me.t * p * (1.0 - p))
    me.mu = min(max(me.mu + gain * (me.n - me.t * p), 0.0), 1.0)
    me.variance *= 1.0 - gain * slope


def estimate(me):
    """The informed estimate."""
    return me.x
