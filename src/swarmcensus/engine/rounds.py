"""A round on fixed networks: minds observe, say what they hold, hear each other and fuse.

`minds` are the addresses of a brain's functions (see `calling.py`).
"""

import numpy as np
from numba import njit

from swarmcensus.engine.calling import call
from swarmcensus.engine.draws import arrange, count_blacks
from swarmcensus.engine.modes import (
    ADD_UP,
    END_ROUND,
    FULL,
    GO_ALONE,
    HEAR,
    HEAR_ALL,
    HEAR_SUMS,
    LISTED,
    SENSE,
)

from .minds import ZERO, arrives, silence_failed

# Robots that are finished together: even, for robots share words in pairs. Robots are counted in uint64 in the
# inner loops: Numba then need not ask whether an index counts from the end.
BLOCK = 256
CACHED = 1 << 15  # robots up to which a full network passes through the cache as a whole


@njit(nogil=True)
def bounds_of(receivers, robots):
    """Where each robot's links begin, and where the last one's end; links are sorted by receiver."""
    out = np.empty(robots + 1, np.int64)
    link = 0
    for i in range(robots + 1):
        while link < receivers.size and receivers[link] < i:
            link += 1
        out[i] = link
    return out


@njit(nogil=True)
def most_links(bounds, links, robots):
    """How many messages may arrive in one call: at a block of robots, or of a full network at one robot."""
    most = robots if links != LISTED else 0
    for first in range(0, robots, BLOCK):
        most = max(most, bounds[min(first + BLOCK, robots)] - bounds[first])
    return most


@njit(nogil=True)
def hear_what_arrives(
    minds, memory, outbox, said, receivers, senders, first, last, arrivals, key, trial, tick, threshold, stops
):  # fmt: skip
    """Messages pass along links first ... last - 1, but for those that are lost and robots that do not talk."""
    count = 0
    for link in range(first, last):
        if arrives(key, trial, tick, tick, np.int64(receivers[link]), np.int64(senders[link]), threshold, stops):
            arrivals[0, count] = receivers[link]
            arrivals[1, count] = senders[link]
            count += 1
    call(minds[HEAR], memory, outbox, said, arrivals[0], arrivals[1], ZERO, count, memory.shape[0])


@njit(nogil=True)
def hear_pairs(minds, memory, outbox, said, arrivals, key, trial, tick, threshold, stops, stop):
    """Everyone hears everyone, one by one: O(N^2), for a lossy radio or a brain that does not only add."""
    robots = memory.shape[0]
    for i in range(robots):
        if stop[0] != 0:
            return
        count = 0
        for j in range(robots):
            if i != j and arrives(key, trial, tick, tick, i, j, threshold, stops):
                arrivals[0, count] = i
                arrivals[1, count] = j
                count += 1
        call(minds[HEAR], memory, outbox, said, arrivals[0], arrivals[1], ZERO, count, memory.shape[0])


@njit(nogil=True)
def advance(
    minds, additive, memory, outbox, sums_beside, readings, bits, tables, first, last, looks, trial,
    read_key, link_key, links, receivers, senders, bounds, arrivals, threshold, rows, stops, stop,
):  # fmt: skip
    """Run rounds first ... last - 1; their estimates go to `rows`.

    But for pairs a robot ends one round and observes for the next in one go, block by block, so that a
    swarm larger than the processor's cache passes through it once a round. Hence the outbox has two halves:
    `said` is where this round's messages begin.
    """
    n = np.uint64(memory.shape[0])
    said, next_said = ZERO, n
    sound = threshold == 0 and stops.shape[1] == 0
    in_sums = links == LISTED and sound and additive
    at_once = n <= CACHED
    for k in range(first - 1, last):
        if stop[0] != 0:
            return
        r = k - first
        here = np.uint64(max(r, 0)) * n
        if r >= 0 and links == FULL:
            call(minds[ADD_UP], outbox, said, sums_beside, n if at_once else np.uint64(BLOCK), n)
            if at_once:
                call(minds[HEAR_ALL], memory, outbox, said, sums_beside, ZERO, rows, here, ZERO, n)
        elif r >= 0 and links != LISTED:
            hear_pairs(minds, memory, outbox, said, arrivals, link_key, trial, k, threshold, stops, stop)
        for block in range(ZERO, np.uint64(sums_beside.shape[0] - 1)):
            start = block * np.uint64(BLOCK)
            end = min(start + np.uint64(BLOCK), n)
            if r >= 0 and in_sums:
                call(
                    minds[HEAR_SUMS], memory, outbox, said, bounds, senders, senders.size, rows, here, start, end, n
                )  # fmt: skip
            elif r >= 0 and links == FULL and not at_once:
                call(minds[HEAR_ALL], memory, outbox, said, sums_beside, block, rows, here, start, end)
            elif r >= 0 and links != FULL:
                if links == LISTED and sound:
                    call(minds[HEAR], memory, outbox, said, receivers, senders, bounds[start], bounds[end], n)
                elif links == LISTED:
                    hear_what_arrives(
                        minds, memory, outbox, said, receivers, senders, bounds[start], bounds[end], arrivals,
                        link_key, trial, k, threshold, stops,
                    )  # fmt: skip
                call(minds[END_ROUND], memory, rows, here, start, end)
            if k + 1 < last:
                count_blacks(readings, bits, tables, looks, read_key, trial, k + 1, start, end)
                silence_failed(readings, stops, k + 1, start, end)
                call(minds[SENSE], memory, outbox, next_said, readings, float(looks), start, end)
        said, next_said = next_said, said


@njit(nogil=True)
def advance_alone(
    minds, memory, readings, blacks, bits, tables, first, last, looks, trial, read_key, order_key, rows, stops, stop
):  # fmt: skip
    """Run single observations first ... last - 1 of robots that hear nobody; their estimates go to `rows`."""
    n = np.uint64(memory.shape[0])
    for k in range(first, last):
        if stop[0] != 0:
            return
        left = looks - (k - 1) % looks
        tick = (k - 1) // looks + 1
        if left == looks:
            count_blacks(blacks, bits, tables, looks, read_key, trial, tick, ZERO, n)
        arrange(readings, blacks, bits, left, order_key, trial, k)
        silence_failed(readings, stops, tick, ZERO, n)
        call(minds[GO_ALONE], memory, readings, rows, np.uint64(k - first) * n, n)
