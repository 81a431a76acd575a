"""Information filter: robots add up the information in each other's new readings, weighted by precision.

Rao, Durrant-Whyte, Sheen, "A fully decentralised multi-sensor system for tracking and surveillance", 1993, in its
scalar form for a state that does not change. A reading X (1: black) gives (i, I), and

    y += sum of i, Y += sum of I, over own and neighbours' new readings;    x = y / Y
    i = k (X - 1 + w) / R,  I = k^2 / R,  k = b + w - 1,  R = q (1 - q),  q = b f + (1 - w)(1 - f)

As published: the sums, and that nothing is sent twice. In a full network without losses, every robot has the estimate
of a robot with all readings.

Deviations:
- The variance R of a reading depends on the unknown fill ratio. It is computed from the sender's estimate before the
  round, and is at least `least_variance`: otherwise a first estimate near 0 or 1 would outweigh all later ones. With
  0.25, all readings have the same variance.
- There is no prior: y and Y begin at 0. x is y / Y, clipped to [0, 1]; y is not clipped.
- A robot without readings in a round is silent.
"""

PARAMETERS = {
    "least_variance": 0.05,  # of a reading; with 0.25, all readings have it
}
MEMORY = {
    "t": 0.0,  # observations made in this round
    "n": 0.0,  # black ones among them
    "y": 0.0,  # information: the estimate times its precision
    "Y": 0.0,  # precision: the inverse of the variance of the estimate
    "x": 0.5,  # the estimate
    "heard_i": 0.0,  # the sums of neighbours' messages in this round
    "heard_I": 0.0,
}
MESSAGE = ("i", "I")
ROLES = {"i": "information", "I": "confidence"}
SUMS = ("heard_i", "heard_I")


def observe(me, blacks, looks):
    """Count readings."""
    me.t += looks
    me.n += blacks


def told(me):
    """The information in the readings of this round: i and I."""
    slope = me.b + me.w - 1.0
    if me.t == 0.0 or abs(slope) < 1e-12:
        return 0.0, 0.0  # no reading, or a sensor that tells nothing
    q = me.b * me.x + (1.0 - me.w) * (1.0 - me.x)
    variance = max(q * (1.0 - q), me.least_variance, 1e-9)
    return slope * (me.n - (1.0 - me.w) * me.t) / variance, slope * slope * me.t / variance


def broadcast(me):
    """The new information."""
    if me.t == 0.0:
        return None
    return told(me)


def receive(me, message):
    """A neighbour's terms of the two sums."""
    me.heard_i += message[0]
    me.heard_I += message[1]


def fuse(me):
    """The two sums, and the estimate."""
    i, sure = told(me)
    me.y += i + me.heard_i
    me.Y += sure + me.heard_I
    if me.Y > 0.0:
        me.x = min(max(me.y / me.Y, 0.0), 1.0)
    me.t = 0.0
    me.n = 0.0
    me.heard_i = 0.0
    me.heard_I = 0.0


def estimate(me):
    """The estimate."""
    return me.x
