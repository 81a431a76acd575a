"""Intervals by bootstrap over trials of many rows at once: of means and of medians, infinite ones too.

Percentile intervals, made wider for few trials, as Hesterberg proposes in "What teachers should know about the
bootstrap", 2015. Medians take the percentiles at which the interval of a normal mean would be Student's. Means keep the
usual ones, and their distances from the mean are stretched by as much, for the ends of few resamples are too near.
"""

from statistics import NormalDist
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from swarmcensus.statistics.intervals import FEWEST, LEVEL, ROUNDING, resample, student

RESAMPLES = 2000
BLOCK = 2**21  # numbers that are held at once

Floats = NDArray[np.float64]
Statistic = Literal["median", "mean"]


def centres(values: Floats, statistic: Statistic) -> Floats:
    """The median or mean along the last axis without NaN; NaN of nothing, and 0 half way between both infinities."""
    count = (~np.isnan(values)).sum(axis=-1)
    if statistic == "mean":
        with np.errstate(invalid="ignore", divide="ignore"):
            return np.asarray(np.nansum(values, axis=-1) / count)
    ordered = np.sort(values, axis=-1)  # NaN last
    at = np.stack([np.maximum(count - 1, 0) // 2, count // 2], axis=-1)
    ends = np.take_along_axis(ordered, np.minimum(at, values.shape[-1] - 1), axis=-1)
    middle = _halfway(ends[..., 0], ends[..., 1])
    return np.where(count > 0, middle, np.nan)


def intervals(values: Floats, statistic: Statistic, level: float = LEVEL) -> tuple[Floats, Floats]:
    """The ends of the intervals of `centres` of `values` (row, trial), each (row,); a NaN is a trial that is not there.

    NaN for fewer than 6 trials, for trials that are all equal, which tell of no spread, and for an infinite mean. The
    same values give the same numbers.
    """
    ordered = np.sort(values, axis=1)
    count = (~np.isnan(values)).sum(axis=1)
    low, high = np.full((2, len(values)), np.nan)
    for trials in np.unique(count[count >= FEWEST]).tolist():
        rows = np.flatnonzero(count == trials)
        mine = ordered[rows, :trials]
        with np.errstate(invalid="ignore"):
            told = mine[:, -1] - mine[:, 0] > ROUNDING * np.abs(mine[:, [0, -1]]).max(axis=1)
        told |= (mine[:, -1] != mine[:, 0]) & ~np.isfinite(mine[:, [0, -1]]).all(axis=1)
        told &= (statistic == "median") | np.isfinite(mine).all(axis=1)
        kinds, which = np.unique(mine[told], axis=0, return_inverse=True)
        ends = _of_medians(kinds, level) if statistic == "median" else _of_means(kinds, level)
        low[rows[told]], high[rows[told]] = ends[:, which.ravel()]
    return low, high


def _errors(trials: int, level: float) -> float:
    """How many of the bootstrap's own standard errors hold the middle `level` of a mean of so many."""
    return float(np.sqrt(trials / (trials - 1)) * student(trials, level))


def _of_means(values: Floats, level: float) -> Floats:
    trials = values.shape[1]
    counts = resample(trials, RESAMPLES)[1:] / trials
    tail, means = (1 - level) / 2, values.mean(axis=1)
    ends = np.empty((2, len(values)))
    step = max(1, BLOCK // RESAMPLES)
    for first in range(0, len(values), step):
        rows = slice(first, first + step)
        ends[:, rows] = np.quantile(values[rows] @ counts.T, [tail, 1 - tail], axis=1)
    stretched: Floats = means + (ends - means) * _errors(trials, level) / NormalDist().inv_cdf(1 - tail)
    return stretched


def _of_medians(ordered: Floats, level: float) -> Floats:
    """Of rows in rising order: which places a resample's median is half way between does not depend on the values."""
    trials = ordered.shape[1]
    seen = np.cumsum(resample(trials, RESAMPLES)[1:], axis=1)
    middles = [np.argmax(seen > rank, axis=1) for rank in ((trials - 1) // 2, trials // 2)]
    places, often = np.unique(np.stack(middles, axis=1), axis=0, return_counts=True)
    tail = NormalDist().cdf(-_errors(trials, level))
    ends = np.empty((2, len(ordered)))
    step = max(1, BLOCK // len(places))
    for first in range(0, len(ordered), step):
        rows = slice(first, first + step)
        found = _halfway(ordered[rows][:, places[:, 0]], ordered[rows][:, places[:, 1]])
        order = np.argsort(found, axis=1)
        upto = np.cumsum(often[order], axis=1)
        for k, share in enumerate((tail, 1 - tail)):
            at = np.argmax(upto >= share * RESAMPLES, axis=1)
            chosen = np.take_along_axis(order, at[:, np.newaxis], axis=1)
            ends[k, rows] = np.take_along_axis(found, chosen, axis=1)[:, 0]
    return ends


def _halfway(one: Floats, other: Floats) -> Floats:
    with np.errstate(invalid="ignore"):
        middle = one + (other - one) / 2
    infinite = np.where(one == -other, 0.0, np.where(np.isinf(one), one, other))
    return np.where(np.isfinite(one) & np.isfinite(other), middle, infinite)
