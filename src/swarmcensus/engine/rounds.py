"""A round on fixed networks: robots observe, talk, hear each other and fuse.

A `Swarm` (`layout.py`) holds the addresses of the brains' functions, which are called by address (`calling.py`).
"""

from typing import Any, NamedTuple

import numpy as np

from swarmcensus.engine.calling import call, place
from swarmcensus.engine.changes import renew
from swarmcensus.engine.compiling import inside, loop
from swarmcensus.engine.constants import (
    ADD_UP,
    BLOCK,
    BLOCKS,
    DRAW_ALONE,
    DRAW_ALONE_FUSE,
    DRAW_FUSE,
    DRAW_OBSERVE,
    END_ROUND,
    FULL,
    GO_ALONE,
    HEAR,
    HEAR_ALL,
    HEAR_SUMS,
    HEARD,
    LISTED,
    PAIRS,
    PASS_ON,
    SENSE,
)
from swarmcensus.engine.draws import arrange, count_blacks
from swarmcensus.engine.random import words

from .states import (
    ONE,
    ZERO,
    agree,
    arrives,
    count_said,
    count_sent,
    draw_for_messages,
    drowned,
    first_from,
    is_noise,
    is_said,
    judge,
    option_of,
    silence_failed,
)
from .teams import unanimous, wait

# Robots are counted in uint64 in the inner loops: Numba then does not check for negative indices.
SIZE, TOGETHER = np.uint64(BLOCK), np.uint64(BLOCKS)


class Graph(NamedTuple):
    """Who hears whom in a trial."""

    mode: Any  # LISTED, FULL or PAIRS
    receivers: Any
    senders: Any
    bounds: Any  # (robot + 1): robot i has the links from bounds[i] to bounds[i + 1]


class Work(NamedTuple):
    """Room to work in, for a block of robots, or for all that go alone."""

    blacks: Any  # (robot): how many readings of a round are black
    bits: Any  # (robot): random words
    single: Any  # (robot): single readings; no robots if they do not go alone
    draws: Any  # (3, robot or message): words to observe, fuse and hear with; empty where no brain uses luck
    sums: Any  # (block, byte): sums of messages of blocks of a full network, see `phases.hear_all`
    partial: Any  # (2 x block, byte): sums of the blocks before and after each
    arrivals: Any  # (2, message): receivers and senders of what gets through


@inside()
def graph_of(links, graph, robots, first, last):
    """One of the graphs of a batch; nobody touches the bounds of other robots than first ... last - 1."""
    receivers = links.receivers[links.starts[graph] : links.starts[graph + 1]]
    senders = links.senders[links.starts[graph] : links.starts[graph + 1]]
    bounds = np.empty(robots + 1, np.int64)
    link = first_from(receivers, first)
    for i in range(first, last + 1):
        while link < receivers.size and receivers[link] < i:
            link += 1
        bounds[i] = link
    return Graph(links.mode, receivers, senders, bounds)


@loop()
def most_arrivals(graph, begin, end):
    """How many messages may arrive in one call at robots begin ... end - 1: at a block, or among pairs at one robot."""
    most = graph.bounds.size - 1 if graph.mode == PAIRS else 0
    for first in range(begin, end, BLOCK):
        most = max(most, graph.bounds[min(first + BLOCK, end)] - graph.bounds[first])
    return most


@loop()
def count_heard(swarm, graph, radio, stops, rounds, counts, begin, end):
    """Count what robots begin ... end - 1 hear in so many rounds if it is the same in each; else `advance` does."""
    sound = radio.threshold == 0 and stops.shape[1] == 0 and graph.mode != PAIRS
    if not swarm.is_signalled and (graph.mode == FULL or sound):
        robots = graph.bounds.size - 1
        for i in range(begin, min(end, counts.shape[1])):
            degree = robots - 1 if graph.mode == FULL else graph.bounds[i + 1] - graph.bounds[i]
            counts[HEARD, i] += rounds * degree


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
            arrivals[0, kept] = arrivals[0, k]
            arrivals[1, kept] = arrivals[1, k]
            kept += 1
    return kept


