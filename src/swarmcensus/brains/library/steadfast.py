"""Steadfast: commons among liars, bounded by what a robot and its neighbours have read themselves.

Sums s, v of evidence are mixed as in `commons`, with k = b + w - 1. A robot also says o, p, the same sums of its own
readings alone. A lie about these cannot go far, because everybody has readings of the same floor to compare it with.

1. r is a robust mean of the own o / p and of those heard. Each has the standard error sqrt(q (1 - q) / p), where q is
the share of own readings that said black; p counts as at most the own p. A difference d from the last r, with the
standard error D = sqrt(q (1 - q) / p + E^2), counts fully up to HUBER D. From there on its weight falls as HUBER D / d,
and in the last D before ZERO D to nothing. The own o / p always counts fully. The standard error of r is
E = sqrt(q (1 - q) / (sum of p)). r and the sum are averaged over the last 1 / RECENT of all rounds, or LARGE rounds.

2. R is the mean of the own r and those heard, as the robots near have neighbours of their own. An r heard weighs as
much as that robot's own readings in the last r, and counts as at most SECOND E from the own. In honest swarms with few
links R is nearer to f than r. It is averaged as r is.

3. The own o / p pulls r by p times its distance, a neighbour by at most HUBER D p, whatever it says. E is at most the
standard error S of the own o / p when it is made, and D p then at most sqrt(2) S p. So while S and o / p hold still, m
messages a round hold r at most m HUBER sqrt(2) S from it, and the estimate at most (SECOND + CUT) S more. r lags behind
an o / p that varies, and in the first rounds, or with many readings a round, E is larger.

4. Neighbours' sums have the weight of their own readings. With s / v more than GATE E from R they are not counted; with
more than CLIP E they count as at CLIP E. Nobody weighs more than CAP times as much as the own. The estimate is s / v,
cut to R -+ CUT E. If s / v is more than GATE E from R, the robot sets its sums to R.

5. Change, by own readings only, which nobody else can move. `short` is a running mean of the latest, with the evidence
e = min(memory, max(LEAST, p / 4)). If it leaves o / p by more than z sqrt(noise / e), the robot forgets its other own
readings. The noise is measured as in `census`, by how far readings are from `short`, with random signs. Where ground
hangs together it is above q (1 - q), and then takes its place.

A robot that has read nothing gives all messages the same weight. Anonymous: there are no names to forge. As in
`commons`, a robot remembers what rounding took of its sums, so that they bear single precision.
"""

import math

HUBER = 0.35  # standard errors from r to own readings that count fully
ZERO = 3.5  # and to those that do not count
RECENT = 40.0  # r is averaged over the last 1 / RECENT of all rounds
SECOND = 2.5  # E from r to the farthest that a neighbour's r counts as
GATE = 4.0  # E from R to sums that count,
CLIP = 1.2  # that count as they are,
CUT = 1.0  # and to the estimate
CAP = 1.1  # the largest weight of a message, in own weights
LEAST = 10.0  # evidence that the short mean may always hold, in readings of a perfect sensor
LIVES = 16.0  # lives of the short mean over which the noise is averaged
STEEPEST = 1e6  # the largest ratio of sums that a robot can have
MOST = 1e30  # and the most evidence
LARGE = 8192.0  # times new evidence: the sum of which rounding takes too much of it

PARAMETERS = {
    "memory": 100.0,  # the most evidence in the short mean
    "z": 4.0,  # standard deviations that show a change
}
MEMORY = {
    "s": 0.0,  # evidence for black, mixed
    "v": 0.0,  # evidence, mixed
    "own_s": 0.0,  # o
    "own_v": 0.0,  # p
    "s_rest": 0.0,  # what rounding took of s,
    "v_rest": 0.0,  # of v,
    "own_s_rest": 0.0,  # of o
    "own_v_rest": 0.0,  # and of p
    "fresh_s": 0.0,  # of this round
    "fresh": 0.0,
    "short": 0.5,
    "chance": 0.0,  # the running mean with signs
    "sign": 1.0,
    "signed": 0.0,  # evidence since it was drawn
    "noise": 0.125,
    "near_v": 0.0,  # the sum of weights, in own p
    "near": 0.5,  # r
    "error": 1.0,  # E
    "shift": 0.0,  # R - r
    "x": 0.5,  # estimate
    "heard": 0.0,  # weights of messages; the sums in them:
    "heard_s": 0.0,
    "heard_v": 0.0,
    "heard_near_s": 0.0,  # from the last r
    "heard_near_v": 0.0,
    "heard_shift": 0.0,
}
MESSAGE = ("s", "v", "own_s", "own_v", "near")
ROLES = {"s": "information", "v": "confidence", "own_s": "information", "own_v": "confidence", "near": "estimate"}


