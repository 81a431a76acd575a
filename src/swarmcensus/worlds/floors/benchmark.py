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


Order = Callable[[Numbers, Numbers, Numbers, Numbers], Numbers]  # of the cells at x and y, with random noise and lines
PATTERNS: dict[str, Order] = {
    "random": lambda x, y, noise, lines: noise,  # cells anywhere
    "stripe": lambda x, y, noise, lines: np.abs(x),  # one stripe from wall to wall through the middle
    "block": lambda x, y, noise, lines: np.maximum(np.abs(x), np.abs(y)),  # one square in the middle
    # two squares in opposite corners
    "off-diagonal": lambda x, y, noise, lines: np.minimum(np.maximum(x, -y), np.maximum(-x, y)),
    # whole rows and columns, which cross
    "star": lambda x, y, noise, lines: np.minimum(lines[: len(x), np.newaxis], lines[len(x) :]),
    # diagonal lines from wall to wall, in any places
    "band": lambda x, y, noise, lines: lines[np.round((x + y + 1.0) * len(x) - 1.0).astype(np.int64)],
    "bandwidth": lambda x, y, noise, lines: np.abs(x + y),  # one wide band along a diagonal
    # the same band, with cells at random: the nearer to the diagonal, the more of them
    "bandwidth-r": lambda x, y, noise, lines: np.abs(x + y) + noise,
    # straight lines of one cell from wall to wall, in any places
    "band-stripe": lambda x, y, noise, lines: np.broadcast_to(lines[: len(x)], x.shape),
}
