"""The statistics of a comparison: every pair of contenders in every world, trial by trial, corrected for being many."""

from dataclasses import dataclass, replace
from itertools import combinations
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from swarmcensus.statistics.bootstrap import Statistic, centres, intervals
from swarmcensus.statistics.corrections import holm
from swarmcensus.statistics.intervals import LEVEL
from swarmcensus.statistics.rankings import friedman
from swarmcensus.statistics.signed_ranks import SignedRanks, differences, midranks, signed_ranks

ALPHA = 1 - LEVEL
BLOCK = 2**22  # numbers that are compared at once

Floats = NDArray[np.float64]


class Asked(NamedTuple):
    """What a contest is about: numbers (world, contender, trial), their statistic over trials, and what they are like.

    NaN is a trial that is not there, infinity one in which what is measured never came.
    """

    numbers: Floats
    statistic: Statistic
    low: bool = True
    share: bool = False


@dataclass(frozen=True)
class Contest:
    """One measure: contenders and pairs of them in worlds, (world, contender) and (world, pair), NaN where lacking.

    A pair's `difference` is its first contender less its second. `ranks` (trial, contender) are summed over the worlds
    that all contenders have met, and centred: of `duels` (pair,), the tests over all these worlds, each trial has one
    number, the share of worlds in which the first is ahead, less that in which it is behind. `corrected` and
    `duels_corrected` are the p-values after Holm's correction for all tests of all measures of a comparison;
    `friedman_corrected` is Friedman's, corrected for the measures alone.
    """

    low: bool  # is better
    values: Floats
    value_ends: tuple[Floats, Floats]
    trials: NDArray[np.int64]
    difference: Floats
    difference_ends: tuple[Floats, Floats]
    tests: SignedRanks
    met: NDArray[np.bool_]  # by all contenders, (world,)
    ranks: Floats
    ahead: Floats  # the mean of those numbers over trials, (pair,)
    duels: SignedRanks
    friedman: tuple[float, float]  # Q and p
    corrected: Floats
    duels_corrected: Floats
    friedman_corrected: float = np.nan

    @property
    def differ(self) -> bool:
        """Whether Friedman's test finds that contenders differ over all worlds, whoever they are."""
        return self.friedman_corrected <= ALPHA

    @property
    def apart(self) -> NDArray[np.bool_]:
        """Which pairs are told apart in which worlds, (world, pair): where the difference points as the test does."""
        agree = np.sign(self.difference) * np.sign(self.tests.balance) >= 0
        return np.asarray((self.corrected <= ALPHA) & agree)

    @property
    def alike(self) -> NDArray[np.bool_]:
        """Which pairs have met, and had the same number in every trial of every world, (pair,)."""
        differ = (self.tests.below + self.tests.above).sum(axis=0)
        return np.asarray((differ == 0) & (self.tests.equal.sum(axis=0) > 0))

    @property
    def average_ranks(self) -> Floats:
        """The mean rank of each contender, 1 the best, over the trials and worlds that all have met; NaN without."""
        if not len(self.ranks):
            return np.full(self.values.shape[1], np.nan)
        return np.asarray(self.ranks.mean(axis=0) / self.met.sum() + (self.values.shape[1] + 1) / 2)

    @property
    def duels_apart(self) -> NDArray[np.bool_]:
        """Which pairs are told apart over all worlds, (pair,): where the mean of `ahead` points as the test does."""
        agree = np.sign(self.ahead) * np.sign(self.duels.balance) >= 0
        return np.asarray((self.duels_corrected <= ALPHA) & agree)

    def shares(self, pair: int) -> tuple[float, float]:
        """In what share of trials, in the worlds that all have met, the first of a pair is better, and worse."""
        tests = self.tests
        below, equal, above = (int(part[self.met, pair].sum()) for part in (tests.below, tests.equal, tests.above))
        better, worse = (below, above) if self.low else (above, below)
        return better / (below + equal + above), worse / (below + equal + above)


def pairs_of(contenders: int) -> list[tuple[int, int]]:
    """The pairs of so many contenders, in the order of every array of pairs."""
    return list(combinations(range(contenders), 2))


