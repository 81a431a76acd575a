"""A round on fixed networks: minds observe, say what they hold, hear each other and fuse.

Like the kernel, which calls it, this file is compiled anew for every brain (see `compiler.py`): `.mind` is that brain.
"""

import numpy as np
from numba import njit

from swarmcensus.engine.draws import arrange, count_blacks
from swarmcensus.engine.modes import FULL, LISTED, SENSING, TALKING

from .mind import (
    add_sums,
    broadcast,
    compiled,
    estimate,
    fuse,
    no_sums,
    observe,
    pack,
    receive,
    sums_with,
    unpack,
)
from .minds import ZERO, fuse_some, heard_by, works

# Robots that are finished together: even, for robots share words in pairs. Robots are counted in uint64 in the
# inner loops: Numba then need not ask whether an index counts from the end.
BLOCK = np.uint64(256)


@njit(nogil=True, error_model="python")
def blocks(receivers, robots):
    """Where each block's links begin, and where the last one's end; links are sorted by receiver."""
    count = (robots + 255) // 256
    out = np.empty(count + 1, np.uint64)
    link = 0
    for place in range(count + 1):
        while link < receivers.size and receivers[link] < place * 256:
            link += 1
        out[place] = link
    return out


@njit(nogil=True, error_model="python")
def observe_where_able(memory, outbox, said, blacks, looks, tick, first, last, stops):
    """The same of robots of which some fail: apart, so that the loop of sound robots stays bare."""
    for i in range(first, last):
        if works(stops, SENSING, i, tick):
            observe(memory[i], float(blacks[i - first]), float(looks))
        pack(outbox, said + i, broadcast(memory[i]))


@compiled
def observe_some(memory, outbox, said, blacks, bits, tables, looks, key, trial, tick, first, last, stops):
    """Robots first ... last - 1 make their round's observations and say what they hold then."""
    count_blacks(blacks, bits, tables, looks, key, trial, tick, first, last)
    if stops.shape[1] > 0:
        observe_where_able(memory, outbox, said, blacks, looks, tick, first, last, stops)
        return
    for i in range(first, last):
        observe(memory[i], float(blacks[i - first]), float(looks))
        pack(outbox, said + i, broadcast(memory[i]))


@compiled
def hear_all(memory, outbox, said, scratch, rows, r):
    """Everyone hears everyone and fuses, in O(N), for a brain whose `receive` only adds.

    What all but one robot say is a sum over those before it and a sum over those after it: no cancellation,
    unlike "all minus own".
    """
    n = np.uint64(memory.size)
    before = no_sums
    for i in range(ZERO, n):
        add_sums(memory[i], before)
        before = sums_with(before, unpack(outbox, said + i), scratch[0])
    after = no_sums
    for below in range(ZERO, n):
        i = n - np.uint64(1) - below
        add_sums(memory[i], after)
        after = sums_with(after, unpack(outbox, said + i), scratch[0])
        fuse(memory[i])
        rows[r, i] = estimate(memory[i])


@njit(nogil=True, error_model="python")
def hear_what_arrives(memory, outbox, said, receivers, senders, first, last, key, trial, tick, threshold, stops):
    """Messages pass along links first ... last - 1, but for those that are lost and robots that do not talk."""
    for link in range(first, last):
        if works(stops, TALKING, senders[link], tick) and (
            threshold == 0 or heard_by(key, trial, tick, receivers[link], senders[link], threshold)
        ):
            receive(memory[receivers[link]], unpack(outbox, said + senders[link]))


@compiled
def hear_listed(memory, outbox, said, receivers, senders, first, last, key, trial, tick, threshold, stops):
    """Messages pass along links first ... last - 1; `threshold` 0 means that none is lost."""
    if threshold > 0 or stops.shape[1] > 0:
        hear_what_arrives(
            memory, outbox, said, receivers, senders, first, last, key, trial, tick, threshold, stops
        )  # fmt: skip
        return
    for link in range(first, last):
        receive(memory[receivers[link]], unpack(outbox, said + senders[link]))


@njit(nogil=True, error_model="python")
def hear_pairs(memory, outbox, said, key, trial, tick, threshold, stops, stop):
    """Everyone hears everyone, one by one: O(N^2), for a lossy radio or a brain that does not only add."""
    for i in range(memory.size):
        if stop[0] != 0:
            return
        for j in range(memory.size):
            if (
                i != j
                and works(stops, TALKING, j, tick)
                and (threshold == 0 or heard_by(key, trial, tick, i, j, threshold))
            ):
                receive(memory[i], unpack(outbox, said + np.uint64(j)))


@njit(nogil=True, error_model="python")
def advance(
    memory, outbox, scratch, blacks, bits, tables, first, last, looks, trial,
    read_key, link_key, links, receivers, senders, reach, threshold, rows, stops, stop,
):  # fmt: skip
    """Run rounds first ... last - 1; their estimates go to `rows`.

    Along listed links a robot ends one round and observes for the next in one go, block by block, so that a
    swarm larger than the processor's cache passes through it once a round. Hence the outbox has two halves:
    `said` is where this round's messages begin.
    """
    n = np.uint64(memory.size)
    said, next_said = ZERO, n
    for k in range(first - 1, last):
        if stop[0] != 0:
            return
        r = k - first
        if r >= 0 and links == FULL:
            hear_all(memory, outbox, said, scratch, rows, r)
        elif r >= 0 and links != LISTED:
            hear_pairs(memory, outbox, said, link_key, trial, k, threshold, stops, stop)
        for start in range(ZERO, n, BLOCK):
            end = min(start + BLOCK, n)
            if r >= 0 and links == LISTED:
                one, other = reach[start // BLOCK], reach[start // BLOCK + np.uint64(1)]
                hear_listed(memory, outbox, said, receivers, senders, one, other, link_key, trial, k, threshold, stops)
            if r >= 0 and links != FULL:
                fuse_some(memory, start, end, rows, r)
            if k + 1 < last:
                observe_some(
                    memory, outbox, next_said, blacks, bits, tables, looks, read_key, trial, k + 1, start, end, stops
                )
        said, next_said = next_said, said


@njit(nogil=True, error_model="python")
def advance_alone(
    memory, reading, blacks, bits, tables, first, last, looks, trial, read_key, order_key, rows, stops, stop
):  # fmt: skip
    """Run single observations first ... last - 1 of robots that hear nobody; their estimates go to `rows`."""
    for k in range(first, last):
        if stop[0] != 0:
            return
        left = looks - (k - 1) % looks
        if left == looks:
            count_blacks(
                blacks, bits, tables, looks, read_key, trial, (k - 1) // looks + 1, ZERO, np.uint64(memory.size)
            )
        arrange(reading, blacks, bits, left, order_key, trial, k)
        for i in range(memory.size):
            if works(stops, SENSING, i, (k - 1) // looks + 1):
                observe(memory[i], reading[i], 1.0)
            fuse(memory[i])
            rows[k - first, i] = estimate(memory[i])
