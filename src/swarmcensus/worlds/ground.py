"""The floor of a trial: its tiles' colours, and the share of black tiles among those that robots can reach.

A tile's colour is computed whenever a sensor is over it; no tiles are stored.
"""

import functools
import math
from collections.abc import Iterator
from typing import Any

import numpy as np
from numpy.typing import NDArray

from swarmcensus.worlds.arena import MOST_COUNTED, Arena, Scores, Tiles
from swarmcensus.worlds.bodies import Body
from swarmcensus.worlds.chance import Chance
from swarmcensus.worlds.patterns import Floor

BLOCK = 1 << 16  # tiles that are painted at a time: few enough for a core's cache
NO_TURN = np.iinfo(np.int32).max


class Ground:
    """One trial's floor: tiles' colours, and the share of black tiles among those in reach.

    Where the fill ratio changes, no more tiles change colour than necessary: each tile has a fixed number, its level or
    score, and is black if that is below the tick's cut. So the black tiles of a smaller fill ratio are among those of a
    larger one.
    """

    def __init__(
        self, floor: Floor, body: Body, side: float, shares: NDArray[np.float64], key: np.ndarray, trial: int,
        most: int = MOST_COUNTED,
    ) -> None:  # fmt: skip
        """`side` is the arena's, in metres; `shares` are the fill ratios of the ticks until a change has ended.

        The cuts of scores are found, and black tiles are counted, at once, among `most` tiles at the most.
        """
        arena, chance = Arena(side, body.tile), Chance(key, trial)
        self.across = arena.across
        most = min(most, floor.most_counted(arena))
        reached = reachable(side / 2.0, body.radius, math.hypot(*body.sensor), body.tile, most)
        blocks = np.array_split(reached, -(-reached.shape[1] // BLOCK), axis=1)
        distinct, place = np.unique(shares, return_inverse=True)
        self._paint = floor.paint(arena, chance, float(shares[0])) if distinct.size == 1 else None
        if self._paint is not None:
            black = np.array([sum(int(np.count_nonzero(self._paint(block))) for block in blocks)])
            cuts = distinct
        else:
            level = floor.level(arena, chance)  # which is a share itself; the cuts of scores must be found
            self.number = level or floor.score(arena, chance)
            numbers = np.concatenate([self.number(block)[0] for block in blocks])
            cuts = distinct if level else quantiles(numbers, distinct)
            # how many numbers are below each cut: cuts are sorted, so each number is below all cuts from one on
            first = np.searchsorted(cuts, numbers, side="right")
            black = np.cumsum(np.bincount(first, minlength=cuts.size + 1))[:-1]
        self.cuts, self.truths = cuts[place], (black / reached.shape[1])[place]

    @property
    def true_fill_ratio(self) -> float:
        """The share of black tiles among those in reach, after the last tick."""
        return float(self.truths[-1])

    def truth(self, ticks: Any) -> NDArray[np.float64]:
        """The share of black tiles among those in reach, after each of these ticks."""
        return np.asarray(self.truths[self._index(ticks)])

    def colours(self, tiles: Tiles, tick: int = 1) -> NDArray[np.bool_]:
        """Whether tiles (tick, robot, 2) are black (tick, robot); the first row is of tick `tick`."""
        if self._paint is not None:
            return self._paint(tiles)
        return np.asarray(self.number(tiles) < self.cuts[self._index(tick + np.arange(len(tiles)))][:, np.newaxis])

    def all_tiles(self) -> NDArray[np.uint8]:
        """Return the tiles of the arena in tick 1, (row, column), 1 black; the first row has the lowest y.

        The tile at a point (x, y), in metres from the arena's centre, is in row floor(y / tile) + rows / 2 and column
        floor(x / tile) + columns / 2. Walls cut through the outermost tiles. One byte a tile.
        """
        tiles = np.empty((self.across, self.across), np.bool_)
        for k, row in enumerate(rows_of(self.across)):
            tiles[k] = self.colours(row)[0]
        return tiles.view(np.uint8)

    def turns(self) -> NDArray[np.int32]:
        """The tick at which each tile of the arena changes colour (row, column), NO_TURN if it never does.

        A fill ratio only rises or only falls, so no tile changes colour twice. No rows where it does not change.
        """
        if self.cuts.size == 1:
            return np.zeros((0, 0), np.int32)
        out = np.empty((self.across, self.across), np.int32)
        rises = self.cuts[-1] > self.cuts[0]
        for row, tiles in enumerate(rows_of(self.across)):
            numbers = self.number(tiles)[0]
            turn = np.searchsorted(self.cuts, numbers, "right") if rises else np.searchsorted(-self.cuts, -numbers)
            # what has the colour of the end from the first tick on never turns
            out[row] = np.where((numbers < self.cuts[0]) == rises, self.cuts.size, turn)
        out[out == self.cuts.size] = NO_TURN - 1
        return out + np.int32(1)

    def _index(self, ticks: Any) -> Any:
        """The index of ticks in `cuts` and `truths`; the last one stays."""
        return np.clip(np.asarray(ticks) - 1, 0, self.cuts.size - 1)


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
