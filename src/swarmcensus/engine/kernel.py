"""Trials on fixed networks, run in batches to their metrics, and states on recorded data.

Compiled once on a machine, for all brains: a `Swarm` (`layout.py`) holds the addresses of the brains' functions
(`calling.py`), and a state is a row of numbers.
"""

import numpy as np

from swarmcensus.engine.calling import call, packed, place, unpacked, unpacking
from swarmcensus.engine.changes import source_with
from swarmcensus.engine.compiling import entry, loop
from swarmcensus.engine.constants import (
    AGREED,
    ALL_ALONE,
    AMISS,
    ASK_INTERVALS,
    COUNT_AHEAD,
    COUNT_CLIPPED,
    DECISION,
    DRAW_FUSE,
    DRAW_OBSERVE,
    END_ROUND,
    FIRST_WRONG,
    FORGET,
    HALF_WIDTH,
    HEAR,
    INTERVALS,
    IS_DONE,
    RENEW,
    SENSE,
    SETTLED,
    VERDICTS,
)
from swarmcensus.engine.layout import Intervals, States, Tally
from swarmcensus.engine.random import word_of, words

from .rounds import advance, graph_of
from .shared_trials import copy_together, most_of, share_of, team_of, wait
from .states import (
    ZERO,
    ask_all,
    believe_all,
    blank_states,
    copy_all,
    first_from,
    forget_verdicts,
    is_said,
    judge,
    sensors_of,
)
from .trial_arguments import ARGUMENTS, INTERVALS_OF_TRIAL, SIMULATION, SOURCE, TO_SIMULATE, TrialArguments

tally_of, intervals_of = map(loop(inline="always"), (Tally.of_trial, Intervals.of_trial))


@loop()
def are_numbers(team, swarm, rows, rounds, robots, first, wrong, answer):
    """Whether all estimates of honest robots so far are numbers in [0, 1]; else `wrong` says which is the first."""
    begin, end = share_of(team, rounds * robots)
    call(swarm.helpers[AMISS], rows, rounds, robots, begin, end, answer)
    if most_of(team, answer[0]) > 0.0:
        if team.me == 0:
            call(swarm.helpers[FIRST_WRONG], rows, rounds, robots, first, swarm.honest, swarm.honest.size, wrong)
        wait(team)
    return wrong[0] < 0.0


@loop()
def agreed_together(team, swarm, rows, rounds, first, delta, room, agreed, answer):
    """What `agreed_from` returns: each member looks at some of these rows."""
    begin, end = share_of(team, rounds)
    answer[0] = -1.0
    if begin < end:
        part, size, honest = place(rows, begin * room.size), room.size, swarm.honest
        call(swarm.helpers[AGREED], part, end - begin, size, first + begin, honest, honest.size, delta, room, answer)
    since = most_of(team, answer[0])
    return since if since >= 0.0 else agreed


