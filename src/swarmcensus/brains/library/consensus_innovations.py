"""Consensus + innovations: a fixed step towards the neighbours' values, a decreasing one towards the own readings.

Kar, Moura, "Consensus + innovations distributed inference over networks", 2013, in its scalar form. In the t-th round
with readings, counted from 0,

    x += -B sum (x - x_j) + (z - x) / (t + 1),    z = (share - 1 + w) / (b + w - 1) of the round's readings

As published: this step, but for B. If links go both ways, B is the same at all links, and all robots have readings in
every round, the mean of all x is that of all z so far; each x approaches it if the network is connected on average.

Deviations:
- B, `pull`, is at most 1 / (1 + neighbours heard), so that consensus is a weighted mean and does not oscillate with
  many neighbours. The source chooses B for a network with known degrees. If the bound applies to some robots only, the
  mean of all x is not preserved.
- B stays. In the source it falls with the rounds too, more slowly than the step of the innovations.
- A round without readings, or with b + w = 1, has no innovation and is not counted.
- Robots with good and poor sensors have the same weight, as in the plain form.
- x may leave [0, 1], as z does; the estimate is clipped to [0, 1].
"""

PARAMETERS = {
    "pull": 0.25,  # B
}
MEMORY = {
    "t": 0.0,  # observations made in this round
    "n": 0.0,  # black ones among them
    "rounds": 0.0,  # with readings, so far
    "x": 0.5,  # the value, before clipping
    "heard": 0.0,  # messages in this round
    "heard_x": 0.0,  # the sum of their values
}
MESSAGE = ("x",)
SUMS = ("heard", "heard_x")


def observe(me, blacks, looks):
    """Count readings."""
    me.t += looks
    me.n += blacks


def broadcast(me):
    """The value."""
    return (me.x,)


def receive(me, message):
    """A neighbour's term of the sum."""
    me.heard += 1.0
    me.heard_x += message[0]


def fuse(me):
    """Add the steps of consensus and innovation."""
    step = min(me.pull, 1.0 / (1.0 + me.heard)) * (me.heard_x - me.heard * me.x)
    slope = me.b + me.w - 1.0
    if me.t > 0.0 and abs(slope) >= 1e-12:
        z = (me.n / me.t + me.w - 1.0) / slope
        me.rounds += 1.0
        step += (z - me.x) / me.rounds
    me.x += step
    me.t = 0.0
    me.n = 0.0
    me.heard = 0.0
    me.heard_x = 0.0


def estimate(me):
    """The value, clipped."""
    return min(max(me.x, 0.0), 1.0)
