"""What robots do in a round: all of the engine that is compiled for each brain.

`.robot` has the brain's functions (see `codegen.py`). The engine's loops call the functions here by address
(`calling.py`), which costs little because each call handles many robots. States are records, one per robot. A
round's messages are rows of the outbox, from row `place` on, and estimates go to `rows` from index `start` on: offsets,
because making a view of an array costs more than such a call. Robots are counted in uint64: Numba then does not check
for negative indices. `draws` has a random word for each call of the brain, which only brains that use luck read.
"""

import numpy as np

from swarmcensus.engine.calling import ARRAY, REAL, WHOLE, phase, seen_as
from swarmcensus.engine.constants import (
    BLOCK,
    CHANGED,
    DECIDED_IN,
    DECISION,
    DONE_ESTIMATE,
    DONE_IN,
    IS_DONE,
    VERDICTS,
    WRONG,
    WRONG_IN,
)
from swarmcensus.engine.return_values import chosen, ends_of

from .robot import (
    add_sums,
    broadcast,  # noqa: F401
    decide,
    done,
    estimate,
    fuse,
    give,
    give_draw,
    interval,
    is_signalled,
    keep_sums,
    number,
    observe,
    options,
    put_sums,
    receive,  # noqa: F401
    record,
    say,
    steer,
    sums_at,
    sums_of,
    sums_with,
    take,
    width,
)

ZERO = np.uint64(0)
ONE = np.uint64(1)
SIZE = np.uint64(BLOCK)


@phase(ARRAY, ARRAY, ARRAY, ARRAY, WHOLE, WHOLE, WHOLE, WHOLE)
def begin(memory, blank, b, w, b_step, w_step, first, last):
    """Robots first ... last - 1 have `blank` states that assume accuracies b[i * b_step] and w[i * w_step]."""
    states = seen_as(memory, last, record)
    size = states.itemsize
    rows, start = seen_as(memory, (last, size), np.uint8), seen_as(blank, size, np.uint8)
    of_b, of_w = seen_as(b, last, np.float64), seen_as(w, last, np.float64)
    for i in range(first, last):
        for k in range(np.uint64(size)):
            rows[i, k] = start[k]
        give(states[i], float(i), of_b[i * b_step], of_w[i * w_step])


@phase(ARRAY, ARRAY, ARRAY, WHOLE, ARRAY, REAL, WHOLE, WHOLE, ARRAY, WHOLE)
def sense(memory, outbox, signals, place, readings, looks, first, last, draws, begins):
    """Robots first ... last - 1 observe `readings` black ones of `looks`, below 0 for no reading, and then talk.

    Robots that are done make no reading; they are asked for it only where a round `begins`. Both branches call `say`,
    so that what was just computed is not read back from memory: that halves the time. Robots that may be silent or jam
    write to `signals` what they do.
    """
    states = seen_as(memory, last, record)
    said = seen_as(outbox, (place + last, width), number)
    does = seen_as(signals, place + last if is_signalled else ZERO, np.uint8)
    seen = seen_as(readings, last - first, np.float64)
    for i in range(first, last):
        if seen[i - first] >= 0.0 and not (begins and done(states[i])):
            give_draw(states[i], draws, i - first)
            observe(states[i], seen[i - first], looks)
            signal = say(said, place + i, states[i])
        else:
            signal = say(said, place + i, states[i])
        if is_signalled:
            does[place + i] = signal


@phase(ARRAY, ARRAY, WHOLE, ARRAY, ARRAY, WHOLE, WHOLE, WHOLE, ARRAY)
def hear(memory, outbox, place, receivers, senders, first, last, robots, draws):
    """Messages pass along links first ... last - 1."""
    states = seen_as(memory, robots, record)
    said = seen_as(outbox, (place + robots, width), number)
    to = seen_as(receivers, last, np.uint32)
    by = seen_as(senders, last, np.uint32)
    for link in range(first, last):
        give_draw(states[np.uint64(to[link])], draws, link - first)
        take(states[np.uint64(to[link])], said, place + np.uint64(by[link]))


