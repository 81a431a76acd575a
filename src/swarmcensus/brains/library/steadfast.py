"""Steadfast: commons among liars, bounded by what a robot and its neighbours have read themselves.

Sums s, v of evidence are mixed as in `commons`, with k = b + w - 1. A robot also says o, p, the same sums of its own
readings alone. A lie about these cannot go far, because everybody has readings of the same floor to compare it with.

1. Pairs. A neighbour's o / p and the own differ by chance with the standard error W sqrt(1 / p + 1 / p') / 2, or less.
A neighbour whose o / p differs by more than PAIR of them is not heard.

2. r is the mean of the own o / p and those of all who are heard, with weights p, but at most the own p. Each counts as
if it were at most WINSOR standard errors from the last r, and not at all beyond NEAR. So a minority cannot draw r far.
Its standard error is E = W / (2 sqrt(sum of weights)). Both are averaged over the last 1 / RECENT of all rounds.

3. Sums with s / v more than GATE E from r are not counted. Others weigh at most CAP times as much as the own.

4. The estimate is s / v, cut to r -+ CUT E. If s / v is more than GATE E from r, others have mixed in lies: the robot
sets its sums to r. So for any lie the error is hardly above sqrt(1 + CUT^2) E. E is the error of a robot alone over the
root of the number of honest robots near.

5. Change, by own readings only, which nobody else can move. `short` is a running mean of the latest, with the evidence
e = min(memory, max(LEAST, p / 4)). If it leaves o / p by more than z sqrt(noise / e), the robot forgets its other own
readings. The noise is measured as in `census`, by how far readings are from `short`, with random signs. Where ground
hangs together it is above 1 / 4, and then W^2 = 4 noise; else W = 1.

A robot that has read nothing gives all messages the same weight. Anonymous: there are no names to forge.
"""

import math

PAIR = 4.5  # standard errors between two robots' own readings
NEAR = 2.5  # from r to own readings that count in it
WINSOR = 0.6  # and the largest that they count as
RECENT = 20.0  # r is averaged over the last 1 / RECENT of all rounds
GATE = 4.0  # from r to sums that count
CUT = 1.25  # and to the estimate
CAP = 2.0  # the largest weight of a message, in own weights
LEAST = 10.0  # evidence that the short mean may always hold, in readings of a perfect sensor
LIVES = 16.0  # lives of the short mean over which the noise is averaged
STEEPEST = 1e6  # the largest ratio of sums that a robot can have

PARAMETERS = {
    "memory": 100.0,  # the most evidence in the short mean
    "z": 4.0,  # standard deviations that show a change
}
MEMORY = {
    "s": 0.0,  # evidence for black, mixed
    "v": 0.0,  # evidence, mixed
    "own_s": 0.0,  # o
    "own_v": 0.0,  # p
    "fresh_s": 0.0,  # of this round
    "fresh": 0.0,
    "short": 0.5,
    "chance": 0.0,  # the running mean with signs
    "sign": 1.0,
    "signed": 0.0,  # evidence since it was drawn
    "noise": 0.125,
    "near_s": 0.0,  # r, times near_v
    "near_v": 0.0,  # the sum of weights, in own p
    "near": 0.5,  # r
    "error": 1.0,  # E
    "bound": 0.0,  # rounds in which a limit has changed the estimate
    "x": 0.5,  # estimate
    "heard": 0.0,  # messages that count; the sums in them:
    "heard_s": 0.0,
    "heard_v": 0.0,
    "heard_near_s": 0.0,
    "heard_near_v": 0.0,
}
MESSAGE = ("s", "v", "own_s", "own_v")
ROLES = {"s": "information", "v": "confidence", "own_s": "information", "own_v": "confidence"}


def observe(me, blacks, looks):
    """Add unbiased evidence, weighted by how much the sensor tells."""
    slope = me.b + me.w - 1.0
    s = slope * (blacks - looks * (1.0 - me.w))
    v = slope * slope * looks
    me.s += s
    me.v += v
    me.own_s += s
    me.own_v += v
    me.fresh_s += s
    me.fresh += v


