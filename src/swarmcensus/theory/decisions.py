"""Which share of robots decides for the right bin: of an exact law, and of a normal one.

Bins are those of the engine: [0, 1/B), [1/B, 2/B), ..., the last one closed. A pooled or a mixed estimate is a weighted
mean of many readings, and so nearly normal, cut to [0, 1].
"""

import itertools
import math

import numpy as np
from numpy.typing import ArrayLike

from swarmcensus.basics.bins import right_bin
from swarmcensus.basics.errors import InputError
from swarmcensus.theory.checks import Floats, count, fitting, from_zero, numbers, one_share
from swarmcensus.theory.local import Law

HALVINGS = 48  # of the unit interval: to rounding

_erf = np.vectorize(math.erf, otypes=[np.float64])


def right_share(law: Law, fill_ratio: float, bins: int = 10) -> float:
    """The expected share of robots in the bin of the fill ratio, where each robot's estimate has this law.

    It is the chance that one robot is right, and so the expected share whether robots depend on each other or not.
    Raises InputError.
    """
    low, high = right_bin(one_share("fill_ratio", fill_ratio), count("bins", bins))
    return law.between(low, high)


def bin_shares(law: Law, bins: int = 10) -> Floats:
    """The expected share of robots in every bin, (bin,), from the lowest on. Raises InputError."""
    edges = np.arange(count("bins", bins) + 1) / bins
    edges[[0, -1]] = -np.inf, np.inf
    return np.array([law.between(low, high) for low, high in itertools.pairwise(edges)])


def normal_right_share(variance: ArrayLike, fill_ratio: float, bins: int = 10, bias: ArrayLike = 0.0) -> Floats:
    """The same where estimates are normal about f + bias with this variance, cut to [0, 1]; of the shape of both.

    A variance of 0 is an estimate that lies at f + bias. Raises InputError.
    """
    f = one_share("fill_ratio", fill_ratio)
    spread, off = fitting(variance=from_zero("variance", variance), bias=numbers("bias", bias))
    low, high = right_bin(f, count("bins", bins))
    centre, sd = f + off, np.sqrt(spread)
    known = sd > 0.0
    scale = np.sqrt(2.0) * np.where(known, sd, 1.0)
    below = [0.5 * (1.0 + _erf((end - centre) / scale)) for end in (low, high)]
    return np.where(known, below[1] - below[0], (low <= centre) & (centre < high))


def normal_median_error(variances: ArrayLike, fill_ratio: float) -> Floats:
    """The median of |x - f| over robots whose estimates are normal about f, each with a variance of its own.

    Estimates are cut to [0, 1]. `variances` is (..., robot), the medians (...). By bisection: the share of robots
    within e of f grows with e. Raises InputError.
    """
    f, spread = one_share("fill_ratio", fill_ratio), numbers("variances", variances)
    if spread.ndim == 0 or not spread.size or (spread < 0.0).any():
        raise InputError("variances: should be numbers from 0 on, one a robot")
    known = spread > 0.0
    scale = np.sqrt(2.0 * np.where(known, spread, 1.0))
    low, high = np.zeros(spread.shape[:-1]), np.full(spread.shape[:-1], max(f, 1.0 - f))
    for _ in range(HALVINGS):
        middle = (low + high) / 2.0
        within = np.where(known, _erf(middle[..., np.newaxis] / scale), 1.0)
        sides = [np.where(middle[..., np.newaxis] >= room, 1.0, within) for room in (f, 1.0 - f)]
        enough = ((sides[0] + sides[1]) / 2.0).mean(axis=-1) >= 0.5
        low, high = np.where(enough, low, middle), np.where(enough, middle, high)
    return np.asarray(high)
