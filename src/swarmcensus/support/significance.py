"""Significance tests: paired signed ranks for many samples at once, average ranks over trials, Holm's correction.

The signed-rank test is exact also with ties, zeros and infinite values. Wilcoxon, "Individual comparisons by ranking
methods", 1945. Zeros: Pratt, "Remarks on zeros and ties in the Wilcoxon signed rank procedures", 1959. Matched
rank-biserial correlation: Kerby, "The simple difference formula", 2014. Mid-p: Lancaster, "Significance tests in
discrete distributions", 1961. Correction: Holm, "A simple sequentially rejective multiple test procedure", 1979. Ranks:
Friedman, "The use of ranks to avoid the assumption of normality", 1937, by permutation; trials are the blocks. If
contenders met in several worlds, the ranks of a trial are summed over the worlds, because worlds may share its readings
and networks.
"""

import functools
import itertools
import math
from statistics import NormalDist
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from swarmcensus.support.intervals import ROUNDING, Floats, student_p

EXACT = 64  # p is exact up to this number of non-zero differences, for which there are 2^64 sign patterns
PERMUTATIONS = 9999  # of ranks within trials, in Friedman's test
SEED = 2023
STEPS, TINY = 60, 1e-99  # of bisection, and beyond what ends it
KEPT_BITS = 2.0**30  # of a difference; differences that agree to nine digits are tied


def holm(p: NDArray[np.float64]) -> NDArray[np.float64]:
    """Holm's corrected p-values, in the shape of `p`; NaN stays NaN and does not count as a test.

    The chance that any true null hypothesis has a corrected p-value of `a` or less is at most `a`, whatever the
    dependence between the tests.
    """
    order = np.argsort(p, axis=None, kind="stable")[: (~np.isnan(p)).sum()]  # NaN last
    corrected = np.full(p.size, np.nan)
    steps = p.ravel()[order] * np.arange(order.size, 0, -1)
    corrected[order] = np.minimum(1.0, np.maximum.accumulate(steps))
    return corrected.reshape(p.shape)


def fewest_trials(tests: int, level: float, paired: bool = True) -> int:
    """The fewest trials with which one of `tests` tests can reach `level` after Holm's correction.

    All n differences of paired trials have the same sign by chance in 2 of 2^n cases. All n trials of one sample
    exceed all n of the other by chance in 2 of (2n choose n) cases.
    """
    least = level / max(tests, 1)
    return next(n for n in itertools.count(1) if 2 / (2**n if paired else math.comb(2 * n, n)) <= least * (1 + 1e-9))


Counts = NDArray[np.int64]


class RankTest(NamedTuple):
    """Results of signed-rank tests; each array has the shape of the differences without their last axis.

    `below`, `equal` and `above` count the trials with negative, zero and positive differences. `balance` is the
    matched rank-biserial correlation in [-1, 1]: positive if differences mostly are, 0 if there are none. `p` is
    two-sided. `swarmcensus.support.rank_sums` has the same of rank-sum tests, for pairs of trials.
    """

    below: Counts
    equal: Counts
    above: Counts
    balance: Floats
    p: Floats


def differences(first: Floats, second: Floats) -> Floats:
    """`first - second`: 0 where they differ by rounding or are the same infinity, NaN where either is NaN."""
    with np.errstate(invalid="ignore"):
        difference = first - second
        equal = (first == second) | (np.abs(difference) <= ROUNDING * np.maximum(np.abs(first), np.abs(second)))
    equal &= (np.isfinite(first) & np.isfinite(second)) | (first == second)
    return np.where(equal, 0.0, difference)


def midranks(values: Floats) -> Floats:
    """Ranks from 1 along the last axis; equal values share the mean of their ranks, and NaN has rank NaN."""
    import pandas as pd  # slow to import, and most commands rank nothing

    rows = values.reshape(math.prod(values.shape[:-1]), values.shape[-1])
    return np.asarray(pd.DataFrame(rows).rank(axis=1), np.float64).reshape(values.shape)


def signed_ranks(off: Floats) -> RankTest:
    """The two-sided test that differences `off` (..., trial) are symmetric about 0; NaN is ignored.

    The null hypothesis is that the sign of each difference is random, as it is if two contenders are exchangeable in
    every trial. The p-value is the share of sign patterns with rank sums at least as far apart as the observed ones.
    Zeros are ranked and then dropped (Pratt). For more than 64 non-zero differences, the p-value is that of the normal
    approximation with continuity correction. Without any difference it is 1.
    """
    return _ranked(off)[0]


def _ranked(off: Floats) -> tuple[RankTest, Counts]:
    """`signed_ranks`, and twice the ranks of the differences (row, trial), 0 of those that do not count."""
    flat = off.reshape(math.prod(off.shape[:-1]), off.shape[-1])
    mantissa, exponent = np.frexp(np.abs(flat))
    sizes = np.ldexp(np.rint(mantissa * KEPT_BITS), exponent)  # ties of decimal numbers stay ties
    weights = np.rint(2 * np.nan_to_num(midranks(sizes))).astype(np.int64)  # twice the ranks, which may be halves
    weights[(flat == 0) | np.isnan(flat)] = 0
    above = np.where(flat > 0, weights, 0).sum(axis=1)
    total = weights.sum(axis=1)
    p = np.minimum(1.0, 2 * tails(weights, np.minimum(above, total - above)))
    counts = [(flat < 0).sum(axis=1), (flat == 0).sum(axis=1), (flat > 0).sum(axis=1)]
    found = [*counts, (2 * above - total) / np.maximum(total, 1), p]
    return RankTest(*(part.reshape(off.shape[:-1]) for part in found)), weights


