"""The floor itself: tiles are finite in number, robots see some of them again, and others never.

A floor has M tiles, and a share a_m of the T readings falls on tile m, on a path that does not depend on colours. Then
a mean of corrected readings errs by two parts that are independent of each other: the sensor's, which falls with T, and
the floor's, which falls as tiles are visited more evenly:

    Var = (f b (1 - b) + (1 - f) w (1 - w)) / (k^2 T)  +  sum_{m,m'} d_m d_m' Cov(c_m, c_m').

c_m is 1 where tile m is black. Against the floor's own black share, d_m = a_m - 1/M; against the nominal f, d_m = a_m.
With exactly f M black tiles, in places of no order, the second part is f (1 - f) (M C - 1) / (M - 1) either way, where
C = sum a_m^2; of tiles drawn one by one it is f (1 - f) (C - 1/M), or f (1 - f) C against the nominal f. Derived from
Var(mean of X) = E Var(X | colours) + Var E(X | colours), readings being independent given the colours.
"""

import math
from typing import Literal, get_args

import numpy as np
from numpy.typing import ArrayLike

from swarmcensus.basics.errors import InputError
from swarmcensus.basics.formatting import counted
from swarmcensus.theory.checks import BLIND, Floats, count, fitting, numbers, one_share, positive, sensors, shares

Drawn = Literal["exactly", "one by one"]
Truth = Literal["floor", "nominal"]
MOST_TILES = 20_000  # of a covariance: tile by tile


def concentration(visits: ArrayLike) -> float:
    """C = sum a_m^2 of readings or visits a tile (tile,): 1/M where all tiles have as many, 1 where one has all.

    Tiles that nobody visits may be left out. Raises InputError.
    """
    return float((_visited(visits) ** 2).sum())


def even_concentration(readings: ArrayLike, tiles: int) -> Floats:
    """The expected C where each reading falls on any of the tiles alike: 1/T + (1 - 1/T)/M.

    Raises InputError, also for less than one reading.
    """
    t = positive("readings", readings)
    if (t < 1.0).any():
        raise InputError(f"readings = {float(t.min()):g}: should be 1 or above")
    return np.asarray(1.0 / t + (1.0 - 1.0 / t) / count("tiles", tiles))


def sensing_variance(readings: ArrayLike, fill_ratio: float, b: float, w: float | None = None) -> Floats:
    """What the sensor leaves of a mean of so many corrected readings, colours being given: the first part above.

    Less than `robot_bound`, which counts the drawing of the tiles too. Raises InputError, also for b + w = 1.
    """
    f, t = one_share("fill_ratio", fill_ratio), positive("readings", readings)
    black, white = sensors(b, w)
    t, black, white = fitting(readings=t, b=black, w=white)
    slope = black + white - 1.0
    if (np.abs(slope) < BLIND).any():
        raise InputError("b + w = 1: such a sensor's readings say nothing of the floor")
    errs = f * black * (1.0 - black) + (1.0 - f) * white * (1.0 - white)
    return np.asarray(errs / slope**2 / t)


def tiles_variance(
    concentrated: ArrayLike, fill_ratio: float, tiles: int, *, drawn: Drawn = "one by one", truth: Truth = "nominal"
) -> Floats:
    """What the floor leaves, of `concentration` C on so many tiles: the second part above, of tiles in no order.

    `drawn` is "exactly" for a floor with exactly f M black tiles; `truth` is what the estimate is held against. Raises
    InputError, also for a C below 1/M, or above 1.
    """
    f, m = one_share("fill_ratio", fill_ratio), count("tiles", tiles)
    c = shares("concentration", concentrated)
    _among("drawn", drawn, get_args(Drawn))
    _among("truth", truth, get_args(Truth))
    if (c < (1.0 - 1e-9) / m).any():
        raise InputError(f"concentration = {float(c.min()):g}: should be 1/tiles or above, {1.0 / m:g}")
    if drawn == "exactly":
        return np.maximum(f * (1.0 - f) * (m * c - 1.0) / max(m - 1, 1), 0.0)
    return np.maximum(f * (1.0 - f) * (c - (1.0 / m if truth == "floor" else 0.0)), 0.0)


def floor_variance(
    readings: ArrayLike,
    concentrated: ArrayLike,
    tiles: int,
    fill_ratio: float,
    b: float,
    w: float | None = None,
    *,
    drawn: Drawn = "one by one",
    truth: Truth = "nominal",
) -> Floats:
    """The variance of a mean of corrected readings on a finite floor: both parts above. Raises InputError."""
    of_tiles = tiles_variance(concentrated, fill_ratio, tiles, drawn=drawn, truth=truth)
    of_sensors, of_tiles = fitting(readings=sensing_variance(readings, fill_ratio, b, w), concentration=of_tiles)
    return np.asarray(of_sensors + of_tiles)


def covariance_variance(visits: ArrayLike, covariance: ArrayLike, *, truth: Truth = "nominal") -> float:
    """The second part above for tiles of any order: visits (tile,) and Cov(c_m, c_m') (tile, tile).

    With `truth` "floor" the tiles must be all that there are, also those that nobody visits. Raises InputError, also
    for more than 20,000 tiles.
    """
    weights = _visited(visits)
    _among("truth", truth, get_args(Truth))
    if weights.size > MOST_TILES:
        raise InputError(f"visits: {counted(weights.size, 'tile')}: should be {MOST_TILES:,} at the most")
    between = numbers("covariance", covariance)
    if between.shape != (weights.size, weights.size):
        raise InputError(
            f"covariance has the shape {between.shape}: should be {weights.size} by {counted(weights.size, 'tile')}"
        )
    if truth == "floor":
        weights = weights - 1.0 / weights.size
    return max(float(weights @ between @ weights), 0.0)


def cluster_covariance(fill_ratio: float, correlation: ArrayLike) -> Floats:
    """Cov(c, c') of two tiles that are black where a Gaussian field is lowest, from the field's correlation there.

    The shipped floor `clusters` has the correlation exp(-(d / length)^2) at a distance d. P(both below z) grows with
    the correlation r by the bivariate density exp(-z^2 / (1 + r)) / (2 pi sqrt(1 - r^2)); integrated over r = sin(u)
    from 0 on (Plackett, 1954), by Gauss and Legendre in 64 points. Of the correlation's shape. Raises InputError.
    """
    from statistics import NormalDist

    f, r = one_share("fill_ratio", fill_ratio), numbers("correlation", correlation)
    if (np.abs(r) > 1.0).any():
        raise InputError("correlation: should be from -1 to 1")
    if f in (0.0, 1.0):
        return np.zeros(r.shape)
    z = NormalDist().inv_cdf(f)
    nodes, weights = np.polynomial.legendre.leggauss(64)
    half = np.arcsin(r)[..., np.newaxis] / 2.0
    inner = np.exp(-(z**2) / (1.0 + np.sin(half * (nodes + 1.0))))
    return np.asarray((half * weights * inner).sum(axis=-1) / (2.0 * math.pi))


def _visited(visits: ArrayLike) -> Floats:
    found = numbers("visits", visits)
    if found.ndim != 1 or (found < 0.0).any() or not found.sum() > 0.0:
        raise InputError("visits: should be numbers from 0 on, one a tile, and not all 0")
    return np.asarray(found / found.sum())


def _among(name: str, value: str, known: tuple[str, ...]) -> None:
    if value not in known:
        raise InputError(f"{name} = {value!r}: should be {' or '.join(map(repr, known))}")
