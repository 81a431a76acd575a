"""What minds do in every world: they begin, fail in parts, lose messages, and settle on an estimate."""

import numpy as np
from numba import njit

from swarmcensus.engine.modes import SENSING, TALKING
from swarmcensus.engine.random import block, counter

ZERO = np.uint64(0)
TILE = 256  # robots whose curves are looked at together: their extremes stay in the processor's nearest cache


@njit(nogil=True)
def begin(memory, blank, b, w):
    """Blank minds that believe in the accuracies b and w (of one robot where all are alike), their last fields."""
    fields = blank.size
    for i in range(memory.shape[0]):
        for j in range(fields):
            memory[i, j] = blank[j]
        memory[i, fields - 2] = b[i % b.size]
        memory[i, fields - 1] = w[i % w.size]


@njit(nogil=True)
def put(into, minds):
    """Copy minds (robot, field); an assignment of arrays takes two seconds to compile."""
    for i in range(minds.shape[0]):
        for j in range(minds.shape[1]):
            into[i, j] = minds[i, j]


@njit(nogil=True, forceinline=True)
def works(stops, part, i, tick):
    """Whether a part of robot i has not failed yet; `stops` (part, robot) is empty where nothing ever fails."""
    return stops.shape[1] == 0 or tick < stops[part, i]


@njit(nogil=True, forceinline=True)
def silence_failed(readings, stops, tick, first, last):
    """No reading for robots whose sensor has failed."""
    if stops.shape[1] > 0:
        for i in range(first, last):
            if not works(stops, SENSING, i, tick):
                readings[i - first] = -1.0


@njit(nogil=True)
def heard_by(key, trial, tick, receiver, sender, threshold):
    """Whether a message gets through, with probability threshold / 2^64."""
    return block(key[0], key[1], counter(trial, tick), counter(receiver, sender))[0] < threshold


@njit(nogil=True, forceinline=True)
def arrives(key, trial, tick, said_at, receiver, sender, threshold, stops):
    """The same of a sender that talked at `said_at`; `threshold` 0 means that no message is lost."""
    return works(stops, TALKING, sender, said_at) and (
        threshold == 0 or heard_by(key, trial, tick, receiver, sender, threshold)
    )


@njit(nogil=True)
def settle(rows, top, delta, low, high, where, value):
    """One backward pass of the paper's convergence rule over rows[0], rows[1], ... = indices top, top + 1, ...

    `low` and `high` hold each robot's extremes over all later indices, `where` and `value` the earliest
    index that is within delta of all later ones. False once no earlier index can qualify for any robot. Robots lie
    side by side in a row and are compared without a branch, so that the processor takes several at once.
    """
    undecided = False
    for first in range(ZERO, np.uint64(low.size), np.uint64(TILE)):
        last = min(first + np.uint64(TILE), np.uint64(low.size))
        open_ones = True
        r = rows.shape[0] - 1
        while r >= 0 and open_ones:
            row = rows[r]
            still = 0
            for i in range(first, last):
                least = low[i]
                most = high[i]
                x = row[i]
                is_open = most - least <= 2.0 * delta  # no more once it met a NaN, which is near to nothing
                less = least if least <= x else x
                more = most if most >= x else x
                near = is_open & (more - x < delta) & (x - less < delta)
                low[i] = less if is_open else least
                high[i] = more if is_open else most
                where[i] = top + r if near else where[i]
                value[i] = x if near else value[i]
                still += is_open & (more - less <= 2.0 * delta)
            open_ones = still > 0
            r -= 1
        undecided |= open_ones
    return undecided
