"""Trials on fixed networks, run in batches to their metrics, and states on recorded data.

Compiled once on a machine, for all brains: a `Swarm` (`layout.py`) holds the addresses of the brains' functions
(`calling.py`), and a state is a row of numbers.
"""

import numpy as np

from swarmcensus.engine.calling import call, place
from swarmcensus.engine.changes import renew, source_of
from swarmcensus.engine.compiling import entry, loop
from swarmcensus.engine.constants import (
    BLOCK,
    BLOCKS,
    BOUND,
    DECISION,
    DRAW_FUSE,
    DRAW_OBSERVE,
    END_ROUND,
    HEAR,
    IS_DONE,
    SENSE,
    VERDICTS,
)
from swarmcensus.engine.layout import Intervals, States, Tally
from swarmcensus.engine.random import word_of, words

from .agreement import agreed_from, half_width
from .rounds import Work, advance, advance_alone, count_heard, graph_of, most_arrivals
from .states import (
    ZERO,
    believe_all,
    blank_states,
    copy_all,
    count_clipped,
    count_known,
    find_wrong,
    forget_verdicts,
    is_said,
    judge,
    judge_blank,
    measure_intervals,
    next_checkpoint,
    sensors_of,
    settle,
)

tally_of, intervals_of = map(loop(inline="always"), (Tally.of_trial, Intervals.of_trial))


