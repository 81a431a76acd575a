"""A belief over ten bins: each robot weighs every bin by its readings, adds its neighbours' weights, picks the best."""

import math

BINS = 10
OPTIONS = 10  # what `decide` decides among: [0, 0.1), [0.1, 0.2), ... of the fill ratio

MEMORY = {
    "own": (0.0,) * 10,  # the logarithm of how likely its readings are, were the fill ratio in the bin's middle
    "heard": (0.0,) * 10,  # the sum of the neighbours' in this round
    "belief": (0.0,) * 10,  # both together
}
MESSAGE = ("own",)
SUMS = ("heard",)


def observe(me, blacks, looks):
    for k in range(BINS):
        middle = (k + 0.5) / BINS
        black = me.b * middle + (1.0 - me.w) * (1.0 - middle)  # the probability of a black reading
        black = min(max(black, 1e-9), 1.0 - 1e-9)
        me.own[k] += blacks * math.log(black) + (looks - blacks) * math.log(1.0 - black)


def broadcast(me):
    return (me.own,)


def receive(me, message):
    for k in range(BINS):
        me.heard[k] += message[0][k]


def fuse(me):
    for k in range(BINS):
        me.belief[k] = me.own[k] + me.heard[k]
        me.heard[k] = 0.0


def best(me):
    found = 0
    for k in range(1, BINS):
        if me.belief[k] > me.belief[found]:
            found = k
    return found


def decide(me):
    found = best(me)
    if me.belief[found] == 0.0:  # nothing is known yet: all bins weigh the same
        return -1
    return found


def estimate(me):
    """The mean over the bins' middles."""
    top = me.belief[best(me)]
    total = 0.0
    mean = 0.0
    for k in range(BINS):
        weight = math.exp(me.belief[k] - top)
        total += weight
        mean += weight * (k + 0.5) / BINS
    return mean / total
