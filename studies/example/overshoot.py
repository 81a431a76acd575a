"""How far an estimate goes beyond the truth, from the side on which it began."""

UNIT = "1"
MEANING = "largest overshoot of the estimate beyond the fill ratio"
BETTER = "low"


def begin(my):
    my.side = 0.0
    my.most = 0.0


def watch(my, k, estimate, truth):
    if k == 1:
        my.side = 1.0 if estimate < truth else -1.0
    my.most = max(my.most, my.side * (estimate - truth))


def result(my):
    return my.most
