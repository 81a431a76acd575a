"""The expected squared error of an estimate that is cut to [0, 1], and that a prior draws to 1/2.

A prior of mean 1/2 that weighs p beside evidence v makes (s + p / 2) / (v + p) of the ratio s / v: a share
p / (v + p), its `pull`, of the way to 1/2. So the estimate has (1 - pull)^2 of the ratio's variance and a bias of
pull (1/2 - f), as v does not depend on readings. The error of an estimate that is cut has no closed form, but of one
robot's readings, or of several robots' with equal sensors, all counts of black can be listed with their chances.
"""

import math

import numpy as np
from numpy.typing import ArrayLike

from swarmcensus.basics.errors import InputError
from swarmcensus.theory.checks import (
    BLIND,
    MOST_READINGS,
    Floats,
    count,
    fitting,
    from_zero,
    one_share,
    sensors,
    shares,
)
from swarmcensus.theory.local import binomial

_erf = np.vectorize(math.erf, otypes=[np.float64])


def local_squared_error(
    readings: int, fill_ratio: float, b: ArrayLike, w: ArrayLike | None = None, pull: ArrayLike = 0.0
) -> Floats:
    """The mean of (x - f)^2 of the local estimate (paper, Eq. 4) after so many `readings`, cut to [0, 1].

    `pull` is the share of its way to 1/2 that a prior draws it before it is cut. Of the shape of the sensors; time is
    O(readings) for each that is another. With b + w = 1, x stays at 1/2. Raises InputError.
    """
    t = count("readings", readings, 1, MOST_READINGS)
    f, (black, white) = one_share("fill_ratio", fill_ratio), sensors(b, w)
    black, white, share = fitting(b=black, w=white, pull=shares("pull", pull))
    kinds, which = np.unique(np.stack([black.ravel(), white.ravel(), share.ravel()]), axis=1, return_inverse=True)
    said = np.arange(t + 1) / t
    found = []
    for b_, w_, h in kinds.T.tolist():
        slope = b_ + w_ - 1.0
        if abs(slope) < BLIND:
            found.append((0.5 - f) ** 2)
            continue
        x = np.clip((1.0 - h) * (said + w_ - 1.0) / slope + 0.5 * h, 0.0, 1.0)
        found.append(float(binomial(t, slope * f + 1.0 - w_) @ (x - f) ** 2))
    return np.array(found)[which.ravel()].reshape(black.shape)


def pulled_squared_error(variance: ArrayLike, fill_ratio: float, pull: ArrayLike) -> Floats:
    """The mean of (x - f)^2 of an unbiased estimate with this `variance` that a prior draws to 1/2, before it is cut.

    Of the shape of both together. Raises InputError.
    """
    spread, share = _normal(variance, pull)
    bias = share * (0.5 - one_share("fill_ratio", fill_ratio))
    return np.asarray((1.0 - share) ** 2 * spread + bias**2)


def cut_off(variance: ArrayLike, fill_ratio: float, pull: ArrayLike = 0.0) -> Floats:
    """By how much cutting such an estimate to [0, 1] lowers its mean of (x - f)^2, were it normal.

    Below 0 that is the mean of (x - f)^2 - f^2 where x < 0, and above 1 likewise. Of the shape of variance and pull
    together. Raises InputError.
    """
    f, (spread, share) = one_share("fill_ratio", fill_ratio), _normal(variance, pull)
    bias, sd = share * (0.5 - f), (1.0 - share) * np.sqrt(spread)
    total = np.zeros(sd.shape)
    for end, off in ((f, bias), (1.0 - f, -bias)):
        z = (end + off) / np.where(sd > 0.0, sd, np.inf)
        density = np.exp(-0.5 * z**2) / np.sqrt(2.0 * np.pi)
        beyond = 0.5 * (1.0 - _erf(z / np.sqrt(2.0)))
        part = (off**2 - end**2 + sd**2) * beyond + (sd * z - 2.0 * off) * sd * density
        total += np.where(sd > 0.0, part, 0.0)
    return total


def _normal(variance: ArrayLike, pull: ArrayLike) -> tuple[Floats, Floats]:
    """Finite variances and shares, of one shape. Raises InputError."""
    found = from_zero("variance", variance)
    if np.isinf(found).any():
        raise InputError("variance: should be finite")
    found, share = fitting(variance=found, pull=shares("pull", pull))
    return found, share
