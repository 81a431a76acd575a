"""A round on fixed networks: robots observe, talk, hear each other and fuse.

A `Swarm` (`layout.py`) holds the addresses of the brains' functions, which are called by address (`calling.py`).
"""

import numpy as np

from swarmcensus.engine.calling import call, packed, place
from swarmcensus.engine.compiling import loop
from swarmcensus.engine.constants import (
    ADD_UP,
    AGREE,
    AHEAD,
    BLOCK,
    BLOCKS,
    COUNT_SIGNALS,
    DRAW_FUSE,
    DRAW_OBSERVE,
    DRAW_WORDS,
    END_ROUND,
    FAIL_SENSORS,
    FILL_WORDS,
    FULL,
    HEAR,
    HEAR_ALL,
    HEAR_PAIRS,
    HEAR_SINGLY,
    HEAR_SUMS,
    JUDGE_BLOCK,
    LISTED,
    PAIRS,
    PASS_ON,
    RENEW,
    SENSE,
)
from swarmcensus.engine.draws import count_blacks

from .shared_trials import wait
from .states import ONE, ZERO
from .trial_arguments import ARGUMENTS, SOURCE, Graph, TrialArguments

# Robots are counted in uint64 in the inner loops: Numba then does not check for negative indices.
SIZE, TOGETHER = np.uint64(BLOCK), np.uint64(BLOCKS)


