"""What robots do in every world: they start blank, fail in parts, lose messages, decide, and converge."""

import numpy as np

from swarmcensus.engine.calling import call, place, seen_as, word_at
from swarmcensus.engine.compiling import loop
from swarmcensus.engine.constants import (
    BEGIN,
    BELIEVE,
    BOUND,
    CHANGED,
    CLIPPED,
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
    SLACK,
    TALKING,
    WIDTH,
    WRONG,
)
from swarmcensus.engine.layout import Sensors
from swarmcensus.engine.random import word_of

from .failures import works

ZERO = np.uint64(0)
ONE = np.uint64(1)
NOBODY = -2.0  # the option of no robots
TILE = 256  # robots whose curves are looked at together: their extremes fit in the processor's first-level cache

sensors_of = loop(inline="always")(Sensors.of_trial)


@loop()
def blank_states(swarm, memory, b, w):
    """Blank states that assume the accuracies b and w (robot or 1)."""
    for run in range(swarm.runs.shape[0]):
        group, first, last = swarm.runs[run, 0], swarm.runs[run, 1], swarm.runs[run, 2]
        base, blank = place(memory, swarm.bases[group]), place(swarm.blanks, np.int64(group) * swarm.blanks.shape[1])
        call(swarm.functions[group, BEGIN], base, blank, b, w, b.size > 1, w.size > 1, first, last)


@loop()
def believe_all(swarm, memory, rows, start):
    """Write the current estimates of all states from rows.flat[start] on."""
    for run in range(swarm.runs.shape[0]):
        group, first, last = swarm.runs[run, 0], swarm.runs[run, 1], swarm.runs[run, 2]
        call(swarm.functions[group, BELIEVE], place(memory, swarm.bases[group]), rows, start, first, last)


@loop()
def copy_all(target, source):
    """Copy an array: `target[:] = source` would take two seconds to compile."""
    there, here = place(target, 0), place(source, 0)
    there, here = seen_as(there, target.size, target.dtype), seen_as(here, source.size, source.dtype)
    for k in range(here.size):
        there[k] = here[k]


@loop(forceinline=True)
def silence_failed(readings, stops, tick, first, last):
    """Robots whose sensor has failed make no reading."""
    if stops.shape[1] > 0:
        for i in range(first, last):
            if not works(stops, SENSING, np.int64(i), tick):
                readings[i - first] = -1.0


@loop(from_cpython=True)
def heard_by(key, trial, tick, receiver, sender, threshold):
    """Whether a message gets through, with probability threshold / 2^64."""
    return word_of(key[0], key[1], trial, tick, receiver, sender) < threshold


@loop(forceinline=True)
def arrives(radio, trial, tick, receiver, sender, stops):
    """Whether the radio of a sender worked when it talked, and its message is not lost."""
    return works(stops, TALKING, np.int64(sender), tick - radio.delay) and (
        radio.threshold == 0 or heard_by(radio.key, trial, tick, receiver, sender, radio.threshold)
    )


@loop(forceinline=True)
def is_said(signals, place):
    """Whether a message was said."""
    return signals.size == 0 or signals[place] == SAID


@loop(forceinline=True)
def is_noise(signals, said, sender, stops, tick):
    """Whether a robot made noise at `tick`."""
    return signals[said + np.uint64(sender)] == NOISE and works(stops, TALKING, sender, tick)


@loop()
def drowned(signals, said, senders, first, last, stops, tick):
    """Whether any of senders[first:last] makes noise: then their receiver hears nothing in that round."""
    noises = 0
    for e in range(first, last):
        noises += is_noise(signals, said, np.int64(senders[e]), stops, tick)
    return noises > 0


@loop()
def draw_for_messages(swarm, trial, tick, receivers, senders, first, last, draws):
    """Draw a word for each of the messages first ... last - 1, addressed by receiver and sender."""
    k0, k1 = swarm.draws[2], swarm.draws[3]
    for link in range(first, last):
        draws[link - first] = word_of(k0, k1, trial, tick, receivers[link], senders[link])


