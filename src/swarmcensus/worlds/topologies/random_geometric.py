"""A random geometric graph, another for each trial: robots at random places of a square of side 1 hear those nearby.

Robots hear each other within `radius`. Without it, the radius is that at which a robot far from the border would have
2 ln N + 4 neighbours. Places are drawn again until the graph is connected. A radius at which this does not come about
is refused.
"""

import math
from typing import Annotated

import numpy as np
from pydantic import Field

from swarmcensus.worlds.chance import Chance
from swarmcensus.worlds.connected import lowest_reached

Radius = Annotated[float, Field(gt=0.0, le=1.5)]
DRAWS = 100  # of places, at most


def check(robots: int, *, radius: Radius | None = None) -> None:
    """Refuse a radius at which graphs are not connected, as one of them shows."""
    edges(robots, Chance(np.zeros(2, np.uint64), 0), radius=radius)


def edges(robots: int, chance: Chance, *, radius: Radius | None = None) -> np.ndarray:
    """Neighbours, (edge, 2)."""
    reach = radius or math.sqrt((2.0 * math.log(robots) + 4.0) / math.pi / robots)
    for draw in range(DRAWS):
        places = chance.uniform(2 * robots * (draw + 1))[-2 * robots :].reshape(-1, 2)
        pairs = _nearby(places, reach)
        if not lowest_reached(robots, pairs[:, 0], pairs[:, 1]).any():
            return pairs
    raise ValueError(f"none of {DRAWS} graphs with radius = {reach:.4g} was connected: a larger radius is right")


def _nearby(places: np.ndarray, reach: float) -> np.ndarray:
    """Pairs of places within reach, (pair, 2), found among the cells of a grid next to each other."""
    count = len(places)
    across = max(1, min(int(1.0 / reach), math.isqrt(count)))
    cell = np.minimum((places * across).astype(np.int64), across - 1)
    number = cell @ [across, 1]
    order = np.argsort(number, kind="stable")
    starts = np.searchsorted(number[order], np.arange(across * across + 1))
    found = []
    for step in np.ndindex(3, 3):
        other = cell + step - 1
        inside = np.flatnonzero(((other >= 0) & (other < across)).all(axis=1))
        first = starts[other[inside] @ [across, 1]]
        many = starts[other[inside] @ [across, 1] + 1] - first
        one = np.repeat(inside, many)
        two = order[np.arange(many.sum()) + np.repeat(first - np.cumsum(many) + many, many)]
        near = (one < two) & (((places[one] - places[two]) ** 2).sum(axis=1) <= reach**2)
        found.append(np.stack([one[near], two[near]], axis=1))
    return np.concatenate(found)