def broadcast(me):
    """The mixed sums, and those of the own readings."""
    return me.s, me.v, me.own_s, me.own_v


def width(me):
    """W: how many times more own readings vary than independent ones."""
    return max(1.0, 2.0 * math.sqrt(me.noise))


def sound(s, v):
    """Whether a robot can have such sums."""
    return abs(s) <= STEEPEST * v and v > 0.0


def receive(me, message):
    """A neighbour's sums, as far as the own readings allow."""
    s, v, own_s, own_v = message
    if not sound(s, v):
        return
    if me.own_v <= 0.0:
        count(me, s / v, 1.0)
        return
    if not sound(own_s, own_v):
        return
    weight = min(own_v, me.own_v)
    other = own_s / own_v
    half = 0.5 * width(me)
    if abs(other - me.own_s / me.own_v) > PAIR * half * math.sqrt(1.0 / me.own_v + 1.0 / weight):
        return
    off = other - me.near
    error = math.sqrt(half * half / weight + me.error * me.error)
    if me.near_v == 0.0:
        off = error = 0.0
    if abs(off) <= NEAR * error:
        me.heard_near_s += weight * (other - off + min(max(off, -WINSOR * error), WINSOR * error))
        me.heard_near_v += weight
    if me.near_v == 0.0 or abs(s / v - me.near) <= GATE * me.error:
        share = min(1.0, CAP * max(me.v, me.own_v) / v)
        count(me, share * s, share * v)


def count(me, s, v):
    """Count sums."""
    me.heard += 1.0
    me.heard_s += s
    me.heard_v += v


def fuse(me):
    """Average all voices, and bound the result."""
    me.s = (me.s + me.heard_s) / (1.0 + me.heard)
    me.v = (me.v + me.heard_v) / (1.0 + me.heard)
    if me.fresh > 0.0:
        watch(me)
    if me.v > 0.0:
        prior = min(0.25, 0.0625 / me.v)
        me.x = (me.s + 0.5 * prior) / (me.v + prior)
    if me.own_v > 0.0:
        look_around(me)
        bound(me)
    me.fresh_s = me.fresh = me.heard = me.heard_s = me.heard_v = me.heard_near_s = me.heard_near_v = 0.0


def watch(me):
    """Learn how much own readings vary, and begin again with the latest if the floor has changed."""
    e = min(me.own_v, me.memory, max(LEAST, 0.25 * me.own_v))
    part = min(me.fresh / e, 1.0)
    off = part * (me.fresh_s / me.fresh - me.short)
    me.short += off
    me.chance += me.sign * off - part * me.chance
    me.noise += part / LIVES * (me.chance * me.chance * e - me.noise)
    me.signed += me.fresh
    if me.signed >= e:
        me.signed = 0.0
        me.sign = 1.0 if me.luck < 0.5 else -1.0
    off = me.short - me.own_s / me.own_v
    if me.own_v > 1.01 * e and off * off * e > me.z * me.z * max(me.noise, 0.125):
        me.own_s = me.near_s = me.short
        me.own_v = me.near_v = 1.0


def look_around(me):
    """What the robots near have read."""
    part = min(1.0, RECENT * me.fresh / me.own_v)
    me.near_s += part * ((me.own_s + me.heard_near_s) / me.own_v - me.near_s)
    me.near_v += part * ((me.own_v + me.heard_near_v) / me.own_v - me.near_v)
    if me.near_v > 0.0:
        me.near = me.near_s / me.near_v
        me.error = 0.5 * width(me) / math.sqrt(me.own_v * me.near_v)


def bound(me):
    """Cut the estimate, and set the sums to r where they hold lies."""
    off = me.s / me.v - me.near
    if abs(off) <= CUT * me.error:
        return
    me.bound += 1.0
    if abs(off) > GATE * me.error:
        me.s = me.near * me.own_v
        me.v = me.own_v
        off = 0.0
    me.x = me.near + min(max(off, -CUT * me.error), CUT * me.error)


def estimate(me):
    """The estimate, in [0, 1]."""
    return min(max(me.x, 0.0), 1.0)
