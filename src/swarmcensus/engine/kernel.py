"""The engine's inner loops on fixed networks: minds that observe, talk and fuse, round by round.

This file is compiled anew for every brain (see `compiler.py`): `.mind` is that brain.
"""

import numpy as np
from numba import njit

from swarmcensus.engine.draws import arrange, black_tables, count_blacks
from swarmcensus.engine.modes import FULL, LISTED, SENSING, TALKING

from .mind import (
    add_sums,
    broadcast,
    compiled,
    entry,
    estimate,
    fuse,
    no_sums,
    observe,
    outbox_width,
    pack,
    receive,
    sums_with,
    unpack,
)
from .minds import ZERO, begin, fuse_some, heard_by, settle, works

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


@entry
def simulate(
    blank, memory, outbox, rows, snapshots, first_trial, b, w, assumed_b, assumed_w, fill_ratio, local, looks, rounds,
    read_key, order_key, link_key, links, starts, all_receivers, all_senders, threshold, all_stops,
    delta, bin_low, bin_high, checkpoints, where, value, final, correct, kept, stop,
):  # fmt: skip
    """Run a batch of trials from blank minds to their metrics; False if stopped.

    Accuracies are (trial, robot or 1). Links are those of graph g in [starts[g], starts[g + 1]), one graph for
    all trials or one for each. `memory` (robot), `outbox` (2 robots, message), `rows` (index, robot) and
    `snapshots` (segment, robot) are room to work in. With `local`, robots hear nobody and `rounds` counts single
    observations. `kept` (checkpoint or 0, trial, robot) is filled with estimates at the checkpoints, if it has room.
    Estimates are kept for a segment of indices, as many as `rows`, at a time; where the
    convergence rule must look further back, the segment before is run again from a snapshot of the minds, to the
    same bits.
    """
    robots = memory.size
    segment = rows.shape[0]
    segments = (rounds + segment - 1) // segment
    scratch = blank.copy()
    blacks = np.zeros(robots if local else min(robots, 256), np.int64)
    bits = np.zeros(blacks.size, np.uint64)
    reading = np.zeros(robots)
    low = np.empty(robots)
    high = np.empty(robots)
    for trial in range(where.shape[0]):
        number = first_trial + trial
        graph = trial if starts.size > 2 else 0
        receivers = all_receivers[starts[graph] : starts[graph + 1]]
        senders = all_senders[starts[graph] : starts[graph + 1]]
        stops = all_stops[trial]
        reach = blocks(receivers, robots)
        tables = black_tables(b[trial], w[trial], fill_ratio, looks)
        begin(memory, blank, assumed_b[trial], assumed_w[trial])
        start = np.empty((1, robots))
        for i in range(robots):
            start[0, i] = estimate(memory[i])
        for i in range(robots):
            low[i] = np.inf
            high[i] = -np.inf
        undecided = True
        for step in range(2 * segments - 1):  # forward through all segments, then back where needed
            forward = step < segments
            s = step if forward else 2 * segments - 2 - step
            if forward and segments > 1:
                for i in range(robots):
                    snapshots[s, i] = memory[i]
            elif not forward and undecided:
                for i in range(robots):
                    memory[i] = snapshots[s, i]
            if forward or undecided:
                first = s * segment + 1
                last = min(first + segment, rounds + 1)
                if local:
                    advance_alone(
                        memory, reading, blacks, bits, tables, first, last, looks, number, read_key, order_key,
                        rows, stops, stop,
                    )  # fmt: skip
                else:
                    advance(
                        memory, outbox, scratch, blacks, bits, tables, first, last, looks, number, read_key,
                        link_key, links, receivers, senders, reach, threshold, rows, stops, stop,
                    )  # fmt: skip
                if stop[0] != 0:
                    return False
                if forward:
                    for c in range(checkpoints.size):
                        if first <= checkpoints[c] < last:
                            right = 0
                            for i in range(robots):
                                x = rows[checkpoints[c] - first, i]
                                right += bin_low <= x < bin_high
                                if kept.shape[0] > 0:
                                    kept[c, trial, i] = x
                            correct[c, trial] = right / robots
                if s == segments - 1:
                    for i in range(robots):
                        final[trial, i] = value[trial, i] = rows[last - 1 - first, i]
                        where[trial, i] = rounds
                if not forward or s == segments - 1:
                    undecided = settle(rows[: last - first], first, delta, low, high, where[trial], value[trial])
        if undecided:
            settle(start, 0, delta, low, high, where[trial], value[trial])
    return True


@entry
def record(
    blank, trial, b, w, assumed_b, assumed_w, fill_ratio, looks, history, blacks_seen,
    read_key, link_key, links, receivers, senders, threshold, stops,
):  # fmt: skip
    """Run one trial and keep every mind after every round in `history`, (round, robot), and its readings."""
    robots = history.shape[1]
    memory = np.empty(robots, blank.dtype)
    scratch = blank.copy()
    outbox = np.empty((2 * robots, outbox_width), np.float64)
    blacks = np.zeros(min(robots, 256), np.int64)
    bits = np.zeros(robots, np.uint64)
    rows = np.empty((1, robots))
    stop = np.zeros(1, np.uint8)
    tables = black_tables(b, w, fill_ratio, looks)
    reach = blocks(receivers, robots)
    begin(memory, blank, assumed_b, assumed_w)
    history[0, :] = memory
    for k in range(1, history.shape[0]):
        count_blacks(blacks_seen[k], bits, tables, looks, read_key, trial, k, ZERO, np.uint64(robots))
        advance(
            memory, outbox, scratch, blacks, bits, tables, k, k + 1, looks, trial, read_key, link_key, links,
            receivers, senders, reach, threshold, rows, stops, stop,
        )  # fmt: skip
        history[k, :] = memory


@entry
def follow(blank, b, w, readings, every, periodic, first_message, senders, receivers, history):
    """Run minds on recorded readings (step, robot; NaN where none) and keep them after every round.

    A round ends every `every` steps and at the last. With `periodic`, all messages pass at the end of each
    whole round; else message m passes at the step s with first_message[s] <= m < first_message[s + 1].
    """
    robots = readings.shape[1]
    memory = np.empty(robots, blank.dtype)
    outbox = np.empty((robots, outbox_width), np.float64)
    begin(memory, blank, b, w)
    history[0, :] = memory
    k = 0
    for s in range(readings.shape[0]):
        whole = (s + 1) % every == 0
        for i in range(robots):
            if readings[s, i] >= 0.0:
                observe(memory[i], readings[s, i], 1.0)
            pack(outbox, i, broadcast(memory[i]))
        if periodic:
            first, last = 0, senders.size if whole else 0
        else:
            first, last = first_message[s], first_message[s + 1]
        for m in range(first, last):
            receive(memory[receivers[m]], unpack(outbox, senders[m]))
        if whole or s == readings.shape[0] - 1:
            for i in range(robots):
                fuse(memory[i])
            k += 1
            history[k, :] = memory


@entry
def believe(history, out):
    """The estimates of minds (round, robot)."""
    for k in range(history.shape[0]):
        for i in range(history.shape[1]):
            out[k, i] = estimate(history[k, i])
