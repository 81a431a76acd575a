"""The mean error of a robot's estimate over a trial: the area under its error curve, divided by the rounds."""

UNIT = "1"
MEANING = "mean |x - f| over all rounds"
BETTER = "low"
BOUNDS = (0.0, 1.0)


def begin(my):
    my.total = 0.0


def watch(my, k, estimate, truth):
    my.total += abs(estimate - truth)


def result(my):
    return my.total / my.rounds
