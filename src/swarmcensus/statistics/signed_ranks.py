"""The paired signed-rank test for many samples at once, exact also with ties, zeros and infinite values.

Wilcoxon, "Individual comparisons by ranking methods", 1945. Zeros: Pratt, "Remarks on zeros and ties in the Wilcoxon
signed rank procedures", 1959. Matched rank-biserial correlation: Kerby, "The simple difference formula", 2014.
"""

import math
from statistics import NormalDist
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from swarmcensus.statistics.intervals import ROUNDING

EXACT = 64  # p is exact up to this number of non-zero differences, for which there are 2^64 sign patterns
KEPT_BITS = 2.0**30  # of a difference; differences that agree to nine digits are tied

Floats = NDArray[np.float64]
Counts = NDArray[np.int64]


class SignedRanks(NamedTuple):
    """Results of the signed-rank test; each array has the shape of the differences without their last axis.

    `below`, `equal` and `above` count the trials whose difference is negative, zero and positive. `balance` is the
    matched rank-biserial correlation in [-1, 1]: positive if differences mostly are, 0 if there are none. `p` is
    two-sided.
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
    order = np.argsort(values, axis=-1, kind="stable")
    ordered = np.take_along_axis(values, order, axis=-1)
    starts = np.ones(values.shape, np.bool_)  # the first of equal values
    starts[..., 1:] = ordered[..., 1:] != ordered[..., :-1]
    place = np.broadcast_to(np.arange(values.shape[-1]), values.shape)
    first = np.maximum.accumulate(np.where(starts, place, 0), axis=-1)
    ends = np.ones(values.shape, np.bool_)  # the last of equal values
    ends[..., :-1] = starts[..., 1:]
    backwards = np.where(ends, place, values.shape[-1])[..., ::-1]
    last = np.minimum.accumulate(backwards, axis=-1)[..., ::-1]
    ranks = np.empty(values.shape)
    np.put_along_axis(ranks, order, (first + last) / 2 + 1, axis=-1)
    return np.where(np.isnan(values), np.nan, ranks)


def signed_ranks(off: Floats) -> SignedRanks:
    """The two-sided test that differences `off` (..., trial) are symmetric about 0; NaN is ignored.

    The null hypothesis is that the sign of each difference is random, as it is if two contenders are exchangeable in
    every trial. The p-value is the share of sign patterns whose rank sums are at least as far apart as the observed
    ones. Zeros are ranked and then dropped (Pratt). For more than 64 non-zero differences, the p-value is that of the
    normal approximation with continuity correction. Without any difference it is 1.
    """
    flat = off.reshape(math.prod(off.shape[:-1]), off.shape[-1])
    mantissa, exponent = np.frexp(np.abs(flat))
    sizes = np.ldexp(np.rint(mantissa * KEPT_BITS), exponent)  # ties of decimal numbers stay ties
    weights = np.rint(2 * np.nan_to_num(midranks(sizes))).astype(np.int64)  # twice the ranks, which may be halves
    weights[(flat == 0) | np.isnan(flat)] = 0
    above = np.where(flat > 0, weights, 0).sum(axis=1)
    total = weights.sum(axis=1)
    balance = (2 * above - total) / np.maximum(total, 1)
    p = np.minimum(1.0, 2 * _tails(weights, np.minimum(above, total - above)))
    shape = off.shape[:-1]
    counts = [(flat < 0).sum(axis=1), (flat == 0).sum(axis=1), (flat > 0).sum(axis=1)]
    below, equal, over = (count.reshape(shape) for count in counts)
    return SignedRanks(below, equal, over, balance.reshape(shape), p.reshape(shape))


def _tails(weights: Counts, least: Counts) -> Floats:
    """The chance that a random subset of the weights (row, trial) of a row has a sum of `least` (row,) or less.

    Each weight is in the subset with probability 1/2.
    """
    tails = np.ones(len(weights))
    many = (weights > 0).sum(axis=1) > EXACT
    if many.any():
        middle, spread = weights[many].sum(axis=1) / 2, np.sqrt((weights[many] ** 2).sum(axis=1)) / 2
        step = np.gcd.reduce(weights[many], axis=1) / 2  # half the smallest step between sums
        z = np.minimum(least[many] + step - middle, 0.0) / spread
        tails[many] = [NormalDist().cdf(score) for score in z.tolist()]
    few = np.flatnonzero(~many & (weights > 0).any(axis=1))
    if not few.size:
        return tails
    distinct, which = np.unique(np.sort(weights[few], axis=1), axis=0, return_inverse=True)
    which = which.ravel()
    grouped = np.argsort(which, kind="stable")
    starts = np.searchsorted(which[grouped], np.arange(len(distinct) + 1))
    for k, row in enumerate(distinct):
        rows = few[grouped[starts[k] : starts[k + 1]]]
        tails[rows] = _exact(row[row > 0], least[rows])
    return tails


def _exact(weights: Counts, least: Counts) -> Floats:
    """`_tails` for one row of positive weights in rising order, and several sums `least`."""
    unit = int(np.gcd.reduce(weights))
    reach = int(least.max()) // unit + 1
    ways = np.zeros(reach)
    ways[0], top = 1.0, 1
    for weight in (weights // unit).tolist():
        top = min(top + weight, reach)
        if weight < top:
            ways[weight:top] += ways[: top - weight]
    return np.asarray(np.cumsum(ways)[least // unit] / math.ldexp(1.0, len(weights)))
