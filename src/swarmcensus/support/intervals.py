"""95 % intervals over trials: in closed form for one setting, by bootstrap for comparisons of settings.

The robots of a trial share a network and hear one another, so their values are correlated. The trial is therefore the
unit of observation and of resampling. All settings are resampled jointly, because the same trial of two settings shares
random numbers: readings if only the topology or brain differs, graphs and sensor accuracies nearly always. Joint
resampling is right whether they share much or nothing. Percentile intervals: Efron and Tibshirani, "An Introduction to
the Bootstrap", chapters 8 and 13.
"""

import math
from bisect import bisect_left
from statistics import NormalDist
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

RESAMPLES = 1000
LEVEL = 0.95
SEED = 2023
FEWEST = 6  # with fewer trials, all lie on one side of the true median in more than 1 of 20 cases: 2 / 2^5
ROUNDING = 1e-12  # relative; values that differ by less are equal

Floats = NDArray[np.float64]
Z95 = 1.959963984540054  # half the width of a 95 % interval, in standard deviations


def resample(trials: int, resamples: int = RESAMPLES, seed: int = SEED) -> Floats:
    """How often each trial counts, (1 + resample, trial): row 0 is the sample, the others are drawn with replacement.

    The same arguments always give the same numbers. Raises ValueError without any trial.
    """
    if trials < 1:
        raise ValueError(f"trials = {trials}: should be 1 or more")
    drawn = np.random.default_rng(seed).multinomial(trials, np.full(trials, 1 / trials), size=resamples)
    return np.concatenate([np.ones((1, trials)), drawn])