@loop()
def count_known(swarm, counts, stops, rounds, begin, end):
    """Start counts of robots begin ... end - 1: they send a message a round while they work, or 0 so far if silent."""
    for i in range(begin, min(end, counts.shape[1])):
        last = rounds
        if stops.shape[1] > 0 and stops[TALKING, i] - 1 < last:
            last = stops[TALKING, i] - 1
        sent = last
        for tick in range(last + 1, rounds + 1 if stops.shape[0] > PARTS else 0):
            sent += works(stops, TALKING, i, tick)
        counts[SENT, i] = 0 if swarm.is_signalled else sent
        counts[HEARD, i] = 0


@loop()
def count_sent(signals, said, stops, tick, counts, begin, end):
    """Count which of robots begin ... end - 1 talk in this round, if they may be silent; else `count_known` did."""
    for i in range(begin, min(end, counts.shape[1])):
        counts[SENT, i] += signals[said + np.uint64(i)] == SAID and works(stops, TALKING, i, tick)


@loop()
def count_said(signals, said, bounds, senders, links, counts, begin, end):
    """Count what robots begin ... end - 1 hear, where robots may be silent, messages are sums and none is lost."""
    total = 0
    for i in range(counts.shape[1] if links == FULL else 0):
        total += signals[said + np.uint64(i)] == SAID
    for i in range(begin, min(end, counts.shape[1])):
        if links == FULL:
            counts[HEARD, i] += total - (signals[said + np.uint64(i)] == SAID)
        else:
            for e in range(bounds[i], bounds[i + 1]):
                counts[HEARD, i] += signals[said + np.uint64(senders[e])] == SAID


@loop()
def count_clipped(swarm, memory, counts):
    """Count each robot's messages with a number that the format cannot hold: its state has counted them."""
    for run in range(swarm.runs.shape[0]):
        group = swarm.runs[run, 0]
        if swarm.clipped[group] >= 0 and counts.shape[1] > 0:
            for i in range(np.int64(swarm.runs[run, 1]), np.int64(swarm.runs[run, 2])):
                at = swarm.bases[group] + i * swarm.sizes[group] + swarm.clipped[group]
                counts[CLIPPED, i] = np.int64(word_at(place(memory, at), 0))


@loop()
def judge(swarm, of_block, memory, rows, start, verdicts, now):
    """Update what the robots of a block have decided after round `now`."""
    for run in range(swarm.of_block[of_block], swarm.of_block[of_block + np.uint64(1)]):
        group, first, last = swarm.runs[run, 0], swarm.runs[run, 1], swarm.runs[run, 2]
        base = place(memory, swarm.bases[group])
        call(swarm.functions[group, JUDGE], base, rows, start, verdicts, float(now), first, last)


@loop()
def option_of(verdicts, honest, begin, end):
    """The option that all honest ones of robots begin ... end - 1 have decided for; NOBODY if none of them is honest.

    Below 0 if they differ, or have not decided.
    """
    option = NOBODY
    for i in range(begin, end):
        if honest.size == 0 or honest[i]:
            if option == NOBODY:
                option = verdicts[i, DECISION]
            elif verdicts[i, DECISION] != option:
                return -1.0
    return option


@loop()
def agree_on(option, agreed, now):
    """Note the first round after which all honest robots have decided for the same option, and the option."""
    if agreed[0] < 0.0 <= option:
        agreed[0], agreed[1] = option, now


@loop()
def forget_verdicts(verdicts, agreed, begin, end):
    """Reset decisions of robots begin ... end - 1 to what is known before the first round."""
    for i in range(min(begin, verdicts.shape[0]), min(end, verdicts.shape[0])):
        verdicts[i, DECISION] = verdicts[i, WRONG] = -1.0  # none, and no wrong one
        verdicts[i, DECIDED_IN] = verdicts[i, CHANGED] = verdicts[i, DONE_IN] = np.inf
        verdicts[i, DONE_ESTIMATE] = np.nan
        verdicts[i, IS_DONE] = 0.0
    agreed[0], agreed[1] = -1.0, np.inf


