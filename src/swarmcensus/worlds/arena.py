"""The square that robots move in, and how many of them it holds.

Swarm density is D = N pi r^2 / L^2, with r the radio range and L the side (paper, Sec. IV-C).
"""

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Annotated, Any

import numpy as np
from numpy.typing import NDArray
from pydantic import Field

from swarmcensus.worlds.bodies import Body

Length = Annotated[float, Field(gt=0.0, le=1000.0, description="metres")]
Tiles = NDArray[np.int32]  # (tick, robot, 2): column and row, counted from the arena's centre
Scores = NDArray[np.floating[Any]]  # (tick, robot)
Score = Callable[[Tiles], Scores]
Paint = Callable[[Tiles], NDArray[np.bool_]]

MOST_COUNTED = 10_000_000  # tiles; of a larger floor only a regular grid of tiles is counted
COVERED = 0.45  # the largest share of the floor under bodies: above it, random placement often fails


@dataclass(frozen=True)
class Arena:
    """A square of this inner side on tiles of this width, in metres; its centre is a corner of four tiles."""

    side: float
    tile: float

    @property
    def across(self) -> int:
        """How many tiles lie in a row, from wall to wall."""
        return tiles_across(self.side, self.tile)


def tiles_across(side: float, tile: float) -> int:
    """Return how many tiles of width `tile` (metres) cover `side` (metres) from wall to wall: an even number."""
    return 2 * math.ceil(side / 2.0 / tile)


def side(robots: int, density: float, body: Body) -> float:
    """The inner side of the arena in metres."""
    return math.sqrt(robots * math.pi * body.radio_range**2 / density)


def density(robots: int, side: float, body: Body) -> float:
    """The swarm density of an arena of this inner side in metres."""
    return robots * math.pi * body.radio_range**2 / side**2


def smallest_side(robots: int, body: Body) -> float:
    """The inner side of the smallest arena that still holds its robots with room to move."""
    return max(math.sqrt(robots * math.pi * body.radius**2 / COVERED), 4.0 * body.radius)


def largest_density(robots: int, body: Body) -> float:
    """The largest density at which the arena still holds its robots with room to move."""
    return density(robots, smallest_side(robots, body), body)
