"""What minds do in every world: they begin, fail in parts, lose messages, and settle on an estimate."""

import numpy as np

from swarmcensus.engine.calling import call, place
from swarmcensus.engine.compiling import loop
from swarmcensus.engine.constants import (
    BELIEVE,
    BOUND,
    CHANGED,
    COVERAGE,
    DECIDED_IN,
    DECISION,
    DONE_ESTIMATE,
    DONE_IN,
    FULL,
    HEARD,
    IS_DONE,
    JUDGE,
    NOISE,
    PARTS,
    SAID,
    SENSING,
    SENT,
    TALKING,
    WIDTH,
    WRONG,
)
from swarmcensus.engine.random import word_of

from .failures import works

ZERO = np.uint64(0)
ONE = np.uint64(1)
TILE = 256  # robots whose curves are looked at together: their extremes stay in the processor's nearest cache


@loop()
def begin(swarm, memory, b, w):
    """Blank minds that believe in the accuracies b and w (of one robot where all are alike), their last fields."""
    flat = memory.reshape(-1)
    b_step, w_step = np.int64(b.size > 1), np.int64(w.size > 1)
    for run in range(swarm.runs.shape[0]):
        group = swarm.runs[run, 0]
        fields = swarm.fields[group]
        for i in range(np.int64(swarm.runs[run, 1]), np.int64(swarm.runs[run, 2])):
            row = swarm.bases[group] + i * fields
            for j in range(fields):
                flat[row + j] = swarm.blanks[group, j]
            if swarm.named[group]:
                flat[row + fields - 3] = i
            flat[row + fields - 2] = b[i * b_step]
            flat[row + fields - 1] = w[i * w_step]


@loop()
def believe_all(swarm, memory, rows, start):
    """The estimates of all minds as they are, from rows.flat[start] on."""
    for run in range(swarm.runs.shape[0]):
        group, first, last = swarm.runs[run, 0], swarm.runs[run, 1], swarm.runs[run, 2]
        call(swarm.minds[group, BELIEVE], place(memory, swarm.bases[group]), rows, start, first, last)


@loop()
def put(into, minds):
    """Copy minds (robot, field); an assignment of arrays takes two seconds to compile."""
    for i in range(minds.shape[0]):
        for j in range(minds.shape[1]):
            into[i, j] = minds[i, j]


@loop(forceinline=True)
def silence_failed(readings, stops, tick, first, last):
    """No reading for robots whose sensor has failed."""
    if stops.shape[1] > 0:
        for i in range(first, last):
            if not works(stops, SENSING, i, tick):
                readings[i - first] = -1.0


@loop(from_cpython=True)
def heard_by(key, trial, tick, receiver, sender, threshold):
    """Whether a message gets through, with probability threshold / 2^64."""
    return word_of(key[0], key[1], trial, tick, receiver, sender) < threshold


@loop(forceinline=True)
def arrives(key, trial, tick, said_at, receiver, sender, threshold, stops):
    """The same of a sender that talked at `said_at`; `threshold` 0 means that no message is lost."""
    return works(stops, TALKING, sender, said_at) and (
        threshold == 0 or heard_by(key, trial, tick, receiver, sender, threshold)
    )


@loop(forceinline=True)
def is_said(outbox, place, flag):
    """Whether a robot said anything: `flag` is where in the outbox that stands, below 0 where all do."""
    return flag < 0 or outbox[place, flag] == SAID


@loop(forceinline=True)
def is_noise(swarm, outbox, said, sender, stops, tick):
    """Whether a robot made noise at `tick`."""
    return outbox[said + np.uint64(sender), swarm.flag] == NOISE and works(stops, TALKING, sender, tick)


@loop()
def drowned(swarm, outbox, said, senders, first, last, stops, tick):
    """Whether any of senders[first:last] makes noise: whom it reaches hears nothing of that round."""
    noises = 0
    for e in range(first, last):
        noises += is_noise(swarm, outbox, said, np.int64(senders[e]), stops, tick)
    return noises > 0


@loop()
def luck_of_messages(swarm, trial, tick, receivers, senders, first, last, luck):
    """A word for each of the messages first ... last - 1, addressed by who says it to whom."""
    k0, k1 = swarm.luck[2], swarm.luck[3]
    for link in range(first, last):
        luck[link - first] = word_of(k0, k1, trial, tick, receivers[link], senders[link])


@loop()
def count_known(swarm, counts, stops, rounds):
    """What robots send that are never silent, one message a round while they work; that of others is not known yet."""
    for i in range(counts.shape[1]):
        last = rounds
        if stops.shape[1] > 0 and stops[TALKING, i] - 1 < last:
            last = stops[TALKING, i] - 1
        sent = last
        for tick in range(last + 1, rounds + 1 if stops.shape[0] > PARTS else 0):
            sent += works(stops, TALKING, i, tick)
        counts[SENT, i] = sent if swarm.flag < 0 else 0
        counts[HEARD, i] = 0


@loop()
def count_sent(swarm, outbox, said, stops, tick, counts):
    """Who of those that may be silent talks in this round; of others it is known beforehand."""
    for i in range(counts.shape[1]):
        counts[SENT, i] += outbox[said + np.uint64(i), swarm.flag] == SAID and works(stops, TALKING, i, tick)


