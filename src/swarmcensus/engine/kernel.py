"""What the engine does on fixed networks: batches of trials to their metrics, single trials and recorded ones in full.

This file is compiled anew for every brain (see `compiler.py`): `.mind` is that brain.
"""

import numpy as np

from swarmcensus.engine.draws import black_tables, count_blacks

from .mind import broadcast, entry, estimate, fuse, observe, outbox_width, pack, receive, unpack
from .minds import ZERO, begin, settle
from .rounds import advance, advance_alone, blocks


@entry
def simulate(
    blank, memory, outbox, rows, snapshots, first_trial, b, w, assumed_b, assumed_w, fill_ratio, local, looks, rounds,
    read_key, order_key, link_key, links, starts, all_receivers, all_senders, threshold, all_stops,
    delta, bin_low, bin_high, checkpoints, where, value, final, correct, kept, extremes, first_step, last_step, stop,
):  # fmt: skip
    """Run a batch of trials from blank minds to their metrics; False if stopped.

    Accuracies are (trial, robot or 1). Links are those of graph g in [starts[g], starts[g + 1]), one graph for
    all trials or one for each. `memory` (robot), `outbox` (2 robots, message), `rows` (index, robot) and
    `snapshots` (segment, robot) are room to work in. With `local`, robots hear nobody and `rounds` counts single
    observations. `kept` (checkpoint or 0, trial, robot) is filled with estimates at the checkpoints, if it has room.
    Estimates are kept for a segment of indices, as many as `rows`, at a time; where the
    convergence rule must look further back, the segment before is run again from a snapshot of the minds, to the
    same bits: 2 segments - 1 steps. Whoever wants to see all estimates of a trial runs it alone, forward step by step,
    with the same room: `rows` then hold the step's.
    """
    robots = memory.size
    segment = rows.shape[0]
    segments = (rounds + segment - 1) // segment
    scratch = blank.copy()
    blacks = np.zeros(robots if local else min(robots, 256), np.int64)
    bits = np.zeros(blacks.size, np.uint64)
    reading = np.zeros(robots)
    low = extremes[0]
    high = extremes[1]
    for trial in range(where.shape[0]):
        number = first_trial + trial
        graph = trial if starts.size > 2 else 0
        receivers = all_receivers[starts[graph] : starts[graph + 1]]
        senders = all_senders[starts[graph] : starts[graph + 1]]
        stops = all_stops[trial]
        reach = blocks(receivers, robots)
        tables = black_tables(b[trial], w[trial], fill_ratio, looks)
        start = extremes[2:]
        if first_step == 0:
            begin(memory, blank, assumed_b[trial], assumed_w[trial])
            for i in range(robots):
                start[0, i] = estimate(memory[i])
            for i in range(robots):
                low[i] = np.inf
                high[i] = -np.inf
        undecided = True
        for step in range(first_step, last_step):  # forward through all segments, then back where needed
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
        if undecided and last_step == 2 * segments - 1:
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
