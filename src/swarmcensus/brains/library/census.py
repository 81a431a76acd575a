"""Census: commons with momentum, on a floor that may change, among honest robots; see docs/beyond.md.

Sums s, v of evidence are mixed as in `commons`, with k = b + w - 1:  s += k (blacks - looks (1 - w)),  v += k^2 looks.

1. Momentum, as in `swift`, while the network is steady. It ends for good if a robot hears nobody, hears another number
of robots than in the first round, hears one without momentum or evidence, or if one round mixes all. Messages hold s, v
divided by the gain that momentum gives them, so that robots with and without it can be mixed.

Mixing counts readings in proportion to the voices n that a robot hears: in a star, those of the hub as much as those of
half the swarm. So with momentum they are weighted by 1 / (n l). The level l is the mean of 1 / n, mixed as s and v are,
so that v keeps its size. In steady networks all readings then weigh alike in the end.

If robots fail, those left read for themselves, but `commons` weighs a round of one robot like an earlier one of all.
`swift` never takes back the gain of 10 that the earlier ones have. So a robot that loses neighbours keeps it here too,
and learns again what chance does.

2. Without momentum, the own sums weigh as much as all messages, so that late messages do not split the swarm in parts
that never mix. Then what a robot has just read weighs much. Let A be the sum of squares of what has stayed with it of
its own readings. The evidence in s / v is at most v^2 / A. So s / v is averaged with r, the ratio of the own readings
of all n voices heard, which the paper shares; the weights are v^2 / (n A) and the evidence in r.

3. Change. `short` is a running mean of the latest readings, with the evidence e = min(v, memory, max(LEAST, v / 4)),
mixed as s / v is. It leaves s / v if the floor changes, or by chance. What chance does is in `chance`, a running mean
of how far readings are from `short`, times a random sign that a robot keeps for e. The noise is the mean of chance^2 e,
but at least 1 / (4 CROWD n), and at least that of past (s / v - short)^2 e, cut at CUT times itself, in which patches
show. Where one round mixes all it is KNOWN / n. A robot begins again, with the short ratio, if

    (s / v - short)^2 > z^2 noise / e;  or (confirm^2 + 2 ln(n / m)) noise / e, if m > 0 of n voices have just begun;
    or lone^2 noise / e, if none has, and the short ratios heard do not differ in the same direction.

Until it has the evidence SETTLED, it counts only the sums of robots that have begun again. Against liars: `steadfast`.
"""

import math

LEAST = 10.0  # evidence that the short ratio may always hold, in readings of a perfect sensor
SETTLED = 30.0  # evidence from which on a robot that has begun again counts the sums of all
CUT = 4.0  # times the noise: the largest square of a distance that counts
FIRST = 1.0  # weight of the first guess of the noise, 1 / (4 n), in lives of the short ratio
LIVES = 8.0  # over which the noise is averaged; twice as many for distances, which slow changes raise
KNOWN = 0.08  # times 1 / n: the noise where one round mixes all, 1 / 8, and less as nothing is guessed
CROWD = 8.0  # times n: the most robots that the noise is taken to be averaged over
STILL = -1.0  # instead of the sum of marks: no momentum;
MIXED = -2.0  # one round mixes all;
BEGUN = -3.0  # the robot has begun again

PARAMETERS = {
    "momentum": 0.9,
    "memory": 100.0,  # the most evidence in the short ratio
    "z": 5.0,  # standard deviations that show a change
    "confirm": 1.5,  # that confirm one with which all voices have begun
    "lone": 7.0,  # that show one which no other robot sees
}
MEMORY = {
    "s": 0.0,  # evidence for black, times the gain
    "v": 0.0,  # evidence, times the gain
    "said_s": 0.0,  # the same in the last message
    "said_v": 0.0,
    "unit": 0.0,  # what evidence of 1 per round would have become
    "said_unit": 0.0,
    "squares": 0.0,  # A
    "own_s": 0.0,  # evidence for black of the own readings
    "own_v": 0.0,  # and evidence
    "fresh_s": 0.0,  # the same of this round
    "fresh": 0.0,
    "short": 0.5,
    "chance": 0.0,
    "sign": 0.0,
    "signed": 0.0,  # evidence since the sign was drawn
    "noise": 0.0,
    "seen": 0.0,  # the mean square of past distances
    "lives": 0.0,  # of the short ratio in both
    "rounds": 0.0,  # with evidence, so far
    "first": 0.0,  # messages in the first round
    "marks": 0.0,  # their sum and the own, squares of names, as in `swift`; see STILL
    "level": 0.0,  # l
    "x": 0.5,  # estimate
    "heard": 0.0,  # messages since the last round; the sums in them:
    "heard_s": 0.0,
    "heard_v": 0.0,
    "heard_short": 0.0,
    "heard_chance": 0.0,
    "heard_noise": 0.0,
    "heard_own_s": 0.0,
    "heard_own_v": 0.0,
    "heard_marks": 0.0,
    "alarms": 0.0,  # of robots without momentum or evidence
    "begun": 0.0,  # of robots that have begun again
    "begun_s": 0.0,
    "begun_v": 0.0,
}
MESSAGE = ("s", "v", "short", "chance", "noise", "own_s", "own_v", "marks")
ROLES = {"s": "information", "v": "confidence", "own_s": "information", "own_v": "confidence"}
NEEDS = {"mutual": 1}  # momentum is unstable where links go one way only
SUMS = (
    "heard", "heard_s", "heard_v", "heard_short", "heard_chance", "heard_noise", "heard_own_s", "heard_own_v",
    "heard_marks", "alarms", "begun", "begun_s", "begun_v",
)  # fmt: skip