def paired_tests(off: Floats) -> RankTest:
    """`signed_ranks` of `off` and a sign test in the direction of its balance: `p` is small only if both find much.

    Skewed differences are not symmetric about 0 although half of them are on either side. So both have to differ: the
    ranks, and the number of trials in which one is ahead, which is what the probability of being better is made of.
    The sign test is one-sided, as the ranks choose the side, with Lancaster's mid-p, which counts one half of what is
    as likely as the observation, and at least 1/1.2 of its exact p. Both seldom err together, so the p of ranks is
    raised to the power 1 / r, with r the correlation of both statistics under random signs. By the normal approximation
    `p` is then that of both together, to a seventh. It is at least 2 / 2^n of n differences.
    """
    tests, weights = _ranked(off)
    coins = (weights > 0).astype(np.int64)
    against = np.where(tests.balance > 0, tests.below, tests.above).ravel()
    exact, less = tails(coins, against), tails(coins, against - 1)
    signs = np.maximum((exact + less) / 2, np.where(against > 0, exact / 1.2, np.minimum(2 * exact, 1.0)))
    r = weights.sum(axis=1) / np.maximum(np.sqrt(coins.sum(axis=1) * (weights**2).sum(axis=1)), 1.0)
    return tests._replace(p=np.maximum(tests.p.ravel() ** (1 / np.maximum(r, 0.5)), signs).reshape(tests.p.shape))


def mean_tests(off: Floats) -> RankTest:
    """`signed_ranks` of rows (row, trial) without NaN; `p` is at least that of their mean.

    The mean of skewed numbers may be 0 although their ranks differ. Its p is that of the empirical likelihood ratio
    (Owen, 1988) as the square of Student's t: no weights of numbers on one side of 0 make their mean 0.
    """
    ends = -1 / np.stack([off.max(axis=1, initial=TINY), off.min(axis=1, initial=-TINY)])
    for _ in range(STEPS):
        tilt = ends.mean(axis=0)[:, np.newaxis]
        below = (off / (1 + tilt * off)).sum(axis=1) > 0.0
        ends = np.where([below, ~below], tilt[:, 0], ends)
    ratios, tests = 2 * np.log1p(tilt * off).sum(axis=1), signed_ranks(off)
    found = [student_p(max(ratio, 0.0), max(off.shape[1] - 1, 2)) for ratio in ratios.tolist()]
    return tests._replace(p=np.maximum(tests.p, found))


def tails(weights: Counts, least: Counts) -> Floats:
    """The chance that a random subset of the weights (row, trial) of a row has a sum of `least` (row,) or less.

    Each weight is in the subset with probability 1/2.
    """
    chances, positive = np.ones(len(weights)), weights > 0
    many = positive.sum(axis=1) > EXACT
    middle, spread = weights[many].sum(axis=1) / 2, np.sqrt((weights[many] ** 2).sum(axis=1)) / 2
    # half the smallest step between sums is the correction for continuity
    z = np.minimum(least[many] + np.gcd.reduce(weights[many], axis=1) / 2 - middle, 0.0) / spread
    chances[many] = [NormalDist().cdf(score) for score in z.tolist()]
    for row in np.flatnonzero(~many & positive.any(axis=1)).tolist():
        unit, up_to = _sums(np.sort(weights[row][positive[row]]).tobytes())
        chances[row] = up_to[least[row] // unit + 1]
    return chances


@functools.lru_cache(maxsize=1024)
def _sums(weights: bytes) -> tuple[int, Floats]:
    """The unit of the sums of random subsets of these weights, and the chances of sums up to -1, 0, 1 ... units."""
    rising = np.frombuffer(weights, np.int64)
    unit = int(np.gcd.reduce(rising))
    ways = np.zeros(int(rising.sum()) // unit + 1)
    ways[0] = 1.0
    for weight in (rising // unit).tolist():
        ways[weight:] += ways[:-weight]
    return unit, np.append(0.0, np.cumsum(ways)) / math.ldexp(1.0, len(rising))


def friedman(ranks: Floats, permutations: int = PERMUTATIONS) -> tuple[float, float]:
    """The statistic Q of `ranks` (trial, contender), and its p-value by permuting contenders within trials.

    Q = (k - 1) x (sum of squares of the contenders' totals about their mean) / (sum of squares of all ranks about the
    mean of their trial). For the ranks 1 .. k of one world, this is Friedman's statistic, corrected for ties. Returns
    NaN and 1 if all ranks are equal in every trial. The same ranks always give the same p-value.
    """
    off = ranks - ranks.mean(axis=1, keepdims=True)
    spread = float((off**2).sum())
    if spread <= 0:
        return float("nan"), 1.0
    observed = float((off.sum(axis=0) ** 2).sum())
    generator, extreme = np.random.default_rng(SEED), 0
    step = max(1, 2**21 // off.size)
    for first in range(0, permutations, step):
        copies = np.broadcast_to(off, (min(step, permutations - first), *off.shape))
        sums = generator.permuted(copies, axis=2).sum(axis=1)
        extreme += int(((sums**2).sum(axis=1) >= observed * (1 - 1e-9)).sum())
    return (ranks.shape[1] - 1) * observed / spread, (1 + extreme) / (1 + permutations)


def groups(order: list[int], apart: NDArray[np.bool_]) -> list[list[int]]:
    """The maximal runs of two or more contenders in `order`, no two of which are `apart` (contender, contender)."""
    runs: list[list[int]] = []
    for start in range(len(order)):
        end = start + 1
        while end < len(order) and not apart[order[end], order[start:end]].any():
            end += 1
        if end - start > 1 and not (runs and set(order[start:end]) <= set(runs[-1])):
            runs.append(order[start:end])
    return runs
