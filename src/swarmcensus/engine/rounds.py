"""A round on fixed networks: minds observe, say what they hold, hear each other and fuse.

A `swarm` (see `swarms.py`) holds the addresses of brains' functions, which are called by them (see `calling.py`).
"""

import numpy as np
from numba import njit

from swarmcensus.engine.calling import call, place
from swarmcensus.engine.changes import renew
from swarmcensus.engine.compiling import INSIDE, loop
from swarmcensus.engine.constants import (
    ADD_UP,
    BLOCK,
    END_ROUND,
    FULL,
    GO_ALONE,
    HEAR,
    HEAR_ALL,
    HEAR_SUMS,
    HEARD,
    LISTED,
    LUCK_ALONE,
    LUCK_ALONE_FUSE,
    LUCK_FUSE,
    LUCK_OBSERVE,
    SENSE,
)
from swarmcensus.engine.draws import arrange, count_blacks
from swarmcensus.engine.random import words

from .minds import (
    ONE,
    ZERO,
    agree,
    arrives,
    count_said,
    count_sent,
    drowned,
    is_noise,
    is_said,
    judge,
    luck_of_messages,
    silence_failed,
)

# Robots are counted in uint64 in the inner loops: Numba then need not ask whether an index counts from the end.
CACHED = 1 << 15  # robots up to which a full network passes through the cache as a whole


@njit(nogil=True, **INSIDE)
def bounds_of(receivers, robots):
    """Where each robot's links begin, and where the last one's end; links are sorted by receiver."""
    out = np.empty(robots + 1, np.int64)
    link = 0
    for i in range(robots + 1):
        while link < receivers.size and receivers[link] < i:
            link += 1
        out[i] = link
    return out


@loop()
def most_links(bounds, links, robots):
    """How many messages may arrive in one call: at a block of robots, or of a full network at one robot."""
    most = robots if links != LISTED else 0
    for first in range(0, robots, BLOCK):
        most = max(most, bounds[min(first + BLOCK, robots)] - bounds[first])
    return most


@loop()
def take_drowned_away(swarm, outbox, said, senders, bounds, arrivals, count, stops, tick, counts):
    """How many messages are left of those that arrive, which come receiver by receiver, where some make noise.

    Apart from the loop below, which it would slow by a fifth for those that never jam.
    """
    kept, receiver, deaf = 0, -1, False
    for k in range(count):
        to = np.int64(arrivals[0, k])
        if to != receiver:
            receiver, deaf = to, drowned(swarm, outbox, said, senders, bounds[to], bounds[to + 1], stops, tick)
        if deaf and counts.shape[1] > 0:
            counts[HEARD, to] -= 1
        if not deaf:
            arrivals[0, kept] = arrivals[0, k]
            arrivals[1, kept] = arrivals[1, k]
            kept += 1
    return kept


@loop()
def hear_what_arrives(
    swarm, group, memory, outbox, said, receivers, senders, bounds, first, last, arrivals, luck, key, trial, tick,
    said_at, threshold, stops, counts,
):  # fmt: skip
    """What was said at `said_at` passes along links first ... last - 1, but for what is lost and who did not talk."""
    count = 0
    for link in range(first, last):
        to, by = np.int64(receivers[link]), np.int64(senders[link])
        if is_said(outbox, said + np.uint64(by), swarm.flag) and arrives(
            key, trial, tick, said_at, to, by, threshold, stops
        ):
            arrivals[0, count] = to
            arrivals[1, count] = by
            count += 1
            if counts.shape[1] > 0:
                counts[HEARD, to] += 1
    if swarm.jams:
        count = take_drowned_away(swarm, outbox, said, senders, bounds, arrivals, count, stops, said_at, counts)
    if swarm.luck.size > 0:
        luck_of_messages(swarm, trial, tick, arrivals[0], arrivals[1], 0, count, luck)
    call(
        swarm.minds[group, HEAR], place(memory, swarm.bases[group]), outbox, said, arrivals[0], arrivals[1], ZERO,
        count, memory.shape[0], luck,
    )  # fmt: skip


