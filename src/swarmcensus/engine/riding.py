"""The engine's inner loops of robots that move: minds that ride along on a walk, and say where it should go.

Like the kernel, these are compiled once on a machine: a `swarm` (see `swarms.py`) holds the addresses of brains'
functions.
"""

import numpy as np
from numba import njit

from swarmcensus.engine.calling import call, place
from swarmcensus.engine.changes import accuracy_in
from swarmcensus.engine.compiling import INSIDE, entry, loop
from swarmcensus.engine.constants import (
    ADD_UP,
    ASK,
    END_ROUND,
    HEAR,
    HEAR_ALL,
    HEAR_SUMS,
    HEARD,
    LISTED,
    LUCK_FUSE,
    LUCK_OBSERVE,
    LUCK_STEER,
    SENSE,
)
from swarmcensus.engine.random import unit, words
from swarmcensus.engine.swarms import Swarm

from .minds import (
    ONE,
    ZERO,
    agree,
    arrives,
    ask_intervals,
    begin,
    believe_all,
    count_known,
    count_said,
    count_sent,
    drowned,
    first_from,
    forget_verdicts,
    is_said,
    judge,
    judge_blank,
    luck_of_messages,
    put,
    settle,
    silence_failed,
)


@entry
def wake(
    minds, bases, fields, named, blanks, runs, of_block, additive, flag, jams, luck_keys, honest,
    memory, b, w, outbox, start, counts, verdicts, agreed, stops, rounds,
):  # fmt: skip
    """Blank minds of a `Swarm` that believe in b and w; what they would say, and estimate before any observation."""
    swarm = Swarm(minds, bases, fields, named, blanks, runs, of_block, additive, flag, jams, luck_keys, honest)
    count_known(swarm, counts, stops, rounds)
    begin(swarm, memory, b, w)
    nothing = np.full(memory.shape[0], -1.0)
    luck = np.zeros(memory.shape[0], np.uint64)
    for run in range(swarm.runs.shape[0]):
        group, a, z = swarm.runs[run, 0], swarm.runs[run, 1], swarm.runs[run, 2]
        call(swarm.minds[group, SENSE], place(memory, swarm.bases[group]), outbox, ZERO, nothing, 1.0, a, z, luck, ONE)
    believe_all(swarm, memory, start, ZERO)
    forget_verdicts(verdicts, agreed)
    if verdicts.shape[0] > 0:
        judge_blank(swarm, memory, start, verdicts)


@loop(forceinline=True)
def look(readings, looked, black, b, w, bits):
    """What robots that look read of the colour under them: 1 for black, -1 of those that do not look."""
    step_b, step_w = np.uint64(b.size > 1), np.uint64(w.size > 1)
    for i in range(ZERO, np.uint64(readings.size)):
        right = unit(bits[i]) < (b[i * step_b] if black[i] else w[i * step_w])
        readings[i] = (1.0 if black[i] == right else 0.0) if looked[i] else -1.0


@loop()
def hear_each(
    swarm, memory, outbox, then, arrivals, luck, heard, senders, key, trial, tick, delay, threshold, stops, counts
):  # fmt: skip
    """Each hears what senders[heard[i]: heard[i + 1]] said, but for lost messages and who did not talk, `delay` ago."""
    robots = memory.shape[0]
    for run in range(swarm.runs.shape[0]):
        group = swarm.runs[run, 0]
        count = 0
        for i in range(np.int64(swarm.runs[run, 1]), np.int64(swarm.runs[run, 2])):
            before = count
            if swarm.jams and drowned(swarm, outbox, then, senders, heard[i], heard[i + 1], stops, tick - delay):
                continue
            for e in range(heard[i], heard[i + 1]):
                if is_said(outbox, then + senders[e], swarm.flag) and arrives(
                    key, trial, tick, tick - delay, i, senders[e], threshold, stops
                ):
                    arrivals[0, count] = i
                    arrivals[1, count] = senders[e]
                    count += 1
            counts[HEARD, i] += count - before
        if swarm.luck.size > 0:
            luck_of_messages(swarm, trial, tick, arrivals[0], arrivals[1], 0, count, luck)
        call(
            swarm.minds[group, HEAR], place(memory, swarm.bases[group]), outbox, then, arrivals[0], arrivals[1], ZERO,
            count, robots, luck,
        )  # fmt: skip


