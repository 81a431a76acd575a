"""95 % intervals over trials: of one setting in closed form, of what compares settings by bootstrap.

The robots of a trial share a network and hear one another, so their values are correlated and a trial is the unit:
that which counts as one observation, and that which is drawn again. One draw serves all settings at once: trial 7 of
two settings shares what their addresses share (readings where only topology or brain differ; graphs and heterogeneous
sensors nearly always), and drawing trials jointly is right whether they share much or nothing. Efron and Tibshirani,
"An Introduction to the Bootstrap", chapters 8 and 13 (percentile intervals).
"""

import math
from collections.abc import Callable
from statistics import NormalDist
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

RESAMPLES = 1000
LEVEL = 0.95
SEED = 2023
FEWEST = 6  # with fewer trials, all lie on one side of the true median in more than 1 of 20 cases: 2 / 2^5
ROUNDING = 1e-12  # relative: values that differ by less are equal

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

    Values are sorted once and a resample weighs them: its median is where its weights add up to a half. Which block of
    values that is in is found by bisection, for all resamples at once, then the place within the block. With blocks as
    long as there are trials, memory is O(values + resamples x trials). Values must not be NaN.
    """
    trials, robots = values.shape
    order = np.argsort(values, axis=None, kind="stable")
    ordered, of_trial = values.ravel()[order], (order // robots).reshape(robots, trials)  # a block a row
    among = np.array([np.bincount(block, minlength=trials) for block in of_trial], dtype=np.float64)
    seen = np.cumsum(among, axis=0)
    rows = np.arange(len(counts))

    def ranked(rank: int) -> Floats:
        low, high = np.zeros(len(counts), np.intp), np.full(len(counts), robots - 1)
        for _ in range(robots.bit_length()):
            middle = (low + high) // 2
            beyond = np.einsum("ij,ij->i", counts, seen[middle]) > rank  # whole numbers: exact
            low, high = np.where(beyond, low, middle + 1), np.where(beyond, middle, high)
        before = np.einsum("ij,ij->i", counts, seen[low] - among[low])
        within = np.cumsum(counts[rows[:, np.newaxis], of_trial[low]], axis=1)
        return np.asarray(ordered[low * trials + np.argmax(before[:, np.newaxis] + within > rank, axis=1)])

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
    share, z2 = hits / tries, 1.959963984540054**2
    return share, _wilson(share, tries, z2, -1), _wilson(share, tries, z2, 1)


class Estimate(NamedTuple):
    """A statistic of trials, and the ends of its interval: NaN where too few trials, or none, tell."""

    value: float
    low: float
    high: float


UNKNOWN = Estimate(math.nan, math.nan, math.nan)


def estimate(values: Floats, statistic: str, share: bool = False, level: float = LEVEL) -> Estimate:
    """The "median" or "mean" over trials and robots of `values` (trial, robot), and its interval over trials.

    With `share`, values are shares in [0, 1], or 0 and 1, and their mean is a proportion. No interval has the width 0:
    where trials are equal, docs/intervals.md says what stands in for the spread that was not seen. The interval is NaN
    for fewer than 6 trials and for an infinite mean, and the value too where one is missing. Time is O(n log n) and
    memory O(n) for n values. Raises ValueError for another statistic.
    """
    if statistic not in ("median", "mean"):
        raise ValueError(f"statistic = {statistic!r}: should be 'median' or 'mean'")
    if not values.size or np.isnan(values).any():
        return UNKNOWN
    value = float(np.median(values) if statistic == "median" else values.mean())
    if len(values) < FEWEST or (statistic == "mean" and not math.isfinite(value)):
        return Estimate(value, math.nan, math.nan)
    if statistic == "median":
        return Estimate(value, *_median_ends(values, level))
    by_trial = values.mean(axis=1)
    return Estimate(value, *(_share_ends(by_trial, level) if share else _mean_ends(by_trial, level)))


def pooled(values: Floats) -> Floats | None:
    """What (setting, trial, robot) holds of each trial that has been run, (trial, robots of all settings).

    Trial 7 of two settings shares what their addresses share, so that it counts once, with the robots of both. None
    where nothing has been run, or some settings lack trials that others have.
    """
    found = np.moveaxis(values, 1, 0).reshape(values.shape[1], -1)
    there = ~np.isnan(found)
    kept = found[np.ix_(there.any(axis=1), there.any(axis=0))]
    return kept if kept.size and not np.isnan(kept).any() else None


def estimate_pooled(values: Floats, statistic: str, share: bool = False) -> Estimate:
    """The statistic of all numbers of (setting, trial, robot), NaN left out, and its interval over trials.

    The interval is NaN where settings lack trials that others have.
    """
    kept = pooled(values)
    if kept is not None:
        return estimate(kept, statistic, share)
    known = values[~np.isnan(values)]
    if not known.size:
        return UNKNOWN
    return Estimate(float(np.median(known) if statistic == "median" else known.mean()), math.nan, math.nan)


def expected_share(by_trial: Floats) -> float:
    """The share to expect in trials to come, from its means by trial (trial,), where it had a part in choosing them.

    It is (x + 1/2) / (n + 1) where x of n independent tries are right, the mean with Jeffreys's prior, and 1 where all
    are. A time at which this reaches p has a share of p on average: docs/planning.md says why. It is of 6 trials or
    more.
    """
    share = float(by_trial.mean())
    if share == 1.0:
        return 1.0
    tries = tries_of(by_trial, LEVEL)
    return (tries * share + 0.5) / (tries + 1.0)


def _normal(level: float) -> float:
    """How many standard errors to both sides hold the middle `level` of a normal distribution."""
    return NormalDist().inv_cdf((1 + level) / 2)


def student(trials: int, level: float) -> float:
    """How many standard errors hold the middle `level` where the error is estimated from so many trials, 3 or more:
    Student's t, to three digits. Gaver and Kafadar, 1984."""
    freedom = trials - 1
    return math.sqrt(freedom * math.expm1(_normal(level) ** 2 * (freedom - 1.5) / (freedom - 1) ** 2))


