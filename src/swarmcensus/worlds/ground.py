"""The floor of a trial: its tiles' colours, and the share of black tiles among those that robots can reach.

A tile's colour is computed whenever a sensor is over it; no tiles are stored.
"""

import functools
import math
from collections.abc import Iterator
from typing import Any

import numpy as np
from numpy.typing import NDArray

from swarmcensus.worlds.arena import MOST_COUNTED, Arena, Paint, Score, Scores, Tiles
from swarmcensus.worlds.bodies import Body
from swarmcensus.worlds.chance import Chance
from swarmcensus.worlds.patterns import Floor

BLOCK = 1 << 16  # tiles that are painted at a time: few enough for a core's cache


class Ground:
    """One trial's floor: tiles' colours, and `true_fill_ratio`, the share of black tiles among those in reach."""

    def __init__(self, floor: Floor, body: Body, side: float, fill_ratio: float, key: np.ndarray, trial: int) -> None:
        """`side` is the arena's, in metres. The cut of scores is found, and black tiles are counted, at once."""
        arena, chance = Arena(side, body.tile), Chance(key, trial)
        self.across = arena.across
        reached = reachable(side / 2.0, body.radius, math.hypot(*body.sensor), body.tile, floor.most_counted(arena))
        blocks = np.array_split(reached, -(-reached.shape[1] // BLOCK), axis=1)
        self._paint: Paint | None = floor.paint(arena, chance, fill_ratio)
        self.score: Score | None = None
        if self._paint is None:
            self.score = floor.score(arena, chance)
            scores = np.concatenate([self.score(block)[0] for block in blocks])
            self.cut = float(quantiles(scores, np.array([fill_ratio]))[0])
            black = int(np.count_nonzero(scores < self.cut))
        else:
            black = sum(int(np.count_nonzero(self._paint(block))) for block in blocks)
        self.true_fill_ratio = black / reached.shape[1]

    def truth(self, ticks: Any) -> NDArray[np.float64]:
        """The true fill ratio after each of these ticks: always the same."""
        return np.full(np.shape(ticks), self.true_fill_ratio)

    def turns(self) -> NDArray[np.int32]:
        """The tick at which each tile of the arena changes colour: no rows, as none does."""
        return np.zeros((0, 0), np.int32)

    def colours(self, tiles: Tiles, tick: int = 1) -> NDArray[np.bool_]:
        """Whether tiles (tick, robot, 2) are black (tick, robot), at any tick."""
        if self._paint is not None:
            return self._paint(tiles)
        assert self.score is not None
        return self.score(tiles) < self.cut

    def all_tiles(self) -> NDArray[np.uint8]:
        """Return the tiles of the arena, (row, column), 1 black; the first row has the lowest y. One byte a tile.

        The tile at a point (x, y), in metres from the arena's centre, is in row floor(y / tile) + rows / 2 and column
        floor(x / tile) + columns / 2. Walls cut through the outermost tiles.
        """
        tiles = np.empty((self.across, self.across), np.bool_)
        for k, row in enumerate(rows_of(self.across)):
            tiles[k] = self.colours(row)[0]
        return tiles.view(np.uint8)


@functools.lru_cache(maxsize=2)
def reachable(half: float, radius: float, arm: float, tile: float, most: int = MOST_COUNTED) -> Tiles:
    """Return the tiles (1, tile, 2) with a centre that a ground sensor can reach; lengths in metres.

    A robot's centre keeps `radius` from the walls at +-`half`, and its sensor is `arm` from the centre. If the arena
    has more than `most` tiles, only every k-th tile of every k-th row is taken, with the smallest k that suffices.
    """
    inner = half - radius
    last = math.ceil(half / tile)
    step = math.ceil(2 * last / math.isqrt(most))
    place = np.arange(-last + step // 2, last, step, dtype=np.int32)
    centre = np.abs(place + 0.5) * tile
    beyond = np.maximum(centre - inner, 0.0)
    near = beyond[:, np.newaxis] ** 2 + beyond**2 <= arm**2
    near &= (centre[:, np.newaxis] <= half) & (centre <= half)
    row, column = np.nonzero(near)
    return np.stack([place[column], place[row]], axis=1)[np.newaxis]


def rows_of(across: int) -> Iterator[Tiles]:
    """The tiles (1, tile, 2) of an arena that is `across` tiles wide, row by row, the lowest y first.

    One row at a time, because a list of all takes eight bytes a tile.
    """
    place = np.arange(-(across // 2), across // 2, dtype=np.int32)
    for y in place:
        yield np.stack([place, np.full(across, y, np.int32)], axis=1)[np.newaxis]


def quantiles(scores: Scores, shares: NDArray[np.float64]) -> NDArray[np.float64]:
    """The cut below which each of these shares of the scores lies, to the nearest score."""
    below = np.round(shares * scores.size).astype(np.int64)
    inside = (below > 0) & (below < scores.size)
    cuts = np.where(below > 0, math.inf, -math.inf)
    if inside.any():
        cuts[inside] = np.partition(scores, np.unique(below[inside]))[below[inside]]
    return cuts
