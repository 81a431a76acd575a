"""Cramer-Rao bounds: how near any unbiased estimate of the fill ratio can come, of a robot, a neighbourhood, a swarm.

A reading is black with q = k f + 1 - w, where k = b + w - 1. So it holds the Fisher information k^2 / (q (1 - q)) about
f, independent readings add theirs up, and no unbiased estimate has a smaller variance than one over the sum. Estimates
that are cut to [0, 1] are biased near the ends, and may do better there.
"""

import numpy as np
from numpy.typing import ArrayLike

from swarmcensus.basics.errors import InputError
from swarmcensus.theory.checks import Floats, count, fitting, from_zero, numbers, positive, sensors, shares

MEDIAN = 0.6744897501960817  # standard deviations: the middle half of a normal law lies within


def information(fill_ratio: ArrayLike, b: ArrayLike, w: ArrayLike | None = None) -> Floats:
    """The Fisher information of one reading about f, of the shape of all together; w is b by default.

    0 with b + w = 1; infinite where the readings are certain, as those of a perfect sensor on a floor all black. Raises
    InputError.
    """
    black, white = sensors(b, w)
    f, black, white = fitting(fill_ratio=shares("fill_ratio", fill_ratio), b=black, w=white)
    slope = black + white - 1.0
    q = slope * f + 1.0 - white
    with np.errstate(divide="ignore", invalid="ignore"):
        found = slope**2 / np.maximum(q * (1.0 - q), 0.0)
    return np.where(np.abs(slope) < 1e-12, 0.0, found)


def reading_variance(fill_ratio: ArrayLike, b: ArrayLike, w: ArrayLike | None = None) -> Floats:
    """The variance q (1 - q) / k^2 of one reading corrected for its sensor, (X - 1 + w) / k, which is unbiased for f.

    Infinite with b + w = 1. One over `information`. Raises InputError.
    """
    with np.errstate(divide="ignore"):
        return np.asarray(1.0 / information(fill_ratio, b, w))


def robot_bound(readings: ArrayLike, fill_ratio: ArrayLike, b: ArrayLike, w: ArrayLike | None = None) -> Floats:
    """The least variance of what a robot alone can know after so many `readings`: q (1 - q) / (k^2 t).

    Arrays of one shape, or numbers. Raises InputError.
    """
    black, white = sensors(b, w)
    t, f = positive("readings", readings), shares("fill_ratio", fill_ratio)
    t, f, black, white = fitting(readings=t, fill_ratio=f, b=black, w=white)
    return np.asarray(reading_variance(f, black, white) / t)


def swarm_bound(
    readings: ArrayLike, fill_ratio: float, b: ArrayLike, w: ArrayLike | None = None, robots: int | None = None
) -> Floats:
    """The least variance of what a whole swarm can know that has made so many `readings` a robot.

    Of unequal sensors, b and w are (robot,), or (trial, robot): one over the sum of all informations. Of equal ones
    they are numbers, and `robots` says how many there are. So d + 1 robots are the neighbourhood of one with d
    neighbours. `readings` (rounds times readings a round) may be an array: (readings, ...) comes out. Raises
    InputError.
    """
    told = information(fill_ratio, b, w)
    if told.ndim == 0:
        total = told * count("robots", 1 if robots is None else robots)
    elif robots not in (None, told.shape[-1]):
        raise InputError(f"robots = {robots}: b has {told.shape[-1]} numbers, one a robot: leave robots out")
    else:
        total = told.sum(axis=-1)
    return _outer(positive("readings", readings), total)


def neighbourhood_bound(
    matrix: ArrayLike, readings: ArrayLike, fill_ratio: float, b: ArrayLike, w: ArrayLike | None = None
) -> Floats:
    """The least variance of what each robot and those that it hears have seen: all that the paper's brain can use.

    `matrix` (robot, robot) is not 0 where a row's robot hears a column's, as `mixing_matrix` gives it; a robot always
    hears itself. b and w are numbers or (robot,). Of the shape (readings, robot), or (robot,) for one number. Raises
    InputError.
    """
    hears = numbers("matrix", matrix) != 0.0
    robots = len(hears) if hears.ndim else 0
    if hears.shape != (robots, robots):
        raise InputError(f"matrix has the shape {hears.shape}: should be a square, a row and a column a robot")
    told = information(fill_ratio, b, w)
    if told.shape not in ((), (robots,)):
        raise InputError(f"b has the shape {told.shape}: should be one number, or {robots}, one a robot")
    told = np.broadcast_to(told, (robots,))
    np.fill_diagonal(hears, True)
    total = np.array([told[row].sum() for row in hears])
    return _outer(positive("readings", readings), total)


def median_error(variance: ArrayLike) -> Floats:
    """The median of |x - f| where x is normal about f with this variance: 0.6745 standard deviations.

    Of the variance's shape. Raises InputError.
    """
    return np.asarray(MEDIAN * np.sqrt(from_zero("variance", variance)))


def _outer(readings: Floats, total: Floats) -> Floats:
    with np.errstate(divide="ignore"):
        return np.asarray(1.0 / np.multiply.outer(readings, total))
