"""Floors of trials: their tiles' colours, and how much of what robots can reach is black.

Every tile has a score, and black are the tiles whose score is below the floor's cut. Tiles are painted where a
sensor stands, and nothing is stored of them.
"""

import functools
import math
from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from swarmcensus.engine.compiler import compile_world
from swarmcensus.worlds.bodies import Body
from swarmcensus.worlds.patterns import Floor

MOST_COUNTED = 10_000_000  # tiles; of more, a regular grid of as many stands for all
SOME_COUNTED = 1_000_000  # the same of clusters whose lattice is too large to be kept: each tile is costly
MOST_NODES = 1 << 24  # of a lattice that are kept: 128 MB
BLOCK = 1 << 20  # tiles that are scored at a time
KERNEL = 3.5  # standard deviations, where the smoothing kernel is cut off
SHADES = 512  # a dithered tile is black, and white, with odds of no less than one to so many at its mean

Tiles = NDArray[np.int32]  # (tick, robot, 2): column and row, counted from the arena's centre
Scores = NDArray[np.floating[Any]]
Score = Callable[[Tiles], Scores]


class Ground:
    """One trial's floor. It paints tiles, and knows `true_fill_ratio`, the share of black ones among those in reach."""

    def __init__(self, floor: Floor, body: Body, side: float, fill_ratio: float, key: np.ndarray, trial: int) -> None:
        """Take a kind of floor in an arena of such a side (metres); see where the floor's cut lies, and count."""
        self.key, self.trial, self.fill_ratio = key, trial, fill_ratio
        tile = body.tile
        self.across = tiles_across(side, tile)
        costly = floor.kind == "clusters" and not lattice(floor.length, tile, side)[1]
        most = SOME_COUNTED if costly else MOST_COUNTED
        reached = reachable(side / 2.0, body.radius, math.hypot(*body.sensor), tile, most)
        self.score: Score | None = None
        if floor.kind != "tiles":
            self.score = SCORES[floor.kind](floor, tile, side, self.key, trial)
            blocks = np.array_split(reached, -(-reached.shape[1] // BLOCK), axis=1)
            scores = np.concatenate([self.score(block)[0] for block in blocks])
            self.cut = self.fill_ratio if floor.kind == "stripes" else quantile(scores, self.fill_ratio)
            black = scores < self.cut
        else:
            black = self.colours(reached)
        self.true_fill_ratio = float(np.count_nonzero(black) / black.size)

    def colours(self, tiles: Tiles) -> NDArray[np.bool_]:
        """Whether tiles (tick, robot, 2) are black (tick, robot)."""
        if self.score is not None:
            return self.score(tiles) < self.cut
        black = np.empty(tiles.shape[:2], np.bool_)
        compile_world().paint_tiles(tiles, self.key, self.trial, self.fill_ratio, black)
        return black

    def all_tiles(self) -> NDArray[np.uint8]:
        """Return the tiles of the arena, (row, column), 1 black; the first row is the lowest in y. A byte a tile.

        The tile of a point (x, y), in metres from the arena's centre, is the one of row floor(y / tile) + rows / 2
        and column floor(x / tile) + columns / 2. Walls cut through the outermost tiles.
        """
        across = self.across
        place = np.arange(-(across // 2), across // 2, dtype=np.int32)
        tiles = np.empty((across, across), np.bool_)
        for row, y in enumerate(place):  # a row at a time: the list of tiles takes eight bytes each
            tiles[row] = self.colours(np.stack([place, np.full(across, y, np.int32)], axis=1)[np.newaxis])[0]
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


def quantile(scores: Scores, share: float) -> float:
    """Return what a `share` of the scores lies below, to the nearest one."""
    below = round(share * scores.size)
    if below in (0, scores.size):
        return math.inf if below else -math.inf
    return float(np.partition(scores, below)[below])


def noise(tiles: Tiles, key: np.ndarray, trial: int) -> NDArray[np.float64]:
    """Return one uniform number a tile (tick, robot)."""
    out = np.empty(tiles.shape[:2])
    compile_world("scores").noise(tiles, key, trial, out)
    return out


def lots(key: np.ndarray, trial: int) -> tuple[float, float]:
    """Return two uniform numbers of a trial."""
    out = np.empty((1, 2))
    compile_world().spread_uniform(key, trial, 0.0, 1.0, out)
    return float(out[0, 0]), float(out[0, 1])


def kernel(length: float, tile: float) -> NDArray[np.float64]:
    """Return the weights (offset, tap) of one axis that smooth a lattice to a field of this correlation length.

    Independent N(0, 1) smoothed by a Gaussian of standard deviation s are correlated by exp(-d^2 / (4 s^2)) at a
    distance d, so s is half the correlation length, where that is 1/e. Nodes are at most s apart, a whole number of
    tiles: then the correlation is this, from every tile, to 0.001. A tile lies `offset` tiles after the node of the
    last tap but half of them.
    """
    sd = length / 2.0 / tile
    apart = max(1, math.floor(sd + 1e-9))
    reach = math.ceil(KERNEL * sd / apart)
    distance = np.arange(1 - reach, reach + 1) * apart - np.arange(apart)[:, np.newaxis]
    weights = np.exp(-0.5 * (distance / sd) ** 2)
    normal: NDArray[np.float64] = weights / np.sqrt((weights**2).sum(axis=1, keepdims=True))
    return normal


def lattice(length: float, tile: float, side: float) -> tuple[int, int]:
    """Return the first node, in both directions, that tiles of the arena need, and how many in a row; 0: too many."""
    apart, taps = kernel(length, tile).shape
    first = -tiles_across(side, tile) // 2 // apart - taps
    return first, -2 * first if 4 * first**2 <= MOST_NODES else 0


def _clusters(floor: Floor, tile: float, side: float, key: np.ndarray, trial: int) -> Score:
    module, weights = compile_world("scores"), kernel(floor.length, tile)
    first, size = lattice(floor.length, tile, side)
    nodes = np.empty((size, size))
    module.fill_nodes(key, trial, first, nodes)

    def score(tiles: Tiles) -> Scores:
        out = np.empty(tiles.shape[:2])
        module.field(tiles, key, trial, first, nodes, weights, out)
        return out

    return score


def _stripes(floor: Floor, tile: float, side: float, key: np.ndarray, trial: int) -> Score:
    which, phase = lots(key, trial)
    axis = int(which < 0.5)

    def score(tiles: Tiles) -> Scores:
        # somewhere in the tile: where a stripe ends within it, it is black with the share that is covered
        place = (tiles[..., axis] + noise(tiles, key, trial)) * (tile / floor.length) + phase
        within: Scores = np.minimum(place - np.floor(place), 1.0 - 2.0**-53)
        return within

    return score


def _half(floor: Floor, tile: float, side: float, key: np.ndarray, trial: int) -> Score:
    which = int(4.0 * lots(key, trial)[0])
    axis, sign = which % 2, 1.0 if which < 2 else -1.0

    def score(tiles: Tiles) -> Scores:
        # line by line, so that the cut may fall anywhere
        order: Scores = sign * 2.0**31 * tiles[..., axis] + tiles[..., 1 - axis]
        return order

    return score


def _image(floor: Floor, tile: float, side: float, key: np.ndarray, trial: int) -> Score:
    assert floor.picture is not None
    grey = floor.picture.grey
    rows, columns = grey.shape
    darkness = np.clip(1.0 - np.arange(65536) / 65535.0, 1.0 / (SHADES + 1), SHADES / (SHADES + 1))
    against = (1.0 - darkness) / darkness

    def score(tiles: Tiles) -> Scores:
        across, up = (((tiles[..., axis] + 0.5) * (tile / side) + 0.5) for axis in (0, 1))
        column = np.clip(np.floor(across * columns).astype(np.int64), 0, columns - 1)
        row = np.clip(np.floor((1.0 - up) * rows).astype(np.int64), 0, rows - 1)
        level, u = grey[row, column], noise(tiles, key, trial)
        # dithered: below the cut with odds of cut * darkness / (1 - darkness)
        rank: Scores = level + u if floor.mode == "threshold" else against[level] * u / (1.0 - u)
        return rank

    return score


SCORES: dict[str, Callable[[Floor, float, float, np.ndarray, int], Score]] = {
    "clusters": _clusters,
    "stripes": _stripes,
    "half": _half,
    "image": _image,
}


def tiles_across(side: float, tile: float) -> int:
    """Return how many tiles of width `tile` (metres) cover `side` (metres) from wall to wall: an even number."""
    return 2 * math.ceil(side / 2.0 / tile)
