"""What wrong beliefs about sensors cost: where estimates tend to, and what an uncertain calibration adds to the error.

A robot that assumes b' and w' turns the share p of its black readings into (p + w' - 1) / (b' + w' - 1), the paper's
Eq. 4. Its error does not fall with more readings.
"""

import numpy as np
from numpy.typing import ArrayLike

from swarmcensus.support.intervals import Floats
from swarmcensus.theory.bounds import information
from swarmcensus.theory.checks import BLIND, fitting, from_zero, sensors, shares


def asymptote(b: ArrayLike, w: ArrayLike, assumed_b: ArrayLike, assumed_w: ArrayLike, fill_ratio: ArrayLike) -> Floats:
    """The limit of a robot's local estimate for many readings, if it assumes b' and w' in place of its accuracies b, w.

    A share p = b f + (1 - w)(1 - f) of its readings is black, whatever it assumes. Eq. 4 of the paper turns p into
    (p + w' - 1) / (b' + w' - 1), cut to [0, 1]; if b' + w' = 1, it is 0.5. Robots with equal sensors and beliefs have
    the same limit, so communication does not reduce the bias. Takes numbers, or arrays of one shape.
    """
    b, w, assumed_b, assumed_w, f = np.broadcast_arrays(b, w, assumed_b, assumed_w, fill_ratio)
    black = b * f + (1.0 - w) * (1.0 - f)
    slope = assumed_b + assumed_w - 1.0
    blind = np.abs(slope) < BLIND
    return np.where(blind, 0.5, np.clip((black + assumed_w - 1.0) / np.where(blind, 1.0, slope), 0.0, 1.0))


def belief_error(fill_ratio: float, b: Floats, w: Floats, assumed_b: Floats, assumed_w: Floats) -> tuple[float, float]:
    """The root mean squared error that wrong beliefs leave for a robot alone, and for a swarm that pools all readings.

    Sensors and beliefs are (trial, robot). A swarm weighs robots by the information that they believe in.
    """
    off = asymptote(b, w, assumed_b, assumed_w, fill_ratio) - fill_ratio
    weights = np.broadcast_to(information(fill_ratio, assumed_b, assumed_w), off.shape)
    weights = np.where(np.isfinite(weights).all(axis=1, keepdims=True), weights, 1.0)
    total = weights.sum(axis=1)
    pooled = np.divide((weights * off).sum(axis=1), total, where=total > 0.0, out=off.mean(axis=1))
    return float(np.mean(off**2)) ** 0.5, float(np.mean(pooled**2)) ** 0.5


def calibration_error(
    fill_ratio: ArrayLike, b: ArrayLike, w: ArrayLike, b_error: ArrayLike, w_error: ArrayLike
) -> Floats:
    """The standard deviation that standard errors of b and w add to an estimate: sqrt(f^2 eb^2 + (1 - f)^2 ew^2) / |s|.

    s = b + w - 1. It is the delta method on `asymptote`, where the errors of b and w are independent; infinite where
    s = 0. Arrays of one shape, or numbers. Raises InputError.
    """
    black, white = sensors(b, w)
    f, black, white, of_b, of_w = fitting(
        fill_ratio=shares("fill_ratio", fill_ratio), b=black, w=white,
        b_error=from_zero("b_error", b_error), w_error=from_zero("w_error", w_error),
    )  # fmt: skip
    slope = np.abs(black + white - 1.0)
    moved = np.hypot(f * of_b, (1.0 - f) * of_w)
    return np.asarray(np.divide(moved, slope, where=slope > BLIND, out=np.full(slope.shape, np.inf)))