@njit(nogil=True, **INSIDE)
def room_of(robots, messages, width):
    """Room to work in, for so many messages a tick: bits, readings, luck of observing and fusing, arrivals, their luck,
    accuracies b and w of the tick, and sums of messages that are so wide.

    Made once: to make it anew in each tick would cost a small swarm that steers a tenth of its time.
    """
    return (
        np.zeros(robots, np.uint64),
        np.zeros(robots),
        np.zeros((2, robots), np.uint64),
        np.zeros((2, messages), np.uint32),
        np.zeros(messages, np.uint64),
        np.zeros(robots),
        np.zeros(robots),
        np.zeros((2, width)),
    )


@entry
def ride(
    minds, bases, fields, named, blanks, runs, of_block, additive, flag, jams, luck_keys, honest,
    memory, outbox, rows, trial, tick, b, w, drift, read_key, link_key, threshold, delay, everyone,
    looked, black, heard, senders, history, readings, counts, verdicts, agreed, checkpoints, truths, bounds, sure,
    wrong, stops, stop,
):  # fmt: skip
    """`live_on` of a `Swarm`."""
    swarm = Swarm(minds, bases, fields, named, blanks, runs, of_block, additive, flag, jams, luck_keys, honest)
    n, most = memory.shape[0], 0
    for k in range(looked.shape[0]):
        most = max(most, heard[(k + 1) * n] - heard[k * n])
    live_on(
        swarm, room_of(n, most, outbox.shape[1]), memory, outbox, rows, trial, tick, b, w, drift, read_key, link_key,
        threshold, delay, everyone, looked, black, heard, senders, history, readings, counts, verdicts, agreed,
        checkpoints, truths, bounds, sure, wrong, stops, stop,
    )  # fmt: skip


@loop()
def live_on(
    swarm, room, memory, outbox, rows, trial, tick, b, w, drift, read_key, link_key, threshold, delay, everyone,
    looked, black, heard, senders, history, readings, counts, verdicts, agreed, checkpoints, truths, bounds, sure,
    wrong, stops, stop,
):  # fmt: skip
    """Minds that ride along on a chunk of a walk, from `tick` on; estimates of tick k go to rows[k - 1].

    `looked` and `black` (tick, robot): whether a robot observes, and whether the tile under its sensor is black.
    `b` and `w` are the true accuracies of tick 1, `drift` is of `changes.py`. What a robot hears was said `delay`
    ticks ago; `outbox` holds delay + 1 ticks. With `everyone` all hear all, whoever is near: their messages add up.
    `history` and `readings` (NaN where a robot made none) are filled where they have rows. `counts` (what, robot) grows
    by what is sent and heard, but for what is known beforehand; `verdicts` (robot or 0, what) and `agreed` are of
    decisions; from `checkpoints` to `wrong` is what `ask_intervals` takes, `bounds` without robots if none is asked.
    """
    n = memory.shape[0]
    bits, seen, luck, arrivals, message_luck, now_b, now_w, beside = room
    lucky = swarm.luck.size > 0
    silent = swarm.flag >= 0
    in_sums = swarm.additive and threshold == 0 and stops.shape[1] == 0
    for k in range(looked.shape[0]):
        if stop[0] != 0:
            return
        now = tick + k
        said, then = now % (delay + 1) * n, (now - delay) % (delay + 1) * n
        words(read_key, trial, now, np.int64(0), np.uint64(0), np.uint64(n), bits)
        if drift.shape[1] > 0:
            for i in range(n):
                now_b[i], now_w[i] = accuracy_in(b, drift, i, now), accuracy_in(w, drift, i, now)
            look(seen, looked[k], black[k], now_b, now_w, bits)
        else:
            look(seen, looked[k], black[k], b, w, bits)
        silence_failed(seen, stops, now, ZERO, np.uint64(n))
        if readings.shape[0] > 0:
            for i in range(n):
                if seen[i] >= 0.0:
                    readings[k, i] = seen[i]
        if lucky:
            words(swarm.luck, trial, now, LUCK_OBSERVE, ZERO, np.uint64(n), luck[0])
            words(swarm.luck, trial, now, LUCK_FUSE, ZERO, np.uint64(n), luck[1])
        for run in range(swarm.runs.shape[0]):
            group, a, z = swarm.runs[run, 0], swarm.runs[run, 1], swarm.runs[run, 2]
            at = np.int64(a)
            call(
                swarm.minds[group, SENSE], place(memory, swarm.bases[group]), outbox, said, place(seen, at), 1.0, a, z,
                place(luck, at), ONE,
            )  # fmt: skip
        if silent:
            count_sent(swarm, outbox, np.uint64(said), stops, now, counts)
        links = heard[k * n : (k + 1) * n + 1]
        here = (now - 1) * n
        if now >= delay and everyone:
            call(swarm.minds[0, ADD_UP], outbox, then, beside, n, n)
            call(
                swarm.minds[0, HEAR_ALL], memory, outbox, then, beside, ZERO, rows, here, ZERO, n, place(luck, n)
            )  # fmt: skip
            for i in range(n):
                counts[HEARD, i] += n - 1
        elif now >= delay and in_sums:
            call(
                swarm.minds[0, HEAR_SUMS], memory, outbox, then, links, senders, senders.size, rows, here, ZERO, n, n,
                place(luck, n),
            )  # fmt: skip
            if silent:
                count_said(swarm, outbox, np.uint64(then), links, senders, LISTED, counts)
            else:
                for i in range(n):
                    counts[HEARD, i] += links[i + 1] - links[i]
        else:
            if now >= delay:
                hear_each(
                    swarm, memory, outbox, np.uint64(then), arrivals, message_luck, links, senders, link_key, trial,
                    now, delay, threshold, stops, counts,
                )  # fmt: skip
            for run in range(swarm.runs.shape[0]):
                group, a, z = swarm.runs[run, 0], swarm.runs[run, 1], swarm.runs[run, 2]
                call(
                    swarm.minds[group, END_ROUND], place(memory, swarm.bases[group]), rows, here, a, z,
                    place(luck, n + np.int64(a)),
                )  # fmt: skip
        if verdicts.shape[0] > 0:
            for block in range(np.uint64(swarm.of_block.size - 1)):
                judge(swarm, block, memory, rows, np.uint64(here), verdicts, now)
            agree(verdicts, swarm.honest, agreed, now)
        if bounds.shape[1] > 0:
            c = first_from(checkpoints, now)
            if c < checkpoints.size and checkpoints[c] == now:
                ask_intervals(swarm, memory, c, checkpoints, truths, bounds, sure, wrong)
        if history.shape[0] > 0:
            put(history[k], memory)


