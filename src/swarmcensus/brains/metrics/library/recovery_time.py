"""The time from the last change of the fill ratio until a robot's estimate stays near it."""

from math import inf

UNIT = "rounds"
MEANING = "rounds from the last change of f until |x - f| stays below 0.05; infinite where it is not so at the end"
BETTER = "low"
BOUNDS = (0.0, inf)
WITHIN = 0.05


def begin(my):
    my.truth = 0.0
    my.change = 1.0
    my.since = 1.0


def watch(my, k, estimate, truth):
    if k > 1 and truth != my.truth:
        my.change = k
    my.truth = truth
    if abs(estimate - truth) >= WITHIN:
        my.since = k + 1.0


def result(my):
    return max(my.since - my.change, 0.0) if my.since <= my.rounds else inf
