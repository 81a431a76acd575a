"""Floors as arrays: which tiles of a trial's arena are black, for pictures and whoever wants to see all of one.

A run needs no such array: it works out the tile under a sensor from its address (engine/kernel.py, `ride`).
"""

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from swarmcensus import arena
from swarmcensus.engine.random import PARITY
from swarmcensus.settings import Setting

TILE_ZERO = 1 << 30  # the address of the tile right and above of the arena's centre, as in engine/kernel.py
ROTATIONS = (16, 42, 12, 31, 16, 32, 24, 21, 16, 42, 12, 31, 16)
BAND = 1 << 15  # tiles worked out at a time: they stay in the processor's cache


def tiles_across(side: float, tile: float) -> int:
    """Return how many tiles of width `tile` (metres) cover `side` (metres) from wall to wall: an even number."""
    return 2 * math.ceil(side / 2.0 / tile)


def floor_of(setting: Setting, seed: int, trial: int) -> NDArray[np.uint8]:
    """Return the tiles of a trial's arena, (row, column), 1 black; the first row is the lowest in y.

    The tile of a point (x, y), in metres from the arena's centre, is the one of row floor(y / tile) + rows / 2
    and column floor(x / tile) + columns / 2. Walls cut through the outermost tiles. `setting` must be one of
    robots that move; it takes a byte a tile and about 0.2 s for a million.
    """
    assert setting.body is not None
    assert setting.density is not None
    side = arena.side(setting.robots, setting.density, setting.body)
    across = tiles_across(side, setting.body.tile)
    tiles = np.empty((across, across), np.uint8)
    key = setting.floor_key(seed)
    place = np.arange(across, dtype=np.uint64) + np.uint64(TILE_ZERO - across // 2)
    rows = max(1, BAND // across)
    for first in range(0, across, rows):
        low = place[first : first + rows, np.newaxis]
        words = _first_words(key, trial, (place[np.newaxis] << np.uint64(32)) | low)
        tiles[first : first + rows] = (words >> np.uint64(11)) * 2.0**-53 < setting.fill_ratio
    return tiles


def _first_words(key: NDArray[np.uint64], trial: int, counters: NDArray[np.uint64]) -> NDArray[Any]:
    """The first word of `block` (engine/random.py) at the counters (trial, 0) and `counters`, all at once."""
    k = key[0], key[1], np.uint64(PARITY) ^ key[0] ^ key[1]
    a = np.full_like(counters, np.array([trial << 32], np.uint64) + k[0])
    b = counters + k[1]
    for i, turn in enumerate(ROTATIONS, start=1):
        a += b
        b = (b << np.uint64(turn)) | (b >> np.uint64(64 - turn))
        b ^= a
        if i % 4 == 0:
            a += k[i // 4 % 3]
            b += k[(i // 4 + 1) % 3]
            b += np.uint64(i // 4)
    return a
