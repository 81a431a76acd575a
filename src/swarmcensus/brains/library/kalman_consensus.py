"""Kalman consensus filter: a Kalman filter of own and neighbours' readings, pulled towards the neighbours' estimates.

Olfati-Saber, "Distributed Kalman filtering for sensor networks", 2007, in its scalar form. The readings X (1: black) of
a round give (u, U). With sum u and sum U the sums over a robot's own and its neighbours' readings,

    M = 1 / (1 / P + sum U);    x += M (sum u - x sum U) + g sum (x_j - x);    P = M + Q
    u = k (X - 1 + w) / R,  U = k^2 / R,  k = b + w - 1,  R = q (1 - q),  q = b f + (1 - w)(1 - f),  g = e P / (1 + P)

As published: these steps. The filter is not optimal: P ignores what the neighbours' estimates have in common.

Deviations:
- The variance R of a reading depends on the unknown fill ratio. It is computed from the sender's estimate before the
  round, and is at least `least_variance`.
- At first x = 1/2 and P = 1/12, the mean and variance of a uniformly distributed fill ratio.
- e, `pull`, is 1; the floor does not change, so Q, `noise`, is 0.
- g is at most M / (P (1 + neighbours heard)), so that the new x is a weighted mean of readings and estimates and does
  not oscillate with many neighbours. The source chooses e for a network with known degrees.
- x may leave [0, 1], as single readings do; the estimate is clipped to [0, 1].
"""

PARAMETERS = {
    "pull": 1.0,  # e: the strength of the pull towards neighbours' estimates
    "noise": 0.0,  # Q: the variance added per round, for a floor that changes
    "least_variance": 0.05,  # of a reading; with 0.25, all readings have it
}
MEMORY = {
    "t": 0.0,  # observations made in this round
    "n": 0.0,  # black ones among them
    "x": 0.5,  # the estimate, before clipping
    "P": 1.0 / 12.0,  # its variance, ignoring correlations
    "heard": 0.0,  # messages in this round
    "heard_u": 0.0,  # the sums of their contents
    "heard_U": 0.0,
    "heard_x": 0.0,
}
MESSAGE = ("u", "U", "x")
ROLES = {"u": "information", "U": "confidence", "x": "estimate"}
SUMS = ("heard", "heard_u", "heard_U", "heard_x")


def observe(me, blacks, looks):
    """Count readings."""
    me.t += looks
    me.n += blacks


def told(me):
    """The information in the readings of this round: u and U."""
    slope = me.b + me.w - 1.0
    if me.t == 0.0 or abs(slope) < 1e-12:
        return 0.0, 0.0  # no reading, or a sensor that tells nothing
    f = estimate(me)
    q = me.b * f + (1.0 - me.w) * (1.0 - f)
    variance = max(q * (1.0 - q), me.least_variance, 1e-9)
    return slope * (me.n - (1.0 - me.w) * me.t) / variance, slope * slope * me.t / variance


def broadcast(me):
    """The new information, and the estimate before it."""
    u, sure = told(me)
    return u, sure, me.x


def receive(me, message):
    """A neighbour's terms of the three sums."""
    me.heard += 1.0
    me.heard_u += message[0]
    me.heard_U += message[1]
    me.heard_x += message[2]


def fuse(me):
    """The filter's step and the pull."""
    u, sure = told(me)
    u += me.heard_u
    sure += me.heard_U
    variance = 1.0 / (1.0 / me.P + sure)
    g = min(me.pull * me.P / (1.0 + me.P), variance / me.P / (1.0 + me.heard))
    me.x += variance * (u - me.x * sure) + g * (me.heard_x - me.heard * me.x)
    me.P = variance + me.noise
    me.t = 0.0
    me.n = 0.0
    me.heard = 0.0
    me.heard_u = 0.0
    me.heard_U = 0.0
    me.heard_x = 0.0


def estimate(me):
    """The estimate, clipped."""
    return min(max(me.x, 0.0), 1.0)
