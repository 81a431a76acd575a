"""Insider: it knows the source of `steadfast`, and moves the sums of all readings and of its own towards black.

It says r + `errors` E instead where that is not 0, with r the mean of its own and its neighbours' own readings, and E
the standard error of r. Or it repeats what it said in round `repeats`. Until then, and until round `sleeps`, it is
honest.
"""

KNOWS = ("s", "v", "own_s", "own_v", "heard_own_s", "heard_own_v")
PARAMETERS = {
    "step": 0.0,  # how far it moves s / v; towards white below 0
    "own": 0.0,  # and its own readings
    "errors": 0.0,
    "weight": 1.0,  # times the evidence in all sums
    "sleeps": 0.0,
    "repeats": 0.0,  # 0: never
}
MEMORY = {
    "round": 0.0,
    "others_s": 0.0,  # own readings of its neighbours
    "others_v": 0.0,
    "near_s": 0.0,  # and with its own
    "near_v": 0.0,
    "old_s": 0.0,  # what it repeats
    "old_v": 0.0,
    "old_own_s": 0.0,
    "old_own_v": 0.0,
}


def lies(me):
    return me.round >= max(me.sleeps, me.repeats)


def lie(me, x):
    if not lies(me):
        return x
    if me.repeats > 0.0:
        return me.old_s / me.old_v if me.old_v > 0.0 else x
    if me.errors != 0.0 and me.near_v > 0.0:
        r = me.near_s / me.near_v
        q = min(max((me.b + me.w - 1.0) * r + 1.0 - me.w, 0.0), 1.0)  # the share of black readings
        return r + me.errors * (q * (1.0 - q) / me.near_v) ** 0.5
    return x + me.step


def boast(me, confidence):
    if not lies(me):
        return confidence
    return me.old_v if me.repeats > 0.0 else confidence * me.weight


def say_own_s(me, value):
    if not lies(me):
        return value
    return me.old_own_s if me.repeats > 0.0 else (value + me.own * me.own_v) * me.weight


def say_own_v(me, value):
    if not lies(me):
        return value
    return me.old_own_v if me.repeats > 0.0 else value * me.weight


def hear(me, x):
    me.others_s = me.heard_own_s
    me.others_v = me.heard_own_v


def plot(me):
    me.round += 1.0
    me.near_s = me.own_s + me.others_s
    me.near_v = me.own_v + me.others_v
    me.others_s = 0.0
    me.others_v = 0.0
    if me.round == me.repeats:
        me.old_s = me.s
        me.old_v = me.v
        me.old_own_s = me.own_s
        me.old_own_v = me.own_v