@loop()
def count_said(swarm, outbox, said, bounds, senders, links, counts):
    """What is heard of those that may be silent where each message is a sum that is added, and none is lost."""
    total = 0
    for i in range(counts.shape[1]):
        total += outbox[said + np.uint64(i), swarm.flag] == SAID
    for i in range(counts.shape[1]):
        if links == FULL:
            counts[HEARD, i] += total - (outbox[said + np.uint64(i), swarm.flag] == SAID)
        else:
            for e in range(bounds[i], bounds[i + 1]):
                counts[HEARD, i] += outbox[said + np.uint64(senders[e]), swarm.flag] == SAID


@loop()
def judge(swarm, of_block, memory, rows, start, verdicts, now):
    """What the robots of a block have decided after round `now`."""
    for run in range(swarm.of_block[of_block], swarm.of_block[of_block + np.uint64(1)]):
        group, first, last = swarm.runs[run, 0], swarm.runs[run, 1], swarm.runs[run, 2]
        call(
            swarm.minds[group, JUDGE], place(memory, swarm.bases[group]), rows, start, verdicts, float(now), first, last
        )  # fmt: skip


@loop()
def agree(verdicts, honest, agreed, now):
    """Note the first round after which all honest robots have decided for the same option, and the option."""
    if agreed[0] >= 0.0:
        return
    option = -2.0
    for i in range(verdicts.shape[0]):
        if honest.size == 0 or honest[i]:
            if option == -2.0:
                option = verdicts[i, DECISION]
            elif verdicts[i, DECISION] != option:
                return
    if option >= 0.0:
        agreed[0] = option
        agreed[1] = now


@loop()
def forget_verdicts(verdicts, agreed):
    """What is known of decisions before the first round."""
    for i in range(verdicts.shape[0]):
        verdicts[i, DECISION] = -1.0
        verdicts[i, DECIDED_IN] = np.inf
        verdicts[i, CHANGED] = np.inf
        verdicts[i, WRONG] = -1.0  # which is right
        verdicts[i, DONE_IN] = np.inf
        verdicts[i, DONE_ESTIMATE] = np.nan
        verdicts[i, IS_DONE] = 0.0
    agreed[0] = -1.0
    agreed[1] = np.inf


@loop()
def judge_blank(swarm, memory, start, verdicts):
    """Who is done before the first round, by minds that believe in `start`."""
    for block in range(np.uint64(swarm.of_block.size - 1)):
        judge(swarm, block, memory, start, ZERO, verdicts, 0)


@loop(forceinline=True)
def first_from(checkpoints, start):
    """The place of the first checkpoint from a round on: they rise."""
    low, high = 0, checkpoints.size
    while low < high:
        middle = (low + high) // 2
        if checkpoints[middle] < start:
            low = middle + 1
        else:
            high = middle
    return low


@loop()
def ask_intervals(swarm, memory, c, checkpoints, truths, bounds, sure, wrong):
    """What the intervals of honest robots come to at checkpoint c, in `sure` (what, checkpoint), if any has one.

    `bounds` (end, robot) is room for them; `wrong` keeps the first that is none: the robot, below 0 for nobody, the
    round, and both ends.
    """
    held = counted = 0
    wide = 0.0
    for run in range(swarm.runs.shape[0]):
        group, first, last = swarm.runs[run, 0], swarm.runs[run, 1], swarm.runs[run, 2]
        if not swarm.minds[group, BOUND]:  # of several brains perhaps only some have one
            continue
        call(swarm.minds[group, BOUND], place(memory, swarm.bases[group]), bounds, bounds.shape[1], first, last)
        for i in range(np.int64(first), np.int64(last)):
            if swarm.honest.size == 0 or swarm.honest[i]:
                low, high = bounds[0, i], bounds[1, i]
                if wrong[0] < 0.0 and not 0.0 <= low <= high <= 1.0:
                    wrong[0], wrong[1], wrong[2], wrong[3] = i, checkpoints[c], low, high
                held += low <= truths[c] <= high
                wide += high - low
                counted += 1
    if counted > 0:
        sure[COVERAGE, c] = held / counted
        sure[WIDTH, c] = wide / counted


@loop()
def settle(rows, top, delta, low, high, where, value):
    """One backward pass of the paper's convergence rule over rows[0], rows[1], ... = indices top, top + 1, ...

    `low` and `high` hold each robot's extremes over all later indices, `where` and `value` the earliest
    index that is within delta of all later ones. False once no earlier index can qualify for any robot. Robots lie
    side by side in a row and are compared without a branch, so that the processor takes several at once.
    """
    undecided = False
    for first in range(ZERO, np.uint64(low.size), np.uint64(TILE)):
        last = min(first + np.uint64(TILE), np.uint64(low.size))
        open_ones = True
        r = rows.shape[0] - 1
        while r >= 0 and open_ones:
            row = rows[r]
            still = 0
            for i in range(first, last):
                least = low[i]
                most = high[i]
                x = row[i]
                is_open = most - least <= 2.0 * delta  # no more once it met a NaN, which is near to nothing
                less = least if least <= x else x
                more = most if most >= x else x
                near = is_open & (more - x < delta) & (x - less < delta)
                low[i] = less if is_open else least
                high[i] = more if is_open else most
                where[i] = top + r if near else where[i]
                value[i] = x if near else value[i]
                still += is_open & (more - less <= 2.0 * delta)
            open_ones = still > 0
            r -= 1
        undecided |= open_ones
    return undecided
