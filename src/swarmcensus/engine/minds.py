"""What minds do in every world: they begin, fuse, fail in parts, lose messages, and settle on an estimate.

Like the kernel, this file is compiled anew for every brain (see `compiler.py`): `.mind` is that brain.
"""

import numpy as np
from numba import njit

from swarmcensus.engine.random import block, counter

from .mind import compiled, estimate, fuse

ZERO = np.uint64(0)


@njit(nogil=True, error_model="python")
def begin(memory, blank, b, w):
    """Blank minds that believe in the accuracies b and w (of one robot where all are alike)."""
    for i in range(memory.size):
        memory[i] = blank[0]
        memory[i].b = b[i % b.size]
        memory[i].w = w[i % w.size]


@compiled
def works(stops, part, i, tick):
    """Whether a part of robot i has not failed yet; `stops` (part, robot) is empty where nothing ever fails."""
    return stops.shape[1] == 0 or tick < stops[part, i]


@compiled
def fuse_some(memory, first, last, rows, r):
    """Robots first ... last - 1 end their round; their estimates go to row r."""
    for i in range(first, last):
        fuse(memory[i])
        rows[r, i] = estimate(memory[i])


@njit(nogil=True, error_model="python")
def heard_by(key, trial, tick, receiver, sender, threshold):
    """Whether a message gets through, with probability threshold / 2^64."""
    return block(key[0], key[1], counter(trial, tick), counter(receiver, sender))[0] < threshold


@njit(nogil=True, error_model="python")
def settle(rows, top, delta, low, high, where, value):
    """One backward pass of the paper's convergence rule over rows[0], rows[1], ... = indices top, top + 1, ...

    `low` and `high` hold each robot's extremes over all later indices, `where` and `value` the earliest
    index that is within delta of all later ones. False once no earlier index can qualify for any robot.
    """
    undecided = False
    for i in range(low.size):
        least = low[i]
        most = high[i]
        r = rows.shape[0] - 1
        while r >= 0 and most - least <= 2.0 * delta:
            x = rows[r, i]
            least = least if least <= x else x  # NaN sticks, and is near to nothing
            most = most if most >= x else x
            if most - x < delta and x - least < delta:
                where[i] = top + r
                value[i] = x
            r -= 1
        low[i] = least
        high[i] = most
        undecided |= most - least <= 2.0 * delta
    return undecided
