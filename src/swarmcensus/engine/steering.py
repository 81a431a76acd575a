"""Robots whose brains steer: bodies and brains run tick by tick together, because each decides where the other goes.

Compiled once on a machine, like all of the engine's loops.
"""

import numpy as np

from swarmcensus.engine.compiling import entry
from swarmcensus.engine.constants import PACE
from swarmcensus.engine.layout import Chunk, Recorded

from .riding import buffers_of, live_on, steer_all
from .states import sensors_of
from .walk import walk


@entry
def live(swarm, given, states, tally, intervals, bodies, neighbours, floor, turns, messages, stop):
    """Run the only trial `given` for as many ticks as states.rows.

    A tile's colour is that of `floor` (row, column), 1 for black.

    `turns` (row, column) is the tick from which a tile has the other colour; no rows if no tile changes. At most
    `messages` are heard in a tick.
    """
    sensors, radio, stops, trial = sensors_of(given.sensors, 0), given.radio, given.stops[0], given.first
    n = states.memory.shape[0]
    black = np.zeros((1, n), np.bool_)
    looked, tiles, heard = np.zeros((1, n), np.bool_), np.zeros((1, n, 2), np.int32), np.zeros(n + 1, np.int64)
    senders, poses, begin = np.zeros(messages, np.uint32), np.zeros((0, n, 3)), np.zeros((0, 3))
    no_bytes, no_rows = np.zeros((0, 0, 0), np.uint8), np.zeros((0, 0))
    recorded = Recorded(no_bytes, no_rows, no_bytes, np.zeros((0, 0), np.uint8), np.zeros((0, 2), np.int64))
    buffers = buffers_of(n, messages, states.outbox.shape[1])
    low, left = floor.shape[0] // 2, floor.shape[1] // 2
    for tick in range(1, states.rows.shape[0] + 1):
        chunk = Chunk(tick, looked, tiles, heard, senders, poses, begin)
        walk(bodies, neighbours, stops, trial, chunk, stop)
        if stop[0] != 0:
            return
        for i in range(n):
            row, column = tiles[0, i, 1] + low, tiles[0, i, 0] + left
            black[0, i] = floor[row, column] != 0
            if turns.shape[0] > 0 and tick >= turns[row, column]:
                black[0, i] = not black[0, i]
        live_on(swarm, states, buffers, sensors, radio, stops, tally, intervals, chunk, black, recorded, trial, stop)
        steer_all(swarm, buffers.bits, states.memory, bodies.body, bodies.state[PACE], trial, tick, bodies.commands)
