"""95 % intervals by bootstrap over trials.

The robots of a trial share a network and hear one another, so their values are correlated and a trial is the unit
that is drawn again. One draw serves all settings at once: trial 7 of two settings shares what their addresses
share (readings where only topology or brain differ; graphs and heterogeneous sensors nearly always), and drawing
trials jointly is right whether they share much or nothing. Efron and Tibshirani, "An Introduction to the
Bootstrap", chapters 8 and 13 (percentile intervals).
"""

import math

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
