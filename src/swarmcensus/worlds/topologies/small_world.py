"""A small world (Watts and Strogatz, 1998), another for each trial: a ring with some links rewired.

Each robot hears `neighbours` nearest ones on a ring, half of them on each side. Each of these links is rewired with
probability `rewired`: it keeps one end, and the other becomes any robot that is no neighbour yet. Of as few robots as
`neighbours` + 1, all hear each other.
"""

from collections import defaultdict
from typing import Annotated

import numpy as np
from pydantic import Field

from swarmcensus.worlds.chance import Chance

Neighbours = Annotated[int, Field(ge=2, multiple_of=2)]
Rewired = Annotated[float, Field(ge=0.0, le=1.0)]


def edges(robots: int, chance: Chance, *, neighbours: Neighbours = 4, rewired: Rewired = 0.1) -> np.ndarray:
    """Neighbours, (edge, 2)."""
    if robots <= neighbours + 1:
        return np.stack(np.triu_indices(robots, 1), axis=1)
    steps = np.arange(1, neighbours // 2 + 1)
    near = np.repeat(steps, robots)
    first = np.tile(np.arange(robots), steps.size)
    second = (first + near) % robots
    uniform = chance.uniform(2 * first.size).reshape(2, -1)
    around = {*steps.tolist(), *(-steps).tolist()}
    changed: dict[int, set[int]] = defaultdict(set)  # links that are there and not on the ring, or the other way round
    for k in np.flatnonzero(uniform[0] < rewired):
        i, j = int(first[k]), int(second[k])
        taken = {(i + step) % robots for step in around} ^ changed[i] | {i}
        if len(taken) == robots:
            continue
        new = int(uniform[1, k] * (robots - len(taken)))
        for other in sorted(taken):
            new += other <= new
        for one, two in ((i, j), (i, new)):
            changed[one] ^= {two}
            changed[two] ^= {one}
        second[k] = new
    return np.stack([first, second], axis=1)
