"""What the engine does on fixed networks: batches of trials to their metrics, and minds on recorded data.

It is compiled once on a machine and knows no brain: a `swarm` (see `swarms.py`) holds the addresses of brains'
functions (see `calling.py`), a mind is a row of numbers.
"""

import numpy as np

from swarmcensus.engine.calling import call, place
from swarmcensus.engine.changes import renew, source_of
from swarmcensus.engine.compiling import entry
from swarmcensus.engine.constants import (
    BLOCK,
    BOUND,
    DECISION,
    END_ROUND,
    FULL,
    HEAR,
    HEARD,
    IS_DONE,
    LUCK_FUSE,
    LUCK_OBSERVE,
    PAIRS,
    SENSE,
    VERDICTS,
)
from swarmcensus.engine.random import word_of, words
from swarmcensus.engine.swarms import Swarm

from .minds import (
    ZERO,
    ask_intervals,
    begin,
    believe_all,
    count_known,
    first_from,
    forget_verdicts,
    is_said,
    judge,
    judge_blank,
    put,
    settle,
)
from .rounds import advance, advance_alone, bounds_of, most_links


@entry
def simulate(
    minds, bases, fields, named, blanks, runs, of_block, additive, flag, jams, luck_keys, honest,
    memory, outbox, rows, snapshots, said_before, delay, first_trial, b, w, drift, assumed_b, assumed_w, course, local,
    looks, rounds, read_key, order_key, link_key, links, starts, all_receivers, all_senders, threshold, all_stops,
    delta, bins, checkpoints, where, value, final, correct, kept, all_counts, all_verdicts, agreed,
    truths, room, all_sure, all_wrong, extremes, first_step, last_step, stop,
):  # fmt: skip
    """Run a batch of trials from blank minds to their metrics; False if stopped.

    Accuracies are (trial, robot or 1); `drift` (trial, what, robot or 1) and `course` are of `changes.py`. Links are
    those of graph g in [starts[g], starts[g + 1]), one graph for all trials or one for each. What is heard was said
    `delay` rounds ago. `memory` (robot, field), `outbox` (delay + 2 times robots, message), `rows` (index, robot),
    `snapshots` (segment, robot, field) and `said_before` (segment, like `outbox`) are room to work in: for what is
    before each segment but the first, which begins anew, and the last, which is not run again; the last of them has
    none where messages are not late. With room for every segment `snapshots` gets them all.
    With `local`, robots hear nobody and `rounds` counts single observations. `bins` (checkpoint, 2) are the ends of the
    right bin at each checkpoint; `kept` (checkpoint or 0, trial, robot) is filled with estimates there, if it has room;
    `all_counts` (trial, what, robot) grows by what is sent and heard, but for what is known beforehand;
    `all_verdicts` (trial, robot or 0, what) and `agreed` (trial, 2) are of decisions; `truths` (checkpoint), `room` (2,
    robot or 0), `all_sure` (trial, what, checkpoint) and `all_wrong` (trial, 4) of intervals, see `ask_intervals`.
    Estimates are kept for a segment of indices, as many as `rows`, at a time; where the
    convergence rule must look further back, the segment before is run again from a snapshot of the minds, to the
    same bits: 2 segments - 1 steps. Whoever wants to see all estimates of a trial runs it alone, forward step by step,
    with the same room: `rows` then hold the step's. What comes first is a `Swarm`.
    """
    swarm = Swarm(minds, bases, fields, named, blanks, runs, of_block, additive, flag, jams, luck_keys, honest)
    robots = memory.shape[0]
    segment = rows.shape[0]
    segments = (rounds + segment - 1) // segment
    blacks = np.zeros(robots if local else min(robots, BLOCK))
    bits = np.zeros(blacks.size, np.uint64)
    reading = np.zeros(robots if local else 0)
    arrivals = np.zeros((2, 0), np.uint32)
    luck = np.zeros((3, robots if swarm.luck.size > 0 else 0), np.uint64)
    before = np.int64(snapshots.shape[0] != segments)  # how many segments have no snapshot at the begin
    nothing = np.zeros((2, 0), np.int64)
    unjudged = all_verdicts[0, :0]
    beside = np.empty((1 + (robots + BLOCK - 1) // BLOCK, outbox.shape[1]))
    low = extremes[0]
    high = extremes[1]
    for trial in range(where.shape[0]):
        number = first_trial + trial
        graph = trial if starts.size > 2 else 0
        receivers = all_receivers[starts[graph] : starts[graph + 1]]
        senders = all_senders[starts[graph] : starts[graph + 1]]
        stops = all_stops[trial]
        bounds = bounds_of(receivers, robots)
        most = most_links(bounds, links, robots)
        if most > arrivals.shape[1]:
            arrivals = np.zeros((2, most), np.uint32)
        if swarm.luck.size > 0 and most > luck.shape[1]:
            luck = np.zeros((3, most), np.uint64)
        source = source_of(b[trial], w[trial], drift[trial], course, looks)
        renew(source, looks, 1)
        start = extremes[2:]
        if first_step == 0:
            begin(swarm, memory, assumed_b[trial], assumed_w[trial])
            believe_all(swarm, memory, start, ZERO)
            forget_verdicts(all_verdicts[trial], agreed[trial])
            if all_verdicts.shape[1] > 0:
                judge_blank(swarm, memory, start, all_verdicts[trial])
            count_known(swarm, all_counts[trial], stops, rounds)
            if flag < 0 and (links == FULL or (threshold == 0 and stops.shape[1] == 0 and links != PAIRS)):
                for i in range(all_counts.shape[2]):
                    degree = robots - 1 if links == FULL else bounds[i + 1] - bounds[i]
                    all_counts[trial, HEARD, i] = max(rounds - delay, 0) * degree
            for i in range(robots):
                low[i] = np.inf
                high[i] = -np.inf
        undecided = True
        for step in range(first_step, last_step):  # forward through all segments, then back where needed
            forward = step < segments
            s = step if forward else 2 * segments - 2 - step
            shot = s - before
            if forward and 0 <= shot < snapshots.shape[0]:
                put(snapshots[shot], memory)
                if said_before.shape[0] > 0:
                    put(said_before[shot], outbox)
            elif not forward and undecided and s == 0:
                begin(swarm, memory, assumed_b[trial], assumed_w[trial])
            elif not forward and undecided:
                put(memory, snapshots[shot])
                if said_before.shape[0] > 0:
                    put(outbox, said_before[shot])
            if forward or undecided:
                first = s * segment + 1
                last = min(first + segment, rounds + 1)
                if local:
                    advance_alone(
                        swarm, memory, reading, blacks, bits, luck, source, first, last, looks, number, read_key,
                        order_key, rows, stops, stop,
                    )  # fmt: skip
                else:
                    begun = first
                    while begun < last:  # until a checkpoint where minds are asked, and on
                        c, end = first_from(checkpoints, begun), last
                        asked = forward and room.shape[1] > 0 and c < checkpoints.size and checkpoints[c] < last
                        if asked:
                            end = checkpoints[c] + 1
                        advance(
                            swarm, memory, outbox, beside, blacks, bits, luck, source, delay, begun, end, looks,
                            number, read_key, link_key, links, receivers, senders, bounds, arrivals, threshold,
                            rows[begun - first :], stops,
                            all_counts[trial] if forward else nothing, all_verdicts[trial] if forward else unjudged,
                            agreed[trial], stop,
                        )  # fmt: skip
                        if stop[0] != 0:
                            return False
                        if asked:
                            ask_intervals(
                                swarm, memory, c, checkpoints, truths, room, all_sure[trial], all_wrong[trial]
                            )  # fmt: skip
                        begun = end
                if stop[0] != 0:
                    return False
                if forward:
                    for c in range(checkpoints.size):
                        if first <= checkpoints[c] < last:
                            right = counted = 0
                            for i in range(robots):
                                x = rows[checkpoints[c] - first, i]
                                if honest.size == 0 or honest[i]:
                                    right += bins[c, 0] <= x < bins[c, 1]
                                    counted += 1
                                if kept.shape[0] > 0:
                                    kept[c, trial, i] = x
                            correct[c, trial] = right / counted
                if s == segments - 1:
                    for i in range(robots):
                        final[trial, i] = value[trial, i] = rows[last - 1 - first, i]
                        where[trial, i] = rounds
                if not forward or s == segments - 1:
                    undecided = settle(rows[: last - first], first, delta, low, high, where[trial], value[trial])
        if undecided and last_step == 2 * segments - 1:
            settle(start, np.int64(0), delta, low, high, where[trial], value[trial])
    return True


@entry
def believe(
    minds, bases, fields, named, blanks, runs, of_block, additive, flag, jams, luck_keys, honest, history, estimates
):  # fmt: skip
    """The estimates (round, robot) of minds (round, robot, field) of a `Swarm`."""
    swarm = Swarm(minds, bases, fields, named, blanks, runs, of_block, additive, flag, jams, luck_keys, honest)
    for k in range(history.shape[0]):
        believe_all(swarm, history[k], estimates, np.uint64(k * history.shape[1]))


@entry
def decided(
    minds, bases, fields, named, blanks, runs, of_block, additive, flag, jams, luck_keys, honest,
    history, estimates, verdicts,
):  # fmt: skip
    """What minds (round, robot, field) that believe in `estimates` (round, robot) have decided, as (round, robot, 2):
    the option, and whether they are done. What comes first is a `Swarm`."""
    swarm = Swarm(minds, bases, fields, named, blanks, runs, of_block, additive, flag, jams, luck_keys, honest)
    robots = history.shape[1]
    told = np.empty((robots, VERDICTS))
    agreed = np.empty(2)
    for k in range(history.shape[0]):
        forget_verdicts(told, agreed)
        for part in range(np.uint64(swarm.of_block.size - 1)):
            judge(swarm, part, history[k], estimates, np.uint64(k * robots), told, k)
        for i in range(robots):
            verdicts[k, i, 0] = told[i, DECISION]
            verdicts[k, i, 1] = told[i, IS_DONE]


@entry
def bounded(
    minds, bases, fields, named, blanks, runs, of_block, additive, flag, jams, luck_keys, honest, history, bounds
):  # fmt: skip
    """The intervals (round, end, robot) of minds (round, robot, field) of a `Swarm`, of those that have one."""
    swarm = Swarm(minds, bases, fields, named, blanks, runs, of_block, additive, flag, jams, luck_keys, honest)
    for run in range(swarm.runs.shape[0]):
        group, first, last = swarm.runs[run, 0], swarm.runs[run, 1], swarm.runs[run, 2]
        if swarm.minds[group, BOUND]:
            for k in range(history.shape[0]):
                call(
                    swarm.minds[group, BOUND], place(history[k], swarm.bases[group]), bounds[k], bounds.shape[2],
                    first, last,
                )  # fmt: skip


@entry
def follow(
    minds, bases, fields, named, blanks, runs, of_block, additive, flag, jams, luck_keys, honest,
    outbox, b, w, readings, every, periodic, first_message, senders, receivers, judged, history, estimates,
):  # fmt: skip
    """Run minds on recorded readings (step, robot; NaN where none) and keep them after every round.

    A round ends every `every` steps and at the last. With `periodic`, all messages pass at the end of each
    whole round; else message m passes at the step s with first_message[s] <= m < first_message[s + 1]. All robots have
    one brain. Luck is that of the step; of messages also of their place among all. What comes first is a `Swarm`.
    """
    swarm = Swarm(minds, bases, fields, named, blanks, runs, of_block, additive, flag, jams, luck_keys, honest)
    robots = np.uint64(readings.shape[1])
    minds = swarm.minds[0]
    memory = np.empty((readings.shape[1], swarm.fields[0]))
    row, seen = np.zeros(readings.shape[1]), np.empty(readings.shape[1])
    told, agreed = np.empty((readings.shape[1], VERDICTS)), np.empty(2)
    luck = np.zeros((2, readings.shape[1]), np.uint64)
    message_luck = np.zeros(senders.size, np.uint64)
    arrivals = np.zeros((2, senders.size), np.uint32)
    begin(swarm, memory, b, w)
    put(history[0], memory)
    k = 0
    for s in range(readings.shape[0]):
        whole = (s + 1) % every == 0
        ends = whole or s == readings.shape[0] - 1
        if swarm.luck.size > 0:
            words(swarm.luck, ZERO, s + 1, LUCK_OBSERVE, ZERO, robots, luck[0])
            words(swarm.luck, ZERO, s + 1, LUCK_FUSE, ZERO, robots, luck[1])
        if s % every == 0:  # whoever is done makes no reading of this round
            forget_verdicts(told, agreed)
            for part in range(np.uint64(swarm.of_block.size - 1)):
                if judged:
                    judge(swarm, part, memory, row, ZERO, told, k)
        for i in range(robots):
            seen[i] = -1.0 if told[i, IS_DONE] != 0.0 else readings[s, i]
        call(minds[SENSE], memory, outbox, ZERO, seen, 1.0, ZERO, robots, luck[0], ZERO)
        if periodic:
            first, last = 0, senders.size if whole else 0
        else:
            first, last = first_message[s], first_message[s + 1]
        count = 0
        for m in range(first, last):
            if is_said(outbox, np.uint64(senders[m]), swarm.flag):
                arrivals[0, count] = receivers[m]
                arrivals[1, count] = senders[m]
                if swarm.luck.size > 0:
                    message_luck[count] = word_of(swarm.luck[2], swarm.luck[3], ZERO, s + 1, ZERO, m)
                count += 1
        call(minds[HEAR], memory, outbox, ZERO, arrivals[0], arrivals[1], ZERO, count, robots, message_luck)
        if ends:
            call(minds[END_ROUND], memory, row, ZERO, ZERO, robots, luck[1])
            k += 1
            put(history[k], memory)
    for k in range(history.shape[0]):
        believe_all(swarm, history[k], estimates, np.uint64(k) * robots)
