"""Commons: robots average running sums of all evidence and divide them, so that every reading reaches every robot.

With k = b + w - 1, every reading adds to two sums. In every round, each sum becomes the mean of a robot's own and those
that it heard.

    s += k (blacks - looks (1 - w));    v += k^2 looks;    s, v <- means of own and heard;    f = s / v

The expected contribution of a reading to s is f times its contribution to v, so s / v is consistent for f under any
mixing that treats both alike: over any graph, with unknown degrees, lost or old messages and robots that move, fail or
join late, as long as the network does not depend on the readings. docs/beyond.md derives it.

The ratio is clipped to [0, 1] only for the estimate, because clipped sums would stay biased. For the first rounds there
is a prior with mean 1/2 and weight min(1/4, 1/(16 v)) next to v. For a robot that has seen 100 tiles with b = w = 0.525
it weighs half as much as the readings, and soon nothing.

In single precision, a sum that is large against a reading loses part of it to rounding, always in the same direction.
So a robot remembers what rounding took, and adds it with its next readings.
"""

LARGE = 8192.0  # times new evidence: the sum of which rounding takes too much of it

MEMORY = {
    "s": 0.0,  # evidence for black, mixed
    "v": 0.0,  # evidence, mixed
    "s_rest": 0.0,  # what rounding took of s
    "v_rest": 0.0,  # and of v
    "heard": 0.0,  # messages since the last round
    "heard_s": 0.0,  # the sums in them
    "heard_v": 0.0,
}
MESSAGE = ("s", "v")
ROLES = {"s": "information", "v": "confidence"}
SUMS = ("heard", "heard_s", "heard_v")


def observe(me, blacks, looks):
    """Add unbiased evidence, weighted by how much the sensor tells."""
    slope = me.b + me.w - 1.0
    s = slope * (blacks - looks * (1.0 - me.w))
    v = slope * slope * looks
    if me.v < LARGE * v:
        me.s += s
        me.v += v
        return
    me.s, me.s_rest = added(me.s, me.s_rest + s)
    me.v, me.v_rest = added(me.v, me.v_rest + v)


def added(total, more):
    """A sum with more added, and what rounding took of it."""
    larger = total + more
    return larger, more - (larger - total)


def lost(mean, own, heard, messages):
    """What rounding took of the mean of an own number and those in messages, whose sum is `heard`."""
    return ((heard - mean * messages) + (own - mean)) / (1.0 + messages)


def broadcast(me):
    """The sums."""
    return me.s, me.v


def receive(me, message):
    """A neighbour's sums."""
    s, v = message
    me.heard += 1.0
    me.heard_s += s
    me.heard_v += v


def fuse(me):
    """The mean of all voices."""
    voices = 1.0 + me.heard
    s = (me.s + me.heard_s) / voices
    v = (me.v + me.heard_v) / voices
    if me.s_rest != 0.0 or me.v_rest != 0.0:  # of sums that are large
        me.s_rest += lost(s, me.s, me.heard_s, me.heard)
        me.v_rest += lost(v, me.v, me.heard_v, me.heard)
    me.s = s
    me.v = v
    me.heard = 0.0
    me.heard_s = 0.0
    me.heard_v = 0.0


def estimate(me):
    """The ratio of the sums, with the prior, in [0, 1]."""
    if me.v <= 0.0:
        return 0.5
    prior = min(0.25, 0.0625 / me.v)
    return min(max((me.s + 0.5 * prior) / (me.v + prior), 0.0), 1.0)