@entry
def wish(
    minds, bases, fields, named, blanks, runs, of_block, additive, flag, jams, luck_keys, honest,
    memory, body, paces, trial, tick, wishes,
):  # fmt: skip
    """`ask_all` of a `Swarm`."""
    swarm = Swarm(minds, bases, fields, named, blanks, runs, of_block, additive, flag, jams, luck_keys, honest)
    ask_all(swarm, np.zeros(memory.shape[0], np.uint64), memory, body, paces, trial, tick, wishes)


@loop()
def ask_all(swarm, luck, memory, body, paces, trial, tick, wishes):
    """Ask minds where they want to go; `wishes` (what, robot): whether anywhere, metres and radians a tick.

    `paces` (robot) are the metres a tick that robots can go. Wheels that turn a robot cannot drive it at
    full speed as well: what is too fast for them is slowed as a whole. `luck` is room for a word each.
    """
    n = memory.shape[0]
    if swarm.luck.size > 0:
        words(swarm.luck, trial, tick, LUCK_STEER, ZERO, np.uint64(n), luck)
    for run in range(swarm.runs.shape[0]):
        group, a, z = swarm.runs[run, 0], swarm.runs[run, 1], swarm.runs[run, 2]
        if swarm.minds[group, ASK]:  # of several brains perhaps only some steer
            call(swarm.minds[group, ASK], place(memory, swarm.bases[group]), wishes, n, a, z, place(luck, np.int64(a)))
    for i in range(memory.shape[0]):
        speed = wishes[1, i] * body[0].tick
        turn = wishes[2, i] * body[0].tick
        if not (abs(speed) < 1e300 and abs(turn) < 1e300):
            raise ValueError("steer returned a speed or a turn that is not a finite number")
        load = 0.0
        if speed != 0.0:
            load += abs(speed) / paces[i] if paces[i] > 0.0 else np.inf
        if turn != 0.0:
            load += abs(turn) / body[0].turn if body[0].turn > 0.0 else np.inf
        wishes[1, i] = speed / max(load, 1.0)
        wishes[2, i] = turn / max(load, 1.0)


@entry
def conclude(rows, start, delta, where, value):
    """The convergence of whole curves `rows`, index 1 on, after `start`, index 0."""
    robots = rows.shape[1]
    low = np.empty(robots)
    high = np.empty(robots)
    for i in range(robots):
        low[i] = np.inf
        high[i] = -np.inf
        where[i] = rows.shape[0]
        value[i] = rows[rows.shape[0] - 1, i]
    if settle(rows, np.int64(1), delta, low, high, where, value):
        settle(start, np.int64(0), delta, low, high, where, value)
