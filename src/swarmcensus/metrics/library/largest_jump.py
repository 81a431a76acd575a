"""How far a robot's estimate moves in one round, at the most: what a robot that acts on it must bear."""

UNIT = "1"
MEANING = "largest change of the estimate from one round to the next"
BETTER = "low"
BOUNDS = (0.0, 1.0)


def begin(my):
    my.last = 0.0
    my.jump = 0.0


def watch(my, k, estimate, truth):
    if k > 1:  # the first estimate comes out of nothing
        my.jump = max(my.jump, abs(estimate - my.last))
    my.last = estimate


def result(my):
    return my.jump
