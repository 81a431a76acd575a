"""Running sums of evidence, mixed and divided, as in the theory of mixing: the shipped commons without its prior."""

MEMORY = {"s": 0.0, "v": 0.0, "heard": 0.0, "heard_s": 0.0, "heard_v": 0.0}
MESSAGE = ("s", "v")
SUMS = ("heard", "heard_s", "heard_v")


def observe(me, blacks, looks):
    """Readings corrected for the sensor, and their weight."""
    k = me.b + me.w - 1.0
    me.s += k * (blacks - looks * (1.0 - me.w))
    me.v += k * k * looks


def broadcast(me):
    """Both sums."""
    return me.s, me.v


def receive(me, message):
    """Add up."""
    me.heard += 1.0
    me.heard_s += message[0]
    me.heard_v += message[1]


def fuse(me):
    """The means of one's own and what was heard."""
    me.s = (me.s + me.heard_s) / (1.0 + me.heard)
    me.v = (me.v + me.heard_v) / (1.0 + me.heard)
    me.heard = 0.0
    me.heard_s = 0.0
    me.heard_v = 0.0


def estimate(me):
    """Their ratio."""
    if me.v <= 0.0:
        return 0.5
    return min(max(me.s / me.v, 0.0), 1.0)