def gain(me):
    """How many times larger the sums are than without momentum."""
    return max(me.unit / max(me.rounds, 1.0), 1.0)


def short_evidence(me, v):
    """The evidence in the short ratio, e."""
    return min(v, me.memory, max(LEAST, 0.25 * v))


def observe(me, blacks, looks):
    """Collect unbiased evidence, weighted by how much the sensor tells."""
    slope, weight = me.b + me.w - 1.0, weight_of(me)
    me.fresh_s += weight * (slope * (blacks - looks * (1.0 - me.w)))
    me.fresh += weight * (slope * slope * looks)


def weight_of(me):
    """Of the own readings, which mixing counts in proportion to the voices that a robot hears."""
    return 1.0 / ((1.0 + me.first) * me.level) if me.marks > 0.0 else 1.0


def broadcast(me):
    """The message of the readings so far."""
    return said(me)


def said(me):
    """The sums without gain, both running means, the noise, the own sums, and the mark, level or a state."""
    v = (me.v + me.fresh) / gain(me)
    short, chance = me.short, me.chance
    if me.fresh > 0.0:
        part = min(me.fresh / short_evidence(me, v), 1.0)
        off = part * (me.fresh_s / me.fresh - me.short)
        short += off
        chance += me.sign * off - part * chance
    return (
        (me.s + me.fresh_s) / gain(me), v, short, chance, me.noise, me.own_s + me.fresh_s,
        me.own_v + me.fresh, said_marks(me),
    )  # fmt: skip


def said_marks(me):
    """First the own mark, then the sum of marks, from the fourth round on the level; or a state."""
    if me.rounds == 0.0:
        return mark(me)
    return me.level if me.marks > 0.0 and me.rounds > 2.0 else me.marks


def mark(me):
    """The square of a name, because sums of squares are rarely equal."""
    return (me.name + 1.0) * (me.name + 1.0)


def receive(me, message):
    """A neighbour's message."""
    s, v, short, chance, noise, own_s, own_v, marks = message
    me.heard += 1.0
    me.heard_s += s
    me.heard_v += v
    me.heard_short += v * short
    me.heard_chance += v * chance
    me.heard_noise += v * noise
    me.heard_own_s += own_s
    me.heard_own_v += own_v
    me.heard_marks += marks
    if marks in (STILL, BEGUN) or v <= 0.0:
        me.alarms += 1.0
    if marks == BEGUN:
        me.begun += 1.0
        me.begun_s += s
        me.begun_v += v


def fuse(me):
    """Average all voices, step beyond the mean, look for a change, and make the estimate."""
    s, v, short, chance, noise, me.own_s, me.own_v, _ = said(me)
    look_around(me)
    voices, others_s, others_v = me.heard, me.heard_s, me.heard_v
    if me.marks == BEGUN:
        voices, others_s, others_v = me.begun, me.begun_s, me.begun_v
    own = 1.0 if me.marks > 0.0 or me.marks == MIXED else max(voices, 1.0)
    total = own * v + me.heard_v
    if total > 0.0:
        me.short = (own * (v * short) + me.heard_short) / total
        me.chance = (own * (v * chance) + me.heard_chance) / total
        me.noise = (own * (v * noise) + me.heard_noise) / total
    share = own / (own + voices)
    me.squares = (me.squares + weight_of(me) * me.fresh) * (share * share)
    mean_s = (own * s + others_s) / (own + voices)
    mean_v = (own * v + others_v) / (own + voices)
    step(me, mean_s, mean_v, s, v)
    if mean_v > 0.0:
        if has_changed(me, mean_s / mean_v, mean_v):
            begin(me)
            mean_s, mean_v = me.s, me.v
        if me.marks == BEGUN and me.v > SETTLED:
            me.marks = STILL
        make_estimate(me, mean_s, mean_v)
    me.fresh_s = me.fresh = me.heard = me.heard_s = me.heard_v = me.heard_short = me.heard_chance = 0.0
    me.heard_noise = me.heard_own_s = me.heard_own_v = me.heard_marks = me.alarms = 0.0
    me.begun = me.begun_s = me.begun_v = 0.0


