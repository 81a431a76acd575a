"""The largest change of a robot's estimate in one round, for which a robot that acts on it must be prepared."""

UNIT = "1"
MEANING = "largest change of the estimate from one round to the next"
BETTER = "low"
BOUNDS = (0.0, 1.0)


def begin(my):
    my.last = 0.0
    my.jump = 0.0


def watch(my, k, estimate, truth):
    if k > 1:  # there is no estimate before the first
        my.jump = max(my.jump, abs(estimate - my.last))
    my.last = estimate


def result(my):
    return my.jump
