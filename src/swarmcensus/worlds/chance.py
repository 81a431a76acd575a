"""The random numbers of a trial's world. They are counter-based: a number depends on its address alone."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from swarmcensus.engine import compile_world, not_compiled
from swarmcensus.engine.constants import TILE_ZERO


class Chance(NamedTuple):
    """The random numbers of one purpose in one trial. `key` is its address, two uint64."""

    key: np.ndarray
    trial: int

    def generator(self) -> "np.random.Generator":  # quoted: that part of NumPy is imported on first use
        """Return a generator of NumPy, the same at each call: Philox is counter-based too."""
        return np.random.Generator(np.random.Philox(key=self.key, counter=[0, 0, 0, self.trial]))

    def uniform(self, count: int) -> NDArray[np.float64]:
        """Return `count` uniform numbers in [0, 1)."""
        out = np.empty((1, count))
        compile_world().draw_uniform(self.key, self.trial, 0.0, 1.0, out)
        return np.asarray(out[0])

    def noise(self, tiles: NDArray[np.int32]) -> NDArray[np.float64]:
        """Return a uniform number in [0, 1) for each of tiles (tick, robot, 2), always the same one for a tile."""
        if not_compiled():  # a loop over tiles would take ten seconds
            from swarmcensus.engine import block, counter, unit  # loads Numba

            place = counter(TILE_ZERO + tiles[..., 0], TILE_ZERO + tiles[..., 1])
            return np.asarray(unit(block(*self.key, counter(self.trial, 0), place)[0]))
        out = np.empty(tiles.shape[:2])
        compile_world("scores").noise(tiles, self.key, self.trial, out)
        return out
