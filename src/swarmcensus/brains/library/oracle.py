"""The upper bound: the most likely fill ratio, given all readings of all robots and their true accuracies.

No robot could be an oracle: in simulation it hears every robot in every round, whatever the network, without loss
(`ORACLE`); docs/rivals-others.md says what holds with faults and liars. Still it is one file with O(1) memory.

With n of t readings black, k = b + w - 1, and p = k x + 1 - w at the common estimate x, a robot's score and its Fisher
information are s = k (n - t p) / (p (1 - p)) and I = t k^2 / (p (1 - p)). A message is (I x + s, I). A round is a step
of Fisher scoring, x <- sum(I x + s) / sum I, clipped to [0, 1]. It converges to the maximum of the pooled likelihood,
which is concave in x.

Deviations: there is no original. I x + s is sent instead of s, so that robots whose x differ in the last bit do not
drift apart. p is kept within [1e-9, 1 - 1e-9]. A step that reverses the last one is halved, and halved again if the
next one reverses too, because with few readings whole steps may oscillate for ever.
"""

ORACLE = True
EDGE = 1e-9

MEMORY = {
    "t": 0.0,  # observations made
    "n": 0.0,  # black ones among them
    "x": 0.5,  # the estimate, the same in all robots
    "step": 0.0,  # its last change
    "gain": 1.0,  # the share of a step that is taken
    "heard_pull": 0.0,  # the sum of others' pulls
    "heard_information": 0.0,  # the sum of the informations
}
MESSAGE = ("pull", "information")
ROLES = {"pull": "information", "information": "confidence"}
SUMS = ("heard_pull", "heard_information")


def observe(me, blacks, looks):
    """Count readings."""
    me.t += looks
    me.n += blacks


def information(me):
    """The Fisher information of the own readings at x."""
    p = chance(me)
    slope = me.b + me.w - 1.0
    return me.t * slope * slope / (p * (1.0 - p))


def pull(me):
    """The information times x, plus the score."""
    p = chance(me)
    slope = me.b + me.w - 1.0
    return slope * (me.n - me.t * (1.0 - me.w)) / (p * (1.0 - p))


def chance(me):
    """The probability of a black reading at x."""
    p = me.x * me.b + (1.0 - me.x) * (1.0 - me.w)
    return min(max(p, EDGE), 1.0 - EDGE)


def broadcast(me):
    """The pull and the information of the own readings at x."""
    return pull(me), information(me)


def receive(me, message):
    """Add up pulls and informations."""
    me.heard_pull += message[0]
    me.heard_information += message[1]


def fuse(me):
    """A step towards the point where the sum of scores is 0."""
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
