"""By how much contenders differ from one of them, in each world or pooled over worlds that share some coordinates."""

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from swarmcensus.comparing.groups import worlds_by
from swarmcensus.comparing.pair_tests import ALPHA, Contest, pairs_of
from swarmcensus.comparing.standings import Standings
from swarmcensus.results import measures
from swarmcensus.results.measures import Measure
from swarmcensus.statistics.bootstrap import centres, intervals
from swarmcensus.statistics.corrections import holm
from swarmcensus.statistics.signed_ranks import differences, signed_ranks

Floats = NDArray[np.float64]


class Effect(NamedTuple):
    """What contenders have of a measure less what the one has that they are held against, each (row, contender).

    NaN is a contender that is not there, and of `low` and `high`, the ends of 95 % intervals over trials, one without.
    """

    measure: Measure
    value: Floats
    low: Floats
    high: Floats
    apart: NDArray[np.bool_]


def effects(data: xr.Dataset, found: Standings, mark: int, by: Sequence[str] | None) -> tuple[list[Any], list[Effect]]:
    """The rows, by what their worlds have in common, with how many these are, and the effect of each measure.

    `data` are the settings that were compared. Without `by` each world is a row, whose effects are those of `pairs`.
    Else worlds that are alike in these coordinates are one: of each trial the differences in all of them that both have
    met count as one, their median or mean, and its tests are corrected for being as many as there are rows, contenders
    and measures. Raises InputError as `Comparison.by` does.
    """
    if by is None:
        rows = [(world, 1) for world in found.field.worlds]
        return rows, [_of_worlds(one, two, mark) for one, two in zip(found.measures, found.contests, strict=True)]
    groups = worlds_by(found, by)
    pooled = [_pooled(data, found, one, mark, list(groups.values())) for one in found.measures]
    p = holm(np.array([p for _, p in pooled]))
    kept = [effect._replace(apart=effect.apart & (mine <= ALPHA)) for (effect, _), mine in zip(pooled, p, strict=True)]
    return [(dict(zip(by, key, strict=True)), len(worlds)) for key, worlds in groups.items()], kept


def _of_worlds(measure: Measure, contest: Contest, mark: int) -> Effect:
    shape = contest.values.shape
    value, low, high = np.full((3, *shape), np.nan)
    apart = np.zeros(shape, np.bool_)
    for k, (one, other) in enumerate(pairs_of(shape[1])):
        if mark not in (one, other):
            continue
        who, sign = (one, 1.0) if other == mark else (other, -1.0)
        value[:, who] = sign * contest.difference[:, k] + 0.0
        ends = np.stack([sign * end[:, k] for end in contest.difference_ends])
        low[:, who], high[:, who] = np.sort(ends, axis=0)
        apart[:, who] = contest.apart[:, k]
    return Effect(measure, value, low, high, apart)


def _pooled(
    data: xr.Dataset, found: Standings, measure: Measure, mark: int, groups: Sequence[NDArray[np.intp]]
) -> tuple[Effect, Floats]:
    """The effect of groups of worlds, of which `apart` says where test and value agree, and the tests' p-values."""
    numbers = found.field.spread(measures.numbers(data, measure.name))
    shape = len(groups), numbers.shape[1]
    off = np.full((*shape, numbers.shape[2]), np.nan)
    for row, worlds in enumerate(groups):
        for who in range(shape[1]):
            met = worlds[(found.settings[worlds][:, [who, mark]] >= 0).all(axis=1)]
            if who != mark and met.size:
                each = differences(numbers[met, who], numbers[met, mark])
                whole = ~np.isnan(each).any(axis=0)
                off[row, who, whole] = centres(each[:, whole].T, measure.statistic)
    value, tests = centres(off, measure.statistic), signed_ranks(off)
    low, high = (end.reshape(shape) for end in intervals(off.reshape(-1, off.shape[-1]), measure.statistic))
    agree = np.sign(value) * np.sign(tests.balance) >= 0
    return Effect(measure, value, low, high, agree), np.where(np.isnan(value), np.nan, tests.p)
