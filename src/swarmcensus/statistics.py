"""95 % intervals over trials: of one setting in closed form, of what compares settings by bootstrap.

The robots of a trial share a network and hear one another, so their values are correlated and a trial is the unit:
that which counts as one observation, and that which is drawn again. One draw serves all settings at once: trial 7 of
two settings shares what their addresses share (readings where only topology or brain differ; graphs and heterogeneous
sensors nearly always), and drawing trials jointly is right whether they share much or nothing. Efron and Tibshirani,
"An Introduction to the Bootstrap", chapters 8 and 13 (percentile intervals).
"""

import math
from statistics import NormalDist

import numpy as np
from numpy.typing import NDArray

RESAMPLES = 1000
LEVEL = 0.95
SEED = 2023
FEWEST = 6  # with fewer trials, all lie on one side of the true median in more than 1 of 20 cases: 2 / 2^5

Floats = NDArray[np.float64]


def resample(trials: int, resamples: int = RESAMPLES, seed: int = SEED) -> Floats:
    """How often each trial counts, (1 + resample, trial): row 0 is the sample itself, the others draw with return.

    The same arguments give the same numbers. Raises ValueError for fewer than one trial.
    """
    if trials < 1:
        raise ValueError(f"trials = {trials}: there is nothing to draw from")
    drawn = np.random.default_rng(seed).multinomial(trials, np.full(trials, 1 / trials), size=resamples)
    return np.concatenate([np.ones((1, trials)), drawn])


