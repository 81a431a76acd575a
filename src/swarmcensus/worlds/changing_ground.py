"""The floor of a trial whose fill ratio changes: tiles turn, and no more of them than need be."""

import math
from collections.abc import Iterator
from typing import Any

import numpy as np
from numpy.typing import NDArray

from swarmcensus.worlds.arena import Arena, Scores, Tiles
from swarmcensus.worlds.bodies import Body
from swarmcensus.worlds.chance import Chance
from swarmcensus.worlds.ground import BLOCK, reachable, rows_of
from swarmcensus.worlds.patterns import Floor

NO_TURN = np.iinfo(np.int32).max


class ChangingGround:
    """What `Ground` is, of a share of black that changes by tick.

    Each tile has a number that stays, its level or score, and is black where that lies below the cut of the tick: so
    black tiles of a smaller share are among those of a larger one.
    """

    def __init__(
        self, floor: Floor, body: Body, side: float, shares: NDArray[np.float64], key: np.ndarray, trial: int
    ) -> None:
        """Take a floor in an arena of such a side (metres), and the share of each tick until it changes no more."""
        arena, chance = Arena(side, body.tile), Chance(key, trial)
        self.across = arena.across
        reached = reachable(side / 2.0, body.radius, math.hypot(*body.sensor), body.tile, floor.most_counted(arena))
        blocks = np.array_split(reached, -(-reached.shape[1] // BLOCK), axis=1)
        level = floor.level(arena, chance)
        self.number = level or floor.score(arena, chance)
        numbers = np.concatenate([self.number(block)[0] for block in blocks])
        distinct, place = np.unique(shares, return_inverse=True)
        cuts = distinct if level else quantiles(numbers, distinct)
        # how many lie below each cut: each number below those from some cut on
        first = np.searchsorted(cuts, numbers, side="right")
        black = np.cumsum(np.bincount(first, minlength=cuts.size + 1))[:-1]
        self.cuts, self.truths = cuts[place], (black / numbers.size)[place]

    @property
    def true_fill_ratio(self) -> float:
        """The share of black among the tiles in reach after the last tick."""
        return float(self.truths[-1])

    def truth(self, ticks: Any) -> NDArray[np.float64]:
        """The same after these ticks."""
        return np.asarray(self.truths[self._of(ticks)])

    def colours(self, tiles: Tiles, tick: int = 1) -> NDArray[np.bool_]:
        """Whether tiles (tick, robot, 2) are black (tick, robot), from this tick on."""
        return np.asarray(self.number(tiles) < self.cuts[self._of(tick + np.arange(len(tiles)))][:, np.newaxis])

    def all_tiles(self) -> NDArray[np.uint8]:
        """The tiles of the arena in tick 1, as `Ground.all_tiles`."""
        tiles = np.empty((self.across, self.across), np.bool_)
        for row, numbers in enumerate(self._rows()):
            tiles[row] = numbers < self.cuts[0]
        return tiles.view(np.uint8)

    def turns(self) -> NDArray[np.int32]:
        """The tick from which each of them has the other colour (row, column), NO_TURN where it never has.

        A fill ratio rises or falls all the way, so that none turns twice.
        """
        out = np.empty((self.across, self.across), np.int32)
        rises = self.cuts[-1] > self.cuts[0]
        for row, numbers in enumerate(self._rows()):
            if rises:
                turn = np.searchsorted(self.cuts, numbers, side="right")
                out[row] = np.where(numbers < self.cuts[0], self.cuts.size, turn)
            else:
                turn = np.searchsorted(-self.cuts, -numbers, side="left")
                out[row] = np.where(numbers < self.cuts[0], turn, self.cuts.size)
        out[out == self.cuts.size] = NO_TURN - 1
        return out + np.int32(1)

    def _of(self, ticks: Any) -> Any:
        """Where the numbers of ticks stand: the last ones hold on."""
        return np.clip(np.asarray(ticks) - 1, 0, self.cuts.size - 1)

    def _rows(self) -> Iterator[Scores]:
        """The numbers of the arena's tiles, row by row; the first row is the lowest in y."""
        return (self.number(row)[0] for row in rows_of(self.across))


def quantiles(scores: Scores, shares: NDArray[np.float64]) -> NDArray[np.float64]:
    """What each of the shares of the scores lies below, as `ground.quantile` has it."""
    below = np.round(shares * scores.size).astype(np.int64)
    inside = (below > 0) & (below < scores.size)
    cuts = np.where(below > 0, math.inf, -math.inf)
    if inside.any():
        cuts[inside] = np.partition(scores, np.unique(below[inside]))[below[inside]]
    return cuts