def look_around(me):
    """Give up momentum, for good, if the network changes or one round mixes all of it; mix the level."""
    if me.rounds == 0.0:
        me.first = me.heard
        me.level = 1.0 / (1.0 + me.heard)
        me.marks = me.heard_marks + mark(me) if me.alarms == 0.0 else STILL
    elif me.rounds == 1.0 and me.marks > 0.0 and me.heard_marks == me.heard * me.marks:
        me.marks = MIXED
    elif me.rounds == 2.0 and me.marks == MIXED and me.heard_marks != me.heard * MIXED:
        me.marks = 1.0  # the sums were equal by chance
    elif me.rounds > 2.0 and me.heard_marks < me.heard:  # levels, each below 1
        me.level = (me.level + me.heard_marks) / (1.0 + me.heard)
    if me.marks > 0.0 and me.heard < me.first:  # old news stays in `chance` for a life
        me.lives = LIVES + 2.0
    if me.marks != BEGUN and (me.heard == 0.0 or me.heard != me.first or me.alarms > 0.0):
        me.marks = STILL


def step(me, s, v, sent_s, sent_v):
    """Set what is sent next: beyond the means by the momentum."""
    size = gain(me) if me.marks > 0.0 or me.heard < me.first else 1.0  # with fewer robots, what all have read stays
    g = me.momentum if me.marks > 0.0 and me.rounds > 1.0 else 0.0
    if size * (v + g * v) - g * me.said_v <= 0.5 * size * v:
        g = 0.0
    me.s = size * s + g * (size * s - me.said_s)
    me.v = size * v + g * (size * v - me.said_v)
    me.said_s, me.said_v = size * sent_s, size * sent_v
    if sent_v > 0.0:
        me.rounds += 1.0
        unit = me.unit + 1.0
        me.unit, me.said_unit = unit + g * (unit - me.said_unit), unit
    if me.marks <= 0.0:
        me.unit = me.said_unit = me.rounds
        me.squares *= size * size


def has_changed(me, ratio, v):
    """Learn what chance does, and tell whether the short ratio differs by more."""
    voices, e = 1.0 + me.heard, short_evidence(me, v)
    part = min(me.fresh / e, 1.0)
    if me.lives == 0.0 or me.lives > LIVES:  # nothing is known, or robots have failed within two lives
        me.noise = min(0.25 / voices, 0.125)
    me.lives = min(me.lives + part, LIVES) if me.lives <= LIVES else max(me.lives - part, LIVES)
    late = min(1.0, v / me.own_v) if me.marks == STILL and me.own_v > 0.0 else 1.0  # what is not on its way
    me.noise += min(part / late, 1.0) / (FIRST + me.lives) * (me.chance * me.chance * e - me.noise)
    me.signed += me.fresh
    if me.signed >= e:
        me.signed = 0.0
        me.sign = 1.0 if me.luck < 0.5 else -1.0
    if v <= 1.01 * e or me.marks == BEGUN:  # the short ratio holds nearly all readings
        return False
    off = ratio - me.short
    me.seen += late * part / (FIRST + 2.0 * me.lives) * (min(off * off * e / (1.0 - e / v), CUT * me.noise) - me.seen)
    noise = KNOWN / voices if me.marks == MIXED else max(me.noise, me.seen, 0.25 / (CROWD * voices))
    least = me.z * me.z
    if me.begun > 0.0:
        least = min(least, me.confirm * me.confirm + 2.0 * math.log(voices / me.begun))
    elif me.lives <= LIVES and (me.heard_s - me.heard_short) * off <= 0.0:
        least = me.lone * me.lone
    return off * off * e > least * noise


def begin(me):
    """Begin again, with the short ratio as one reading of a perfect sensor."""
    me.s, me.v = me.short, 1.0
    me.marks = BEGUN if me.marks != MIXED else MIXED  # then all begin again at once
    me.own_s = me.own_v = me.squares = 0.0


def make_estimate(me, s, v):
    """The ratio of the sums, with the prior of `commons`, drawn to that of the own readings of all voices."""
    prior = min(0.25, 0.0625 / v)
    me.x = (s + 0.5 * prior) / (v + prior)
    near_v = me.own_v + me.heard_own_v
    if me.marks == STILL and near_v > 0.0 and me.begun == 0.0:
        near = (me.own_s + me.heard_own_s) / near_v
        weight = (1.0 + me.heard) * me.squares * near_v / (v * v)
        me.x += weight / (1.0 + weight) * (near - me.x)


def estimate(me):
    """The estimate, in [0, 1]."""
    return min(max(me.x, 0.0), 1.0)
