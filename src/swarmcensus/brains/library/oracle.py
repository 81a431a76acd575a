"""The upper bound: the most likely fill ratio, given all readings of all robots and their true accuracies.

No robot could be an oracle: in simulation it hears every robot in every round, whatever the network, without loss
(`ORACLE`); docs/rivals.md says what holds with faults and liars. Still it is one file with O(1) memory.

With n of t readings black, k = b + w - 1, and p = k x + 1 - w at the common estimate x, a robot's score and its Fisher
information are s = k (n - t p) / (p (1 - p)) and I = t k^2 / (p (1 - p)). A message is (I x + s, I). A round is a step
of Fisher scoring, x <- sum(I x + s) / sum I, clipped to [0, 1]. It converges to the maximum of the pooled likelihood,
which is concave in x.

A simulation tells it when the fill ratio changes, though not from what to what, and how sensors drift, by the last
fields of MEMORY. After a switch in round `change` only later readings count. While f changes in equal
steps, f = (1 - g) a + g c with a known share g of the way, and robots fit a and c in [0, 1] to all readings. Then, and
if sensors drift, a reading is used once, with I and s at the estimate of its round: robots add up sum (1 - g)^2 I,
sum (1 - g) g I, sum g^2 I, sum (1 - g) (I x + s) and sum g (I x + s).

Deviations: there is no original. I x + s is sent instead of s, so that robots whose x differ in the last bit do not
drift apart. p is kept within [1e-9, 1 - 1e-9]. A step that reverses the last one is halved, and halved again if the
next one reverses too, because with few readings whole steps may oscillate for ever.
"""

ORACLE = True
EDGE = 1e-9

MEMORY = {
    "t": 0.0,  # observations made, or the information of this round's readings
    "n": 0.0,  # black ones among them, or the pull of this round's readings
    "x": 0.5,  # the estimate, the same in all robots
    "step": 0.0,  # its last change
    "gain": 1.0,  # the share of a step that is taken
    "fused": 0.0,  # calls of `fuse` so far
    "first": 0.0,  # the information about the first fill ratio
    "both": 0.0,  # what the information has of both fill ratios
    "last": 0.0,  # the information about the last fill ratio
    "first_pull": 0.0,  # the pulls, by their shares of the first fill ratio
    "last_pull": 0.0,  # the same, by their shares of the last fill ratio
    "heard_pull": 0.0,  # the sum of others' pulls
    "heard_information": 0.0,  # the sum of the informations
    # set by the simulation:
    "change": 0.0,  # the first round in which the fill ratio differs; 0: it is constant
    "until": 0.0,  # the first round in which it has its last value
    "drift": 0.0,  # what b and w gain a round, from round 1 on
    "least": 0.0,  # where they stop falling
    "most": 1.0,  # where they stop rising
    "fuses": 1.0,  # calls of `fuse` in a round
}
MESSAGE = ("pull", "information")
ROLES = {"pull": "information", "information": "confidence"}
SUMS = ("heard_pull", "heard_information")


def observe(me, blacks, looks):
    """Count readings, or add what they are worth at x."""
    if adds_up(me):
        b, w = accuracy(me, me.b), accuracy(me, me.w)
        p = chance(me.x, b, w)
        weight = (b + w - 1.0) / (p * (1.0 - p))
        me.t += weight * (b + w - 1.0) * looks
        me.n += weight * (blacks - looks * (1.0 - w))
    else:
        me.t += looks
        me.n += blacks


def this_round(me):
    """The number of the round, from 1 on."""
    return me.fused // me.fuses + 1.0


def adds_up(me):
    """Whether readings are used once, in the round in which they are made."""
    return me.drift != 0.0 or (me.until > me.change and me.fused >= (me.change - 1.0) * me.fuses)


def accuracy(me, start):
    """An accuracy in this round."""
    drifted = start + me.drift * (this_round(me) - 1.0)
    return min(max(drifted, min(me.least, start)), max(me.most, start))


def information(me):
    """The Fisher information of the own readings at x."""
    p = chance(me.x, me.b, me.w)
    slope = me.b + me.w - 1.0
    return me.t * slope * slope / (p * (1.0 - p))


def pull(me):
    """The information times x, plus the score."""
    p = chance(me.x, me.b, me.w)
    slope = me.b + me.w - 1.0
    return slope * (me.n - me.t * (1.0 - me.w)) / (p * (1.0 - p))


def chance(x, b, w):
    """The probability of a black reading at x."""
    p = x * b + (1.0 - x) * (1.0 - w)
    return min(max(p, EDGE), 1.0 - EDGE)


def broadcast(me):
    """The pull and the information of the own readings at x."""
    if adds_up(me):
        return me.n, me.t
    return pull(me), information(me)


def receive(me, message):
    """Add up pulls and informations."""
    me.heard_pull += message[0]
    me.heard_information += message[1]


def fuse(me):
    """A step towards the point where the sum of scores is 0, or the fit to all that was added up."""
    if adds_up(me):
        total = me.heard_information + me.t
        pulls = me.heard_pull + me.n
        fit(me, total, pulls)
        me.t = 0.0
        me.n = 0.0
    else:
        total = me.heard_information + information(me)
        pulls = me.heard_pull + pull(me)
        if total > 0.0:
            whole = min(max(pulls / total, 0.0), 1.0) - me.x
            turns = whole * me.step < 0.0
            me.gain = 0.5 * me.gain if turns else min(3.0 * me.gain, 1.0)
            me.step = me.gain * whole
            me.x = min(max(me.x + me.step, 0.0), 1.0)
    me.fused += 1.0
    if me.change > 0.0 and me.fused == (me.change - 1.0) * me.fuses:
        change(me, total, pulls)
    me.heard_pull = 0.0
    me.heard_information = 0.0


def change(me, total, pulls):
    """After the last round of the first fill ratio: a switch makes all readings old, else they are about the first."""
    if me.until <= me.change:
        me.first = 0.0
        me.first_pull = 0.0
        me.step = 0.0
        me.gain = 1.0
    elif me.drift == 0.0:
        me.first = total
        me.first_pull = pulls
    me.t = 0.0
    me.n = 0.0


def fit(me, total, pulls):
    """Add up this round's information and pull, and fit the first and the last fill ratio to all."""
    k, g = this_round(me), 0.0
    if me.until > me.change and k >= me.change:
        g = 1.0 if k >= me.until else (k - me.change + 1.0) / (me.until - me.change + 1.0)
    me.first += (1.0 - g) * (1.0 - g) * total
    me.both += (1.0 - g) * g * total
    me.last += g * g * total
    me.first_pull += (1.0 - g) * pulls
    me.last_pull += g * pulls
    whole = me.first * me.last - me.both * me.both
    if whole > EDGE * me.first * me.last:
        last = within(me.first * me.last_pull - me.both * me.first_pull, whole, me.x)
        first = within(me.first_pull - me.both * last, me.first, me.x)
        last = within(me.last_pull - me.both * first, me.last, me.x)
        me.x = (1.0 - g) * first + g * last
    else:  # all readings are of one fill ratio
        me.x = within(me.first_pull + me.last_pull, me.first + 2.0 * me.both + me.last, me.x)


def within(above, below, otherwise):
    """A quotient, clipped to [0, 1]; `otherwise` if there is none."""
    return min(max(above / below, 0.0), 1.0) if below > 0.0 else otherwise


def estimate(me):
    """The estimate."""
    return me.x