def contests(measures: list[Asked], with_intervals: bool = True, against: int | None = None) -> list[Contest]:
    """The contest of each measure; without intervals, and Friedman's test, which take the most time, these are NaN.

    With `against` only pairs with that contender are tested. All tests of pairs, of all measures, are one family: if no
    contender differs from another, anything is told apart in at most 5 % of comparisons. Friedman's tests, one a
    measure, are a family of their own: they ask whether contenders differ at all, and tell no two apart.
    """
    found = [_contest(one, with_intervals, against) for one in measures]
    tested = [part.ravel() for one in found for part in (one.corrected, one.duels_corrected)]
    corrected = holm(np.concatenate(tested)) if tested else np.zeros(0)
    at = 0
    for one in found:
        for part in (one.corrected, one.duels_corrected):
            part[...] = corrected[at : at + part.size].reshape(part.shape)
            at += part.size
    overall = holm(np.array([one.friedman[1] for one in found]))
    return [replace(one, friedman_corrected=float(p)) for one, p in zip(found, overall, strict=True)]


def _contest(asked: Asked, with_intervals: bool, against: int | None) -> Contest:
    numbers, statistic, low, share = asked
    worlds, contenders, trials = numbers.shape
    most = 1.0 if share else np.inf
    first, second = np.array(pairs_of(contenders), np.intp).reshape(-1, 2).T
    shape = worlds, len(first)
    tested = np.full(len(first), True) if against is None else (first == against) | (second == against)
    parts: list[tuple[Floats, Floats, Floats, SignedRanks]] = []
    step = max(1, BLOCK // max(1, len(first) * trials))
    for start in range(0, worlds, step):
        some = numbers[start : start + step]
        off = differences(some[:, first], some[:, second])
        ends = _ends(off, statistic, with_intervals, -most, most)
        parts.append((centres(off, statistic), *ends, signed_ranks(off)))
    difference, lowest, highest = (np.concatenate([part[k] for part in parts]) for k in range(3))
    tests = SignedRanks(*(np.concatenate(columns) for columns in zip(*(part[3] for part in parts), strict=True)))
    there = tests.below + tests.equal + tests.above > 0
    p = np.where(there & tested, tests.p, np.nan).reshape(shape)
    met = np.asarray(np.all(np.any(~np.isnan(numbers), axis=2), axis=1))
    ranks, ahead = _over_worlds(numbers[met], low, first, second)
    duels = signed_ranks(ahead.T)
    told = (
        (duels.below + duels.equal + duels.above > 0) & (met.sum() > 1) & tested
    )  # in one, the world's own tests say it all
    return Contest(
        low=low,
        values=centres(numbers, statistic),
        value_ends=_ends(numbers, statistic, with_intervals, 0.0 if share else -np.inf, most),
        trials=np.asarray((~np.isnan(numbers)).sum(axis=2)),
        difference=difference,
        difference_ends=(lowest, highest),
        tests=tests,
        met=met,
        ranks=ranks,
        ahead=centres(ahead.T, "mean"),
        duels=duels,
        friedman=friedman(ranks) if len(ranks) and contenders > 1 and with_intervals else (np.nan, np.nan),
        corrected=p,
        duels_corrected=np.where(told, duels.p, np.nan),
    )


def _ends(values: Floats, statistic: Statistic, wanted: bool, least: float, most: float) -> tuple[Floats, Floats]:
    if not wanted:
        return np.full(values.shape[:-1], np.nan), np.full(values.shape[:-1], np.nan)
    low, high = np.clip(intervals(values.reshape(-1, values.shape[-1]), statistic), least, most)
    return low.reshape(values.shape[:-1]), high.reshape(values.shape[:-1])


def _over_worlds(
    numbers: Floats, low: bool, first: NDArray[np.intp], second: NDArray[np.intp]
) -> tuple[Floats, Floats]:
    """Of the trials that all contenders have in all these worlds: the sums of centred ranks over the worlds
    (trial, contender), the best lowest, and the share of worlds in which the first of each pair is ahead, less that in
    which it is behind (trial, pair).
    """
    whole = ~np.isnan(numbers).any(axis=(0, 1)) & bool(len(numbers))
    mine = numbers[:, :, whole] if low else -numbers[:, :, whole]
    contenders, trials = mine.shape[1:]
    ranks, ahead = np.zeros((trials, contenders)), np.zeros((trials, len(first)))
    step = max(1, BLOCK // max(1, len(first) * trials))
    for start in range(0, len(mine), step):
        some = mine[start : start + step]
        off = np.sign(differences(some[:, first], some[:, second]))
        ahead -= off.sum(axis=0).T
        # a rank is 1 and the number of those that are better, where equal ones count a half
        for k, (one, other) in enumerate(zip(first.tolist(), second.tolist(), strict=True)):
            behind = off[:, k].sum(axis=0) / 2
            ranks[:, one] += behind
            ranks[:, other] -= behind
    return ranks, ahead / max(len(mine), 1)


def world_ranks(values: Floats, low: bool) -> Floats:
    """The rank of each contender by its value in each world (world, contender), 1 the best; NaN where it is lacking."""
    return midranks(values if low else -values)
