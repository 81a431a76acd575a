"""Floors as arrays: which tiles of a trial's arena are black, for pictures and whoever wants to see all of one.

A run needs no such array: it paints only the tiles under its sensors, with the same function.
"""

import math

import numpy as np
from numpy.typing import NDArray

from swarmcensus import arena
from swarmcensus.engine.compiler import compile_world
from swarmcensus.settings import Setting


def tiles_across(side: float, tile: float) -> int:
    """Return how many tiles of width `tile` (metres) cover `side` (metres) from wall to wall: an even number."""
    return 2 * math.ceil(side / 2.0 / tile)


def floor_of(setting: Setting, seed: int, trial: int) -> NDArray[np.uint8]:
    """Return the tiles of a trial's arena, (row, column), 1 black; the first row is the lowest in y.

    The tile of a point (x, y), in metres from the arena's centre, is the one of row floor(y / tile) + rows / 2
    and column floor(x / tile) + columns / 2. Walls cut through the outermost tiles. `setting` must be one of
    robots that move; it takes a byte a tile.
    """
    assert setting.body is not None
    assert setting.density is not None
    side = arena.side(setting.robots, setting.density, setting.body)
    across = tiles_across(side, setting.body.tile)
    place = np.arange(-(across // 2), across // 2, dtype=np.int32)
    tiles = np.empty((across, across), np.bool_)
    paint = compile_world().paint_tiles
    for row, y in enumerate(place):  # a row at a time: the list of tiles takes eight bytes each
        where = np.stack([place, np.full(across, y, np.int32)], axis=1)[np.newaxis]
        paint(where, setting.floor_key(seed), trial, setting.fill_ratio, tiles[row : row + 1])
    return tiles.view(np.uint8)
