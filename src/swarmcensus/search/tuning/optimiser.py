"""The optimiser: CMA-ES, by the library cma, over positions of values in their ranges.

It proposes a generation of candidates and receives their losses, of which only the order counts. With the same seed and
losses it proposes the same candidates.

CMA-ES cannot learn from a generation in which all losses are equal (a flat one), but the search goes on.
While no generation has had candidates that differ in the metric, generations are also drawn from the whole ranges, and
the search restarts around the best of such a generation if it is better than all before. Afterwards a flat generation
widens the next.
"""

import math
from collections.abc import Sequence
from typing import Any

import numpy as np

from swarmcensus.search.tuning.ranges import Range
from swarmcensus.support.errors import InputError

WIDTH = 0.25  # of the first generation, as a standard deviation in [0, 1]
LAST_SHARE = 0.25  # share of generations, the last ones, from which the winner is computed
FEWEST = 2  # dimensions that the library can search: a single parameter gets a second one without meaning
POPULATION_FACTOR = 2  # times the library's candidates of a generation: trials are noisy, and more average out
WIDEN = 1.5  # factor by which a flat generation widens the next
WIDEST = 1 / 3  # largest standard deviation in [0, 1], as in the library
LEAST_STEPS = 0.3  # of whole numbers: a search that is narrower than this would try one of them only


class Search:
    """Proposes generations of candidates, each a value for every range."""

    def __init__(self, ranges: Sequence[Range], start: Sequence[float], seed: int) -> None:
        """Begin around the start. Raises InputError if the library is not installed."""
        self.ranges = ranges
        self._random = np.random.default_rng(seed)
        lacking = max(0, FEWEST - len(ranges))
        self._proposed: list[Any] = []
        self._best: tuple[float, ...] | None = None  # the losses of the best candidate so far
        self._everywhere = False  # whether the next generation is drawn from the whole ranges
        self.differed = False  # whether any generation had candidates that differ in the metric, before breaking ties
        self._begin([range_.share(value) for range_, value in zip(ranges, start, strict=True)] + [0.5] * lacking)

    def _begin(self, places: Sequence[float]) -> None:
        """Start, or restart, around these positions."""
        least = [LEAST_STEPS * range_.step for range_ in self.ranges] + [0.0] * (len(places) - len(self.ranges))
        size = POPULATION_FACTOR * (4 + int(3 * math.log(len(places))))
        options = {
            "bounds": [0, 1], "popsize": size, "minstd": least, "verbose": -9, "seed": np.nan,
            "randn": lambda *shape: self._random.standard_normal(shape),
        }  # fmt: skip  # a seed would set that of NumPy itself
        self._strategy: Any = library().CMAEvolutionStrategy(places, WIDTH, options)
        self._middles: list[Any] = []
        self._centre = places

    @property
    def size(self) -> int:
        """The number of candidates of a generation."""
        return int(self._strategy.popsize)

    @property
    def ended(self) -> bool:
        """Whether the search has narrowed to one candidate, in the digits in which values are written.

        It never ends if all ranges are of whole numbers: generations stay wide enough to try neighbouring numbers.
        """
        whole = all(range_.scale == "whole" for range_ in self.ranges)
        return self.differed and not whole and len({self._values(places) for places in self._proposed}) == 1

    def ask(self) -> list[tuple[float, ...]]:
        """The values of the next generation's candidates.

        Those from the whole ranges are a Latin hypercube: each range is cut into as many equal parts as there are
        candidates, each used once.
        """
        if self._everywhere:
            parts = np.tile(np.arange(self.size), (len(self._centre), 1))
            places = (self._random.permuted(parts, axis=1).T + self._random.random(parts.T.shape)) / self.size
        self._proposed = list(places) if self._everywhere else self._strategy.ask()
        return [self._values(places) for places in self._proposed]

    def tell(self, losses: Sequence[Sequence[float]]) -> None:
        """Receive each candidate's losses, where later numbers break ties of earlier ones."""
        order = np.unique(np.array(losses), axis=0, return_inverse=True)[1].ravel()
        best, flat = min(map(tuple, losses)), not order.any()
        self.differed |= len({loss[0] for loss in losses}) > 1
        if self._everywhere:
            if not flat and (self._best is None or best < self._best):
                self._begin(list(self._proposed[int(np.argmin(order))]))
        elif flat:
            if max(self._strategy.stds) * WIDEN <= WIDEST:
                self._strategy.sigma *= WIDEN
        else:
            self._strategy.tell(self._proposed, order.tolist())
            worst = max(loss[0] for loss in losses)
            half = np.argsort(order, kind="stable")[: len(order) // 2].tolist()
            better = [k for k in half if losses[k][0] < worst] or half  # leaves out those as bad as the worst
            weights = np.log(len(better) + 0.5) - np.log(np.arange(1, len(better) + 1))
            self._middles.append(np.average([self._proposed[k] for k in better], axis=0, weights=weights))
        self._best = best if self._best is None else min(best, self._best)
        self._everywhere = not self.differed and (flat or not self._everywhere)

    @property
    def favourite(self) -> tuple[float, ...]:
        """The mean of the better halves of the last generations, which is less noisy than the best candidate.

        The library's own result, the mean of its distribution, would be at the end of a range if the distribution
        reaches beyond it.
        """
        last = self._middles[-math.ceil(len(self._middles) * LAST_SHARE) :] or [self._centre]
        return self._values(np.mean(last, axis=0))

    def _values(self, places: Any) -> tuple[float, ...]:
        return tuple(range_.value(float(place)) for range_, place in zip(self.ranges, places, strict=False))


def library() -> Any:
    """The package cma. Raises InputError if it is not installed."""
    try:
        import cma
    except ImportError:
        raise InputError("tuning needs the package cma: pip install 'swarmcensus[tune]'") from None
    return cma
