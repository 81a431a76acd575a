"""What of the engine is compiled apart, and only where a run needs it: measuring, and what is not in every study.

The loops call these functions by their addresses, as they call those of brains. A `TrialArguments`
(`trial_arguments.py`) is passed by its address, too.
"""

import numpy as np

from swarmcensus.engine.calling import ARRAY, REAL, WHOLE, apart, call, place, seen_as, unpacked
from swarmcensus.engine.changes import renew
from swarmcensus.engine.compiling import loop
from swarmcensus.engine.constants import DRAW_ALONE, DRAW_ALONE_FUSE, FULL, GO_ALONE, HEAR, HEARD, PAIRS
from swarmcensus.engine.draws import arrange, count_blacks
from swarmcensus.engine.random import words

from .agreement import agreed_from, half_width
from .shared_trials import unanimous
from .states import (
    ONE,
    ZERO,
    agree_on,
    arrives,
    ask_all,
    count_amiss,
    count_clipped,
    count_known,
    count_said,
    count_sent,
    draw_for_messages,
    drowned,
    find_wrong,
    forget_verdicts,
    is_noise,
    is_said,
    judge,
    judge_blank,
    measure_intervals,
    option_of,
    settle,
    silence_failed,
)
from .trial_arguments import ARGUMENTS, INTERVALS_OF_TRIAL, SOURCE


@apart(ARRAY, WHOLE, WHOLE, WHOLE, unpacks=True)
def renew_tables(source, k, first, last):
    """Make the tables of round k for robots first ... last - 1; in round 1 they may be those of another trial."""
    of = unpacked(source, SOURCE)
    if k == ONE:
        for i in range(first if of.sensors.b.size > 1 else ZERO, last if of.sensors.b.size > 1 else ONE):
            of.stand[0, i] = np.nan
    renew(of, np.int64(k), np.int64(first), np.int64(last))


@apart(ARRAY, WHOLE, unpacks=True)
def count_ahead(arguments, rounds):
    """Start the counts of messages, with what is known before the rounds."""
    of = unpacked(arguments, ARGUMENTS)
    rounds, begin, end = np.int64(rounds), of.team.first, of.team.last
    count_known(of.swarm, of.tally.counts, of.stops, rounds, begin, end)
    heard = max(rounds - of.radio.delay, 0)
    count_heard(of.swarm, of.graph, of.radio, of.stops, heard, of.tally.counts, begin, end)


@apart(ARRAY, WHOLE, WHOLE, WHOLE, WHOLE, ARRAY)
def note_amiss(rows, rounds, robots, begin, end, result):
    """Set result[0] to the number of estimates begin ... end - 1 of these rows that are no numbers in [0, 1]."""
    estimates = seen_as(rows, (rounds, robots), np.float64)
    seen_as(result, 1, np.float64)[0] = count_amiss(estimates, np.int64(begin), np.int64(end))


@apart(ARRAY, WHOLE, WHOLE, WHOLE, ARRAY, WHOLE, ARRAY)
def note_wrong(rows, rounds, robots, first, honest, size, wrong):
    """See `find_wrong`."""
    estimates, whom = seen_as(rows, (rounds, robots), np.float64), seen_as(honest, size, np.bool_)
    find_wrong(whom, estimates, np.int64(first), seen_as(wrong, 3, np.float64))


@apart(ARRAY, WHOLE, WHOLE, WHOLE, ARRAY, WHOLE, REAL, ARRAY, ARRAY)
def note_agreed(rows, rounds, robots, first, honest, size, delta, room, result):
    """Set result[0] to what `agreed_from` says of these rows, from what it said of earlier ones."""
    estimates, whom = seen_as(rows, (rounds, robots), np.float64), seen_as(honest, size, np.bool_)
    since = seen_as(result, 1, np.float64)
    since[0] = agreed_from(estimates, np.int64(first), whom, delta, seen_as(room, robots, np.float64), since[0])