@loop()
def hear_pairs(
    swarm, memory, outbox, said, arrivals, luck, key, trial, tick, said_at, threshold, stops, counts, stop
):  # fmt: skip
    """All hear what all said at `said_at`, one by one: O(N^2), for a lossy radio or a brain that does not only add."""
    robots = memory.shape[0]
    noises = 0
    if swarm.jams:
        for j in range(robots):
            noises += is_noise(swarm, outbox, said, j, stops, said_at)
    for run in range(swarm.runs.shape[0]):
        group = swarm.runs[run, 0]
        for i in range(np.int64(swarm.runs[run, 1]), np.int64(swarm.runs[run, 2])):
            if stop[0] != 0:
                return
            count = 0
            if noises > 0 and noises > is_noise(swarm, outbox, said, i, stops, said_at):  # of another one
                continue
            for j in range(robots):
                if (
                    i != j
                    and is_said(outbox, said + np.uint64(j), swarm.flag)
                    and arrives(key, trial, tick, said_at, i, j, threshold, stops)
                ):
                    arrivals[0, count] = i
                    arrivals[1, count] = j
                    count += 1
            if counts.shape[1] > 0:
                counts[HEARD, i] += count
            if swarm.luck.size > 0:
                luck_of_messages(swarm, trial, tick, arrivals[0], arrivals[1], 0, count, luck)
            call(
                swarm.minds[group, HEAR], place(memory, swarm.bases[group]), outbox, said, arrivals[0], arrivals[1],
                ZERO, count, robots, luck,
            )  # fmt: skip


@loop()
def advance(
    swarm, memory, outbox, sums_beside, readings, bits, luck, source, delay, first, last, looks, trial,
    read_key, link_key, links, receivers, senders, bounds, arrivals, threshold, rows, stops,
    counts, verdicts, agreed, stop,
):  # fmt: skip
    """Run rounds first ... last - 1; their estimates go to `rows`.

    But for pairs a robot ends one round and observes for the next in one go, block by block, so that a
    swarm larger than the processor's cache passes through it once a round. Hence the outbox has two parts, and one more
    for each round that messages are late (`delay`), which take turns: `said` is where those begin that are heard in
    this round. `luck` (what for, robot or message) is empty where none is asked for; `counts` (what, robot) and
    `verdicts` where nothing is to be counted or judged. `source` is one of `changes.py`.
    """
    n = np.uint64(memory.shape[0])
    ring = np.uint64(delay + 2) * n
    said, next_said = np.uint64((first + 1) % (delay + 2)) * n, np.uint64(first % (delay + 2)) * n
    sound = threshold == 0 and stops.shape[1] == 0
    in_sums = links == LISTED and sound and swarm.additive
    one_by_one = links == LISTED and not (sound and swarm.flag < 0)
    at_once = n <= CACHED
    lucky = swarm.luck.size > 0
    fused, heard = np.int64(luck.shape[1]), np.int64(2 * luck.shape[1])  # where in it the luck of what begins
    addresses, bases, runs, of_block, flag = swarm.minds, swarm.bases, swarm.runs, swarm.of_block, swarm.flag
    minds = addresses[0]  # of all robots, where the swarm is additive
    for k in range(first - 1, last):
        if stop[0] != 0:
            return
        r = k - first
        here = np.uint64(max(r, 0)) * n
        if source.changes and k + 1 < last:
            renew(source, looks, k + 1)
        hears = r >= 0 and k > delay
        if hears and links == FULL:
            call(minds[ADD_UP], outbox, said, sums_beside, n if at_once else np.uint64(BLOCK), n)
            if at_once:
                if lucky:
                    words(swarm.luck, trial, k, LUCK_FUSE, ZERO, n, luck[1])
                call(minds[HEAR_ALL], memory, outbox, said, sums_beside, ZERO, rows, here, ZERO, n, place(luck, fused))
        elif hears and links != LISTED:
            hear_pairs(
                swarm, memory, outbox, said, arrivals, luck[2], link_key, trial, k, k - delay, threshold, stops,
                counts, stop,
            )  # fmt: skip
        if hears and flag >= 0 and (in_sums or links == FULL):
            count_said(swarm, outbox, said, bounds, senders, links, counts)
        for block in range(ZERO, np.uint64(sums_beside.shape[0] - 1)):
            start = block * np.uint64(BLOCK)
            end = min(start + np.uint64(BLOCK), n)
            if r >= 0 and lucky and not (hears and links == FULL and at_once):
                words(swarm.luck, trial, k, LUCK_FUSE, start, end - start, luck[1])
            if hears and in_sums:
                call(
                    minds[HEAR_SUMS], memory, outbox, said, bounds, senders, senders.size, rows, here, start, end, n,
                    place(luck, fused),
                )  # fmt: skip
            elif hears and links == FULL and not at_once:
                call(
                    minds[HEAR_ALL],
                    memory,
                    outbox,
                    said,
                    sums_beside,
                    block,
                    rows,
                    here,
                    start,
                    end,
                    place(luck, fused),
                )
            elif r >= 0 and not (hears and links == FULL):
                for run in range(of_block[block], of_block[block + np.uint64(1)]):
                    group, a, z = runs[run, 0], runs[run, 1], runs[run, 2]
                    base = bases[group]
                    if hears and one_by_one:
                        hear_what_arrives(
                            swarm, group, memory, outbox, said, receivers, senders, bounds, bounds[a], bounds[z],
                            arrivals, luck[2], link_key, trial, k, k - delay, threshold, stops, counts,
                        )  # fmt: skip
                    elif hears and links == LISTED:
                        if lucky:
                            luck_of_messages(swarm, trial, k, receivers, senders, bounds[a], bounds[z], luck[2])
                        call(
                            addresses[group, HEAR], place(memory, base), outbox, said, receivers, senders, bounds[a],
                            bounds[z], n, place(luck, heard),
                        )  # fmt: skip
                    call(
                        addresses[group, END_ROUND], place(memory, base), rows, here, a, z,
                        place(luck, fused + np.int64(a - start)),
                    )  # fmt: skip
            if r >= 0 and verdicts.shape[0] > 0:
                judge(swarm, block, memory, rows, here, verdicts, k)
            if k + 1 < last:
                count_blacks(readings, bits, source.tables, looks, read_key, trial, k + 1, start, end)
                silence_failed(readings, stops, k + 1, start, end)
                if lucky:
                    words(swarm.luck, trial, k + 1, LUCK_OBSERVE, start, end - start, luck[0])
                for run in range(of_block[block], of_block[block + np.uint64(1)]):
                    group, a, z = runs[run, 0], runs[run, 1], runs[run, 2]
                    offset = np.int64(a - start)
                    call(
                        addresses[group, SENSE], place(memory, bases[group]), outbox, next_said,
                        place(readings, offset), float(looks), a, z, place(luck, offset), ONE,
                    )  # fmt: skip
        if k + 1 < last and flag >= 0:
            count_sent(swarm, outbox, next_said, stops, k + 1, counts)
        if r >= 0 and verdicts.shape[0] > 0:
            agree(verdicts, swarm.honest, agreed, k)
        said = said + n if said + n < ring else ZERO
        next_said = next_said + n if next_said + n < ring else ZERO