@loop()
def judge_blank(swarm, memory, start, verdicts):
    """Note who is done before the first round; robots have the estimates `start`."""
    for block in range(np.uint64(swarm.of_block.size - 1)):
        judge(swarm, block, memory, start, ZERO, verdicts, np.int64(0))


@loop(forceinline=True)
def first_from(values, start):
    """The index of the first of some values, in order, that is not below `start`."""
    low, high = 0, values.size
    while low < high:
        middle = (low + high) // 2
        if values[middle] < start:
            low = middle + 1
        else:
            high = middle
    return low


@loop()
def ask_all(swarm, memory, bounds):
    """Write the intervals of robots into `bounds` (end, robot); some brains of a mixed swarm may have none."""
    for run in range(swarm.runs.shape[0]):
        group, first, last = swarm.runs[run, 0], swarm.runs[run, 1], swarm.runs[run, 2]
        if swarm.functions[group, BOUND]:
            call(swarm.functions[group, BOUND], place(memory, swarm.bases[group]), bounds, bounds.shape[1], first, last)


@loop()
def measure_intervals(swarm, c, intervals, goes_on):
    """Write how the intervals of honest robots do at checkpoint c into the `Intervals` of a trial.

    If this `goes_on`, these robots come after those of the last call.
    """
    bounds, wrong, truth, sums = intervals.bounds, intervals.wrong, intervals.truths[c], intervals.sums
    held, wide, counted = (sums[0], sums[1], sums[2]) if goes_on else (0.0, 0.0, 0.0)
    for run in range(swarm.runs.shape[0]):
        group, first, last = swarm.runs[run, 0], swarm.runs[run, 1], swarm.runs[run, 2]
        if not swarm.functions[group, BOUND]:
            continue
        for i in range(np.int64(first), np.int64(last)):
            if swarm.honest.size == 0 or swarm.honest[i]:
                low, high = bounds[0, i], bounds[1, i]
                if wrong[0] < 0.0 and not 0.0 <= low <= high <= 1.0:
                    wrong[0], wrong[1], wrong[2], wrong[3] = i, intervals.checkpoints[c], low, high
                held += low <= truth <= high
                wide += high - low
                counted += 1
    sums[0], sums[1], sums[2] = held, wide, counted
    if counted > 0:
        intervals.sure[COVERAGE, c] = held / counted
        intervals.sure[WIDTH, c] = wide / counted


@loop()
def count_amiss(rows, begin, end):
    """How many of rows.flat[begin:end] are no numbers in [0, 1]; without branches, for several at once."""
    estimates, amiss = seen_as(place(rows, 0), rows.size, np.float64), 0
    for k in range(np.uint64(begin), np.uint64(end)):
        amiss += not ((estimates[k] >= -SLACK) & (estimates[k] <= 1.0 + SLACK))
    return amiss


@loop()
def find_wrong(honest, rows, first, wrong):
    """Note the first estimate of an honest robot that is no number in [0, 1], in rows of the rounds from `first` on."""
    estimates, robots = seen_as(place(rows, 0), rows.size, np.float64), rows.shape[1]
    if wrong[0] < 0.0 and count_amiss(rows, np.int64(0), estimates.size) > 0:
        for k in range(estimates.size):
            counts = honest.size == 0 or honest[k % robots]
            if counts and not -SLACK <= estimates[k] <= 1.0 + SLACK:
                wrong[0], wrong[1], wrong[2] = k % robots, first + k // robots, estimates[k]
                return


@loop()
def settle(rows, top, delta, low, high, where, value, begin, end):
    """One backward pass of the paper's convergence rule (Sec. IV-A) over rows of indices top, top + 1, ...

    `low` and `high` hold each robot's extremes over all later indices, `where` and `value` the earliest index that is
    within delta of all later ones. Returns False once no earlier index can qualify for any of robots begin ... end - 1.
    Robots are compared without branches, so that the processor handles several at once.
    """
    undecided = False
    for first in range(np.uint64(begin), np.uint64(end), np.uint64(TILE)):
        last = min(first + np.uint64(TILE), np.uint64(end))
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
