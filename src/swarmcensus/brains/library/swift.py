"""Swift: commons with momentum, which spreads news faster; momentum is switched off for good if the network changes.

What a robot sends next goes beyond the mean of the voices, in proportion to how far that mean is from its last message:

    s, v <- M + g (M - said),    M the mean of own and heard, as in commons;    f = s / v of the means

This is a second-order step (Polyak, 1964; in consensus: Muthukrishnan, Ghosh, Schultz, 1998). It treats s and v alike,
so f stays consistent. With lost or old messages, or changing neighbours, it is unstable; and a robot with momentum does
harm next to one without. So a robot is shaken as soon as it hears nobody, or fewer or more robots than in its first
round, or a mind without evidence (older than that mind's first reading), or a robot that is shaken, which all messages
say. A shaken robot mixes as in commons, for good, and within a few rounds all robots do. If nothing changes, all keep
their momentum.

The last 1 / (1 - g) rounds of readings do not count in full yet. If one round mixes everything, that is a loss. So g
falls with the square of the voices heard above `crowd`. Robots also give up momentum if all their neighbours heard
exactly the same robots as they did, which in a connected swarm is true of all or none. To find out, messages contain a
mark: first the robot's own, then for good the sum of all marks heard, which rarely equals another sum by chance.
Momentum begins in the third round, when this is known. A robot whose v would be halved by the step omits it once. The
prior is that of commons, scaled like the sums.

As in `commons`, a robot remembers what rounding took, of the means and of the steps, so that the sums bear single
precision. `unit` tells how large they are against what a round adds.
"""

from math import isfinite

LARGE = 16384.0  # the unit of sums of which rounding takes too much of a reading

PARAMETERS = {
    "momentum": 0.9,  # g
    "crowd": 50.0,  # the number of voices above which momentum is reduced
}
MEMORY = {
    "s": 0.0,  # sent: evidence for black
    "v": 0.0,  # and evidence
    "s_rest": 0.0,  # what rounding took of s
    "v_rest": 0.0,  # and of v
    "said_s": 0.0,  # in the round before
    "said_v": 0.0,
    "mean_s": 0.0,  # the means, with later readings
    "mean_v": 0.0,
    "unit": 0.0,  # what evidence of 1 per round would have become, as sent
    "said_unit": 0.0,
    "rounds": 0.0,  # so far
    "first": 0.0,  # messages in the first round
    "company": 0.0,  # the sum of marks heard in the first round and the own; 0 before, -1 if shaken
    "heard": 0.0,  # messages since the last round
    "heard_s": 0.0,  # the sums in them
    "heard_v": 0.0,
    "heard_company": 0.0,
    "alarms": 0.0,  # messages of robots that are shaken or have no evidence
}
MESSAGE = ("s", "v", "company")
ROLES = {"s": "information", "v": "confidence"}
NEEDS = {"mutual": 1}  # momentum is unstable where links go one way only
SUMS = ("heard", "heard_s", "heard_v", "heard_company", "alarms")


def mark(me):
    """The mark of a robot, the square of a name, because sums of squares are rarely equal."""
    return (me.name + 1.0) * (me.name + 1.0)


def observe(me, blacks, looks):
    """Add unbiased evidence, weighted by how much the sensor tells."""
    slope = me.b + me.w - 1.0
    s = slope * (blacks - looks * (1.0 - me.w))
    v = slope * slope * looks
    me.mean_s += s
    me.mean_v += v
    add(me, s, v)


def add(me, s, v):
    """Add to the sums sent, and what rounding took before if they are large."""
    if me.unit < LARGE:
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
    """The sums, and the mark, or that the robot is shaken."""
    return me.s, me.v, me.company if me.rounds > 0.0 else mark(me)


def receive(me, message):
    """A neighbour's sums."""
    s, v, company = message
    me.heard += 1.0
    me.heard_s += s
    me.heard_v += v
    me.heard_company += company
    if company < 0.0 or v <= 0.0:
        me.alarms += 1.0


def fuse(me):
    """Average all voices, and step beyond the mean."""
    voices = 1.0 + me.heard
    me.mean_s = (me.s + me.heard_s) / voices
    me.mean_v = (me.v + me.heard_v) / voices
    if not (isfinite(8.0 * me.mean_s) and isfinite(8.0 * me.mean_v)):  # liars exaggerate without end: hear nobody
        me.mean_s = me.s
        me.mean_v = me.v
        me.heard = 0.0
        me.heard_s = 0.0
        me.heard_v = 0.0
    if me.rounds == 0.0:
        me.first = me.heard
        me.company = me.heard_company + mark(me)
    elif me.rounds == 1.0 and me.heard_company == me.heard * me.company:
        me.company = -1.0
    if me.heard == 0.0 or me.heard != me.first or me.alarms > 0.0:
        me.company = -1.0
    s = me.mean_s
    v = me.mean_v
    unit = me.unit + 1.0
    g = 0.0
    if me.company > 0.0 and me.rounds > 1.0:
        share = min(1.0, me.crowd / voices)
        g = me.momentum * (share * share)
        if v + g * (v - me.said_v) <= 0.5 * v:
            g = 0.0
    step_s = g * (s - me.said_s)
    step_v = g * (v - me.said_v)
    step_unit = g * (unit - me.said_unit)
    if me.v_rest != 0.0:  # of sums that are large
        me.s_rest += (1.0 + g) * lost(s, me.s, me.heard_s, me.heard)
        me.v_rest += (1.0 + g) * lost(v, me.v, me.heard_v, me.heard)
    me.said_s = me.s
    me.said_v = me.v
    me.said_unit = unit
    me.s = s
    me.v = v
    me.unit = unit + step_unit
    add(me, step_s, step_v)
    me.rounds += 1.0
    me.heard = 0.0
    me.heard_s = 0.0
    me.heard_v = 0.0
    me.heard_company = 0.0
    me.alarms = 0.0


def estimate(me):
    """The ratio of the means, with the prior, in [0, 1]."""
    if me.mean_v <= 0.0:
        return 0.5
    gain = max(me.said_unit / max(me.rounds, 1.0), 1.0)
    prior = min(0.25, 0.0625 * gain / me.mean_v) * gain
    return min(max((me.mean_s + 0.5 * prior) / (me.mean_v + prior), 0.0), 1.0)
