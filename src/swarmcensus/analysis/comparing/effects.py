"""By how much contenders differ from a reference, in each world or pooled over worlds that share some coordinates."""

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from swarmcensus.analysis.comparing.pair_tests import ALPHA, Contest, ends_of_pairs
from swarmcensus.analysis.comparing.standings import Standings
from swarmcensus.summaries import Measure
from swarmcensus.support.bootstrap import centres, intervals
from swarmcensus.support.intervals import Floats
from swarmcensus.support.significance import differences, holm, paired_tests


class Effect(NamedTuple):
    """The differences of a measure between contenders and the reference, (row, contender).

    `low` and `high` are the ends of 95 % intervals over trials. NaN is a missing contender, or interval.
    """

    measure: Measure
    value: Floats
    low: Floats
    high: Floats
    apart: NDArray[np.bool_]


def effects(standings: Standings, reference: int, by: Sequence[str] | None) -> tuple[list[Any], list[Effect]]:
    """Rows of worlds, each with its common coordinates and number of worlds, and the effect of each measure.

    Without `by` each world is a row, with the effects of `Comparison.pairs`. With `by`, worlds that agree in these
    coordinates are one row: a trial's differences in all worlds that both contenders have met are reduced to their
    median or mean, and tests are corrected for the number of rows, contenders and measures. Raises InputError as
    `Comparison.by` does.
    """
    both = list(zip(standings.measures, standings.contests, strict=True))
    if by is None:
        return [(world, 1) for world in standings.grid.worlds], [_of_worlds(*each, reference) for each in both]
    groups = standings.worlds_by(by)
    pooled = [_pooled(standings, *each, reference, list(groups.values())) for each in both]
    tested = zip([effect for effect, _ in pooled], holm(np.array([p for _, p in pooled])), strict=True)
    apart = [effect._replace(apart=effect.apart & (p <= ALPHA)) for effect, p in tested]
    return [(dict(zip(by, key, strict=True)), len(worlds)) for key, worlds in groups.items()], apart


def _of_worlds(measure: Measure, contest: Contest, reference: int) -> Effect:
    value, low, high = np.full((3, *contest.values.shape), np.nan)
    apart = np.zeros(contest.values.shape, np.bool_)
    first, second = ends_of_pairs(contest.values.shape[1])
    for k in np.flatnonzero((first == reference) | (second == reference)):
        contender, sign = (first[k], 1.0) if second[k] == reference else (second[k], -1.0)
        # + 0.0, as a difference of none should not be -0.0
        value[:, contender] = sign * contest.difference[:, k] + 0.0
        ends = np.stack([sign * end[:, k] for end in contest.difference_ends])
        low[:, contender], high[:, contender] = np.sort(ends, axis=0)
        apart[:, contender] = contest.apart[:, k]
    return Effect(measure, value, low, high, apart)


def _pooled(
    standings: Standings, measure: Measure, contest: Contest, reference: int, groups: Sequence[NDArray[np.intp]]
) -> tuple[Effect, Floats]:
    """The effect in groups of worlds, and p-values; its `apart` tells where value and test have the same sign."""
    numbers = contest.numbers
    shape = len(groups), numbers.shape[1]
    pooled = np.full((*shape, numbers.shape[2]), np.nan)
    for row, worlds in enumerate(groups):
        for who in range(shape[1]):
            met = worlds[(standings.settings[worlds][:, [who, reference]] >= 0).all(axis=1)]
            if who != reference and met.size:
                each = differences(numbers[met, who], numbers[met, reference])
                # a trial counts only with all worlds: else trials would be about different worlds
                whole = ~np.isnan(each).any(axis=0)
                pooled[row, who, whole] = centres(each[:, whole].T, measure.statistic)
    value, tests = centres(pooled, measure.statistic), paired_tests(pooled)
    low, high = (end.reshape(shape) for end in intervals(pooled.reshape(-1, pooled.shape[-1]), measure.statistic))
    agree = np.sign(value) * np.sign(tests.balance) >= 0
    return Effect(measure, value, low, high, agree), np.where(np.isnan(value), np.nan, tests.p)
