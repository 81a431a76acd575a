"""The minimalistic brain in a robot that drives straight ahead, and so leaves ground that it has already seen.

Local and informed estimates as in Chin, Khaluf and Pinciroli, "Minimalistic Collective Perception with Imperfect
Sensors", Sec. III, Algorithm 1; equation numbers below are the paper's. These functions are repeated here because
a brain is one file.
"""

STRAIGHT_ON = 0.14  # m/s: the Khepera IV's speed in the paper

MEMORY = {
    "t": 0.0,  # observations made
    "n": 0.0,  # black ones among them
    "x_hat": 0.5,  # local estimate
    "alpha": 0.0,  # local confidence
    "x_bar": 0.5,  # social estimate
    "beta": 0.0,  # social confidence
    "x": 0.5,  # informed estimate
    "heard": 0.0,  # messages since the last round
    "heard_alpha": 0.0,  # the sum of their confidences
    "heard_x": 0.0,  # the sum of their estimates, each times its confidence
}
MESSAGE = ("x_hat", "alpha")
SUMS = ("heard", "heard_alpha", "heard_x")


def observe(me, blacks, looks):
    """Local estimate (Eq. 4) and its Fisher information (Eq. 5)."""
    me.t += looks
    me.n += blacks
    t = me.t
    n = me.n
    b = me.b
    w = me.w
    slope = b + w - 1.0  # how much more often black tiles read black than white tiles do
    if t == 0.0 or abs(slope) < 1e-12:
        return  # no reading, or a sensor that tells nothing
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
    """Social estimate (Eqs. 7 and 8), then informed estimate (Eq. 6)."""
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


def estimate(me):
    """The informed estimate."""
    return me.x


def steer(me):
    """Drive straight ahead, so that the same patch of ground is not read again and again; only obstacles turn it."""
    return STRAIGHT_ON, 0.0