def medians(values: Floats, counts: Floats) -> Floats:
    """The median over all trials and robots of `values` (trial, robot), for each row of `counts` (resample, trial).

    Values are sorted once and a resample weighs them: its median is where its weights add up to a half, found by
    bisection, for all resamples at once. Values must not be NaN.
    """
    trials, robots = values.shape
    order = np.argsort(values, axis=None, kind="stable")
    ordered = values.ravel()[order]
    seen = np.cumsum(order[:, np.newaxis] // robots == np.arange(trials), axis=0, dtype=np.float32)
    weights = counts.astype(np.float32)  # whole numbers below 2^24: exact

    def ranked(rank: int) -> Floats:
        low, high = np.zeros(len(counts), np.intp), np.full(len(counts), ordered.size - 1)
        for _ in range(ordered.size.bit_length()):
            middle = (low + high) // 2
            beyond = np.einsum("ij,ij->i", weights, seen[middle]) > rank
            low, high = np.where(beyond, low, middle + 1), np.where(beyond, middle, high)
        return np.asarray(ordered[low])

    return (ranked((ordered.size - 1) // 2) + ranked(ordered.size // 2)) / 2


def means(values: Floats, counts: Floats) -> Floats:
    """The mean over trials of `values` (trial,), for each row of `counts` (resample, trial)."""
    return np.asarray(counts @ values / values.size)


def interval(statistic: Floats, level: float = LEVEL) -> tuple[float, float, float]:
    """The value and its percentile interval: row 0 of a statistic (1 + resample,), and the middle of the others.

    NaN where any resample is NaN.
    """
    tail = (1 - level) / 2
    low, high = np.quantile(statistic[1:], [tail, 1 - tail])
    return float(statistic[0]), float(low), float(high)


def share_interval(hits: int, tries: int) -> tuple[float, float, float]:
    """The share hits / tries and its 95 % score interval, which says something of 30 in 30 too. Wilson, 1927."""
    z2 = 1.959963984540054**2
    share = hits / tries
    middle = (share + z2 / (2 * tries)) / (1 + z2 / tries)
    half = math.sqrt(z2 * (share * (1 - share) + z2 / (4 * tries)) / tries) / (1 + z2 / tries)
    return share, max(0.0, middle - half), min(1.0, middle + half)


def interval_of(
    values: Floats, statistic: str, share: bool = False, level: float = LEVEL
) -> tuple[float, float, float]:
    """The "median" or "mean" over trials and robots of `values` (trial, robot), and its interval over trials.

    With `share`, values are shares in [0, 1], or 0 and 1, and their mean is a proportion. No interval has the width 0:
    see docs/intervals.md for what stands in for a spread that was not seen, and for the coverage that was measured.
    The interval is NaN for fewer than 6 trials, and all three are where a value is missing. Time is O(n log n) and
    memory O(n) for n values. Raises ValueError for another statistic.
    """
    if statistic not in ("median", "mean"):
        raise ValueError(f"statistic = {statistic!r}: should be 'median' or 'mean'")
    if not values.size or np.isnan(values).any():
        return math.nan, math.nan, math.nan
    value = float(np.median(values) if statistic == "median" else values.mean())
    if len(values) < FEWEST:
        return value, math.nan, math.nan
    if statistic == "median":
        return value, *_median_ends(values, level)
    by_trial = values.mean(axis=1)
    if share:
        return value, *_share_ends(by_trial, level)
    half = _student(len(values) - 1, level) * math.sqrt(by_trial.var(ddof=1) / len(values))
    half = half or _unseen(len(values), level)
    return value, value - half, value + half


def _normal(level: float) -> float:
    """How many standard errors hold the middle `level` of a normal distribution."""
    return NormalDist().inv_cdf((1 + level) / 2)


def _student(freedom: float, level: float) -> float:
    """The same of Student's t, to 0.3 % from 5 degrees of freedom on. Gaver and Kafadar, 1984."""
    return math.sqrt(freedom * math.expm1(_normal(level) ** 2 * (freedom - 1.5) / (freedom - 1) ** 2))


def _unseen(trials: int, level: float) -> float:
    """The largest share of trials that may differ from the others and yet not be among so many."""
    return float(1 - (1 - level) ** (1 / trials))


def _share_ends(by_trial: Floats, level: float) -> tuple[float, float]:
    """Wilson's interval of the mean of a share (trial,), over as many independent tries as its spread tells of.

    Robots that err together count as one try, those that err alone as one each: tries = trials / design effect,
    where the design effect is the variance of a trial over that of a single try. It is known no better than the trials
    are many that make up the variance, so that it is drawn to 1, its largest value, where these are few.
    """
    trials = len(by_trial)
    share = float(by_trial.mean())
    squares = (by_trial - share) ** 2
    total = float(squares.sum())
    tries: float = trials
    if total > 0.0:
        bearing = total**2 / float((squares**2).sum())  # trials, each of the mean square, would make up the variance
        effect = min(1.0, total / (trials - 1) / (share * (1 - share))) ** (bearing / (bearing + 1))
        tries = max(tries, trials / effect * (_normal(level) / _student(trials - 1, level)) ** 2)
    z2 = _normal(level) ** 2
    middle = (share + z2 / (2 * tries)) / (1 + z2 / tries)
    half = math.sqrt(z2 * (share * (1 - share) + z2 / (4 * tries)) / tries) / (1 + z2 / tries)
    return max(0.0, middle - half), min(1.0, middle + half)


def _median_ends(values: Floats, level: float) -> tuple[float, float]:
    """All m with which the data agree: the interval of the share of values below m, at most m, does not exclude 1/2."""
    ordered = np.sort(values, axis=None)

    def too_low(m: float) -> bool:
        return _share_ends((values <= m).mean(axis=1), level)[1] < 0.5

    def too_high(m: float) -> bool:
        return _share_ends((values < m).mean(axis=1), level)[0] > 0.5

    half = ordered.size // 2
    first, last = 0, half  # the smallest that is not too low is in [first, last]
    while first < last:
        middle = (first + last) // 2
        first, last = (middle + 1, last) if too_low(ordered[middle]) else (first, middle)
    low = ordered[first]
    first, last = half - 1, ordered.size - 1  # the largest that is not too high
    while first < last:
        middle = (first + last + 1) // 2
        first, last = (first, middle - 1) if too_high(ordered[middle]) else (middle, last)
    high = ordered[first]
    if low == high:  # many values are equal: between them and the next ones nothing was seen
        others = ordered[ordered != low]
        half_width = np.abs(others - low).min() / 2 if others.size else _unseen(len(values), level)
        low, high = low - half_width, high + half_width
    return float(low), float(high)