def _unseen(trials: int, level: float) -> float:
    """The largest share of trials that may differ from the others and yet not be among so many."""
    return -math.expm1(math.log1p(-level) / trials)


def _equal(values: Floats) -> bool:
    """Whether they differ by no more than rounding does."""
    least, most = float(values.min()), float(values.max())
    return most - least <= ROUNDING * max(-least, most)


def _mean_ends(by_trial: Floats, level: float) -> tuple[float, float]:
    """Student's interval of the mean of (trial,), both ends moved by its skewness. Hall, 1992, "On the removal of
    skewness by transformation", with Student's quantiles in place of the normal ones.
    """
    trials, mean = len(by_trial), float(by_trial.mean())
    if _equal(by_trial):
        half = _unseen(trials, level)
        return mean - half, mean + half
    error = float(by_trial.std(ddof=1)) / math.sqrt(trials)
    skew = float(((by_trial - mean) ** 3).mean() / by_trial.std() ** 3) / math.sqrt(trials)

    def straight(errors: float) -> float:
        return 3 / skew * (float(np.cbrt(1 + skew * (errors - skew / 6))) - 1) if abs(skew) > 1e-6 else errors

    beyond = student(trials, level)
    return mean - straight(beyond) * error, mean - straight(-beyond) * error


def _wilson(share: float, tries: float, z2: float, side: int) -> float:
    """The lower (-1) or the upper (1) end of Wilson's score interval."""
    middle = (share + z2 / (2 * tries)) / (1 + z2 / tries)
    half = math.sqrt(z2 * (share * (1 - share) + z2 / (4 * tries)) / tries) / (1 + z2 / tries)
    return min(1.0, max(0.0, middle + side * half))


def tries_of(by_trial: Floats, level: float) -> float:
    """How many independent tries tell as much of a share as its means by trial (trial,), no fewer than the trials.

    Robots that err together count as one try, those that err alone as one each: tries = trials / design effect,
    the variance of a trial over that of a single try (Kish, 1965). That is known no better than the trials are many
    that make up the variance, and is drawn to 1, its largest value, where these are few.
    """
    trials, share = len(by_trial), float(by_trial.mean())
    if _equal(by_trial):
        return trials
    squares = (by_trial - share) ** 2
    total = float(squares.sum())
    bearing = total**2 / float((squares**2).sum())  # so many trials of the mean square make up the variance
    effect: float = min(1.0, total / (trials - 1) / (share * (1 - share))) ** (bearing / (bearing + 1))
    return trials * max(1.0, (_normal(level) / student(trials, level)) ** 2 / effect)


def _share_ends(by_trial: Floats, level: float) -> tuple[float, float]:
    """Wilson's interval of the mean of a share (trial,), with both ends moved outwards for tries being whole and for
    the skewness of their number (Cai, 2005): nearly the exact one of Clopper and Pearson, near 0 and 1 too.
    """
    share, tries, z2 = float(by_trial.mean()), tries_of(by_trial, level), _normal(level) ** 2
    lean = (z2 - 1) / 6 * (2 * share - 1)
    fewer = max(0.0, share - max(0.0, 0.5 - lean) / tries)
    more = min(1.0, share + max(0.0, 0.5 + lean) / tries)
    return _wilson(fewer, tries, z2, -1), _wilson(more, tries, z2, 1)


def _median_ends(values: Floats, level: float) -> tuple[float, float]:
    """All m for which the shares of values below m, and up to m, are not clearly on one side of 1/2. Woodruff, 1952."""
    ordered, z = np.sort(values, axis=None), _normal(level)

    def clearly_less(share: NDArray[np.bool_]) -> bool:
        by_trial = share.mean(axis=1)
        tries = tries_of(by_trial, level)
        return bool(by_trial.mean() + (0.5 + z * math.sqrt(tries) / 2) / tries < 0.5)

    half = ordered.size // 2
    low = ordered[_first(0, half, lambda k: not clearly_less(values <= ordered[k]))]
    high = ordered[_first(half, ordered.size, lambda k: clearly_less(values >= ordered[k])) - 1]
    if math.isfinite(high) and _equal(
        np.array([low, high])
    ):  # many values are equal: between them and the next ones nothing was seen
        gaps = np.abs(ordered - low)
        gaps = gaps[(gaps > ROUNDING * abs(low)) & np.isfinite(gaps)]
        room = gaps.min() / 2 if gaps.size else _unseen(len(values), level)
        low, high = low - room, high + room
    return float(low), float(high)


def _first(start: int, end: int, holds: Callable[[int], bool]) -> int:
    """The first of start .. end - 1 for which something holds that goes on to hold; `end` if there is none."""
    while start < end:
        middle = (start + end) // 2
        start, end = (start, middle) if holds(middle) else (middle + 1, end)
    return start
