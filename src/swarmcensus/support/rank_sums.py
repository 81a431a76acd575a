"""The rank-sum test of two independent samples, with the difference and the probability that go with it.

The test is exact for up to 60 values, also with ties and infinite values. Test: Wilcoxon, "Individual comparisons by
ranking methods", 1945; Mann and Whitney, 1947. Difference and its interval: Hodges and Lehmann, 1963; Moses, 1965.
Unequal spreads: Brunner and Munzel, "The nonparametric Behrens-Fisher problem", 2000. Interval of the probability:
Newcombe, "Confidence intervals for an effect size measure based on the Mann-Whitney statistic", 2006, method 5.
"""

import functools
import math
from statistics import NormalDist

import numpy as np
from numpy.typing import NDArray

from swarmcensus.support.bootstrap import centres
from swarmcensus.support.intervals import FEWEST, LEVEL, Estimate, Floats, student, student_p
from swarmcensus.support.significance import KEPT_BITS, STEPS, RankTest, differences, midranks

EXACT = 60  # p is exact up to this number of values in both samples


def rank_sums(first: Floats, second: Floats) -> RankTest:
    """The two-sided test that two samples without NaN are of one distribution, with numbers of shape ().

    `below`, `equal` and `above` count the pairs of a value of `first` and a value of `second`, and `balance` is the
    difference of the shares of those above and below (Cliff's delta). The p-value is twice the share of ways to deal
    the values out that have a sum of ranks as far on the same side, or that of Brunner and Munzel's test if that is
    larger: the first is exact for equal distributions, the second nearly so where neither tends to be larger, such as
    for two of unequal spread. With more than 60 values the first is that of the normal approximation with
    corrections for ties and continuity.
    """
    mantissa, exponent = np.frexp(np.concatenate([first, second]))
    values = np.ldexp(np.rint(mantissa * KEPT_BITS), exponent)  # ties of decimal numbers stay ties
    weights = np.rint(2 * midranks(values)).astype(np.int64)  # twice the ranks, which may be halves
    own, others = weights[: first.size, np.newaxis], weights[first.size :]
    below, equal, above = (np.array(part.sum()) for part in (own < others, own == others, own > others))
    balance = np.array((int(above) - int(below)) / max(first.size * second.size, 1))
    return RankTest(below, equal, above, balance, np.array(max(_p(weights, first.size), _p_of_unequal(first, second))))


def _placements(first: Floats, second: Floats) -> tuple[float, float, float]:
    """The chance that a value of `first` exceeds one of `second`, its squared error and the degrees of freedom.

    Equal values count one half.
    """
    off = np.sign(differences(first[:, np.newaxis], second))
    over = (1 + off) / 2
    rows, columns = over.mean(axis=1), over.mean(axis=0)
    with np.errstate(invalid="ignore", divide="ignore"):
        parts = rows.var(ddof=1) / first.size, columns.var(ddof=1) / second.size
        freedom = sum(parts) ** 2 / (parts[0] ** 2 / (first.size - 1) + parts[1] ** 2 / (second.size - 1))
    return float(over.mean()), float(sum(parts)), float(freedom)


def _p_of_unequal(first: Floats, second: Floats) -> float:
    """The two-sided p-value of Brunner and Munzel's test; 0 where there is none, as of samples that do not overlap."""
    if min(first.size, second.size) < 2:
        return 0.0
    chance, squared, freedom = _placements(first, second)
    return student_p((chance - 0.5) ** 2 / squared, max(freedom, 2.0)) if squared > 0.0 else 0.0


def _p(weights: NDArray[np.int64], size: int) -> float:
    """The two-sided p-value of the sum of the first `size` weights."""
    total, seen = len(weights), int(weights[:size].sum())
    if size in (0, total) or (weights == weights[0]).all():
        return 1.0
    if total <= EXACT:
        least, unit, chances = _sums(np.sort(weights).tobytes(), size)
        place = (seen - least) // unit
        return min(1.0, 2 * float(min(chances[: place + 1].sum(), chances[place:].sum())))
    spread = math.sqrt(size * (total - size) / (total - 1)) * float(weights.std())  # of the sum
    return min(1.0, 2 * NormalDist().cdf(-max(0.0, abs(seen - size * (total + 1)) - 1) / spread))


