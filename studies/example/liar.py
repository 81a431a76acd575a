"""A liar: it looks as others do, and tells them the opposite of what it sees."""

MEMORY = {
    "t": 0.0,  # observations made
    "n": 0.0,  # of which said black
    "x_hat": 0.5,  # local estimate
}
MESSAGE = ("x",)


def observe(me, blacks, looks):
    me.t += looks
    me.n += blacks
    slope = me.b + me.w - 1.0
    if abs(slope) > 1e-12:  # else there is nothing to learn from
        me.x_hat = min(max((me.n / me.t + me.w - 1.0) / slope, 0.0), 1.0)


def broadcast(me):
    return (1.0 - me.x_hat,)


def receive(me, message):
    pass


def fuse(me):
    pass


def estimate(me):
    return me.x_hat
