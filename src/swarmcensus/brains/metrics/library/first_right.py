"""The round from which a robot decides for the correct bin until the end (bins: paper, Sec. IV-A)."""

from math import inf

UNIT = "rounds"
MEANING = "first round from which on the estimate stays in the correct bin; infinite if outside after the last round"
BETTER = "low"
BOUNDS = (1.0, inf)


def begin(my):
    my.since = 1.0


def watch(my, k, estimate, truth):
    if not my.low <= estimate < my.high:
        my.since = k + 1.0


def result(my):
    return my.since if my.since <= my.rounds else inf
