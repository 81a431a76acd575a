"""Kalman consensus filter: a Kalman filter of own and neighbours' readings, pulled towards the neighbours' estimates.

Olfati-Saber, "Distributed Kalman filtering for sensor networks", 2007, in its scalar form. Readings X (1: black) of a
round tell (u, U), sums over the own ones and those of neighbours are written sum u, sum U, and

    M = 1 / (1 / P + sum U);    x += M (sum u - x sum U) + g sum (x_j - x);    P = M + Q
    u = k (X - 1 + w) / R,  U = k^2 / R,  k = b + w - 1,  R = q (1 - q),  q = b f + (1 - w)(1 - f),  g = e P / (1 + P)

As published: these steps. It is not optimal: P takes no account of what neighbours' estimates have in common.

Deviations:
- A reading's variance R depends on the fill ratio sought. It is taken at the sender's estimate before the round, and as
  at least `least_variance`.
- At first x = 1/2 and P = 1/12, the mean and the variance of a fill ratio that may be any.
- e, `pull`, is 1; the floor does not change, so Q, `noise`, is 0.
- g is at most M / (P (1 + neighbours heard)): the new x is then a weighted mean of readings and estimates, and no crowd
  of neighbours makes it swing. The source chooses e for a network whose degrees it knows.
- x may leave [0, 1] as what a reading tells does; the estimate is cut to [0, 1].
"""

PARAMETERS = {
    "pull": 1.0,  # e: how strongly neighbours' estimates pull
    "noise": 0.0,  # Q: how much variance a round adds, for a floor that changes
    "least_variance": 0.05,  # of a reading; 0.25: that of each
}
MEMORY = {
    "t": 0.0,  # observations made in this round
    "n": 0.0,  # of which said black
    "x": 0.5,  # the estimate, before it is cut
    "P": 1.0 / 12.0,  # its variance, as far as the robot knows
    "heard": 0.0,  # messages in this round
    "heard_u": 0.0,  # the sums of what they tell
    "heard_U": 0.0,
    "heard_x": 0.0,
}
MESSAGE = ("u", "U", "x")
ROLES = {"u": "information", "U": "confidence", "x": "estimate"}
SUMS = ("heard", "heard_u", "heard_U", "heard_x")


def observe(me, blacks, looks):
    """Count."""
    me.t += looks
    me.n += blacks


def told(me):
    """What the readings of this round tell: u and U."""
    slope = me.b + me.w - 1.0
    if me.t == 0.0 or abs(slope) < 1e-12:
        return 0.0, 0.0  # nothing seen, or a sensor that says the same of black and white
    f = estimate(me)
    q = me.b * f + (1.0 - me.w) * (1.0 - f)
    variance = max(q * (1.0 - q), me.least_variance, 1e-9)
    return slope * (me.n - (1.0 - me.w) * me.t) / variance, slope * slope * me.t / variance


def broadcast(me):
    """What is new, and the estimate before it."""
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
    """The estimate, cut."""
    return min(max(me.x, 0.0), 1.0)
