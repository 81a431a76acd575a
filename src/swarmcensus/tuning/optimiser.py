"""The search: CMA-ES, by the library cma, over the places of values in their ranges.

It asks for a generation of candidates and is told how bad each is. Of these only the order counts. With the same seed
and told the same, it asks for the same.

CMA-ES learns from the order of a generation, and has nothing to learn from one whose candidates are all as bad. Such a
generation is no end of a search. As long as no generation has candidates that differ in the metric, candidates are
drawn from the whole of the ranges as well, and the search begins anew around the best of them where that is better than
all before. Once some have differed, a generation that is flat makes the next one wider.
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
WIDEN = 1.5  # times as wide is the generation after one whose candidates were all as bad
WIDEST = 1 / 3  # standard deviations in [0, 1]: the library goes no further either
STEPS = 0.3  # of whole numbers: a search that is narrower than this would try one of them only


class Search:
    """Generations of candidates, each a value for every range."""

    def __init__(self, ranges: Sequence[Range], start: Sequence[float], seed: int) -> None:
        """Begin around the start. Raises InputError where the library is not installed."""
        self.ranges = ranges
        self._random = np.random.default_rng(seed)
        lacking = max(0, FEWEST - len(ranges))
        self._asked: list[Any] = []
        self._best: tuple[float, ...] | None = None  # how bad the best candidate of all generations was
        self._everywhere = False  # whether the next generation is drawn from the whole of the ranges
        self.differed = False  # whether any generation had candidates that differ in the metric, ties not broken
        self.drawn = 0  # generations from the whole of the ranges
        self._begin([one.share(value) for one, value in zip(ranges, start, strict=True)] + [0.5] * lacking)

    def _begin(self, places: Sequence[float]) -> None:
        """Begin, or begin anew, around some places."""
        least = [STEPS * one.step for one in self.ranges] + [0.0] * (len(places) - len(self.ranges))
        size = AS_MANY * (4 + int(3 * math.log(len(places))))
        options = {
            "bounds": [0, 1], "popsize": size, "minstd": least, "verbose": -9, "seed": np.nan, "randn": self._normal,
        }  # fmt: skip  # seed: the library's would be that of all of NumPy
        self._strategy: Any = library().CMAEvolutionStrategy(places, WIDTH, options)
        self._middles: list[Any] = []
        self._centre = places

    def _normal(self, *shape: int) -> Any:
        return self._random.standard_normal(shape)

    @property
    def size(self) -> int:
        """How many candidates a generation has."""
        return int(self._strategy.popsize)

    @property
    def ended(self) -> bool:
        """Whether it has narrowed down to one candidate, in the digits in which values are written.

        Whole numbers alone never end it: its generations are always wide enough to try the next ones.
        """
        whole = all(one.scale == "whole" for one in self.ranges)
        return self.differed and not whole and len({self._values(one) for one in self._asked}) == 1

    def ask(self) -> list[tuple[float, ...]]:
        """The next generation's values."""
        self._asked = self._from_everywhere() if self._everywhere else self._strategy.ask()
        return [self._values(one) for one in self._asked]

    def _from_everywhere(self) -> list[Any]:
        """A Latin hypercube: of as many equal parts of a range as there are candidates, each has one."""
        parts = np.tile(np.arange(self.size), (len(self._centre), 1))
        return list((self._random.permuted(parts, axis=1).T + self._random.random(parts.T.shape)) / self.size)

    def tell(self, losses: Sequence[Sequence[float]]) -> None:
        """How bad each of them is: numbers of which the next counts where those before are the same."""
        order = np.unique(np.array(losses), axis=0, return_inverse=True)[1].ravel()
        best, flat = min(map(tuple, losses)), not order.any()
        self.differed |= len({loss[0] for loss in losses}) > 1
        if self._everywhere:
            self.drawn += 1
            if not flat and (self._best is None or best < self._best):
                self._begin(list(self._asked[int(np.argmin(order))]))
        elif flat:
            self._widen()
        else:
            self._strategy.tell(self._asked, order.tolist())
            worst = max(loss[0] for loss in losses)
            half = np.argsort(order, kind="stable")[: len(order) // 2].tolist()
            better = [k for k in half if losses[k][0] < worst] or half  # few may be any good in the metric
            weights = np.log(len(better) + 0.5) - np.log(np.arange(1, len(better) + 1))
            self._middles.append(np.average([self._asked[k] for k in better], axis=0, weights=weights))
        self._best = best if self._best is None else min(best, self._best)
        self._everywhere = not self.differed and (flat or not self._everywhere)

    def _widen(self) -> None:
        if max(self._strategy.stds) * WIDEN <= WIDEST:
            self._strategy.sigma *= WIDEN

    @property
    def favourite(self) -> tuple[float, ...]:
        """The middle of the better halves of the last generations: what they agree on, not one's luckiest candidate.

        The library's own, the image of its distribution's mean, is at the very end of a range where the distribution
        reaches over it.
        """
        last = self._middles[-math.ceil(len(self._middles) * LAST) :] or [self._centre]
        return self._values(np.mean(last, axis=0))

    def _values(self, places: Any) -> tuple[float, ...]:
        return tuple(one.value(float(place)) for one, place in zip(self.ranges, places, strict=False))


def library() -> Any:
    """The package cma. Raises InputError where it is not installed."""
    try:
        import cma
    except ImportError:
        raise InputError("tuning needs the package cma: pip install 'swarmcensus[tune]'") from None
    return cma