@phase(ARRAY, ARRAY, WHOLE, ARRAY, ARRAY, WHOLE, ARRAY, WHOLE, WHOLE, WHOLE, WHOLE, ARRAY)
def hear_sums(memory, outbox, place, heard, senders, messages, rows, start, first, last, robots, draws):
    """Robots first ... last - 1 hear what senders[heard[i]: heard[i + 1]] said and end the round.

    For brains whose `receive` only adds: sums stay in the processor's registers.
    """
    states = seen_as(memory, last, record)
    said = seen_as(outbox, (place + robots, width), number)
    bounds = seen_as(heard, last + ONE, np.int64)
    by = seen_as(senders, messages, np.uint32)
    estimates = seen_as(rows, start + last, np.float64)
    for i in range(first, last):
        sums = sums_of(states[i])
        for e in range(np.uint64(bounds[i]), np.uint64(bounds[i + ONE])):
            sums = sums_with(sums, said, place + np.uint64(by[e]))
        put_sums(states[i], sums)
        give_draw(states[i], draws, i - first)
        fuse(states[i])
        estimates[start + i] = estimate(states[i])


@phase(ARRAY, WHOLE, ARRAY, WHOLE, WHOLE, WHOLE)
def add_up(outbox, place, sums_of_blocks, first, last, robots):
    """Row k of `sums_of_blocks` becomes the sum of the messages of block k, for blocks first ... last - 1.

    Two blocks are added at the same time, because a processor waits for each addition before the next in a sum.
    """
    said = seen_as(outbox, (place + robots, width), number)
    added = seen_as(sums_of_blocks, (last, width), number)
    end = min(last * SIZE, robots)
    for block in range(first, last, ONE + ONE):
        for j in range(np.uint64(width)):
            added[block, j] = 0.0
        sums = more = sums_at(added, block)
        for i in range(block * SIZE, min((block + ONE) * SIZE, end)):
            sums = sums_with(sums, said, place + i)
            if i + SIZE < end:
                more = sums_with(more, said, place + i + SIZE)
        keep_sums(added, block, sums)
        if block + ONE < last:
            keep_sums(added, block + ONE, more)


@phase(ARRAY, ARRAY, WHOLE)
def pass_on(sums_of_blocks, partial_sums, blocks):
    """Rows 2 k and 2 k + 1 of `partial_sums` become the sums of the blocks before and after block k, see `hear_all`."""
    added = seen_as(sums_of_blocks, (blocks, width), number)
    partial = seen_as(partial_sums, (blocks + blocks, width), number)
    for j in range(np.uint64(width)):
        partial[0, j] = 0.0
    before = after = sums_at(partial, ZERO)
    for block in range(blocks):
        later = blocks - ONE - block
        keep_sums(partial, block + block, before)
        keep_sums(partial, later + later + ONE, after)
        before, after = sums_with(before, added, block), sums_with(after, added, later)