@loop()
def graph_of(links, graph, bounds):
    """One of the graphs of a batch; `bounds` get the links of all robots."""
    receivers = links.receivers[links.starts[graph] : links.starts[graph + 1]]
    senders = links.senders[links.starts[graph] : links.starts[graph + 1]]
    link, reach, blocks = 0, 0, (bounds.size + BLOCK - 2) // BLOCK
    for i in range(bounds.size):
        while link < receivers.size and receivers[link] < i:
            apart = abs(np.int64(receivers[link] // SIZE) - np.int64(senders[link] // SIZE))
            reach = max(reach, min(apart, blocks - apart))
            link += 1
        bounds[i] = link
    return Graph(links.mode, receivers, senders, bounds, reach)


@loop()
def advance(swarm, states, work, source, graph, radio, tally, stops, trial, first, last, stop, team):
    """Run rounds first ... last - 1 of a trial; states.rows get their estimates.

    A member of a team does so for its own robots. All wait after each round, because robots hear what others said.

    Except with PAIRS, a robot ends one round and observes for the next in one pass, block by block, so that a swarm
    larger than the processor's cache passes through it once a round. So the outbox has two parts, which take turns, and
    one more for each round that messages are late; `said` is where the messages begin that are heard in this round.
    Nothing is counted or judged where the `Tally` has no robots.

    Where links reach only a few blocks and nothing is shared but messages, it passes once in AHEAD rounds. A member
    goes on by a round with each block as soon as those that it hears have ended the one before. That leaves out blocks
    near both ends of its own, more of them in each round; once all are here, it makes up for those around its first.
    """
    memory, outbox, signals, rows = states
    blacks, bits, draws, partial = work.blacks, work.bits, work.draws, work.partial
    n, own, begin, delay = np.uint64(memory.shape[0]), swarm.of_block.size - 1, np.uint64(team.begin), radio.delay
    blocks, everyone = np.uint64(own), (memory.shape[0] + BLOCK - 1) // BLOCK
    verdicts, tables, key = tally.verdicts, source.tables, source.sensors.key
    links, receivers, senders, bounds, reach = graph
    sound = radio.threshold == 0 and stops.shape[1] == 0
    in_sums = links == LISTED and sound and swarm.additive
    one_by_one = links == LISTED and (swarm.is_signalled or not sound)
    is_random, looks = swarm.draws.size > 0, source.sensors.looks
    fused = np.int64(draws.shape[1])  # where in `draws` this part begins
    later, heard, many = place(draws, fused), place(draws, 2 * fused), senders.size
    addresses, bases, runs, of_block = swarm.functions, swarm.bases, swarm.runs, swarm.of_block
    shared = addresses[0]  # functions of all robots, if the swarm is additive
    helpers, arguments, at_once = swarm.helpers, place(rows, 0), 1
    if is_random or one_by_one or links == PAIRS or swarm.is_signalled or not sound or verdicts.shape[0] > 0:
        of = TrialArguments(swarm, states, work, source, graph, radio, tally, stops, trial, team, stop)
        arguments = packed(of, ARGUMENTS)
    elif in_sums and not source.changes and (team.count == 1 or tables.shape[1] == 1):
        at_once = AHEAD if 2 * reach * AHEAD <= everyone // team.count else 1
    for begun in range(first - 1, last, at_once):
        if stop[0] != 0:
            return
        span = min(at_once, last - begun)
        half = span * (own + 2 * reach * span)
        for turn in range(min(span, 2) * half):
            makes_up, step = turn >= half, turn - half if turn >= half else turn
            later_by = step % span if span > 1 else 0  # divisions take long for small swarms
            k, edge = begun + later_by, reach * later_by
            nth, r = (step // span if span > 1 else step) - edge, k - first
            if makes_up and step == 0:
                wait(team)
            if not (-edge if makes_up else edge) <= nth < (edge if makes_up else own - edge):
                continue
            here, hears, said = np.uint64(max(r, 0)) * n, r >= 0 and k > delay, np.uint64((k + 2) % (delay + 2)) * n
            next_said = said - n if said > ZERO else np.uint64(delay + 1) * n
            whole, wide = hears and links == FULL, links == FULL and everyone > 1
            if turn == 0 and source.changes and k + 1 < last:
                call(helpers[RENEW], packed(source, SOURCE), k + 1, team.first, team.last)
            if turn == 0 and hears and wide and delay > 0:
                call(shared[ADD_UP], outbox, said, work.sums, begin, begin + blocks, n)
                wait(team)
            if turn == 0 and hears and wide:
                call(shared[PASS_ON], work.sums, partial, everyone)
                wait(team)
            if turn == 0 and hears and links == PAIRS:
                call(helpers[HEAR_PAIRS], arguments, k, said)
            if turn == 0 and hears and swarm.is_signalled and (in_sums or links == FULL):
                call(helpers[COUNT_SIGNALS], arguments, k, said, 1)
            block, nth = np.uint64(nth + own if nth < 0 else nth), team.begin + nth
            start = np.uint64(nth + everyone if nth < 0 else nth) * SIZE
            end = min(start + SIZE, n)
            until = min(start + TOGETHER * SIZE, np.uint64(team.last)) if whole else end
            if is_random and r >= 0 and (not whole or block % TOGETHER == ZERO):
                call(helpers[FILL_WORDS], swarm.draws, trial, k, DRAW_FUSE, start, until - start, draws[1])
            if whole and block % TOGETHER == ZERO:
                call(shared[HEAR_ALL], memory, outbox, said, partial, SIZE, rows, here, start, until, later)
            if hears and in_sums:
                call(shared[HEAR_SUMS], memory, outbox, said, bounds, senders, many, rows, here, start, end, n, later)
            elif r >= 0 and not whole:
                for run in range(of_block[block], of_block[block + np.uint64(1)]):
                    group, (a, z) = runs[run, 0], (start, end) if swarm.additive else (runs[run, 1], runs[run, 2])
                    base, link, past = place(memory, bases[group]), bounds[a], bounds[z]
                    if hears and one_by_one:
                        call(helpers[HEAR_SINGLY], arguments, k, said, group, link, past)
                    elif hears and links == LISTED:
                        if is_random:
                            call(helpers[DRAW_WORDS], arguments, k, link, past)
                        call(addresses[group, HEAR], base, outbox, said, receivers, senders, link, past, n, heard)
                    call(addresses[group, END_ROUND], base, rows, here, a, z, place(draws, fused + np.int64(a - start)))
            if r >= 0 and verdicts.shape[0] > 0:
                call(helpers[JUDGE_BLOCK], arguments, k, block, here)
            if k + 1 < last:
                count_blacks(blacks, bits, tables, looks, key, trial, k + 1, start, end)
                if stops.shape[1] > 0:
                    call(helpers[FAIL_SENSORS], arguments, k + 1, start, end)
                if is_random:
                    call(helpers[FILL_WORDS], swarm.draws, trial, k + 1, DRAW_OBSERVE, start, end - start, draws[0])
                for run in range(of_block[block], of_block[block + np.uint64(1)]):
                    group, (a, z) = runs[run, 0], (start, end) if swarm.additive else (runs[run, 1], runs[run, 2])
                    base, seen, luck = place(memory, bases[group]), place(blacks, a - start), place(draws, a - start)
                    call(addresses[group, SENSE], base, outbox, signals, next_said, seen, float(looks), a, z, luck, ONE)
                behind, ahead = block % TOGETHER, begin + block + ONE
                ends = behind + ONE == TOGETHER or block + ONE == blocks
                if wide and delay == 0 and ends:  # now it is in the cache
                    call(shared[ADD_UP], outbox, next_said, work.sums, ahead - behind - ONE, ahead, n)
        if k + 1 < last and swarm.is_signalled:
            call(helpers[COUNT_SIGNALS], arguments, k + 1, next_said, 0)
        if r >= 0 and verdicts.shape[0] > 0:
            call(helpers[AGREE], arguments, k)
        wait(team)
