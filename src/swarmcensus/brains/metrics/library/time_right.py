"""The share of rounds in which a robot decides for the correct bin (bins: paper, Sec. IV-A)."""

UNIT = "1"
MEANING = "share of rounds in the correct bin"
BETTER = "high"
BOUNDS = (0.0, 1.0)


def begin(my):
    my.right = 0.0


def watch(my, k, estimate, truth):
    if my.low <= estimate < my.high:
        my.right += 1.0


def result(my):
    return my.right / my.rounds
