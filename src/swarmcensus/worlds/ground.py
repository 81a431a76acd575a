"""The floor of a trial: its tiles' colours, and how much of what robots can reach is black.

Tiles are painted where a sensor stands, and nothing is stored of them.
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

BLOCK = 1 << 16  # tiles that are painted at a time: as many as a core holds near


class Ground:
    """One trial's floor. It paints tiles, and knows `true_fill_ratio`, the share of black ones among those in reach."""

    def __init__(self, floor: Floor, body: Body, side: float, fill_ratio: float, key: np.ndarray, trial: int) -> None:
        """Take a kind of floor in an arena of such a side (metres); see where the floor's cut lies, and count."""
        arena, chance = Arena(side, body.tile), Chance(key, trial)
        self.across = arena.across
        reached = reachable(side / 2.0, body.radius, math.hypot(*body.sensor), body.tile, floor.most_counted(arena))
        blocks = np.array_split(reached, -(-reached.shape[1] // BLOCK), axis=1)
        self._paint: Paint | None = floor.paint(arena, chance, fill_ratio)
        self.score: Score | None = None
        if self._paint is None:
            self.score = floor.score(arena, chance)
            scores = np.concatenate([self.score(block)[0] for block in blocks])
            self.cut = quantile(scores, fill_ratio)
            black = int(np.count_nonzero(scores < self.cut))
        else:
            black = sum(int(np.count_nonzero(self._paint(block))) for block in blocks)
        self.true_fill_ratio = black / reached.shape[1]

    def truth(self, ticks: Any) -> NDArray[np.float64]:
        """The true fill ratio after these ticks: always the same."""
        return np.full(np.shape(ticks), self.true_fill_ratio)

    def turns(self) -> NDArray[np.int32]:
        """The tick from which each tile of the arena has the other colour: no rows, as none ever has."""
        return np.zeros((0, 0), np.int32)

    def colours(self, tiles: Tiles, tick: int = 1) -> NDArray[np.bool_]:
        """Whether tiles (tick, robot, 2) are black (tick, robot), from whatever tick on."""
        if self._paint is not None:
            return self._paint(tiles)
        assert self.score is not None
        return self.score(tiles) < self.cut

    def all_tiles(self) -> NDArray[np.uint8]:
        """Return the tiles of the arena, (row, column), 1 black; the first row is the lowest in y. A byte a tile.

        The tile of a point (x, y), in metres from the arena's centre, is the one of row floor(y / tile) + rows / 2
        and column floor(x / tile) + columns / 2. Walls cut through the outermost tiles.
        """
        tiles = np.empty((self.across, self.across), np.bool_)
        for k, row in enumerate(rows_of(self.across)):
            tiles[k] = self.colours(row)[0]
        return tiles.view(np.uint8)


@functools.lru_cache(maxsize=2)
def reachable(half: float, radius: float, arm: float, tile: float, most: int = MOST_COUNTED) -> Tiles:
    """Return the tiles (1, tile, 2) whose centre a ground sensor can stand over; lengths in metres.

    A robot's centre keeps `radius` from the walls at +-`half`, and its sensor is `arm` from the centre. Where the
    arena has more than `most` tiles, every k-th of every k-th row, with the least k that will do.
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
    """The tiles of an arena of so many from wall to wall, (1, tile, 2), row by row, the lowest in y first.

    A row at a time, for the list of them takes eight bytes a tile.
    """
    place = np.arange(-(across // 2), across // 2, dtype=np.int32)
    for y in place:
        yield np.stack([place, np.full(across, y, np.int32)], axis=1)[np.newaxis]


def quantile(scores: Scores, share: float) -> float:
    """Return what a `share` of the scores lies below, to the nearest one."""
    below = round(share * scores.size)
    if below in (0, scores.size):
        return math.inf if below else -math.inf
    return float(np.partition(scores, below)[below])
