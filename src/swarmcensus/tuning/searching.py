"""The search: CMA-ES, by the library cma, over the places of values in their ranges.

It asks for a generation of candidates and is told how bad each is. Of these only the order counts. With the same seed
and told the same, it asks for the same.
"""

import math
from collections.abc import Sequence
from typing import Any

import numpy as np

from swarmcensus.basics.errors import InputError
from swarmcensus.tuning.ranges import Range

WIDTH = 0.25  # of the first generation, as a standard deviation in [0, 1]
LAST = 0.25  # of the generations: these make the winner
FEWEST = 2  # dimensions that the library searches: of one parameter there is a second one that means nothing
AS_MANY = 2  # times the candidates a generation that the library would have: trials are noisy, and more average out
STEPS = 0.3  # of whole numbers: a search that is narrower than this would try one of them only


class Search:
    """Generations of candidates, each a value for every range."""

    def __init__(self, ranges: Sequence[Range], start: Sequence[float], seed: int) -> None:
        """Begin around the start. Raises InputError where the library is not installed."""
        self.ranges = ranges
        self._random = np.random.default_rng(seed)
        lacking = max(0, FEWEST - len(ranges))
        places = [one.share(value) for one, value in zip(ranges, start, strict=True)] + [0.5] * lacking
        least = [STEPS * one.step for one in ranges] + [0.0] * lacking
        size = AS_MANY * (4 + int(3 * math.log(len(places))))
        options = {
            "bounds": [0, 1], "popsize": size, "minstd": least, "verbose": -9, "seed": np.nan, "randn": self._normal,
        }  # fmt: skip  # seed: the library's would be that of all of NumPy
        self._strategy: Any = library().CMAEvolutionStrategy(places, WIDTH, options)
        self._asked: list[Any] = []
        self._middles: list[Any] = []

    def _normal(self, *shape: int) -> Any:
        return self._random.standard_normal(shape)

    @property
    def size(self) -> int:
        """How many candidates a generation has."""
        return int(self._strategy.popsize)

    @property
    def ended(self) -> bool:
        """Whether it has narrowed down so far, or sees so little change, that more would find nothing."""
        return bool(self._strategy.stop())

    def ask(self) -> list[tuple[float, ...]]:
        """The next generation's values."""
        self._asked = self._strategy.ask()
        return [self._values(one) for one in self._asked]

    def tell(self, losses: Sequence[float]) -> None:
        """How bad each of them is."""
        self._strategy.tell(self._asked, list(losses))
        better = np.argsort(losses, kind="stable")[: len(losses) // 2]
        weights = np.log(len(better) + 0.5) - np.log(np.arange(1, len(better) + 1))
        self._middles.append(np.average([self._asked[k] for k in better], axis=0, weights=weights))

    @property
    def favourite(self) -> tuple[float, ...]:
        """The middle of the better halves of the last generations: what they agree on, not one's luckiest candidate.

        The library's own, the image of its distribution's mean, is at the very end of a range where the distribution
        reaches over it.
        """
        return self._values(np.mean(self._middles[-math.ceil(len(self._middles) * LAST) :], axis=0))

    def _values(self, places: Any) -> tuple[float, ...]:
        return tuple(one.value(float(place)) for one, place in zip(self.ranges, places, strict=False))


def library() -> Any:
    """The package cma. Raises InputError where it is not installed."""
    try:
        import cma
    except ImportError:
        raise InputError("tuning needs the package cma: pip install 'swarmcensus[tune]'") from None
    return cma