@apart(ARRAY, WHOLE, ARRAY, WHOLE, ARRAY, ARRAY)
def note_width(row, robots, honest, size, room, result):
    """Set result[0] to the disagreement of a row."""
    estimates, whom = seen_as(row, robots, np.float64), seen_as(honest, size, np.bool_)
    seen_as(result, 1, np.float64)[0] = half_width(estimates, whom, seen_as(room, robots, np.float64))


@apart(ARRAY, WHOLE, WHOLE, WHOLE, REAL, ARRAY, ARRAY, ARRAY, ARRAY, WHOLE, WHOLE, ARRAY)
def note_settled(rows, rounds, robots, top, delta, low, high, where, value, begin, end, result):
    """Set result[0] to 1 if `settle` needs to see earlier rows, else to 0."""
    estimates, places = seen_as(rows, (rounds, robots), np.float64), seen_as(where, robots, np.int64)
    least, most = seen_as(low, robots, np.float64), seen_as(high, robots, np.float64)
    values, first, last = seen_as(value, robots, np.float64), np.int64(begin), np.int64(end)
    undecided = settle(estimates, np.int64(top), delta, least, most, places, values, first, last)
    seen_as(result, 1, np.float64)[0] = 1.0 if undecided else 0.0


@apart(ARRAY, unpacks=True)
def note_clipped(arguments):
    """Count messages with numbers that their format cannot hold."""
    of = unpacked(arguments, ARGUMENTS)
    count_clipped(of.swarm, of.states.memory, of.tally.counts)


@apart(ARRAY, WHOLE, WHOLE, WHOLE, unpacks=True)
def fail_sensors(arguments, tick, first, last):
    """Robots of a block whose sensor has failed make no reading."""
    of = unpacked(arguments, ARGUMENTS)
    silence_failed(of.work.blacks, of.stops, np.int64(tick), first, last)


@apart(ARRAY, WHOLE, WHOLE, WHOLE, WHOLE, WHOLE, ARRAY)
def fill_words(key, trial, tick, part, first, size, out):
    """See `random.words`."""
    words(seen_as(key, 2, np.uint64), trial, tick, part, first, size, seen_as(out, size, np.uint64))


@apart(ARRAY, WHOLE, WHOLE, WHOLE, unpacks=True)
def draw_words(arguments, tick, first, last):
    """Draw a word for each of the messages along links first ... last - 1."""
    of = unpacked(arguments, ARGUMENTS)
    links = of.graph.receivers, of.graph.senders, np.int64(first), np.int64(last)
    draw_for_messages(of.swarm, of.trial, np.int64(tick), *links, of.work.draws[2])


@apart(ARRAY, WHOLE, WHOLE, WHOLE, unpacks=True)
def count_signals(arguments, tick, said, hears):
    """Count who talks in a round, or if `hears`, what is heard, where robots may be silent."""
    of = unpacked(arguments, ARGUMENTS)
    signals, counts, graph, begin, end = of.states.signals, of.tally.counts, of.graph, of.team.first, of.team.last
    if hears:
        count_said(signals, said, graph.bounds, graph.senders, graph.mode, counts, begin, end)
    else:
        count_sent(signals, said, of.stops, np.int64(tick), counts, begin, end)


@loop()
def take_drowned_away(signals, said, graph, arrivals, count, stops, tick, counts):
    """Drop arrivals at robots that a neighbour's noise reaches, and return how many are left; they come by receiver.

    A function of its own, because it would slow the loop below by a fifth for brains that never jam.
    """
    senders, bounds = graph.senders, graph.bounds
    kept, receiver, deaf = 0, -1, False
    for k in range(count):
        to = np.int64(arrivals[0, k])
        if to != receiver:
            receiver, deaf = to, drowned(signals, said, senders, bounds[to], bounds[to + 1], stops, tick)
        if deaf and counts.shape[1] > 0:
            counts[HEARD, to] -= 1
        if not deaf:
            arrivals[0, kept], arrivals[1, kept] = arrivals[0, k], arrivals[1, k]
            kept += 1
    return kept