@phase(ARRAY, ARRAY, WHOLE, ARRAY, WHOLE, ARRAY, WHOLE, WHOLE, WHOLE, ARRAY)
def hear_all(memory, outbox, place, partial_sums, size, rows, start, first, last, draws):
    """Robots first ... last - 1 hear all others and end the round, in O(N), for brains whose `receive` only adds.

    What a robot hears is a sum over the robots before it and a sum over the robots after it: unlike "all minus own",
    that has no cancellation. The order of additions is the same for any number of threads, and on any machine. Blocks
    have `size` robots; robot `first` begins one. Let S[k] be the sum of the messages of block k in the order of its
    robots, from zero on, as `add_up` computes it. Then `pass_on` computes, with 0 for the first and the last block,

    - B[k + 1] = B[k] + S[k], the sum over the blocks before block k + 1: row 2 k + 2 of `partial_sums`;
    - A[k - 1] = A[k] + S[k], the sum over the blocks after block k - 1: row 2 k - 1.

    A robot of block k adds to its state first B[k] + the messages of the robots before it in the block, one by one in
    order, and then A[k] + the messages of those after it, one by one from the block's end.
    """
    states = seen_as(memory, last, record)
    said = seen_as(outbox, (place + last, width), number)
    end = (last + size - ONE) // size  # of blocks
    partial = seen_as(partial_sums, (end + end, width), number)
    estimates = seen_as(rows, start + last, np.float64)
    for block in range(first // size, end):
        sums = sums_at(partial, block + block)
        for i in range(block * size, min(block * size + size, last)):
            add_sums(states[i], sums)
            sums = sums_with(sums, said, place + i)
    for later in range(end - first // size):
        block = end - ONE - later
        sums = sums_at(partial, block + block + ONE)
        begin, behind = block * size, min(block * size + size, last)
        for below in range(behind - begin):
            i = behind - ONE - below
            add_sums(states[i], sums)
            sums = sums_with(sums, said, place + i)
            give_draw(states[i], draws, i - first)
            fuse(states[i])
            estimates[start + i] = estimate(states[i])


@phase(ARRAY, ARRAY, WHOLE, WHOLE, WHOLE, ARRAY)
def end_round(memory, rows, start, first, last, draws):
    """Robots first ... last - 1 fuse, and their estimates are written."""
    states = seen_as(memory, last, record)
    estimates = seen_as(rows, start + last, np.float64)
    for i in range(first, last):
        give_draw(states[i], draws, i - first)
        fuse(states[i])
        estimates[start + i] = estimate(states[i])


@phase(ARRAY, ARRAY, ARRAY, WHOLE, WHOLE, WHOLE, ARRAY, ARRAY)
def go_alone(memory, readings, rows, start, first, last, draws, more_draws):
    """Robots first ... last - 1, which hear nobody, make one reading each, below 0 for none, and fuse."""
    states = seen_as(memory, last, record)
    seen = seen_as(readings, last - first, np.float64)
    estimates = seen_as(rows, start + last, np.float64)
    for i in range(first, last):
        if seen[i - first] >= 0.0 and not done(states[i]):
            give_draw(states[i], draws, i - first)
            observe(states[i], seen[i - first], 1.0)
        give_draw(states[i], more_draws, i - first)
        fuse(states[i])
        estimates[start + i] = estimate(states[i])


@phase(ARRAY, ARRAY, WHOLE, WHOLE, WHOLE)
def believe(memory, rows, start, first, last):
    """Write the current estimates of robots first ... last - 1."""
    states = seen_as(memory, last, record)
    estimates = seen_as(rows, start + last, np.float64)
    for i in range(first, last):
        estimates[start + i] = estimate(states[i])


@phase(ARRAY, ARRAY, WHOLE, ARRAY, REAL, WHOLE, WHOLE)
def judge(memory, rows, start, verdicts, now, first, last):
    """Update what robots first ... last - 1 have decided after round `now`, if not 0, and who is done."""
    states = seen_as(memory, last, record)
    estimates = seen_as(rows, start + last, np.float64)
    known = seen_as(verdicts, (last, VERDICTS), np.float64)
    for i in range(first, last):
        choice = 1.0 * decide(states[i]) if now > 0.0 else -1.0
        if not (-1.0 <= choice < options and choice == np.floor(choice)):
            if known[i, WRONG] == -1.0:
                known[i, WRONG] = choice
                known[i, WRONG_IN] = now
        elif choice != known[i, DECISION]:
            if known[i, DECIDED_IN] == np.inf:
                known[i, DECIDED_IN] = now
            known[i, DECISION] = choice
            known[i, CHANGED] = now
        ends = done(states[i])
        known[i, IS_DONE] = 1.0 if ends else 0.0
        if ends and known[i, DONE_IN] == np.inf:
            known[i, DONE_IN] = now
            known[i, DONE_ESTIMATE] = estimates[start + i]


@phase(ARRAY, ARRAY, WHOLE, WHOLE, WHOLE, ARRAY)
def ask(memory, commands, robots, first, last, draws):
    """Ask robots where to go; `commands` (3, robot) get whether they steer, metres and radians per second."""
    states = seen_as(memory, last, record)
    wanted = seen_as(commands, (3, robots), np.float64)
    for i in range(first, last):
        give_draw(states[i], draws, i - first)
        wants, wanted[1, i], wanted[2, i] = chosen(steer(states[i]))
        wanted[0, i] = 1.0 if wants else 0.0


@phase(ARRAY, ARRAY, WHOLE, WHOLE, WHOLE)
def bound(memory, bounds, robots, first, last):
    """Write the intervals of robots first ... last - 1 to `bounds` (end, robot)."""
    states = seen_as(memory, last, record)
    ends = seen_as(bounds, (2, robots), np.float64)
    for i in range(first, last):
        ends[0, i], ends[1, i] = ends_of(interval(states[i]))