@functools.lru_cache(maxsize=256)
def _sums(weights: bytes, size: int) -> tuple[int, int, Floats]:
    """The distribution of the sum of `size` of these weights: its least value, the step, and the chance of each."""
    ordered = np.frombuffer(weights, np.int64)
    off = ordered - ordered[0]
    unit = int(np.gcd.reduce(off))
    off = off // unit
    ways = np.zeros((size + 1, int(off[-size:].sum()) + 1))
    ways[0, 0] = 1.0
    for weight in off.tolist():
        ways[1:, weight:] += ways[:-1, : ways.shape[1] - weight].copy()
    least = int(off[:size].sum())
    return int(size * ordered[0]) + unit * least, unit, ways[size, least:] / math.comb(len(ordered), size)


def shift(first: Floats, second: Floats, level: float = LEVEL) -> Estimate:
    """The median of all differences of a value of `first` and a value of `second`, and its interval.

    The ends are those shifts that the rank-sum test does not reject. They are NaN for samples of fewer than 6 values,
    and if all differences are equal.
    """
    off = np.sort(differences(first[:, np.newaxis], second).ravel())
    value = float(centres(off, "median"))
    if min(first.size, second.size) < FEWEST or off[0] == off[-1]:
        return Estimate(value, math.nan, math.nan)
    beyond = _beyond(first.size, second.size, level)
    return Estimate(value, float(off[beyond]), float(off[-1 - beyond]))


@functools.lru_cache(maxsize=256)
def _beyond(first: int, second: int, level: float) -> int:
    """How many of the ordered differences lie below the interval of the shift."""
    tail = (1 - level) / 2
    if first + second <= EXACT:
        _, _, chances = _sums(np.arange(2, 2 * (first + second) + 1, 2, dtype=np.int64).tobytes(), first)
        return max(0, int(np.searchsorted(np.cumsum(chances), tail * (1 + 1e-12), side="right")) - 1)
    spread = math.sqrt(first * second * (first + second + 1) / 12)
    return int(first * second / 2 + NormalDist().inv_cdf(tail) * spread - 0.5)


def ends_of_probability(first: Floats, second: Floats, level: float = LEVEL) -> tuple[float, float]:
    """The interval of the probability that a value of `first` exceeds one of `second`; equal ones count one half.

    It holds Newcombe's interval, for distributions that differ by a shift, and that of the placements' variances on the
    scale of the logit, for unequal spreads. NaN for samples of fewer than 6 values.
    """
    if min(first.size, second.size) < FEWEST:
        return math.nan, math.nan
    probability, squared, freedom = _placements(first, second)
    low, high = _newcombe(probability, first.size, second.size, level)
    if squared > 0.0 and 0.0 < probability < 1.0:
        logit = math.log(probability / (1 - probability))
        reach = student(max(freedom, 2.0) + 1, level) * math.sqrt(squared) / (probability * (1 - probability))
        least, most = (1 / (1 + math.exp(min(-logit - sign * reach, 700.0))) for sign in (-1, 1))
        low, high = min(low, least), max(high, most)
    return low, high


def _newcombe(probability: float, first: int, second: int, level: float) -> tuple[float, float]:
    """Newcombe's interval for samples of these sizes."""
    z2, extra = NormalDist().inv_cdf((1 + level) / 2) ** 2, (first + second) / 2 - 1

    def too_far(at: float) -> bool:
        spread = 1 + extra * (1 - at) / (2 - at) + extra * at / (1 + at)
        return (probability - at) ** 2 > z2 * at * (1 - at) * spread / (first * second)

    def end(far: float) -> float:
        near = probability
        for _ in range(STEPS):
            middle = (near + far) / 2
            near, far = (near, middle) if too_far(middle) else (middle, far)
        return near

    return end(0.0), end(1.0)
