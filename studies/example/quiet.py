"""Quiet gossip: a robot speaks only when its opinion has moved by more than a step since it last spoke."""

PARAMETERS = {
    "step": 0.02,  # what is worth a message
    "own": 0.02,  # the weight of a robot's own observations in its opinion
}
MEMORY = {
    "t": 0.0,  # observations made
    "n": 0.0,  # of which said black
    "x_hat": 0.5,  # local estimate
    "x": 0.5,  # opinion
    "said": 0.5,  # the opinion that was last told: all begin with this one, which need not be told
    "heard": 0.0,  # messages since the last round
    "heard_x": 0.0,  # the sum of the opinions in them
}
MESSAGE = ("x",)
SUMS = ("heard", "heard_x")


def observe(me, blacks, looks):
    me.t += looks
    me.n += blacks
    slope = me.b + me.w - 1.0
    if abs(slope) > 1e-12:  # else there is nothing to learn from
        me.x_hat = min(max((me.n / me.t + me.w - 1.0) / slope, 0.0), 1.0)


def speaks(me):
    return abs(me.x - me.said) > me.step


def broadcast(me):
    if not speaks(me):
        return None
    return (me.x,)


def receive(me, message):
    me.heard += 1.0
    me.heard_x += message[0]


def fuse(me):
    if speaks(me):  # and so it has, in this round
        me.said = me.x
    talk = (me.x + me.heard_x) / (1.0 + me.heard)
    me.x = me.own * me.x_hat + (1.0 - me.own) * talk
    me.heard = 0.0
    me.heard_x = 0.0


def estimate(me):
    return me.x