@entry
def simulate(
    swarm, given, states, segments, measures, tally, intervals, rounds, local, first_step, last_step, stop
):  # fmt: skip
    """Run a batch of trials from blank states to their metrics; False if stopped.

    `given` are their inputs; all groups are those of `layout.py`. With `local`, robots hear nobody and `rounds` counts
    single observations. Messages are counted only where `count_known` and `count_heard` do not know them beforehand.

    Estimates are kept for a segment of rounds, as many as states.rows. Where the convergence rule must look further
    back, the segment before is run again, to the same bits, from a snapshot of the states: 2 segments - 1 steps. The
    first segment starts from blank states and the last never runs again, so they need no snapshot; with room for every
    segment, all get one. To see all estimates of a trial, run it alone and step by step with the same groups:
    states.rows then hold the estimates of the step.
    """
    memory, outbox, signals, rows = states
    sensors, beliefs, radio, links = given.sensors, given.beliefs, given.radio, given.links
    checkpoints = intervals.checkpoints
    robots = memory.shape[0]
    segment = rows.shape[0]
    count = (rounds + segment - 1) // segment
    blacks = np.zeros(robots if local else min(robots, BLOCK))
    bits = np.zeros(blacks.size, np.uint64)
    single = np.zeros(robots if local else 0)
    arrivals = np.zeros((2, 0), np.uint32)
    draws = np.zeros((3, max(blacks.size, min(robots, BLOCKS * BLOCK)) if swarm.draws.size > 0 else 0), np.uint64)
    before = np.int64(segments.snapshots.shape[0] != count)  # how many segments have no snapshot at the begin
    late = segments.outboxes.shape[0] > 0
    uncounted, unjudged = np.zeros((3, 0), np.int64), tally.verdicts[0, :0]
    sums = np.empty((swarm.of_block.size - 1, outbox.shape[1]), np.uint8)
    partial = np.zeros((2 * sums.shape[0], outbox.shape[1]), np.uint8)
    room = np.empty(robots)
    low, high, start = segments.extremes[0], segments.extremes[1], segments.extremes[2:]
    for trial in range(measures.where.shape[0]):
        number = given.first + trial
        failures = given.stops[trial]
        graph = graph_of(links, trial if links.starts.size > 2 else 0, robots)
        most = most_arrivals(graph, robots)
        if most > arrivals.shape[1]:
            arrivals = np.zeros((2, most), np.uint32)
        if swarm.draws.size > 0 and most > draws.shape[1]:
            draws = np.zeros((3, most), np.uint64)
        work = Work(blacks, bits, single, draws, sums, partial, arrivals)
        source = source_of(sensors_of(sensors, trial))
        renew(source, 1)
        counted = tally_of(tally, trial)
        again = Tally(uncounted, unjudged, counted.agreed)  # of rounds that are run again
        asked = intervals_of(intervals, trial)
        where, value, wrong, agreement = (
            measures.where[trial], measures.value[trial], measures.wrong[trial], measures.agreement,
        )  # fmt: skip
        if first_step == 0:
            blank_states(swarm, memory, beliefs[0][trial], beliefs[1][trial])
            believe_all(swarm, memory, start, ZERO)
            forget_verdicts(counted.verdicts, counted.agreed)
            if counted.verdicts.shape[0] > 0:
                judge_blank(swarm, memory, start, counted.verdicts)
            find_wrong(swarm, start, 0, wrong)
            agreement[trial] = 0.0
            if wrong[0] < 0.0:
                agreement[trial] = agreed_from(start, 0, swarm.honest, measures.delta, room, 0.0)
            count_known(swarm, counted.counts, failures, rounds)
            count_heard(swarm, graph, radio, failures, max(rounds - radio.delay, 0), counted.counts)
            for i in range(robots):
                low[i] = np.inf
                high[i] = -np.inf
        undecided = True
        for step in range(first_step, last_step):  # forward through all segments, then back where needed
            forward = step < count
            s = step if forward else 2 * count - 2 - step
            shot = s - before
            if forward and 0 <= shot < segments.snapshots.shape[0]:
                copy_all(segments.snapshots[shot], memory)
                if late:
                    copy_all(segments.outboxes[shot], outbox)
                    copy_all(segments.signals[shot], signals)
            elif not forward and undecided and s == 0:
                blank_states(swarm, memory, beliefs[0][trial], beliefs[1][trial])
            elif not forward and undecided:
                copy_all(memory, segments.snapshots[shot])
                if late:
                    copy_all(outbox, segments.outboxes[shot])
                    copy_all(signals, segments.signals[shot])
            if forward or undecided:
                first = s * segment + 1
                last = min(first + segment, rounds + 1)
                if local:
                    advance_alone(swarm, states, work, source, failures, number, first, last, stop)
                else:
                    begun = first
                    while begun < last:  # up to a checkpoint at which robots are asked for intervals, and on
                        c, end = next_checkpoint(checkpoints, begun), last
                        asks = forward and asked.bounds.shape[1] > 0 and c < checkpoints.size and checkpoints[c] < last
                        if asks:
                            end = checkpoints[c] + 1
                        advance(
                            swarm, States(memory, outbox, signals, rows[begun - first :]), work, source, graph, radio,
                            counted if forward else again, failures, number, begun, end, stop,
                        )  # fmt: skip
                        if stop[0] != 0:
                            return False
                        if asks:
                            measure_intervals(swarm, memory, c, asked)
                        begun = end
                if stop[0] != 0:
                    return False
                if forward:
                    find_wrong(swarm, rows[: last - first], first, wrong)
                    measurable = not local and wrong[0] < 0.0
                    if measurable:
                        agreement[trial] = agreed_from(
                            rows[: last - first], first, swarm.honest, measures.delta, room, agreement[trial]
                        )  # fmt: skip
                    for c in range(checkpoints.size):
                        if first <= checkpoints[c] < last:
                            right = honest = 0
                            for i in range(robots):
                                x = rows[checkpoints[c] - first, i]
                                if swarm.honest.size == 0 or swarm.honest[i]:
                                    right += measures.bins[c, 0] <= x < measures.bins[c, 1]
                                    honest += 1
                                if measures.kept.shape[0] > 0:
                                    measures.kept[c, trial, i] = x
                            measures.correct[c, trial] = right / honest
                            if measurable:
                                measures.disagreement[c, trial] = half_width(
                                    rows[checkpoints[c] - first], swarm.honest, room
                                )  # fmt: skip
                if s == count - 1:
                    count_clipped(swarm, memory, counted.counts)
                    if agreement[trial] > rounds:
                        agreement[trial] = np.inf
                    for i in range(robots):
                        measures.final[trial, i] = value[i] = rows[last - 1 - first, i]
                        where[i] = rounds
                if not forward or s == count - 1:
                    undecided = settle(rows[: last - first], first, measures.delta, low, high, where, value)
        if undecided and last_step == 2 * count - 1:
            settle(start, np.int64(0), measures.delta, low, high, where, value)
    return True


@entry
def believe(swarm, history, estimates):
    """Fill `estimates` (round, robot) with those of states (round, robot, byte)."""
    for k in range(history.shape[0]):
        believe_all(swarm, history[k], estimates, np.uint64(k * history.shape[1]))


