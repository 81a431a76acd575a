"""Insider: it knows the source of `census`, and lies in each of its sums by another step towards `goal`.

`step` moves the sums of all readings, `own` those of its own readings, `short` those of the latest; each grows by
`grow` a round. It is honest in the first `sleeps` rounds. The defaults are those of a creeper that lies in all alike.
"""

KNOWS = ("short_v", "own_v")  # the evidence in two of the sums of census
PARAMETERS = {
    "goal": 1.0,
    "step": 0.01, "own": 0.01, "short": 0.01, "grow": 0.0, "sleeps": 0.0,
    "weight": 1.0,  # times the evidence in all sums
    "noise": 1.0,  # times the noise that it measures
    "seen": 1.0,  # times the noise that differences have shown it
    "anew": -1.0,  # what it says of a change: 1 for begun anew, 2 for trying one, 3 for both, 0; the truth below 0
}  # fmt: skip
MEMORY = {"round": 0.0}


def lies(me):
    return me.round >= me.sleeps


def moved(me, x, step):
    far = max(step + me.grow * me.round, 0.0) * lies(me)
    return x + min(max(me.goal - x, -far), far)


def lie(me, x):
    return moved(me, x, me.step)


def boast(me, confidence):
    return confidence * me.weight if lies(me) else confidence


def say_own_s(me, value):
    return moved(me, value / me.own_v, me.own) * boast(me, me.own_v) if me.own_v > 0.0 else value


def say_short_s(me, value):
    return moved(me, value / me.short_v, me.short) * boast(me, me.short_v) if me.short_v > 0.0 else value


def say_noise(me, value):
    return value * me.noise if lies(me) else value


def say_seen(me, value):
    return value * me.seen if lies(me) else value


def say_anew(me, value):
    return float(int(me.anew)) if me.anew >= 0.0 and lies(me) else value


def plot(me):
    me.round += 1.0
