"""Cramer-Rao bounds: the least variance of unbiased estimates of the fill ratio, for a robot, a neighbourhood, a swarm.

A reading is black with probability q = k f + 1 - w, where k = b + w - 1. So its Fisher information about f is
k^2 / (q (1 - q)), the informations of independent readings add up, and no unbiased estimate has a smaller variance than
one over their sum. Estimates that are cut to [0, 1] are biased near the ends, and may have a smaller error there.
"""

import numpy as np
from numpy.typing import ArrayLike

from swarmcensus.support.errors import InputError
from swarmcensus.support.formatting import counted
from swarmcensus.support.intervals import Floats
from swarmcensus.theory.checks import count, fitting, from_zero, misshapen, numbers, positive, sensors, shares

MEDIAN = 0.6744897501960817  # standard deviations: half of a normal distribution lies within


def information(fill_ratio: ArrayLike, b: ArrayLike, w: ArrayLike | None = None) -> Floats:
    """The Fisher information of one reading about f, in the broadcast shape of all arguments; w is b by default.

    It is 0 if b + w = 1, and infinite if readings are certain, as those of a perfect sensor on an all-black floor.
    Raises InputError.
    """
    black, white = sensors(b, w)
    f, black, white = fitting(fill_ratio=shares("fill_ratio", fill_ratio), b=black, w=white)
    slope = black + white - 1.0
    q = slope * f + 1.0 - white
    with np.errstate(divide="ignore", invalid="ignore"):
        known = slope**2 / np.maximum(q * (1.0 - q), 0.0)
    return np.where(np.abs(slope) < 1e-12, 0.0, known)


def reading_variance(fill_ratio: ArrayLike, b: ArrayLike, w: ArrayLike | None = None) -> Floats:
    """The variance q (1 - q) / k^2 of one reading corrected for its sensor, (X - 1 + w) / k, which is unbiased for f.

    It is one over `information`, and infinite if b + w = 1. Raises InputError.
    """
    with np.errstate(divide="ignore"):
        return np.asarray(1.0 / information(fill_ratio, b, w))


def swarm_bound(
    readings: ArrayLike, fill_ratio: float, b: ArrayLike, w: ArrayLike | None = None, robots: int | None = None
) -> Floats:
    """The least variance of an estimate from all readings of a swarm, `readings` for each robot.

    For unequal sensors, b and w are (robot,) or (trial, robot), and the bound is one over the sum of all informations.
    For equal ones they are numbers, and `robots` is the number of robots: d + 1 for a robot with d neighbours, 1 by
    default.
    `readings` (rounds times readings a round) may be an array; the result is (readings, ...). Raises InputError.
    """
    each = information(fill_ratio, b, w)
    if each.ndim == 0:
        total = each * count("robots", 1 if robots is None else robots)
    elif robots not in (None, each.shape[-1]):
        has = f"b has {counted(each.shape[-1], 'number')}, one a robot: leave robots out"
        raise InputError.at("robots", robots, has)
    else:
        total = each.sum(axis=-1)
    return _outer(positive("readings", readings), total)


def neighbourhood_bound(
    matrix: ArrayLike, readings: ArrayLike, fill_ratio: float, b: ArrayLike, w: ArrayLike | None = None
) -> Floats:
    """The least variance of an estimate from the readings of a robot and of those that it hears.

    That is all that the paper's brain can use. `matrix` (robot, robot) is not 0 where a row's robot hears a column's,
    as `mixing_matrix` gives it; a robot always hears itself. b and w are numbers or (robot,). Returns
    (readings, robot), or (robot,) for one number. Raises InputError.
    """
    hears = numbers("matrix", matrix) != 0.0
    robots = len(hears) if hears.ndim else 0
    if hears.shape != (robots, robots):
        raise misshapen("matrix", hears, "a square, a row and a column a robot")
    each = information(fill_ratio, b, w)
    if each.shape not in ((), (robots,)):
        raise misshapen("b", each, f"one number, or {robots}, one a robot")
    each = np.broadcast_to(each, (robots,))
    np.fill_diagonal(hears, True)
    total = np.array([each[row].sum() for row in hears])
    return _outer(positive("readings", readings), total)


def median_error(variance: ArrayLike) -> Floats:
    """The median of |x - f| if x is normal about f with this variance: 0.6745 standard deviations.

    Returns the shape of `variance`. Raises InputError.
    """
    return np.asarray(MEDIAN * np.sqrt(from_zero("variance", variance)))


def _outer(readings: Floats, total: Floats) -> Floats:
    with np.errstate(divide="ignore"):
        return np.asarray(1.0 / np.multiply.outer(readings, total))
