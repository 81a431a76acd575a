"""The floor of a trial with a changing fill ratio: no more tiles change colour than necessary."""

import math
from collections.abc import Iterator
from typing import Any

import numpy as np
from numpy.typing import NDArray

from swarmcensus.worlds.arena import Arena, Scores, Tiles
from swarmcensus.worlds.bodies import Body
from swarmcensus.worlds.chance import Chance
from swarmcensus.worlds.ground import BLOCK, quantiles, reachable, rows_of
from swarmcensus.worlds.patterns import Floor

NO_TURN = np.iinfo(np.int32).max


class ChangingGround:
    """Like `Ground`, for a fill ratio that changes from tick to tick.

    Each tile has a fixed number, its level or score, and is black if that is below the tick's cut. So the black tiles
    of a smaller fill ratio are among those of a larger one.
    """

    def __init__(
        self, floor: Floor, body: Body, side: float, shares: NDArray[np.float64], key: np.ndarray, trial: int
    ) -> None:
        """`side` is the arena's, in metres; `shares` are the fill ratios of the ticks until the change has ended."""
        arena, chance = Arena(side, body.tile), Chance(key, trial)
        self.across = arena.across
        reached = reachable(side / 2.0, body.radius, math.hypot(*body.sensor), body.tile, floor.most_counted(arena))
        blocks = np.array_split(reached, -(-reached.shape[1] // BLOCK), axis=1)
        level = floor.level(arena, chance)  # which is a share itself; the cuts of scores must be found
        self.number = level or floor.score(arena, chance)
        numbers = np.concatenate([self.number(block)[0] for block in blocks])
        distinct, place = np.unique(shares, return_inverse=True)
        cuts = distinct if level else quantiles(numbers, distinct)
        # how many numbers are below each cut: cuts are sorted, so each number is below all cuts from one on
        first = np.searchsorted(cuts, numbers, side="right")
        black = np.cumsum(np.bincount(first, minlength=cuts.size + 1))[:-1]
        self.cuts, self.truths = cuts[place], (black / numbers.size)[place]

    @property
    def true_fill_ratio(self) -> float:
        """The share of black tiles among those in reach, after the last tick."""
        return float(self.truths[-1])

    def truth(self, ticks: Any) -> NDArray[np.float64]:
        """The share of black tiles among those in reach, after each of these ticks."""
        return np.asarray(self.truths[self._index(ticks)])

    def colours(self, tiles: Tiles, tick: int = 1) -> NDArray[np.bool_]:
        """Whether tiles (tick, robot, 2) are black (tick, robot); the first row is of tick `tick`."""
        return np.asarray(self.number(tiles) < self.cuts[self._index(tick + np.arange(len(tiles)))][:, np.newaxis])

    def all_tiles(self) -> NDArray[np.uint8]:
        """The tiles of the arena in tick 1, in the form of `Ground.all_tiles`."""
        tiles = np.empty((self.across, self.across), np.bool_)
        for row, numbers in enumerate(self._rows()):
            tiles[row] = numbers < self.cuts[0]
        return tiles.view(np.uint8)

    def turns(self) -> NDArray[np.int32]:
        """The tick at which each tile of the arena changes colour (row, column), NO_TURN if it never does.

        A fill ratio only rises or only falls, so no tile changes colour twice.
        """
        out = np.empty((self.across, self.across), np.int32)
        rises = self.cuts[-1] > self.cuts[0]
        for row, numbers in enumerate(self._rows()):
            if rises:
                turn = np.searchsorted(self.cuts, numbers, side="right")
            else:
                turn = np.searchsorted(-self.cuts, -numbers, side="left")
            # what has the colour of the end from the first tick on never turns
            out[row] = np.where((numbers < self.cuts[0]) == rises, self.cuts.size, turn)
        out[out == self.cuts.size] = NO_TURN - 1
        return out + np.int32(1)

    def _index(self, ticks: Any) -> Any:
        """The index of ticks in `cuts` and `truths`; the last one stays."""
        return np.clip(np.asarray(ticks) - 1, 0, self.cuts.size - 1)

    def _rows(self) -> Iterator[Scores]:
        """The numbers of the arena's tiles, row by row; the first row has the lowest y."""
        return (self.number(row)[0] for row in rows_of(self.across))
