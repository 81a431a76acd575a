"""Covariance intersection: safe for any correlation of estimates; in one dimension it copies the most confident one.

Julier, Uhlmann, "A non-divergent estimation algorithm in the presence of unknown correlations", 1997, in its scalar
form. Two estimates a, b with variances A, B become

    1 / C = o / A + (1 - o) / B,    c = C (o a / A + (1 - o) b / B),    o in [0, 1] such that C is least

which is consistent for any correlation. C is least at o = 0 or o = 1: one estimate is taken, the other is dropped. Own
readings X (1: black) are independent of everything known before, and are added as in a Kalman filter:

    Y += I, x += (i - I x) / Y,    i = k (X - 1 + w) / R,  I = k^2 / R,  k = b + w - 1,  R = q (1 - q),
    q = b f + (1 - w)(1 - f)

As published: both rules. It is a warning in comparisons: it is safe, but gains little from communication.

Deviations:
- Y = 1 / P is stored and sent instead of the variance P, so that Y = 0 stands for a robot that knows nothing.
- The variance R of a reading depends on the unknown fill ratio. It is computed from the estimate before the round, and
  is at least `least_variance`: by default 0.25, its largest value. With less, an estimate near 0 or 1 seems certain and
  is copied again and again, until the whole swarm has it.
- For equal variances any o is right: the robot keeps its own estimate, and averages equally confident neighbours if
  they are more confident than itself.
- x may leave [0, 1], as single readings do; the estimate is clipped to [0, 1].
"""

PARAMETERS = {
    "least_variance": 0.25,  # of a reading; with 0.25, all readings have it
}
MEMORY = {
    "t": 0.0,  # observations made in this round
    "n": 0.0,  # black ones among them
    "x": 0.5,  # the estimate, before clipping
    "Y": 0.0,  # the inverse of its variance
    "most": 0.0,  # the largest Y heard in this round
    "equals": 0.0,  # the number of messages with it
    "heard_x": 0.0,  # the sum of their estimates
}
MESSAGE = ("x", "Y")
ROLES = {"x": "estimate", "Y": "confidence"}


def observe(me, blacks, looks):
    """Count readings."""
    me.t += looks
    me.n += blacks


def filtered(me):
    """x and Y with the readings of this round."""
    slope = me.b + me.w - 1.0
    if me.t == 0.0 or abs(slope) < 1e-12:
        return me.x, me.Y  # no reading, or a sensor that tells nothing
    f = estimate(me)
    q = me.b * f + (1.0 - me.w) * (1.0 - f)
    variance = max(q * (1.0 - q), me.least_variance, 1e-9)
    sure = slope * slope * me.t / variance
    step = slope * (me.n - (1.0 - me.w) * me.t) / variance - sure * me.x
    return me.x + step / (me.Y + sure), me.Y + sure


def broadcast(me):
    """The estimate and its precision, with this round's readings."""
    return filtered(me)


def receive(me, message):
    """Add up the estimates with the largest precision."""
    x, sure = message
    if sure > me.most:
        me.most = sure
        me.equals = 0.0
        me.heard_x = 0.0
    if sure == me.most:
        me.equals += 1.0
        me.heard_x += x


def fuse(me):
    """Own readings, then the intersection with all that was heard."""
    x, sure = filtered(me)
    if me.most > sure:
        sure = me.most
        x = me.heard_x / me.equals
    me.x = x
    me.Y = sure
    me.t = 0.0
    me.n = 0.0
    me.most = 0.0
    me.equals = 0.0
    me.heard_x = 0.0


def estimate(me):
    """The estimate, clipped."""
    return min(max(me.x, 0.0), 1.0)
