"""Insider: it knows the source of `steadfast`, and moves the sums of all readings and of its own towards black.

Where `from_r` is not 0, it says r + `from_r` E instead of s / v: r is what robots near have read, and E its standard
error, both as it knows them itself. `lean` and `from_r` may point away from what its own readings say, which is the
worst that it can do without knowing f. Where `corner` is not 0, it says own readings `corner` D from r, where D is what
a robot allows for chance between r and readings. `second` moves the r that it says to the same side. Or it repeats its
sums at the end of round `repeats`. Until then, and until round `sleeps`, it is honest.
"""

import math

KNOWS = ("s", "v", "own_s", "own_v", "near", "error", "noise")
PARAMETERS = {
    "step": 0.0,  # how far it moves s / v; towards white below 0
    "own": 0.0,  # and its own readings,
    "lean": 0.0,  # also in their standard errors
    "corner": 0.0,  # or where they lie, in D from r
    "from_r": 0.0,  # s / v, in E from r
    "sides": 0.0,  # 0: `lean` and `from_r` towards black; 1: away from what its own readings say
    "second": 0.0,  # what it says of r, in E from the own, to the same side
    "weight": 1.0,  # times the evidence in all sums
    "sleeps": 0.0,
    "repeats": 0.0,  # 0: never
}
MEMORY = {
    "round": 0.0,
    "old_s": 0.0,  # what it repeats
    "old_v": 0.0,
    "old_own_s": 0.0,
    "old_own_v": 0.0,
}


def lies(me):
    return me.round >= max(me.sleeps, me.repeats)


def side(me):
    return -1.0 if me.sides > 0.5 and me.own_s > me.near * me.own_v else 1.0


def deviation(me):
    slope = me.b + me.w - 1.0
    looks = me.own_v / (slope * slope)
    q = (me.own_s / slope + looks * (1.0 - me.w) + 2.0) / (looks + 4.0)
    return math.sqrt(max(q * (1.0 - q), me.noise) / me.own_v + me.error * me.error)


def lie(me, x):
    if not lies(me):
        return x
    if me.repeats > 0.0:
        return me.old_s / me.old_v if me.old_v > 0.0 else x
    return me.near + side(me) * me.from_r * me.error if me.from_r != 0.0 else x + me.step


def boast(me, confidence):
    if not lies(me):
        return confidence
    return me.old_v if me.repeats > 0.0 else confidence * me.weight


def say_own_s(me, value):
    if not lies(me):
        return value
    if me.repeats > 0.0:
        return me.old_own_s
    if me.corner != 0.0 and me.own_v > 0.0:
        return me.own_v * (me.near + side(me) * me.corner * deviation(me)) * me.weight
    return (value + me.own * me.own_v + 0.5 * side(me) * me.lean * me.own_v**0.5) * me.weight


def say_own_v(me, value):
    if not lies(me):
        return value
    return me.old_own_v if me.repeats > 0.0 else value * me.weight


def say_near(me, value):
    return value + side(me) * me.second * me.error if lies(me) else value


def plot(me):
    me.round += 1.0
    if me.round == me.repeats:
        me.old_s = me.s
        me.old_v = me.v
        me.old_own_s = me.own_s
        me.old_own_v = me.own_v
