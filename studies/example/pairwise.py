"""Pairwise gossip by chance: of all that a robot hears in a round, it believes one neighbour, drawn by lot."""

OWN = 0.1  # the weight of a robot's own observations in its opinion

MEMORY = {
    "t": 0.0,  # observations made
    "n": 0.0,  # of which said black
    "x_hat": 0.5,  # local estimate
    "x": 0.5,  # opinion
    "heard": 0.0,  # messages since the last round
    "kept": 0.5,  # one of their opinions
}
MESSAGE = ("x",)


def observe(me, blacks, looks):
    me.t += looks
    me.n += blacks
    slope = me.b + me.w - 1.0
    if abs(slope) > 1e-12:  # else there is nothing to learn from
        me.x_hat = min(max((me.n / me.t + me.w - 1.0) / slope, 0.0), 1.0)


def broadcast(me):
    return (me.x,)


def receive(me, message):
    """Keep the k-th message with probability 1/k: each of them is then as likely to be kept, in whatever order."""
    me.heard += 1.0
    if me.luck * me.heard < 1.0:
        me.kept = message[0]


def fuse(me):
    talk = me.x
    if me.heard > 0.0:
        talk = (me.x + me.kept) / 2.0
    me.x = OWN * me.x_hat + (1.0 - OWN) * talk
    me.heard = 0.0
    me.kept = 0.5


def estimate(me):
    return me.x
