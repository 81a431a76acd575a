"""The upper bound: the most likely fill ratio, given all readings of all robots and their true accuracies.

No robot could be it: in a simulation it hears every robot in every round, whatever the network, and loses nothing
(`ORACLE`); docs/rivals-others.md says what holds with faults and liars. One file all the same, of O(1) memory.

With n of t readings black, k = b + w - 1, and p = k x + 1 - w at the common estimate x, a robot's score and its Fisher
information are s = k (n - t p) / (p (1 - p)) and I = t k^2 / (p (1 - p)). A message is (I x + s, I); a round is a step
of Fisher's scoring, x <- sum(I x + s) / sum I, cut off at [0, 1]. Where it ends, the pooled likelihood, which is
concave in x, is largest.

Deviations: there is no original. I x + s and not s is said, so that robots whose x differ in the last bit do not drift
apart. p is kept within [1e-9, 1 - 1e-9]. A step that turns back on the last one is taken by half, and the next
that does by half of that: with few readings, whole ones may go to and fro for ever.
"""

ORACLE = True
EDGE = 1e-9

MEMORY = {
    "t": 0.0,  # observations made
    "n": 0.0,  # of which said black
    "x": 0.5,  # the estimate, the same in all robots
    "step": 0.0,  # by which it last changed
    "gain": 1.0,  # the share of a step that is taken
    "heard_pull": 0.0,  # the sum of what others would have, each times its information
    "heard_information": 0.0,  # the sum of the informations
}
MESSAGE = ("pull", "information")
ROLES = {"pull": "information", "information": "confidence"}
SUMS = ("heard_pull", "heard_information")


def observe(me, blacks, looks):
    """Count."""
    me.t += looks
    me.n += blacks


def information(me):
    """The Fisher information of the own readings at x."""
    p = chance(me)
    slope = me.b + me.w - 1.0
    return me.t * slope * slope / (p * (1.0 - p))


def pull(me):
    """The information times x, and the score."""
    p = chance(me)
    slope = me.b + me.w - 1.0
    return slope * (me.n - me.t * (1.0 - me.w)) / (p * (1.0 - p))


def chance(me):
    """How likely a black reading is at x."""
    p = me.x * me.b + (1.0 - me.x) * (1.0 - me.w)
    return min(max(p, EDGE), 1.0 - EDGE)


def broadcast(me):
    """What the own readings say at x."""
    return pull(me), information(me)


def receive(me, message):
    """Add them up."""
    me.heard_pull += message[0]
    me.heard_information += message[1]


def fuse(me):
    """A step towards where all scores cancel."""
    total = me.heard_information + information(me)
    if total > 0.0:
        whole = min(max((me.heard_pull + pull(me)) / total, 0.0), 1.0) - me.x
        turns = whole * me.step < 0.0
        me.gain = 0.5 * me.gain if turns else min(3.0 * me.gain, 1.0)
        me.step = me.gain * whole
        me.x = min(max(me.x + me.step, 0.0), 1.0)
    me.heard_pull = 0.0
    me.heard_information = 0.0


def estimate(me):
    """The estimate."""
    return me.x
