"""The root of a robot's mean squared error over a trial: it counts large errors more than `mean-error` does."""

from math import sqrt

UNIT = "1"
LABEL = "RMS error"
MEANING = "root of the mean of (x - f)^2 over all rounds"
BETTER = "low"
BOUNDS = (0.0, 1.0)


def begin(my):
    my.squares = 0.0


def watch(my, k, estimate, truth):
    my.squares += (estimate - truth) * (estimate - truth)


def result(my):
    return sqrt(my.squares / my.rounds)