@entry
def decided(swarm, history, estimates, decisions):
    """Fill `decisions` (round, robot, 2) with the option of states (round, robot, byte), and whether they are done.

    `estimates` (round, robot) are those of the states.
    """
    robots = history.shape[1]
    verdicts = np.empty((robots, VERDICTS))
    agreed = np.empty(2)
    for k in range(history.shape[0]):
        forget_verdicts(verdicts, agreed)
        for block in range(np.uint64(swarm.of_block.size - 1)):
            judge(swarm, block, history[k], estimates, np.uint64(k * robots), verdicts, k)
        for i in range(robots):
            decisions[k, i, 0] = verdicts[i, DECISION]
            decisions[k, i, 1] = verdicts[i, IS_DONE]


@entry
def bounded(swarm, history, bounds):
    """Fill `bounds` (round, end, robot) with the intervals of states (round, robot, byte), where brains have one."""
    for run in range(swarm.runs.shape[0]):
        group, first, last = swarm.runs[run, 0], swarm.runs[run, 1], swarm.runs[run, 2]
        if swarm.functions[group, BOUND]:
            for k in range(history.shape[0]):
                call(
                    swarm.functions[group, BOUND], place(history[k], swarm.bases[group]), bounds[k], bounds.shape[2],
                    first, last,
                )  # fmt: skip


@entry
def follow(
    swarm, outbox, signals, beliefs, readings, every, periodic, first_message, senders, receivers, judged, history,
    estimates,
):  # fmt: skip
    """Run states on recorded readings (step, robot; NaN where none) and keep them after every round.

    A round ends every `every` steps and at the last step. With `periodic`, all messages pass at the end of each whole
    round; else message m passes at the step s with first_message[s] <= m < first_message[s + 1]. All robots have one
    brain, which is asked whether it is done if `judged`. Luck is addressed by step; for messages also by their index.
    """
    robots = np.uint64(readings.shape[1])
    functions = swarm.functions[0]
    memory = np.empty((readings.shape[1], swarm.sizes[0]), np.uint8)
    row, seen = np.zeros(readings.shape[1]), np.empty(readings.shape[1])
    verdicts, agreed = np.empty((readings.shape[1], VERDICTS)), np.empty(2)
    draws = np.zeros((2, readings.shape[1]), np.uint64)
    message_draws = np.zeros(senders.size, np.uint64)
    arrivals = np.zeros((2, senders.size), np.uint32)
    blank_states(swarm, memory, beliefs[0], beliefs[1])
    copy_all(history[0], memory)
    k = 0
    for s in range(readings.shape[0]):
        whole = (s + 1) % every == 0
        ends = whole or s == readings.shape[0] - 1
        if swarm.draws.size > 0:
            words(swarm.draws, ZERO, s + 1, DRAW_OBSERVE, ZERO, robots, draws[0])
            words(swarm.draws, ZERO, s + 1, DRAW_FUSE, ZERO, robots, draws[1])
        if s % every == 0:  # robots that are done make no reading in this round
            forget_verdicts(verdicts, agreed)
            for block in range(np.uint64(swarm.of_block.size - 1)):
                if judged:
                    judge(swarm, block, memory, row, ZERO, verdicts, k)
        for i in range(robots):
            seen[i] = -1.0 if verdicts[i, IS_DONE] != 0.0 else readings[s, i]
        call(functions[SENSE], memory, outbox, signals, ZERO, seen, 1.0, ZERO, robots, draws[0], ZERO)
        if periodic:
            first, last = 0, senders.size if whole else 0
        else:
            first, last = first_message[s], first_message[s + 1]
        count = 0
        for m in range(first, last):
            if is_said(signals, np.uint64(senders[m])):
                arrivals[0, count] = receivers[m]
                arrivals[1, count] = senders[m]
                if swarm.draws.size > 0:
                    message_draws[count] = word_of(swarm.draws[2], swarm.draws[3], ZERO, s + 1, ZERO, m)
                count += 1
        call(functions[HEAR], memory, outbox, ZERO, arrivals[0], arrivals[1], ZERO, count, robots, message_draws)
        if ends:
            call(functions[END_ROUND], memory, row, ZERO, ZERO, robots, draws[1])
            k += 1
            copy_all(history[k], memory)
    for k in range(history.shape[0]):
        believe_all(swarm, history[k], estimates, np.uint64(k) * robots)