@apart(ARRAY, WHOLE, WHOLE, WHOLE, WHOLE, WHOLE, unpacks=True)
def hear_singly(arguments, tick, said, group, first, last):
    """Messages at `said` in the outbox pass along links first ... last - 1, but for lost ones and broken radios."""
    of = unpacked(arguments, ARGUMENTS)
    swarm, states, work, graph = of.swarm, of.states, of.work, of.graph
    radio, stops, trial = of.radio, of.stops, of.trial
    counts, tick, first, last = of.tally.counts, np.int64(tick), np.int64(first), np.int64(last)
    arrivals, outbox, signals, draws = work.arrivals, states.outbox, states.signals, work.draws[2]
    count = np.int64(0)
    for link in range(first, last):
        to, by = np.int64(graph.receivers[link]), np.int64(graph.senders[link])
        if is_said(signals, said + np.uint64(by)) and arrives(radio, trial, tick, to, by, stops):
            arrivals[0, count], arrivals[1, count] = to, by
            count += 1
            if counts.shape[1] > 0:
                counts[HEARD, to] += 1
    if swarm.jams:
        count = take_drowned_away(signals, said, graph, arrivals, count, stops, tick - radio.delay, counts)
    if swarm.draws.size > 0:
        draw_for_messages(swarm, trial, tick, arrivals[0], arrivals[1], np.int64(0), count, draws)
    base, robots = place(states.memory, swarm.bases[group]), states.memory.shape[0]
    call(swarm.functions[group, HEAR], base, outbox, said, arrivals[0], arrivals[1], ZERO, count, robots, draws)


@apart(ARRAY, WHOLE, WHOLE, unpacks=True)
def hear_pairs(arguments, tick, said):
    """All hear all, message by message: O(N^2), for a radio that loses messages or a brain that does more than add."""
    of = unpacked(arguments, ARGUMENTS)
    swarm, states, work, radio, stops, trial = of.swarm, of.states, of.work, of.radio, of.stops, of.trial
    counts, tick, stop = of.tally.counts, np.int64(tick), of.stop
    arrivals, outbox, signals, draws = work.arrivals, states.outbox, states.signals, work.draws[2]
    robots, said_at = states.memory.shape[0], tick - radio.delay
    noises = 0
    if swarm.jams:
        for j in range(robots):
            noises += is_noise(signals, said, j, stops, said_at)
    for run in range(swarm.runs.shape[0]):
        group = swarm.runs[run, 0]
        for i in range(np.int64(swarm.runs[run, 1]), np.int64(swarm.runs[run, 2])):
            if stop[0] != 0:
                return
            count = np.int64(0)
            if noises > 0 and noises > is_noise(signals, said, i, stops, said_at):  # another robot's noise
                continue
            for j in range(robots):
                if i != j and is_said(signals, said + np.uint64(j)) and arrives(radio, trial, tick, i, j, stops):
                    arrivals[0, count], arrivals[1, count] = i, j
                    count += 1
            if counts.shape[1] > 0:
                counts[HEARD, i] += count
            if swarm.draws.size > 0:
                draw_for_messages(swarm, trial, tick, arrivals[0], arrivals[1], np.int64(0), count, draws)
            base = place(states.memory, swarm.bases[group])
            call(swarm.functions[group, HEAR], base, outbox, said, arrivals[0], arrivals[1], ZERO, count, robots, draws)