@loop(forceinline=True)
def hear_what_arrives(swarm, states, work, graph, radio, counts, stops, trial, tick, said, group, first, last):
    """Messages at `said` in the outbox pass along links first ... last - 1, but for lost ones and broken radios.

    It is part of its caller, because passing so many arguments would take longer than what it does for a hundred links.
    """
    arrivals, outbox, signals, draws = work.arrivals, states.outbox, states.signals, work.draws[2]
    count = 0
    for link in range(first, last):
        to, by = np.int64(graph.receivers[link]), np.int64(graph.senders[link])
        if is_said(signals, said + np.uint64(by)) and arrives(radio, trial, tick, to, by, stops):
            arrivals[0, count] = to
            arrivals[1, count] = by
            count += 1
            if counts.shape[1] > 0:
                counts[HEARD, to] += 1
    if swarm.jams:
        count = take_drowned_away(signals, said, graph, arrivals, count, stops, tick - radio.delay, counts)
    if swarm.draws.size > 0:
        draw_for_messages(swarm, trial, tick, arrivals[0], arrivals[1], 0, count, draws)
    call(
        swarm.functions[group, HEAR], place(states.memory, swarm.bases[group]), outbox, said, arrivals[0], arrivals[1],
        ZERO, count, states.memory.shape[0], draws,
    )  # fmt: skip


@loop()
def hear_pairs(swarm, states, work, radio, counts, stops, trial, tick, said, stop):
    """All hear all, message by message: O(N^2), for a radio that loses messages or a brain that does more than add."""
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
            count = 0
            if noises > 0 and noises > is_noise(signals, said, i, stops, said_at):  # another robot's noise
                continue
            for j in range(robots):
                if i != j and is_said(signals, said + np.uint64(j)) and arrives(radio, trial, tick, i, j, stops):
                    arrivals[0, count] = i
                    arrivals[1, count] = j
                    count += 1
            if counts.shape[1] > 0:
                counts[HEARD, i] += count
            if swarm.draws.size > 0:
                draw_for_messages(swarm, trial, tick, arrivals[0], arrivals[1], 0, count, draws)
            call(
                swarm.functions[group, HEAR], place(states.memory, swarm.bases[group]), outbox, said, arrivals[0],
                arrivals[1], ZERO, count, robots, draws,
            )  # fmt: skip


