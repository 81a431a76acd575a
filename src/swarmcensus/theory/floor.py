"""Finite floors: robots see some of the tiles several times, and others never.

A floor has M tiles, and a share a_m of the T readings falls on tile m, on a path that does not depend on colours. Then
the error of a mean of corrected readings has two independent parts: the sensor's, which falls with T, and the floor's,
which falls as tiles are visited more evenly:

    Var = (f b (1 - b) + (1 - f) w (1 - w)) / (k^2 T)  +  sum_{m,m'} d_m d_m' Cov(c_m, c_m').

c_m is 1 if tile m is black. For errors against the floor's own black share, d_m = a_m - 1/M; against the nominal f,
d_m = a_m. With exactly f M black tiles in random places, the second part is f (1 - f) (M C - 1) / (M - 1) in both
cases, where C = sum a_m^2. With tiles drawn one by one it is f (1 - f) (C - 1/M), or f (1 - f) C against the nominal f.
This follows from Var(mean of X) = E Var(X | colours) + Var E(X | colours), as readings are independent given colours.
"""

from typing import Literal, get_args

import numpy as np
from numpy.typing import ArrayLike

from swarmcensus.support.errors import InputError
from swarmcensus.support.intervals import Floats
from swarmcensus.theory.checks import BLIND, count, fitting, numbers, one_share, positive, sensors, shares

Drawn = Literal["exactly", "one by one"]
Truth = Literal["floor", "nominal"]


def concentration(visits: ArrayLike) -> float:
    """C = sum a_m^2, from the numbers of readings or visits (tile,): 1/M if all tiles have as many, 1 if one has all.

    Tiles without visits may be left out. Raises InputError.
    """
    return float((_visit_shares(visits) ** 2).sum())


def even_concentration(readings: ArrayLike, tiles: int) -> Floats:
    """The expected C if each reading falls on any tile with equal probability: 1/T + (1 - 1/T)/M.

    Raises InputError, also for less than one reading.
    """
    t = positive("readings", readings)
    if (t < 1.0).any():
        raise InputError.at("readings", f"{float(t.min()):g}", "should be 1 or above")
    return np.asarray(1.0 / t + (1.0 - 1.0 / t) / count("tiles", tiles))


def sensing_variance(readings: ArrayLike, fill_ratio: float, b: float, w: float | None = None) -> Floats:
    """The sensor's part of the variance of a mean of corrected readings, given the colours: the first part above.

    It is less than `robot_bound`, which includes the drawing of tiles. Raises InputError, also for b + w = 1.
    """
    f, t = one_share("fill_ratio", fill_ratio), positive("readings", readings)
    black, white = sensors(b, w)
    t, black, white = fitting(readings=t, b=black, w=white)
    slope = black + white - 1.0
    if (np.abs(slope) < BLIND).any():
        raise InputError("b + w = 1: such a sensor's readings say nothing about the floor", key="b")
    errs = f * black * (1.0 - black) + (1.0 - f) * white * (1.0 - white)
    return np.asarray(errs / slope**2 / t)


def tiles_variance(
    concentrated: ArrayLike, fill_ratio: float, tiles: int, *, drawn: Drawn = "one by one", truth: Truth = "nominal"
) -> Floats:
    """The floor's part of the variance, for a `concentration` C on M tiles without order: the second part above.

    `drawn` is "exactly" for a floor with exactly f M black tiles. `truth` is what estimates are compared with. Raises
    InputError, also for a C below 1/M or above 1.
    """
    f, m = one_share("fill_ratio", fill_ratio), count("tiles", tiles)
    c = shares("concentration", concentrated)
    _among("drawn", drawn, get_args(Drawn))
    _among("truth", truth, get_args(Truth))
    if (c < (1.0 - 1e-9) / m).any():
        raise InputError.at("concentration", f"{float(c.min()):g}", f"should be 1/tiles or above, {1.0 / m:g}")
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


def _visit_shares(visits: ArrayLike) -> Floats:
    found = numbers("visits", visits)
    if found.ndim != 1 or (found < 0.0).any() or not found.sum() > 0.0:
        raise InputError("visits: should be numbers from 0 on, one a tile, and not all 0", key="visits")
    return np.asarray(found / found.sum())


def _among(name: str, value: str, known: tuple[str, ...]) -> None:
    if value not in known:
        raise InputError.at(name, repr(value), f"should be {' or '.join(map(repr, known))}")