@unpacking(*TO_SIMULATE)
def simulate(groups):
    """Run a batch of trials from blank states to their metrics; False if stopped.

    `given` are their inputs; all groups are those of `layout.py`. With `local`, robots hear nobody and `rounds` counts
    single observations. Messages are counted only where `count_known` and `count_heard` do not know them beforehand.

    Estimates are kept for a segment of rounds, as many as states.rows. Where the convergence rule must look further
    back, the segment before is run again, to the same bits, from a snapshot of the states: 2 segments - 1 steps. The
    first segment starts from blank states and the last never runs again, so they need no snapshot; with room for every
    segment, all get one. To see all estimates of a trial, run it alone and step by step with the same groups:
    states.rows then hold the estimates of the step.

    Several threads may run this at the same time, each as a `member` of a team (`shared_trials.py`) with a `swarm` of
    its own blocks, room to `work` in, and all else in common.
    """
    (
        swarm, given, states, segments, measures, tally, intervals, rounds, local, first_step, last_step, stop, member,
        work,
    ) = unpacked(groups, SIMULATION)  # fmt: skip
    memory, outbox, signals, rows = states
    sensors, beliefs, radio, links = given.sensors, given.beliefs, given.radio, given.links
    robots, segment, checkpoints = memory.shape[0], rows.shape[0], intervals.checkpoints
    count = (rounds + segment - 1) // segment
    team = team_of(member, swarm, segments.votes, robots)
    begin, end = team.first, team.last
    before = np.int64(segments.snapshots.shape[0] != count)  # how many segments have no snapshot at the begin
    agreement, delta = measures.agreement, measures.delta
    unjudged, order, answer = tally.verdicts[0, :0], work.order, work.answer
    helpers, settled, clips = swarm.helpers, swarm.helpers[SETTLED], False
    for group in range(swarm.clipped.size):
        clips |= swarm.clipped[group] >= 0
    low, high, start = segments.extremes[0], segments.extremes[1], segments.extremes[2:]
    for trial in range(measures.where.shape[0]):
        wait(team)
        number = given.first + trial
        stops = given.stops[trial]
        graph = graph_of(links, trial if links.starts.size > 2 else 0, work.bounds)
        source = source_with(work.tables, work.stand, sensors_of(sensors, trial))
        call(helpers[RENEW], packed(source, SOURCE), 1, begin, end)
        counted = tally_of(tally, trial)
        again = Tally(work.uncounted, unjudged, counted.agreed)  # of rounds that are run again
        asked = intervals_of(intervals, trial)
        of = TrialArguments(swarm, states, work, source, graph, radio, counted, stops, number, team, stop)
        arguments = packed(of, ARGUMENTS)
        where, value, wrong = measures.where[trial], measures.value[trial], measures.wrong[trial]
        if first_step == 0:
            blank_states(swarm, memory, beliefs[0][trial], beliefs[1][trial])
            believe_all(swarm, memory, start, ZERO)
            counted.agreed[0], counted.agreed[1] = -1.0, np.inf
            if counted.verdicts.shape[0] > 0:
                call(helpers[FORGET], arguments, start)
            call(helpers[COUNT_AHEAD], arguments, rounds)
            wait(team)
            agreement[trial] = 0.0
            if are_numbers(team, swarm, start, np.int64(1), robots, np.int64(0), wrong, answer):
                agreement[trial] = agreed_together(
                    team, swarm, start, np.int64(1), np.int64(0), delta, order, 0.0, answer
                )
            for i in range(begin, end):
                low[i], high[i] = np.inf, -np.inf
        undecided = True
        for step in range(first_step, last_step):  # forward through all segments, then back where needed
            forward = step < count
            s, noted = (step, counted) if forward else (2 * count - 2 - step, again)
            shot = s - before
            if not forward and undecided and s == 0:
                blank_states(swarm, memory, beliefs[0][trial], beliefs[1][trial])
            elif shot >= 0 and (forward or undecided):
                copy_together(team, segments.snapshots, shot, memory, forward)
                copy_together(team, segments.outboxes, shot, outbox, forward)
                copy_together(team, segments.signals, shot, signals, forward)
            if forward or undecided:
                first = s * segment + 1
                last = min(first + segment, rounds + 1)
                span = last - first
                if local:
                    call(helpers[ALL_ALONE], arguments, first, last)
                    wait(team)
                else:
                    begun = first
                    while begun < last:  # up to a checkpoint at which robots are asked for intervals, and on
                        c, until = first_from(checkpoints, begun), last
                        asks = forward and asked.bounds.shape[1] > 0 and c < checkpoints.size and checkpoints[c] < last
                        if asks:
                            until = checkpoints[c] + 1
                        rest = States(memory, outbox, signals, rows[begun - first :])
                        advance(swarm, rest, work, source, graph, radio, noted, stops, number, begun, until, stop, team)
                        if stop[0] != 0:
                            return False
                        if asks:
                            call(helpers[ASK_INTERVALS], arguments, packed(asked, INTERVALS_OF_TRIAL))
                            for turn in range(team.count):  # sums go through the robots in order
                                if turn == team.me:
                                    call(helpers[INTERVALS], arguments, packed(asked, INTERVALS_OF_TRIAL), c, turn)
                                wait(team)
                        begun = until
                if stop[0] != 0:
                    return False
                if forward:
                    sound = are_numbers(team, swarm, rows, span, robots, first, wrong, answer)
                    if sound and not local:
                        since = agreement[trial]
                        agreement[trial] = agreed_together(team, swarm, rows, span, first, delta, order, since, answer)
                    for c in range(team.me, checkpoints.size, team.count):
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
                            if sound and not local:
                                row = place(rows, (checkpoints[c] - first) * robots)
                                call(helpers[HALF_WIDTH], row, robots, swarm.honest, swarm.honest.size, order, answer)
                                measures.disagreement[c, trial] = answer[0]
                if s == count - 1:
                    if clips:
                        call(helpers[COUNT_CLIPPED], arguments)
                    if agreement[trial] > rounds:
                        agreement[trial] = np.inf
                    for i in range(begin, end):
                        measures.final[trial, i] = value[i] = rows[span - 1, i]
                        where[i] = rounds
                if not forward or s == count - 1:
                    call(settled, rows, span, robots, first, delta, low, high, where, value, begin, end, answer)
                    undecided = most_of(team, answer[0]) > 0.0
        if undecided and last_step == 2 * count - 1:
            call(settled, start, 1, robots, 0, delta, low, high, where, value, begin, end, answer)
    return True


@entry
def decided(swarm, history, estimates, decisions):
    """Fill `decisions` (round, robot, 2) with the option of states (round, robot, byte), and whether they are done.

    `estimates` (round, robot) are those of the states.
    """
    robots = history.shape[1]
    verdicts = np.empty((robots, VERDICTS))
    agreed = np.empty(2)
    for k in range(history.shape[0]):
        forget_verdicts(verdicts, agreed, 0, robots)
        for block in range(np.uint64(swarm.of_block.size - 1)):
            judge(swarm, block, history[k], estimates, np.uint64(k * robots), verdicts, k)
        for i in range(robots):
            decisions[k, i, 0] = verdicts[i, DECISION]
            decisions[k, i, 1] = verdicts[i, IS_DONE]


@entry
def bounded(swarm, history, bounds):
    """Fill `bounds` (round, end, robot) with the intervals of states (round, robot, byte), where brains have one."""
    for k in range(history.shape[0]):
        ask_all(swarm, history[k], bounds[k])


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
            forget_verdicts(verdicts, agreed, 0, readings.shape[1])
            for block in range(np.uint64(swarm.of_block.size - 1 if judged else 0)):
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
                arrivals[0, count], arrivals[1, count] = receivers[m], senders[m]
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
