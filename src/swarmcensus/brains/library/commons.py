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

A robot halves both sums once v passes 2^14, as float32 rounds away too much of a reading that is small against them.
This keeps s / v, and f stays consistent whoever halves first, because v depends on no colours: it only counts older
readings less, so that even a robot alone still has a standard error below 0.0033.
"""

MOST = 16384.0  # evidence above which the sums are halved

MEMORY = {
    "s": 0.0,  # evidence for black, mixed
    "v": 0.0,  # evidence, mixed
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
    me.s += slope * (blacks - looks * (1.0 - me.w))
    me.v += slope * slope * looks


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
    """The mean of all voices, halved if it is large."""
    voices = 1.0 + me.heard
    me.s = (me.s + me.heard_s) / voices
    me.v = (me.v + me.heard_v) / voices
    if me.v > MOST:
        me.s *= 0.5
        me.v *= 0.5
    me.heard = 0.0
    me.heard_s = 0.0
    me.heard_v = 0.0


def estimate(me):
    """The ratio of the sums, with the prior, in [0, 1]."""
    if me.v <= 0.0:
        return 0.5
    prior = min(0.25, 0.0625 / me.v)
    return min(max((me.s + 0.5 * prior) / (me.v + prior), 0.0), 1.0)
