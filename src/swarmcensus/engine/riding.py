"""States of robots that move: they ride along on a walk, and may steer it.

Compiled once on a machine, for all brains: a `Swarm` (`layout.py`) holds the addresses of the brains' functions.
"""

import numpy as np

from swarmcensus.engine.calling import call, place, unpacked, unpacking
from swarmcensus.engine.changes import accuracy_in
from swarmcensus.engine.compiling import entry, loop
from swarmcensus.engine.constants import (
    AGREED,
    ASK,
    DRAW_FUSE,
    DRAW_OBSERVE,
    DRAW_STEER,
    END_ROUND,
    FILL_WORDS,
    FIRST_WRONG,
    HALF_WIDTH,
    HEAR,
    HEAR_ALL,
    HEAR_SUMS,
    HEARD,
    LISTED,
    SENSE,
    SENT,
    SETTLED,
    TALKING,
)
from swarmcensus.engine.random import unit, words

from .failures import works
from .states import (
    ONE,
    ZERO,
    agree_on,
    arrives,
    ask_all,
    believe_all,
    blank_states,
    copy_all,
    count_clipped,
    count_known,
    count_said,
    count_sent,
    draw_for_messages,
    drowned,
    first_from,
    forget_verdicts,
    is_said,
    judge,
    judge_blank,
    measure_intervals,
    option_of,
    sensors_of,
    silence_failed,
)
from .trial_arguments import END, RIDE, START, TO_CONCLUDE, TO_RIDE, TO_START


@unpacking(*TO_START)
def start_states(groups):
    """Blank states of one trial, their first messages, and their estimates `start` (1, robot)."""
    swarm, given, states, start, tally, work = unpacked(groups, START)
    memory, outbox, signals = states.memory, states.outbox, states.signals
    count_known(swarm, tally.counts, given.stops[0], states.rows.shape[0], 0, memory.shape[0])
    blank_states(swarm, memory, given.beliefs[0][0], given.beliefs[1][0])
    no_readings, draws = work.blacks, work.draws[0]
    for i in range(memory.shape[0]):
        no_readings[i] = -1.0
    for run in range(swarm.runs.shape[0]):
        group, a, z = swarm.runs[run, 0], swarm.runs[run, 1], swarm.runs[run, 2]
        base = place(memory, swarm.bases[group])
        call(swarm.functions[group, SENSE], base, outbox, signals, ZERO, no_readings, 1.0, a, z, draws, ONE)
    believe_all(swarm, memory, start, ZERO)
    forget_verdicts(tally.verdicts, tally.agreed, 0, memory.shape[0])
    if tally.verdicts.shape[0] > 0:
        judge_blank(swarm, memory, start, tally.verdicts)


@loop(forceinline=True)
def look(readings, looked, black, b, w, bits):
    """Draw the readings of robots that look: 1 for black, 0 for white; -1 for robots that do not look."""
    step_b, step_w = np.uint64(b.size > 1), np.uint64(w.size > 1)
    for i in range(ZERO, np.uint64(readings.size)):
        right = unit(bits[i]) < (b[i * step_b] if black[i] else w[i * step_w])
        readings[i] = (1.0 if black[i] == right else 0.0) if looked[i] else -1.0


@loop()
def hear_each(swarm, states, work, radio, counts, stops, trial, tick, said, heard, senders):
    """Robot i hears what senders[heard[i]: heard[i + 1]] said, but for lost messages and broken radios."""
    memory, outbox, signals, arrivals = states.memory, states.outbox, states.signals, work.arrivals
    said_at, draws = tick - radio.delay, work.draws[2]
    for run in range(swarm.runs.shape[0]):
        group = swarm.runs[run, 0]
        count = np.int64(0)
        for i in range(np.int64(swarm.runs[run, 1]), np.int64(swarm.runs[run, 2])):
            before = count
            if swarm.jams and drowned(signals, said, senders, heard[i], heard[i + 1], stops, said_at):
                continue
            for e in range(heard[i], heard[i + 1]):
                if is_said(signals, said + senders[e]) and arrives(radio, trial, tick, i, senders[e], stops):
                    arrivals[0, count], arrivals[1, count] = i, senders[e]
                    count += 1
            counts[HEARD, i] += count - before
        if swarm.draws.size > 0:
            draw_for_messages(swarm, trial, tick, arrivals[0], arrivals[1], np.int64(0), count, draws)
        base, robots = place(memory, swarm.bases[group]), memory.shape[0]
        call(swarm.functions[group, HEAR], base, outbox, said, arrivals[0], arrivals[1], ZERO, count, robots, draws)


