"""The paired signed-rank test of many pairs at once: exact with ties, zeros and infinities.

Wilcoxon, "Individual comparisons by ranking methods", 1945; zeros as Pratt, "Remarks on zeros and ties in the Wilcoxon
signed rank procedures", 1959; the rank-biserial correlation of matched pairs as Kerby, "The simple difference formula",
2014.
"""

import math
from statistics import NormalDist
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from swarmcensus.statistics.intervals import ROUNDING

EXACT = 64  # differences that are not 0, up to which p is exact; the count of sign patterns is then 2^64
FEW_BITS = 2.0**30  # of a difference: those that agree to nine digits are tied, whatever rounding left of the others

Floats = NDArray[np.float64]
Counts = NDArray[np.int64]


class SignedRanks(NamedTuple):
    """What the signed-rank test says of differences, each array of the shape of all axes but the last.

    `below`, `equal` and `above` count the trials whose difference is less than 0, 0 and more; `balance` is the matched
    rank-biserial correlation in [-1, 1], above 0 where differences mostly are, and 0 without any; `p` is two-sided.
    """

    below: Counts
    equal: Counts
    above: Counts
    balance: Floats
    p: Floats


def differences(one: Floats, other: Floats) -> Floats:
    """What `one` exceeds `other` by, in each place: 0 where they differ by rounding or both are the same infinity.

    NaN where either is.
    """
    with np.errstate(invalid="ignore"):
        off = one - other
        alike = (one == other) | (np.abs(off) <= ROUNDING * np.maximum(np.abs(one), np.abs(other)))
    alike &= (np.isfinite(one) & np.isfinite(other)) | (one == other)
    return np.where(alike, 0.0, off)


def midranks(values: Floats) -> Floats:
    """The ranks from 1 along the last axis; equal values share the mean of theirs, and NaN have NaN."""
    order = np.argsort(values, axis=-1, kind="stable")
    ordered = np.take_along_axis(values, order, axis=-1)
    new = np.ones(values.shape, np.bool_)
    new[..., 1:] = ordered[..., 1:] != ordered[..., :-1]
    place = np.broadcast_to(np.arange(values.shape[-1]), values.shape)
    first = np.maximum.accumulate(np.where(new, place, 0), axis=-1)
    ends = np.ones(values.shape, np.bool_)
    ends[..., :-1] = new[..., 1:]
    backwards = np.where(ends, place, values.shape[-1])[..., ::-1]
    last = np.minimum.accumulate(backwards, axis=-1)[..., ::-1]
    ranks = np.empty(values.shape)
    np.put_along_axis(ranks, order, (first + last) / 2 + 1, axis=-1)
    return np.where(np.isnan(values), np.nan, ranks)


def signed_ranks(off: Floats) -> SignedRanks:
    """The test that differences `off` (..., trial) are as likely above 0 as below, by as much; NaN are left out.

    The null hypothesis is that each difference might as well have had the other sign, as it might where two contenders
    are exchangeable in every trial; p counts the sign patterns whose rank sums are as far apart as those seen, or
    farther. Zeros are ranked and then left out (Pratt). Beyond 64 differences p is that of the normal distribution,
    with a correction for continuity. Without a difference p is 1.
    """
    flat = off.reshape(math.prod(off.shape[:-1]), off.shape[-1])
    mantissa, exponent = np.frexp(np.abs(flat))
    sizes = np.ldexp(np.rint(mantissa * FEW_BITS), exponent)  # so that ties of decimal numbers stay ties
    weights = np.rint(2 * np.nan_to_num(midranks(sizes))).astype(np.int64)  # whole: ranks may be halves
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
    """The chance that weights (row, trial), each taken or not by a coin's toss, add up to `least` (row,) or less."""
    tails = np.ones(len(weights))
    many = (weights > 0).sum(axis=1) > EXACT
    if many.any():
        middle, spread = weights[many].sum(axis=1) / 2, np.sqrt((weights[many] ** 2).sum(axis=1)) / 2
        step = np.gcd.reduce(weights[many], axis=1) / 2  # half of what the sum moves by
        z = np.minimum(least[many] + step - middle, 0.0) / spread
        tails[many] = [NormalDist().cdf(one) for one in z.tolist()]
    few = np.flatnonzero(~many & (weights > 0).any(axis=1))
    if not few.size:
        return tails
    kinds, which = np.unique(np.sort(weights[few], axis=1), axis=0, return_inverse=True)
    which = which.ravel()
    by_kind = np.argsort(which, kind="stable")
    starts = np.searchsorted(which[by_kind], np.arange(len(kinds) + 1))
    for kind, row in enumerate(kinds):
        mine = few[by_kind[starts[kind] : starts[kind + 1]]]
        tails[mine] = _exact(row[row > 0], least[mine])
    return tails


def _exact(weights: Counts, least: Counts) -> Floats:
    """The same of one row's weights, in rising order and none of them 0, for several sums."""
    unit = int(np.gcd.reduce(weights))
    reach = int(least.max()) // unit + 1
    ways = np.zeros(reach)
    ways[0], top = 1.0, 1
    for weight in (weights // unit).tolist():
        top = min(top + weight, reach)
        if weight < top:
            ways[weight:top] += ways[: top - weight]
    return np.asarray(np.cumsum(ways)[least // unit] / math.ldexp(1.0, len(weights)))