def medians(values: Floats, counts: Floats) -> Floats:
    """The median over all trials and robots of `values` (trial, robot), for each row of `counts` (resample, trial).

    The values are sorted once, and each resample weighs them; its median is where the weights add up to a half. The
    block of values that holds the median is found by bisection for all resamples at once, then the place within the
    block. Blocks have as many values as there are trials, so memory is O(values + resamples x trials). Values must not
    be NaN.
    """
    trials, robots = values.shape
    order = np.argsort(values, axis=None, kind="stable")
    ordered, of_trial = values.ravel()[order], (order // robots).reshape(robots, trials)  # one block per row
    in_block = np.array([np.bincount(block, minlength=trials) for block in of_trial], dtype=np.float64)
    up_to_block = np.cumsum(in_block, axis=0)
    rows = np.arange(len(counts))

    def ranked(rank: int) -> Floats:
        low, high = np.zeros(len(counts), np.intp), np.full(len(counts), robots - 1)
        for _ in range(robots.bit_length()):
            middle = (low + high) // 2
            beyond = np.einsum("ij,ij->i", counts, up_to_block[middle]) > rank  # whole numbers: exact
            low, high = np.where(beyond, low, middle + 1), np.where(beyond, middle, high)
        before = np.einsum("ij,ij->i", counts, up_to_block[low] - in_block[low])
        within = np.cumsum(counts[rows[:, np.newaxis], of_trial[low]], axis=1)
        return np.asarray(ordered[low * trials + np.argmax(before[:, np.newaxis] + within > rank, axis=1)])

    return (ranked((ordered.size - 1) // 2) + ranked(ordered.size // 2)) / 2


def means(values: Floats, counts: Floats) -> Floats:
    """The mean over trials of `values` (trial,), for each row of `counts` (resample, trial)."""
    return np.asarray(counts @ values / values.size)


def interval(statistic: Floats, level: float = LEVEL) -> tuple[float, float, float]:
    """The value of a statistic (1 + resample,), which is its row 0, and the percentile interval of the other rows.

    The interval is NaN if any resample is NaN.
    """
    low, high = np.quantile(statistic[1:], [(1 - level) / 2, 1 - (1 - level) / 2])
    return float(statistic[0]), float(low), float(high)


def share_interval(hits: float, tries: float) -> tuple[float, float, float]:
    """The share hits / tries and its 95 % score interval, which has a positive width for 30 in 30 too. Wilson, 1927."""
    share, z2 = hits / tries, Z95**2
    return share, _wilson(share, tries, z2, -1), _wilson(share, tries, z2, 1)


class Estimate(NamedTuple):
    """A statistic of trials and the ends of its interval; NaN where there are too few trials."""

    value: float
    low: float
    high: float


UNKNOWN = Estimate(math.nan, math.nan, math.nan)


def estimate(values: Floats, statistic: str, share: bool = False, level: float = LEVEL) -> Estimate:
    """The "median" or "mean" over trials and robots of `values` (trial, robot), and its interval over trials.

    With `share`, values are shares in [0, 1], and their mean is a proportion. No interval has width 0;
    docs/comparing.md says what replaces the spread if all trials are equal. The interval is NaN for fewer than 6 trials
    and for an infinite mean. If a value is missing, the statistic is NaN too. Time is O(n log n) and memory O(n) for n
    values. Raises ValueError for another statistic.
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
    """The values (setting, trial, robot) of completed trials as (trial, robots of all settings).

    The same trial of two settings shares random numbers, so it counts as one trial with the robots of both. None if no
    trial is complete, or some settings lack trials that others have.
    """
    by_trial = np.moveaxis(values, 1, 0).reshape(values.shape[1], -1)
    known = ~np.isnan(by_trial)
    kept = by_trial[np.ix_(known.any(axis=1), known.any(axis=0))]
    return kept if kept.size and not np.isnan(kept).any() else None


def estimate_pooled(values: Floats, statistic: str, share: bool = False, with_ends: bool = True) -> Estimate:
    """The statistic of all values (setting, trial, robot) that are not NaN, and its interval over trials.

    The interval is NaN if some settings lack trials that others have, and unless `with_ends`.
    """
    known = values[~np.isnan(values)]
    if not known.size:
        return UNKNOWN
    value = float(np.median(known) if statistic == "median" else known.mean())
    kept = pooled(values) if with_ends else None
    return Estimate(value, *(UNKNOWN if kept is None else estimate(kept, statistic, share))[1:])


def expected_share(by_trial: Floats) -> float:
    """The share to expect in future trials, from the means per trial (trial,), corrected for selection by these trials.

    With x of n independent tries right, it is the mean (x + 1/2) / (n + 1) of the posterior with Jeffreys' prior, and 1
    if all are right. A time chosen because this reaches p has a share of p on average; docs/planning.md says why. Needs
    6 trials or more.
    """
    share = float(by_trial.mean())
    tries = tries_of(by_trial, LEVEL)
    return (tries * share + 0.5) / (tries + 1.0) if share < 1.0 else 1.0


def _normal(level: float) -> float:
    """Half the width of an interval of probability `level` of a normal distribution, in standard errors."""
    return NormalDist().inv_cdf((1 + level) / 2)


def student(trials: float, level: float) -> float:
    """Half the width of an interval of probability `level` of Student's t, in standard errors, for 3 or more trials.

    Correct to three digits. Gaver and Kafadar, 1984.
    """
    freedom = trials - 1
    return math.sqrt(freedom * math.expm1(_normal(level) ** 2 * (freedom - 1.5) / (freedom - 1) ** 2))


def student_p(squared: float, freedom: float) -> float:
    """The two-sided p-value of the square of Student's t, by the same formula."""
    z2 = math.log1p(squared / freedom) * (freedom - 1) ** 2 / (freedom - 1.5)
    return 2.0 * NormalDist().cdf(-math.sqrt(z2))


def _unseen(trials: int, level: float) -> float:
    """The largest share of differing trials that may go unseen in `trials` trials at this level."""
    return -math.expm1(math.log1p(-level) / trials)


def _equal(values: Floats) -> bool:
    """Whether values differ only by rounding."""
    least, most = float(values.min()), float(values.max())
    return most - least <= ROUNDING * max(-least, most)


def _mean_ends(by_trial: Floats, level: float) -> tuple[float, float]:
    """Student's interval of the mean of (trial,), with both ends corrected for skewness.

    Hall, 1992, "On the removal of skewness by transformation", with Student's quantiles in place of the normal ones.
    """
    trials, mean = len(by_trial), float(by_trial.mean())
    if _equal(by_trial):
        return mean - _unseen(trials, level), mean + _unseen(trials, level)
    error = float(by_trial.std(ddof=1)) / math.sqrt(trials)
    skew = float(((by_trial - mean) ** 3).mean() / by_trial.std() ** 3) / math.sqrt(trials)

    def transformed(errors: float) -> float:
        return 3 / skew * (float(np.cbrt(1 + skew * (errors - skew / 6))) - 1) if abs(skew) > 1e-6 else errors

    half = student(trials, level)
    return mean - transformed(half) * error, mean - transformed(-half) * error


def _wilson(share: float, tries: float, z2: float, side: int) -> float:
    """The lower (-1) or the upper (1) end of Wilson's score interval."""
    middle = (share + z2 / (2 * tries)) / (1 + z2 / tries)
    half = math.sqrt(z2 * (share * (1 - share) + z2 / (4 * tries)) / tries) / (1 + z2 / tries)
    return min(1.0, max(0.0, middle + side * half))


def tries_of(by_trial: Floats, level: float) -> float:
    """The number of independent tries that determine a share as well as its means per trial (trial,) do.

    It is at least the number of trials: robots that all err together count as one try, robots that err independently as
    one each. tries = trials / design effect, where the effect is the variance of a trial over that of a single try
    (Kish, 1965). If only few trials contribute to the variance, the effect is uncertain and is shrunk towards 1, its
    largest value.
    """
    trials, share = len(by_trial), float(by_trial.mean())
    if _equal(by_trial):
        return trials
    squares = (by_trial - share) ** 2
    total = float(squares.sum())
    contributing = total**2 / float((squares**2).sum())  # the effective number of trials in the variance
    effect: float = min(1.0, total / (trials - 1) / (share * (1 - share))) ** (contributing / (contributing + 1))
    return trials * max(1.0, (_normal(level) / student(trials, level)) ** 2 / effect)


def _share_ends(by_trial: Floats, level: float) -> tuple[float, float]:
    """Wilson's interval of the mean of a share (trial,), with corrections for continuity and skewness (Cai, 2005).

    It is nearly the exact interval of Clopper and Pearson, near 0 and 1 too.
    """
    share, tries, z2 = float(by_trial.mean()), tries_of(by_trial, level), _normal(level) ** 2
    lean = (z2 - 1) / 6 * (2 * share - 1)
    fewer = max(0.0, share - max(0.0, 0.5 - lean) / tries)
    more = min(1.0, share + max(0.0, 0.5 + lean) / tries)
    return _wilson(fewer, tries, z2, -1), _wilson(more, tries, z2, 1)


def _median_ends(values: Floats, level: float) -> tuple[float, float]:
    """All m for which the shares of values below m and up to m do not differ clearly from 1/2. Woodruff, 1952."""
    ordered, z = np.sort(values, axis=None), _normal(level)

    def clearly_less(share: NDArray[np.bool_]) -> bool:
        by_trial = share.mean(axis=1)
        tries = tries_of(by_trial, level)
        return bool(by_trial.mean() + (0.5 + z * math.sqrt(tries) / 2) / tries < 0.5)

    half = ordered.size // 2
    low = ordered[bisect_left(range(half), True, key=lambda k: not clearly_less(values <= ordered[k]))]
    high = ordered[bisect_left(range(ordered.size), True, half, key=lambda k: clearly_less(values >= ordered[k])) - 1]
    if math.isfinite(high) and _equal(np.array([low, high])):
        # many values are equal, and the median may lie anywhere up to half way to the next ones
        gaps = np.abs(ordered - low)
        gaps = gaps[(gaps > ROUNDING * abs(low)) & np.isfinite(gaps)]
        room = gaps.min() / 2 if gaps.size else _unseen(len(values), level)
        low, high = low - room, high + room
    return float(low), float(high)
