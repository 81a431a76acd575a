"""Robots whose brains steer: bodies and brains run tick by tick together, because each decides where the other goes.

Compiled once on a machine, like all of the engine's loops.
"""

import numpy as np

from swarmcensus.engine.compiling import entry
from swarmcensus.engine.constants import PACE
from swarmcensus.engine.layout import Chunk

from .riding import live_on, steer_all
from .states import sensors_of
from .walk import walk


@entry
def live(swarm, given, states, tally, intervals, bodies, neighbours, floor, turns, work, chunk, recorded, stop):
    """Run the only trial `given` for as many ticks as states.rows.

    A tile's colour is that of `floor` (row, column), 1 for black.

    `turns` (row, column) is the tick from which a tile has the other colour; no rows if no tile changes.
    """
    sensors, radio, stops, trial = sensors_of(given.sensors, 0), given.radio, given.stops[0], given.first
    n, low, left = states.memory.shape[0], floor.shape[0] // 2, floor.shape[1] // 2
    black, tiles = np.zeros((1, n), np.bool_), chunk.tiles
    for tick in range(1, states.rows.shape[0] + 1):
        now = Chunk(tick, chunk.looked, tiles, chunk.heard, chunk.senders, chunk.poses, chunk.begin)
        walk(bodies, neighbours, stops, trial, now, stop)
        if stop[0] != 0:
            return
        for i in range(n):
            row, column = tiles[0, i, 1] + low, tiles[0, i, 0] + left
            black[0, i] = floor[row, column] != 0
            if turns.shape[0] > 0 and tick >= turns[row, column]:
                black[0, i] = not black[0, i]
        live_on(swarm, states, work, sensors, radio, stops, tally, intervals, now, black, recorded, trial, stop)
        steer_all(swarm, work.bits, states.memory, bodies.body, bodies.state[PACE], trial, tick, bodies.commands)
