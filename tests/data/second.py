"""Luck, parameters, vectors, silence, decisions and an end, in one brain: kept as it was for results that name it."""

PARAMETERS = {"chatter": 0.5, "enough": 60.0, "weights": (0.5, 0.25, 0.25)}
MEMORY = {
    "t": 0.0,
    "n": 0.0,
    "x": 0.5,
    "talks": 1.0,
    "heard": 0.0,
    "kept": 0.5,
    "recent": (0.5,) * 3,
}
MESSAGE = ("x", "recent")
OPTIONS = 2


def observe(me, blacks, looks):
    me.t += looks
    me.n += blacks


def broadcast(me):
    if me.talks > 0.0:
        return me.x, me.recent
    return None


def receive(me, message):
    x, recent = message
    me.heard += 1.0
    if me.luck < 1.0 / me.heard:
        me.kept = 0.5 * x + 0.5 * recent[2]


def fuse(me):
    me.heard = 0.0
    total = 0.0
    if me.t > 0.0:
        me.recent[0] = me.n / me.t
    me.recent[1] = me.kept
    me.recent[2] = me.luck
    for k in range(len(me.recent)):
        total += me.weights[k] * me.recent[k]
    me.x = min(max(total, 0.0), 1.0)
    me.talks = 1.0 if me.luck < me.chatter else 0.0


def estimate(me):
    return me.x


def decide(me):
    if me.t < 30.0:
        return -1
    return 1 if me.x > 0.5 else 0


def done(me):
    return me.t >= me.enough
