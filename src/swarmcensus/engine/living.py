"""Minds on a fixed network, some rounds at a time: for those who watch, and want to see each round's."""

import numpy as np

from swarmcensus.engine.changes import renew, source_of
from swarmcensus.engine.compiling import entry
from swarmcensus.engine.constants import BLOCK, FULL, HEARD, PAIRS, SENT, TALKING
from swarmcensus.engine.swarms import Swarm

from .failures import works
from .minds import ZERO, begin, believe_all, forget_verdicts, heard_by, judge_blank, put
from .rounds import advance, bounds_of, most_links


@entry
def wake(
    minds, bases, fields, named, blanks, runs, of_block, additive, flag, jams, luck_keys, honest,
    memory, b, w, start, verdicts, agreed,
):  # fmt: skip
    """Blank minds of a `Swarm` that believe in b and w, and what they estimate before any observation."""
    swarm = Swarm(minds, bases, fields, named, blanks, runs, of_block, additive, flag, jams, luck_keys, honest)
    begin(swarm, memory, b, w)
    believe_all(swarm, memory, start, ZERO)
    forget_verdicts(verdicts, agreed)
    if verdicts.shape[0] > 0:
        judge_blank(swarm, memory, start, verdicts)


@entry
def live(
    minds, bases, fields, named, blanks, runs, of_block, additive, flag, jams, luck_keys, honest,
    memory, outbox, rows, first, trial, b, w, drift, course, looks, read_key, link_key,
    links, receivers, senders, threshold, stops, delay, counts, verdicts, agreed, history, said, messages, stop,
):  # fmt: skip
    """Run the rounds from `first` on, as many as `rows` (round, robot) holds, which get the estimates.

    After each round its minds go to `history` (round, robot, field), what was heard of each robot to `said` (round,
    robot, number), and how many messages all have sent and heard so
    far to `messages` (round, what), whose row before the first is `counts` (what, robot), zero before round 1. All else
    is as `kernel.simulate` takes it, of one trial. What comes first is a `Swarm`.
    """
    swarm = Swarm(minds, bases, fields, named, blanks, runs, of_block, additive, flag, jams, luck_keys, honest)
    robots = memory.shape[0]
    blacks = np.zeros(min(robots, BLOCK))
    bits = np.zeros(blacks.size, np.uint64)
    bounds = bounds_of(receivers, robots)
    most = most_links(bounds, links, robots)
    arrivals = np.zeros((2, most), np.uint32)
    luck = np.zeros((3, max(robots, most if swarm.luck.size > 0 else 0)), np.uint64)
    beside = np.empty((1 + (robots + BLOCK - 1) // BLOCK, outbox.shape[1]))
    source = source_of(b, w, drift, course, looks)
    known = flag < 0 and (links == FULL or (threshold == 0 and stops.shape[1] == 0 and links != PAIRS))
    for r in range(rows.shape[0]):
        k = first + r
        renew(source, looks, k)
        advance(
            swarm, memory, outbox, beside, blacks, bits, luck, source, delay, k, k + 1, looks, trial, read_key,
            link_key, links, receivers, senders, bounds, arrivals, threshold, rows[r:], stops, counts, verdicts,
            agreed, stop,
        )  # fmt: skip
        if stop[0] != 0:
            return
        put(history[r], memory)
        here = (k + 2) % (delay + 2) * robots
        put(said[r], outbox[here : here + robots])
        if flag < 0:
            for i in range(robots):
                counts[SENT, i] += works(stops, TALKING, i, k)
        if known and k > delay:
            for i in range(robots):
                counts[HEARD, i] += robots - 1 if links == FULL else bounds[i + 1] - bounds[i]
        messages[r, 0] = counts[SENT].sum()
        messages[r, 1] = counts[HEARD].sum()


@entry
def carried(key, trial, tick, receivers, senders, threshold, out):
    """Which links carry what is said to them in a round, as `out` (link): 1 where a message gets through."""
    for e in range(receivers.size):
        out[e] = threshold == 0 or heard_by(key, trial, tick, np.int64(receivers[e]), np.int64(senders[e]), threshold)