@loop()
def advance(swarm, states, work, source, graph, radio, tally, stops, trial, first, last, stop, team):
    """Run rounds first ... last - 1 of a trial; states.rows get their estimates.

    A member of a team does so for its own robots. All wait after each round, because robots hear what others said.

    Except with PAIRS, a robot ends one round and observes for the next in one pass, block by block, so that a swarm
    larger than the processor's cache passes through it once a round. So the outbox has two parts, which take turns, and
    one more for each round that messages are late; `said` is where the messages begin that are heard in this round.
    Nothing is counted or judged where the `Tally` has no robots.
    """
    memory, outbox, signals, rows = states
    blacks, bits, draws, partial = work.blacks, work.bits, work.draws, work.partial
    blocks, begin, everyone = np.uint64(swarm.of_block.size - 1), np.uint64(team.begin), np.uint64(work.sums.shape[0])
    counts, verdicts, agreed = tally.counts, tally.verdicts, tally.agreed
    tables, key = source.tables, source.sensors.key
    links, bounds, receivers, senders = graph.mode, graph.bounds, graph.receivers, graph.senders
    looks, delay = source.sensors.looks, radio.delay
    n = np.uint64(memory.shape[0])
    ring = np.uint64(delay + 2) * n
    said, next_said = np.uint64((first + 1) % (delay + 2)) * n, np.uint64(first % (delay + 2)) * n
    sound = radio.threshold == 0 and stops.shape[1] == 0
    in_sums = links == LISTED and sound and swarm.additive
    one_by_one = links == LISTED and (swarm.is_signalled or not sound)
    is_random = swarm.draws.size > 0
    fused, heard = np.int64(draws.shape[1]), np.int64(2 * draws.shape[1])  # where in `draws` those parts begin
    addresses, bases, runs, of_block = swarm.functions, swarm.bases, swarm.runs, swarm.of_block
    shared = addresses[0]  # functions of all robots, if the swarm is additive
    for k in range(first - 1, last):
        if stop[0] != 0:
            return
        r = k - first
        here = np.uint64(max(r, 0)) * n
        if source.changes and k + 1 < last:
            renew(source, k + 1, team.first, team.last)
        hears = r >= 0 and k > delay
        whole = hears and links == FULL
        if whole and everyone > ONE:
            call(shared[ADD_UP], outbox, said, work.sums, begin, begin + blocks, n)
            wait(team)
            call(shared[PASS_ON], work.sums, partial, everyone)
        if hears and links == PAIRS:
            hear_pairs(swarm, states, work, radio, counts, stops, trial, k, said, stop)
        if hears and swarm.is_signalled and (in_sums or links == FULL):
            count_said(signals, said, bounds, senders, links, counts, team.first, team.last)
        for block in range(ZERO, blocks):
            start = (begin + block) * SIZE
            end = min(start + SIZE, n)
            if whole and block % TOGETHER == ZERO:
                until = min(start + TOGETHER * SIZE, np.uint64(team.last))
                if is_random:
                    words(swarm.draws, trial, k, DRAW_FUSE, start, until - start, draws[1])
                call(
                    shared[HEAR_ALL], memory, outbox, said, partial, SIZE, rows, here, start, until,
                    place(draws, fused),
                )  # fmt: skip
            elif r >= 0 and is_random and not whole:
                words(swarm.draws, trial, k, DRAW_FUSE, start, end - start, draws[1])
            if hears and in_sums:
                call(
                    shared[HEAR_SUMS], memory, outbox, said, bounds, senders, senders.size, rows, here, start, end, n,
                    place(draws, fused),
                )  # fmt: skip
            elif r >= 0 and not whole:
                for run in range(of_block[block], of_block[block + np.uint64(1)]):
                    group, a, z = runs[run, 0], runs[run, 1], runs[run, 2]
                    base = bases[group]
                    if hears and one_by_one:
                        hear_what_arrives(
                            swarm, states, work, graph, radio, counts, stops, trial, k, said, group, bounds[a],
                            bounds[z],
                        )  # fmt: skip
                    elif hears and links == LISTED:
                        if is_random:
                            draw_for_messages(
                                swarm, trial, k, receivers, senders, bounds[a], bounds[z], draws[2]
                            )  # fmt: skip
                        call(
                            addresses[group, HEAR], place(memory, base), outbox, said, receivers, senders,
                            bounds[a], bounds[z], n, place(draws, heard),
                        )  # fmt: skip
                    call(
                        addresses[group, END_ROUND], place(memory, base), rows, here, a, z,
                        place(draws, fused + np.int64(a - start)),
                    )  # fmt: skip
            if r >= 0 and verdicts.shape[0] > 0:
                judge(swarm, block, memory, rows, here, verdicts, k)
            if k + 1 < last:
                count_blacks(
                    blacks, bits, tables, looks, key, trial, k + 1, start, end
                )  # fmt: skip
                silence_failed(blacks, stops, k + 1, start, end)
                if is_random:
                    words(swarm.draws, trial, k + 1, DRAW_OBSERVE, start, end - start, draws[0])
                for run in range(of_block[block], of_block[block + np.uint64(1)]):
                    group, a, z = runs[run, 0], runs[run, 1], runs[run, 2]
                    offset = np.int64(a - start)
                    call(
                        addresses[group, SENSE], place(memory, bases[group]), outbox, signals, next_said,
                        place(blacks, offset), float(looks), a, z, place(draws, offset), ONE,
                    )  # fmt: skip
        if k + 1 < last and swarm.is_signalled:
            count_sent(signals, next_said, stops, k + 1, counts, team.first, team.last)
        if r >= 0 and verdicts.shape[0] > 0 and agreed[0] < 0.0:
            agree(unanimous(team, option_of(verdicts, swarm.honest, team.first, team.last)), agreed, k)
        wait(team)
        said = said + n if said + n < ring else ZERO
        next_said = next_said + n if next_said + n < ring else ZERO


@loop()
def advance_alone(swarm, states, work, source, stops, trial, first, last, stop, team):
    """Run single observations first ... last - 1 of robots that hear nobody; states.rows get their estimates.

    A member of a team does so for its own robots.
    """
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
            at = np.int64(a - begin)
            call(
                swarm.functions[group, GO_ALONE], place(memory, swarm.bases[group]), place(work.single, at), rows,
                np.uint64(k - first) * n, a, z, place(draws, at), place(draws, n_words + at),
            )  # fmt: skip
