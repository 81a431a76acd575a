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
from swarmcensus.theory.checks import count, one_share, positive, shares

Drawn = Literal["exactly", "one by one"]
Truth = Literal["floor", "nominal"]


def even_concentration(readings: ArrayLike, tiles: int) -> Floats:
    """The expected C if each reading falls on any tile with equal probability: 1/T + (1 - 1/T)/M.

    Raises InputError, also for less than one reading.
    """
    t = positive("readings", readings)
    if (t < 1.0).any():
        raise InputError.at("readings", f"{float(t.min()):g}", "should be 1 or above")
    return np.asarray(1.0 / t + (1.0 - 1.0 / t) / count("tiles", tiles))


def tiles_variance(
    concentrated: ArrayLike, fill_ratio: float, tiles: int, *, drawn: Drawn = "one by one", truth: Truth = "nominal"
) -> Floats:
    """The floor's part of the variance, for a concentration C on M tiles without order: the second part above.

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


def _among(name: str, value: str, known: tuple[str, ...]) -> None:
    if value not in known:
        raise InputError.at(name, repr(value), f"should be {' or '.join(map(repr, known))}")