def observe(me, blacks, looks):
    """Add unbiased evidence, weighted by how much the sensor tells."""
    slope = me.b + me.w - 1.0
    s = slope * (blacks - looks * (1.0 - me.w))
    v = slope * slope * looks
    me.fresh_s += s
    me.fresh += v
    if max(me.v, me.own_v) < LARGE * v:
        me.s += s
        me.v += v
        me.own_s += s
        me.own_v += v
        return
    me.s, me.s_rest = added(me.s, me.s_rest + s)
    me.v, me.v_rest = added(me.v, me.v_rest + v)
    me.own_s, me.own_s_rest = added(me.own_s, me.own_s_rest + s)
    me.own_v, me.own_v_rest = added(me.own_v, me.own_v_rest + v)


def added(total, more):
    """A sum with more added, and what rounding took of it."""
    larger = total + more
    return larger, more - (larger - total)


def lost(mean, own, heard, messages):
    """What rounding took of the mean of an own number and those in messages, whose sum is `heard`."""
    return ((heard - mean * messages) + (own - mean)) / (1.0 + messages)


def broadcast(me):
    """The mixed sums, those of the own readings, and r."""
    return me.s, me.v, me.own_s, me.own_v, me.near


def variance(me):
    """That of own o / p, times p. In q, two of four readings more were black."""
    slope = me.b + me.w - 1.0
    looks = me.own_v / (slope * slope)
    q = (me.own_s / slope + looks * (1.0 - me.w) + 2.0) / (looks + 4.0)
    return max(q * (1.0 - q), me.noise, 1e-12)  # rounding may leave nothing


def sound(s, v):
    """Whether a robot can have such sums."""
    return 0.0 < v <= MOST and abs(s) <= STEEPEST * v


def receive(me, message):
    """A neighbour's sums, as far as the own readings allow."""
    s, v, own_s, own_v, near = message
    if me.own_v <= 0.0 and sound(s, v):
        count(me, s / v, 1.0, 1.0)
    if me.own_v <= 0.0 or not sound(s, v) or not sound(own_s, own_v) or not sound(near, 1.0):
        return
    p = min(own_v, me.own_v)
    off = own_s / own_v - me.near
    error = math.sqrt(variance(me) / p + me.error * me.error)
    far = abs(off)
    if far > ZERO * error:
        return
    share = fades = min(1.0, ZERO - far / error)
    if far > HUBER * error:
        share *= HUBER * error / far
    me.heard_near_s += share * p * off
    me.heard_near_v += fades * p
    me.heard_shift += fades * p * min(max(near - me.near, -SECOND * me.error), SECOND * me.error)
    x, middle = s / v, me.near + me.shift
    if abs(x - middle) <= GATE * me.error:
        v = min(v, CAP * max(me.v, me.own_v))
        count(me, min(max(x, middle - CLIP * me.error), middle + CLIP * me.error) * v, v, share)


def count(me, s, v, share):
    """Count a share of sums."""
    me.heard += share
    me.heard_s += share * s
    me.heard_v += share * v


def fuse(me):
    """Average all voices, and bound the result."""
    s = (me.s + me.heard_s) / (1.0 + me.heard)
    v = (me.v + me.heard_v) / (1.0 + me.heard)
    if me.v_rest != 0.0:  # of sums that are large
        me.s_rest += lost(s, me.s, me.heard_s, me.heard)
        me.v_rest += lost(v, me.v, me.heard_v, me.heard)
    me.s = s
    me.v = v
    if me.fresh > 0.0:
        watch(me)
        look_around(me)
    if me.v > 0.0:
        prior = min(0.25, 0.0625 / me.v)
        me.x = (me.s + 0.5 * prior) / (me.v + prior)
    if me.own_v > 0.0:
        bound(me)
    me.fresh_s = me.fresh = me.heard = me.heard_s = me.heard_v = 0.0
    me.heard_near_s = me.heard_near_v = me.heard_shift = 0.0


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
        me.own_s = me.near = me.short
        me.own_v = me.near_v = 1.0
        me.own_s_rest = me.own_v_rest = 0.0
        me.shift = me.heard_shift = me.heard_near_s = me.heard_near_v = 0.0  # they were compared with what is forgotten


def look_around(me):
    """What the robots near have read."""
    part = min(1.0, max(RECENT * me.fresh / me.own_v, 1.0 / LARGE))
    me.near_v += part * ((me.own_v + me.heard_near_v) / me.own_v - me.near_v)
    me.near += part * (me.own_s - me.own_v * me.near + me.heard_near_s) / (me.own_v * me.near_v)
    me.error = math.sqrt(variance(me) / (me.own_v * me.near_v))
    me.shift += part * (me.heard_shift / (me.own_v * me.near_v) - me.shift)


def bound(me):
    """Cut the estimate, and set the sums to R where they hold lies."""
    middle = me.near + me.shift
    if abs(me.s / me.v - middle) > GATE * me.error:
        me.s = middle * me.own_v
        me.v = me.own_v
        me.s_rest = me.v_rest = 0.0
        me.x = middle
    me.x = min(max(me.x, middle - CUT * me.error), middle + CUT * me.error)


def estimate(me):
    """The estimate, in [0, 1]."""
    return min(max(me.x, 0.0), 1.0)