@unpacking(*TO_RIDE)
def ride(groups):
    """`live_on` for CPython, in the only trial `given`."""
    swarm, given, states, tally, intervals, chunk, work, black, recorded, stop = unpacked(groups, RIDE)
    sensors, radio, stops = sensors_of(given.sensors, 0), given.radio, given.stops[0]
    live_on(swarm, states, work, sensors, radio, stops, tally, intervals, chunk, black, recorded, given.first, stop)


@loop()
def live_on(swarm, states, work, sensors, radio, stops, tally, intervals, chunk, black, recorded, trial, stop):
    """Run the states of a trial through a chunk of its walk; estimates of tick k go to states.rows[k - 1].

    `black` (tick, robot) says whether the tile under a robot's sensor is black. The outbox holds delay + 1 ticks. The
    other groups are those of one trial (`layout.py`); messages are counted only where `count_known` does not know
    them, or where what robots do is `recorded`.
    """
    memory, outbox, signals, rows = states
    bits, seen, draws, b, w = work.bits, work.blacks, work.draws, work.order, work.single
    counts, verdicts, delay, senders = tally.counts, tally.verdicts, radio.delay, chunk.senders
    n, shared = memory.shape[0], swarm.functions[0]
    fused, luck_at = place(draws, draws.shape[1]), draws.shape[1]
    is_random = swarm.draws.size > 0
    in_sums = swarm.additive and radio.threshold == 0 and stops.shape[1] == 0
    for k in range(chunk.looked.shape[0]):
        if stop[0] != 0:
            return
        now = chunk.tick + k
        said, then = now % (delay + 1) * n, (now - delay) % (delay + 1) * n
        words(sensors.key, trial, now, np.int64(0), np.uint64(0), np.uint64(n), bits)
        if sensors.drift.shape[1] > 0:
            for i in range(n):
                b[i] = accuracy_in(sensors.b, sensors.drift, i, now)
                w[i] = accuracy_in(sensors.w, sensors.drift, i, now)
            look(seen, chunk.looked[k], black[k], b, w, bits)
        else:
            look(seen, chunk.looked[k], black[k], sensors.b, sensors.w, bits)
        silence_failed(seen, stops, now, ZERO, np.uint64(n))
        if recorded.readings.shape[0] > 0:
            for i in range(n):
                if seen[i] >= 0.0:
                    recorded.readings[k, i] = seen[i]
        if is_random:
            call(swarm.helpers[FILL_WORDS], swarm.draws, trial, now, DRAW_OBSERVE, ZERO, n, draws[0])
            call(swarm.helpers[FILL_WORDS], swarm.draws, trial, now, DRAW_FUSE, ZERO, n, draws[1])
        for run in range(swarm.runs.shape[0]):
            group, a, z = swarm.runs[run, 0], swarm.runs[run, 1], swarm.runs[run, 2]
            at = np.int64(a)
            base, looks, luck = place(memory, swarm.bases[group]), place(seen, at), place(draws, at)
            call(swarm.functions[group, SENSE], base, outbox, signals, said, looks, 1.0, a, z, luck, ONE)
        if swarm.is_signalled:
            count_sent(signals, np.uint64(said), stops, now, counts, 0, n)
        heard = chunk.heard[k * n : (k + 1) * n + 1]
        here = (now - 1) * n
        if now >= delay and radio.everyone:
            call(shared[HEAR_ALL], memory, outbox, then, work.partial, n, rows, here, ZERO, n, fused)
            for i in range(n):
                counts[HEARD, i] += n - 1
        elif now >= delay and in_sums:
            call(shared[HEAR_SUMS], memory, outbox, then, heard, senders, senders.size, rows, here, ZERO, n, n, fused)
            if swarm.is_signalled:
                count_said(signals, np.uint64(then), heard, senders, LISTED, counts, 0, n)
            else:
                for i in range(n):
                    counts[HEARD, i] += heard[i + 1] - heard[i]
        else:
            if now >= delay:
                hear_each(swarm, states, work, radio, counts, stops, trial, now, np.uint64(then), heard, senders)
            for run in range(swarm.runs.shape[0]):
                group, a, z = swarm.runs[run, 0], swarm.runs[run, 1], swarm.runs[run, 2]
                base, luck = place(memory, swarm.bases[group]), place(draws, luck_at + np.int64(a))
                call(swarm.functions[group, END_ROUND], base, rows, here, a, z, luck)
        if verdicts.shape[0] > 0:
            for block in range(np.uint64(swarm.of_block.size - 1)):
                judge(swarm, block, memory, rows, np.uint64(here), verdicts, now)
            if tally.agreed[0] < 0.0:
                agree_on(option_of(verdicts, swarm.honest, 0, n), tally.agreed, now)
        if intervals.bounds.shape[1] > 0:
            c = first_from(intervals.checkpoints, now)
            if c < intervals.checkpoints.size and intervals.checkpoints[c] == now:
                ask_all(swarm, memory, intervals.bounds)
                measure_intervals(swarm, c, intervals, False)
        if recorded.history.shape[0] > 0:
            copy_all(recorded.history[k], memory)
            copy_all(recorded.said[k], outbox[then : then + n])
            if swarm.is_signalled:
                copy_all(recorded.signals[k], signals[then : then + n])
            else:
                for i in range(n):
                    counts[SENT, i] += works(stops, TALKING, i, now)
            for i in range(n):
                recorded.messages[k, 0] += counts[SENT, i]
                recorded.messages[k, 1] += counts[HEARD, i]
    count_clipped(swarm, memory, counts)


