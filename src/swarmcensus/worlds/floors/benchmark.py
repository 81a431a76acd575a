"""Nine benchmark patterns of square cells, after the kinds of Bartashevich and Mostaghim (2019).

Shapes are ours, and may differ from their figure. The arena is divided into `cells` by `cells` squares, 20 by 20 as is
usual. A pattern puts them in an order, in which they become black until the share is reached. What a pattern leaves
open, as which rows a star has, is drawn for each trial, and so is how it is turned and mirrored.
"""

from collections.abc import Callable
from typing import Annotated, Literal

import numpy as np
from numpy.typing import NDArray
from pydantic import Field

from swarmcensus.worlds.arena import Arena, Score, Scores, Tiles
from swarmcensus.worlds.chance import Chance

Numbers = NDArray[np.float64]
Name = Literal["random", "stripe", "block", "off-diagonal", "star", "band", "bandwidth", "bandwidth-r", "band-stripe"]
Cells = Annotated[int, Field(ge=2, le=1000)]


def score(
    arena: Arena, chance: Chance, *, pattern: Annotated[Name, Field(examples=["star"])], cells: Cells = 20
) -> Score:
    """The place of a tile's cell in the pattern's order; the tiles of a cell follow each other line by line."""
    uniform = chance.uniform(cells * cells + 2 * cells + 3)
    turn, free = uniform[:3] < 0.5, uniform[3:]
    middle = (np.arange(cells) + 0.5) / cells - 0.5
    x, y = np.meshgrid(middle, middle)
    order = PATTERNS[pattern](x, y, free[: cells * cells].reshape(cells, cells), free[cells * cells :])
    rank = np.empty(cells * cells)
    rank[np.lexsort((free[: cells * cells], order.ravel().round(9)))] = np.arange(cells * cells)

    def placed(tiles: Tiles) -> Scores:
        across = ((tiles + 0.5) * (arena.tile / arena.side) + 0.5) * cells
        across = np.where(turn[:2], cells - across, across)
        column, row = np.moveaxis(across, -1, 0)[:: -1 if turn[2] else 1]
        i, j = (np.clip(np.floor(place), 0, cells - 1).astype(np.int64) for place in (row, column))
        within = np.clip(row - i + (column - j) / 1e4, 0.0, 0.999)
        scores: Scores = rank[i * cells + j] + within
        return scores

    return placed


def _random(x: Numbers, y: Numbers, noise: Numbers, lines: Numbers) -> Numbers:
    """Cells anywhere."""
    return noise


def _stripe(x: Numbers, y: Numbers, noise: Numbers, lines: Numbers) -> Numbers:
    """One stripe from wall to wall through the middle."""
    return np.abs(x)


def _block(x: Numbers, y: Numbers, noise: Numbers, lines: Numbers) -> Numbers:
    """One square in the middle."""
    return np.maximum(np.abs(x), np.abs(y))


def _off_diagonal(x: Numbers, y: Numbers, noise: Numbers, lines: Numbers) -> Numbers:
    """Two squares in opposite corners."""
    return np.minimum(np.maximum(x, -y), np.maximum(-x, y))


def _star(x: Numbers, y: Numbers, noise: Numbers, lines: Numbers) -> Numbers:
    """Whole rows and columns, which cross."""
    rows, columns = lines.reshape(2, -1)
    return np.minimum(rows[:, np.newaxis], columns)


def _band(x: Numbers, y: Numbers, noise: Numbers, lines: Numbers) -> Numbers:
    """Diagonal lines from wall to wall, in any places."""
    along = np.round((x + y + 1.0) * len(x) - 1.0).astype(np.int64)
    return lines[along]


def _bandwidth(x: Numbers, y: Numbers, noise: Numbers, lines: Numbers) -> Numbers:
    """One wide band along a diagonal."""
    return np.abs(x + y)


def _bandwidth_r(x: Numbers, y: Numbers, noise: Numbers, lines: Numbers) -> Numbers:
    """The same band, with cells at random: the nearer to the diagonal, the more of them."""
    return np.abs(x + y) + noise


def _band_stripe(x: Numbers, y: Numbers, noise: Numbers, lines: Numbers) -> Numbers:
    """Straight lines of one cell from wall to wall, in any places."""
    return np.broadcast_to(lines[: len(x)], x.shape)


PATTERNS: dict[str, Callable[[Numbers, Numbers, Numbers, Numbers], Numbers]] = {
    "random": _random, "stripe": _stripe, "block": _block, "off-diagonal": _off_diagonal, "star": _star,
    "band": _band, "bandwidth": _bandwidth, "bandwidth-r": _bandwidth_r, "band-stripe": _band_stripe,
}  # fmt: skip