@loop()
def advance_alone(
    swarm, memory, readings, blacks, bits, luck, source, first, last, looks, trial, read_key, order_key, rows, stops,
    stop,
):  # fmt: skip
    """Run single observations first ... last - 1 of robots that hear nobody; their estimates go to `rows`."""
    n = np.uint64(memory.shape[0])
    lucky = swarm.luck.size > 0
    addresses, bases, runs = swarm.minds, swarm.bases, swarm.runs
    n_words = np.int64(luck.shape[1])
    for k in range(first, last):
        if stop[0] != 0:
            return
        left = looks - (k - 1) % looks
        tick = (k - 1) // looks + 1
        if left == looks:
            if source.changes:
                renew(source, looks, tick)
            count_blacks(blacks, bits, source.tables, looks, read_key, trial, tick, ZERO, n)
        arrange(readings, blacks, bits, left, order_key, trial, k)
        silence_failed(readings, stops, tick, ZERO, n)
        if lucky:
            words(swarm.luck, trial, k, LUCK_ALONE, ZERO, n, luck[0])
            words(swarm.luck, trial, k, LUCK_ALONE_FUSE, ZERO, n, luck[1])
        for run in range(runs.shape[0]):
            group, a, z = runs[run, 0], runs[run, 1], runs[run, 2]
            at = np.int64(a)
            call(
                addresses[group, GO_ALONE], place(memory, bases[group]), place(readings, at), rows,
                np.uint64(k - first) * n, a, z, place(luck, at), place(luck, n_words + at),
            )  # fmt: skip