@entry
def steer(swarm, memory, body, speeds, trial, tick, commands):
    """`steer_all` for CPython."""
    steer_all(swarm, np.zeros(memory.shape[0], np.uint64), memory, body, speeds, trial, tick, commands)


@loop()
def steer_all(swarm, draws, memory, body, speeds, trial, tick, commands):
    """Ask brains where they want to go; `commands` (3, robot) gets whether anywhere, metres and radians a tick.

    `speeds` (robot) are the metres a tick that robots can go. Wheels that turn a robot cannot drive it at full speed as
    well: a command that is too fast for them is slowed as a whole. `draws` (robot) is room for random words.
    """
    n = memory.shape[0]
    if swarm.draws.size > 0:
        words(swarm.draws, trial, tick, DRAW_STEER, ZERO, np.uint64(n), draws)
    for run in range(swarm.runs.shape[0]):
        group, a, z = swarm.runs[run, 0], swarm.runs[run, 1], swarm.runs[run, 2]
        if swarm.functions[group, ASK]:  # some brains of a mixed swarm may not steer
            address = swarm.functions[group, ASK]
            call(address, place(memory, swarm.bases[group]), commands, n, a, z, place(draws, np.int64(a)))
    for i in range(memory.shape[0]):
        speed, turn = commands[1, i] * body[0].tick, commands[2, i] * body[0].tick
        if not (abs(speed) < 1e300 and abs(turn) < 1e300):
            commands[0, i] = tick
            raise ValueError("steer returned a speed or a turn that is not a finite number")
        load = 0.0
        if speed != 0.0:
            load += abs(speed) / speeds[i] if speeds[i] > 0.0 else np.inf
        if turn != 0.0:
            load += abs(turn) / body[0].turn if body[0].turn > 0.0 else np.inf
        commands[1, i], commands[2, i] = speed / max(load, 1.0), turn / max(load, 1.0)


@unpacking(*TO_CONCLUDE)
def conclude(groups):
    """Convergence index and estimate there (robot) of whole curves: `start` is index 0, `rows` are 1 and on.

    `wrong` (3) gets the first invalid estimate, and `disagreement` (checkpoint) that of the `checkpoints`, as in
    `Measures`. Returns the first index from which on it stays within delta; infinite for never.
    """
    swarm, rows, start, delta, work, where, value, wrong, checkpoints, disagreement = unpacked(groups, END)
    rounds, robots = rows.shape
    helpers, honest = swarm.helpers, swarm.honest
    call(helpers[FIRST_WRONG], start, 1, robots, 0, honest, honest.size, wrong)
    call(helpers[FIRST_WRONG], rows, rounds, robots, 1, honest, honest.size, wrong)
    agreed = np.inf
    room, low, high, answer = work.blacks, work.single, work.order, work.answer
    answer[0] = 0.0
    if wrong[0] < 0.0:
        call(helpers[AGREED], start, 1, robots, 0, honest, honest.size, delta, room, answer)
        call(helpers[AGREED], rows, rounds, robots, 1, honest, honest.size, delta, room, answer)
        if answer[0] <= rounds:
            agreed = answer[0]
        for c in range(checkpoints.size):
            if checkpoints[c] <= rounds:
                row = place(rows, (checkpoints[c] - 1) * robots)
                call(helpers[HALF_WIDTH], row, robots, honest, honest.size, room, place(disagreement, c))
    for i in range(robots):
        low[i], high[i] = np.inf, -np.inf
        where[i], value[i] = rounds, rows[rounds - 1, i]
    call(helpers[SETTLED], rows, rounds, robots, 1, delta, low, high, where, value, 0, robots, answer)
    if answer[0] != 0.0:
        call(helpers[SETTLED], start, 1, robots, 0, delta, low, high, where, value, 0, robots, answer)
    return agreed
