"""Bootstrap intervals over trials for the means or medians of many rows at once; medians may be infinite.

These are percentile intervals, widened for few trials as in Hesterberg, "What teachers should know about the
bootstrap", 2015. For medians, the percentiles are those at which the interval of a normal mean would be Student's. For
means, the usual percentiles are used, and their distances from the mean are stretched by the same factor, because
extreme percentiles of few resamples lie too close to the mean.
"""

from statistics import NormalDist
from typing import Literal

import numpy as np

from swarmcensus.support.intervals import FEWEST, LEVEL, ROUNDING, Floats, resample, student

RESAMPLES = 2000
BLOCK = 2**21  # numbers in memory at once
Statistic = Literal["median", "mean"]


def centres(values: Floats, statistic: Statistic) -> Floats:
    """The median or mean along the last axis, ignoring NaN.

    NaN if there are no values. The median between minus and plus infinity is 0.
    """
    count = (~np.isnan(values)).sum(axis=-1)
    if statistic == "mean":
        with np.errstate(invalid="ignore", divide="ignore"):
            return np.asarray(np.nansum(values, axis=-1) / count)
    ordered = np.sort(values, axis=-1)  # NaN last
    places = np.stack([np.maximum(count - 1, 0) // 2, count // 2], axis=-1)
    ends = np.take_along_axis(ordered, np.minimum(places, values.shape[-1] - 1), axis=-1)
    middle = _halfway(ends[..., 0], ends[..., 1])
    return np.where(count > 0, middle, np.nan)


def intervals(values: Floats, statistic: Statistic, level: float = LEVEL) -> tuple[Floats, Floats]:
    """The lower and upper ends, each (row,), of the intervals of `centres(values)`; `values` are (row, trial).

    A NaN value is a missing trial. The ends are NaN for fewer than 6 trials, for trials that are all equal, and for an
    infinite mean. The same values always give the same numbers.
    """
    ordered = np.sort(values, axis=1)
    count = (~np.isnan(values)).sum(axis=1)
    low, high = np.full((2, len(values)), np.nan)
    for trials in np.unique(count[count >= FEWEST]).tolist():
        rows = np.flatnonzero(count == trials)
        present = ordered[rows, :trials]
        extremes = present[:, [0, -1]]
        with np.errstate(invalid="ignore"):
            varied = present[:, -1] - present[:, 0] > ROUNDING * np.abs(extremes).max(axis=1)
        varied |= (present[:, -1] != present[:, 0]) & ~np.isfinite(extremes).all(axis=1)
        varied &= (statistic == "median") | np.isfinite(present).all(axis=1)
        distinct, which = np.unique(present[varied], axis=0, return_inverse=True)
        ends = _of_medians(distinct, level) if statistic == "median" else _of_means(distinct, level)
        low[rows[varied]], high[rows[varied]] = ends[:, which.ravel()]
    return low, high


def _half_width(trials: int, level: float) -> float:
    """Half the width of the interval of a mean, in bootstrap standard errors, for `trials` trials."""
    return float(np.sqrt(trials / (trials - 1)) * student(trials, level))


def _of_means(values: Floats, level: float) -> Floats:
    """The ends (2, row) of the intervals of the means of `values` (row, trial)."""
    trials = values.shape[1]
    counts = resample(trials, RESAMPLES)[1:] / trials
    tail, means = (1 - level) / 2, values.mean(axis=1)
    ends = np.empty((2, len(values)))
    step = max(1, BLOCK // RESAMPLES)
    for first in range(0, len(values), step):
        rows = slice(first, first + step)
        ends[:, rows] = np.quantile(values[rows] @ counts.T, [tail, 1 - tail], axis=1)
    return np.asarray(means + (ends - means) * _half_width(trials, level) / NormalDist().inv_cdf(1 - tail))


def _of_medians(ordered: Floats, level: float) -> Floats:
    """The ends (2, row) of the intervals of the medians of rows in rising order.

    The two places between which a resample's median lies do not depend on the values, and so are the same for all rows.
    """
    trials = ordered.shape[1]
    drawn_so_far = np.cumsum(resample(trials, RESAMPLES)[1:], axis=1)
    middles = [np.argmax(drawn_so_far > rank, axis=1) for rank in ((trials - 1) // 2, trials // 2)]
    places, repeats = np.unique(np.stack(middles, axis=1), axis=0, return_counts=True)
    tail = NormalDist().cdf(-_half_width(trials, level))
    ends = np.empty((2, len(ordered)))
    step = max(1, BLOCK // len(places))
    for first in range(0, len(ordered), step):
        rows = slice(first, first + step)
        medians = _halfway(ordered[rows][:, places[:, 0]], ordered[rows][:, places[:, 1]])
        order = np.argsort(medians, axis=1)
        cumulated = np.cumsum(repeats[order], axis=1)
        for k, share in enumerate((tail, 1 - tail)):
            index = np.argmax(cumulated >= share * RESAMPLES, axis=1)
            chosen = np.take_along_axis(order, index[:, np.newaxis], axis=1)
            ends[k, rows] = np.take_along_axis(medians, chosen, axis=1)[:, 0]
    return ends


def _halfway(low: Floats, high: Floats) -> Floats:
    with np.errstate(invalid="ignore"):
        middle = low + (high - low) / 2
    infinite = np.where(low == -high, 0.0, np.where(np.isinf(low), low, high))
    return np.where(np.isfinite(low) & np.isfinite(high), middle, infinite)
