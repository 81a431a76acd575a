"""The engine's inner loops of robots that move: minds that ride along on a walk, and say where it should go.

Like the kernel, this file is compiled anew for every brain (see `compiler.py`): `.mind` is that brain.
"""

import numpy as np
from numba import njit

from swarmcensus.engine.modes import SENSING, TALKING
from swarmcensus.engine.random import unit, words
from swarmcensus.engine.wishes import chosen

from .mind import (
    add_sums,
    additive,
    broadcast,
    compiled,
    entry,
    estimate,
    no_sums,
    observe,
    pack,
    receive,
    steer,
    sums_with,
    unpack,
)
from .minds import ZERO, begin, fuse_some, heard_by, settle, works


@entry
def wake(memory, blank, b, w, outbox, start):
    """Blank minds that believe in b and w; what they would say, and their estimates before any observation."""
    begin(memory, blank, b, w)
    for i in range(memory.size):
        pack(outbox, i, broadcast(memory[i]))
        start[0, i] = estimate(memory[i])


@compiled
def look(memory, outbox, said, looked, black, b, w, bits):
    """Robots that do look read the colour under them, and all say what they hold then."""
    step_b, step_w = np.uint64(b.size > 1), np.uint64(w.size > 1)
    for i in range(ZERO, np.uint64(memory.size)):
        if looked[i]:
            right = unit(bits[i]) < (b[i * step_b] if black[i] else w[i * step_w])
            observe(memory[i], 1.0 if black[i] == right else 0.0, 1.0)
        pack(outbox, said + i, broadcast(memory[i]))


@njit(nogil=True, error_model="python")
def look_where_able(memory, outbox, said, looked, black, b, w, bits, readings, tick, stops):
    """The same of robots of which some fail or whose `readings` are kept: apart, as above."""
    for i in range(memory.size):
        if looked[i] and works(stops, SENSING, i, tick):
            right = unit(bits[i]) < (b[i % b.size] if black[i] else w[i % w.size])
            reading = 1.0 if black[i] == right else 0.0
            observe(memory[i], reading, 1.0)
            if readings.size > 0:
                readings[i] = reading
        pack(outbox, said + np.uint64(i), broadcast(memory[i]))


@compiled
def hear_sums(memory, outbox, then, heard, senders, scratch):
    """Robot i hears what senders[heard[i]: heard[i + 1]] said: where `receive` only adds, and no message is lost."""
    for i in range(ZERO, np.uint64(memory.size)):
        sums = no_sums
        for e in range(np.uint64(heard[i]), np.uint64(heard[i + np.uint64(1)])):
            sums = sums_with(sums, unpack(outbox, then + np.uint64(senders[e])), scratch[0])
        add_sums(memory[i], sums)


@njit(nogil=True, error_model="python")
def hear_each(memory, outbox, then, heard, senders, key, trial, tick, delay, threshold, stops):
    """The same of any brain, but for messages that are lost and robots that did not talk, `delay` ticks ago."""
    for i in range(memory.size):
        for e in range(heard[i], heard[i + 1]):
            if works(stops, TALKING, senders[e], tick - delay) and (
                threshold == 0 or heard_by(key, trial, tick, i, senders[e], threshold)
            ):
                receive(memory[i], unpack(outbox, then + np.uint64(senders[e])))


@entry
def ride(
    memory, outbox, rows, trial, tick, b, w, read_key, link_key, threshold, delay,
    looked, black, heard, senders, history, readings, stops, stop,
):  # fmt: skip
    """Minds that ride along on a chunk of a walk, from `tick` on; estimates of tick k go to rows[k - 1].

    `looked` and `black` (tick, robot): whether a robot observes, and whether the tile under its sensor is black.
    What a robot hears was said `delay` ticks ago; `outbox` holds delay + 1 ticks. `history` and `readings` (NaN
    where a robot made none) are filled where they have rows.
    """
    n = memory.size
    scratch = memory[:1].copy()
    bits = np.zeros(n, np.uint64)
    nowhere = np.empty(0)
    for k in range(looked.shape[0]):
        if stop[0] != 0:
            return
        now = tick + k
        said, then = np.uint64(now % (delay + 1) * n), np.uint64((now - delay) % (delay + 1) * n)
        words(read_key, trial, now, 0, 0, n, bits)
        if stops.shape[1] == 0 and readings.shape[0] == 0:
            look(memory, outbox, said, looked[k], black[k], b, w, bits)
        else:
            kept = readings[k] if readings.shape[0] > 0 else nowhere
            look_where_able(memory, outbox, said, looked[k], black[k], b, w, bits, kept, now, stops)
        if now >= delay:
            bounds = heard[k * n : (k + 1) * n + 1]
            if additive and threshold == 0 and stops.shape[1] == 0:
                hear_sums(memory, outbox, then, bounds, senders, scratch)
            else:
                hear_each(
                    memory, outbox, then, bounds, senders, link_key, trial, now, delay, threshold, stops
                )  # fmt: skip
        fuse_some(memory, ZERO, np.uint64(n), rows, np.uint64(now - 1))
        if history.shape[0] > 0:
            history[k, :] = memory


@entry
def wish(memory, body, wishes):
    """Ask minds where they want to go; `wishes` (what, robot): whether anywhere, metres and radians a tick.

    Wheels that turn a robot cannot drive it at full speed as well: what is too fast for them is slowed as a whole.
    """
    for i in range(memory.size):
        wants, speed, turn = chosen(steer(memory[i]))
        speed *= body[0].tick
        turn *= body[0].tick
        if not (abs(speed) < 1e300 and abs(turn) < 1e300):
            raise ValueError("steer returned a speed or a turn that is not a finite number")
        load = 0.0
        if speed != 0.0:
            load += abs(speed) / body[0].step if body[0].step > 0.0 else np.inf
        if turn != 0.0:
            load += abs(turn) / body[0].turn if body[0].turn > 0.0 else np.inf
        wishes[0, i] = 1.0 if wants else 0.0
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
    if settle(rows, 1, delta, low, high, where, value):
        settle(start, 0, delta, low, high, where, value)
