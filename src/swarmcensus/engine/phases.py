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


@phase(ARRAY, WHOLE, ARRAY, WHOLE, WHOLE)
def add_up(outbox, place, partial_sums, size, robots):
    """Fill `partial_sums` for `hear_all`: row 1 + block is the sum of messages of all robots after that block.

    Blocks have `size` robots. Row 0 is the sum over the robots before the first: zeros.
    """
    blocks = (robots + size - ONE) // size
    said = seen_as(outbox, (place + robots, width), number)
    partial = seen_as(partial_sums, (ONE + blocks, width), number)
    for j in range(np.uint64(width)):
        partial[0, j] = 0.0
    sums = sums_at(partial, ZERO)
    keep_sums(partial, blocks, sums)
    for later in range(ONE, blocks):
        first = (blocks - later) * size
        last = min(first + size, robots)
        for below in range(ZERO, last - first):
            sums = sums_with(sums, said, place + last - ONE - below)
        keep_sums(partial, blocks - later, sums)


@phase(ARRAY, ARRAY, WHOLE, ARRAY, WHOLE, ARRAY, WHOLE, WHOLE, WHOLE, ARRAY)
def hear_all(memory, outbox, place, partial_sums, block, rows, start, first, last, draws):
    """Robots first ... last - 1 hear all others and end the round, in O(N), for brains whose `receive` only adds.

    What a robot hears is a sum over the robots before it and a sum over the robots after it: unlike "all minus own",
    that has no cancellation. Row 0 of `partial_sums` is the sum over the robots before `first`, and becomes that before
    `last`; row 1 + block is the sum over the robots from `last` on.
    """
    states = seen_as(memory, last, record)
    said = seen_as(outbox, (place + last, width), number)
    partial = seen_as(partial_sums, (block + ONE + ONE, width), number)
    estimates = seen_as(rows, start + last, np.float64)
    sums = sums_at(partial, ZERO)
    for i in range(first, last):
        add_sums(states[i], sums)
        sums = sums_with(sums, said, place + i)
    keep_sums(partial, ZERO, sums)
    sums = sums_at(partial, block + ONE)
    for below in range(ZERO, last - first):
        i = last - ONE - below
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
