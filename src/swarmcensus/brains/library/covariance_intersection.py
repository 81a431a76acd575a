"""Covariance intersection: safe whatever estimates have in common; in one dimension it copies the most confident one.

Julier, Uhlmann, "A non-divergent estimation algorithm in the presence of unknown correlations", 1997, in its scalar
form. Two estimates a, b with variances A, B become

    1 / C = o / A + (1 - o) / B,    c = C (o a / A + (1 - o) b / B),    o in [0, 1] such that C is least

which holds whatever their correlation. C is least at o = 0 or o = 1: one is taken as it is, the other thrown away. Own
readings X (1: black) are independent of all that was known before, and are folded in as a Kalman filter does:

    Y += I, x += (i - I x) / Y,    i = k (X - 1 + w) / R,  I = k^2 / R,  k = b + w - 1,  R = q (1 - q),
    q = b f + (1 - w)(1 - f)

As published: the rule of both. It is a cautionary row in a comparison: safe, and talk gains little.

Deviations:
- Y = 1 / P is kept and told in place of the variance P, so that a robot that knows nothing, Y = 0, has a number for it.
- A reading's variance R depends on the fill ratio sought. It is taken at the estimate before the round, and as at least
  `least_variance`: by default 0.25, the most that there is. With less, an estimate near 0 or 1 passes for a sure one
  and is copied, again and again, until the whole swarm is there.
- Between equals o is anybody's choice: the own estimate stays, and equal neighbours who are surer are averaged.
- x may leave [0, 1] as what a reading tells does; the estimate is cut to [0, 1].
"""

PARAMETERS = {
    "least_variance": 0.25,  # of a reading: that of each
}
MEMORY = {
    "t": 0.0,  # observations made in this round
    "n": 0.0,  # of which said black
    "x": 0.5,  # the estimate, before it is cut
    "Y": 0.0,  # the inverse of its variance
    "most": 0.0,  # the largest Y heard in this round
    "equals": 0.0,  # how many said so
    "heard_x": 0.0,  # the sum of their estimates
}
MESSAGE = ("x", "Y")
ROLES = {"x": "estimate", "Y": "confidence"}


def observe(me, blacks, looks):
    """Count."""
    me.t += looks
    me.n += blacks


def filtered(me):
    """x and Y with the readings of this round."""
    slope = me.b + me.w - 1.0
    if me.t == 0.0 or abs(slope) < 1e-12:
        return me.x, me.Y  # nothing seen, or a sensor that says the same of black and white
    f = estimate(me)
    q = me.b * f + (1.0 - me.w) * (1.0 - f)
    variance = max(q * (1.0 - q), me.least_variance, 1e-9)
    sure = slope * slope * me.t / variance
    step = slope * (me.n - (1.0 - me.w) * me.t) / variance - sure * me.x
    return me.x + step / (me.Y + sure), me.Y + sure


def broadcast(me):
    """The estimate and how sure it is, with this round's readings."""
    return filtered(me)


def receive(me, message):
    """The surest count."""
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
    """The estimate, cut."""
    return min(max(me.x, 0.0), 1.0)