@apart(ARRAY, WHOLE, WHOLE, unpacks=True)
def go_alone(arguments, first, last):
    """Run single observations first ... last - 1 of robots that hear nobody; states.rows get their estimates.

    A member of a team does so for its own robots.
    """
    of = unpacked(arguments, ARGUMENTS)
    swarm, states, work, source = of.swarm, of.states, of.work, of.source
    stops, trial, team = of.stops, of.trial, of.team
    first, last, stop = np.int64(first), np.int64(last), of.stop
    memory, rows, draws, sensors = states.memory, states.rows, work.draws, source.sensors
    looks = sensors.looks
    n, begin, end = np.uint64(memory.shape[0]), np.uint64(team.first), np.uint64(team.last)
    is_random = swarm.draws.size > 0
    n_words = np.int64(draws.shape[1])
    for k in range(first, last):
        if stop[0] != 0:
            return
        left = looks - (k - 1) % looks
        tick = (k - 1) // looks + 1
        if left == looks:
            if source.changes:
                renew(source, tick, team.first, team.last)
            count_blacks(work.blacks, work.bits, source.tables, looks, sensors.key, trial, tick, begin, end)
        arrange(work.single, work.blacks, work.bits, left, sensors.order, trial, k, begin)
        silence_failed(work.single, stops, tick, begin, end)
        if is_random:
            words(swarm.draws, trial, k, DRAW_ALONE, begin, end - begin, draws[0])
            words(swarm.draws, trial, k, DRAW_ALONE_FUSE, begin, end - begin, draws[1])
        for run in range(swarm.runs.shape[0]):
            group, a, z = swarm.runs[run, 0], swarm.runs[run, 1], swarm.runs[run, 2]
            at, here = np.int64(a - begin), np.uint64(k - first) * n
            base, single = place(memory, swarm.bases[group]), place(work.single, at)
            luck, later = place(draws, at), place(draws, n_words + at)
            call(swarm.functions[group, GO_ALONE], base, single, rows, here, a, z, luck, later)


@loop()
def count_heard(swarm, graph, radio, stops, rounds, counts, begin, end):
    """Count what robots begin ... end - 1 hear in so many rounds if it is the same in each; else `advance` does."""
    sound = radio.threshold == 0 and stops.shape[1] == 0 and graph.mode != PAIRS
    if not swarm.is_signalled and (graph.mode == FULL or sound):
        robots = graph.bounds.size - 1
        for i in range(begin, min(end, counts.shape[1])):
            degree = robots - 1 if graph.mode == FULL else graph.bounds[i + 1] - graph.bounds[i]
            counts[HEARD, i] += rounds * degree


@apart(ARRAY, ARRAY, unpacks=True)
def forget(arguments, start):
    """Reset decisions to what is known before the first round, when robots have the estimates `start`."""
    of = unpacked(arguments, ARGUMENTS)
    forget_verdicts(of.tally.verdicts, of.tally.agreed, of.team.first, of.team.last)
    judge_blank(of.swarm, of.states.memory, start, of.tally.verdicts)


@apart(ARRAY, WHOLE, WHOLE, WHOLE, unpacks=True)
def judge_block(arguments, now, block, start):
    """Update what the robots of a block have decided after round `now`."""
    of = unpacked(arguments, ARGUMENTS)
    judge(of.swarm, block, of.states.memory, of.states.rows, start, of.tally.verdicts, now)


@apart(ARRAY, WHOLE, unpacks=True)
def agree(arguments, now):
    """Note if all honest robots have decided for the same option after round `now`, for the first time."""
    of = unpacked(arguments, ARGUMENTS)
    if of.tally.agreed[0] < 0.0:
        option = option_of(of.tally.verdicts, of.swarm.honest, of.team.first, of.team.last)
        agree_on(unanimous(of.team, option), of.tally.agreed, np.int64(now))


@apart(ARRAY, ARRAY, unpacks=True)
def ask_intervals(arguments, intervals):
    """Write the intervals of robots into `bounds`."""
    of = unpacked(arguments, ARGUMENTS)
    ask_all(of.swarm, of.states.memory, unpacked(intervals, INTERVALS_OF_TRIAL).bounds)


@apart(ARRAY, ARRAY, WHOLE, WHOLE, unpacks=True)
def note_intervals(arguments, intervals, c, goes_on):
    """See `measure_intervals`."""
    of = unpacked(arguments, ARGUMENTS)
    measure_intervals(of.swarm, np.int64(c), unpacked(intervals, INTERVALS_OF_TRIAL), goes_on > 0)
