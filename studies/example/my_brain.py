"""Gossip: a robot repeats what it hears, and mixes in a little of what it has seen itself."""

OWN = 0.1  # the weight of a robot's own observations in its opinion

MEMORY = {
    "t": 0.0,  # observations made
    "n": 0.0,  # of which said black
    "x_hat": 0.5,  # local estimate
    "x": 0.5,  # opinion: the estimate after talking
    "heard": 0.0,  # messages since the last round
    "heard_x": 0.0,  # the sum of the opinions in them
}
MESSAGE = ("x",)
SUMS = ("heard", "heard_x")


def observe(me, blacks, looks):
    me.t += looks
    me.n += blacks
    slope = me.b + me.w - 1.0
    if me.t > 0.0 and abs(slope) > 1e-12:  # else there is nothing to learn from
        me.x_hat = min(max((me.n / me.t + me.w - 1.0) / slope, 0.0), 1.0)


def broadcast(me):
    return (me.x,)


def receive(me, message):
    me.heard += 1.0
    me.heard_x += message[0]


def fuse(me):
    talk = (me.x + me.heard_x) / (1.0 + me.heard)
    me.x = OWN * me.x_hat + (1.0 - OWN) * talk
    me.heard = 0.0
    me.heard_x = 0.0


def estimate(me):
    return me.x
