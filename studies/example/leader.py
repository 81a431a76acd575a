"""Follow the leader: all believe what the robot of the lowest name in the swarm has seen, and pass it on."""

MEMORY = {
    "t": 0.0,  # observations made
    "n": 0.0,  # of which said black
    "x_hat": 0.5,  # local estimate
    "leader": 1e9,  # the lowest name that was heard of: none yet
    "since": 0.0,  # how many observations the leader had made when it said so
    "x": 0.5,  # what it said
}
MESSAGE = ("leader", "since", "x")


def observe(me, blacks, looks):
    me.t += looks
    me.n += blacks
    slope = me.b + me.w - 1.0
    if abs(slope) > 1e-12:  # else there is nothing to learn from
        me.x_hat = min(max((me.n / me.t + me.w - 1.0) / slope, 0.0), 1.0)


def broadcast(me):
    return me.leader, me.since, me.x


def receive(me, message):
    """The lowest name counts, and of the same one the latest news: in whatever order they come."""
    leader, since, x = message
    if (leader, -since, -x) < (me.leader, -me.since, -me.x):
        me.leader = leader
        me.since = since
        me.x = x


def fuse(me):
    if me.name <= me.leader:  # it knows of none before itself
        me.leader = me.name
        me.since = me.t
        me.x = me.x_hat


def estimate(me):
    return me.x
