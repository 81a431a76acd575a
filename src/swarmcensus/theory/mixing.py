"""The exact variance of estimates from mixed running sums, for any network and any time.

In each round a robot adds its corrected readings, k (blacks - looks (1 - w)), to s, and their weight, k^2 looks, to v.
It broadcasts (s, v), and replaces them with the mean of its own and all that it hears, or with other weights W that sum
to 1. Messages arrive in the same round, so after round t readings of round r have been mixed t - r + 1 times:

    s_i(t) = sum_{m=1..t} sum_j [W^m]_ij (robot j's new s of round t - m + 1),   v_i(t) likewise,

The ratio s / v is unbiased for f with any W. Given W, and with R readings a round,

    Var = sum_{m,j} [W^m]_ij^2 k_j^2 q_j (1 - q_j) / (R (sum_{m,j} [W^m]_ij k_j^2)^2).

For equal sensors that is the variance of one corrected reading, over R, times (1 / t^2) sum_m |e_i' W^m|^2: the factor
of the network. It is 1 / (N t) in a full network, and 1 / t without links. Estimates are not cut to [0, 1], no message
is lost or late, and W is the same in every round.
"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from swarmcensus.support.errors import InputError
from swarmcensus.support.intervals import Floats
from swarmcensus.theory.checks import BLIND, count, misshapen, one_share, sensors, times
from swarmcensus.theory.matrices import checked, geometric, spectrum_of


def variance_factors(matrix: ArrayLike, rounds: int | Sequence[int]) -> Floats:
    """The factor (1 / t^2) sum_{m=1..t} |e_i' W^m|^2 of each robot after round t, for equal sensors.

    Multiplied by `reading_variance` over the readings of a round, it is the variance of the robot's estimate. Returns
    (robot,) for one number of rounds, (rounds, robot) for several. A reversible W, as of means over undirected
    neighbours, takes one decomposition of O(N^3) steps for all times; any other takes t products of matrices. Raises
    InputError.
    """
    found = checked(matrix)
    at, single = times("rounds", rounds)
    ones = np.ones(len(found))
    squares, _ = moments(found, at, ones, ones)
    factors = squares / np.square(at, dtype=np.float64)[:, np.newaxis]
    return factors[0] if single else factors


class Mixed(NamedTuple):
    """Estimates from running sums after some rounds, each (robot,) or (rounds, robot)."""

    variance: Floats  # of s / v; infinite if v is 0
    evidence: Floats  # v


def mixed_sums(
    matrix: ArrayLike, rounds: int | Sequence[int], observations_per_round: int, fill_ratio: float, b: ArrayLike,
    w: ArrayLike | None = None,
) -> Mixed:  # fmt: skip
    """The variance of each robot's estimate after round t, and its v; b and w are numbers or (robot,).

    Returns (robot,) for one number of rounds, (rounds, robot) for several. The variance is infinite for a robot that
    only has readings of sensors with b + w = 1. Raises InputError, also if all sensors are such.
    """
    found = checked(matrix)
    at, single = times("rounds", rounds)
    looks = count("observations_per_round", observations_per_round)
    black, white = sensors(b, w)
    if black.shape not in ((), (len(found),)):
        raise misshapen("b", black, f"one number, or {len(found)}, one a robot")
    slope = np.broadcast_to(black + white - 1.0, (len(found),))
    if (np.abs(slope) < BLIND).all():
        raise InputError("b + w = 1 for all robots: their readings say nothing about the floor", key="b")
    q = slope * one_share("fill_ratio", fill_ratio) + 1.0 - white
    squares, sums = moments(found, at, slope**2 * q * (1.0 - q), slope**2)
    with np.errstate(divide="ignore", invalid="ignore"):
        variance = np.where(sums > 0.0, squares / (looks * sums**2), np.inf)
    return Mixed(variance[0], looks * sums[0]) if single else Mixed(variance, looks * sums)


def moments(matrix: Floats, at: list[int], squared: Floats, summed: Floats) -> tuple[Floats, Floats]:
    """sum_{m,j} [W^m]_ij^2 squared_j and sum_{m,j} [W^m]_ij summed_j for m = 1 .. t, each (t, robot)."""
    spectrum = spectrum_of(matrix)
    if spectrum is None:
        return by_powers(matrix, at, squared, summed)
    # With S = D^(1/2) W D^(-1/2) = U L U', sum_j [W^m]_ij^2 c_j is [S^m diag(D c) S^m]_ii / d_i, and L^m is summed.
    values, vectors, root = spectrum
    inner = vectors.T @ ((root**2 * squared)[:, np.newaxis] * vectors)
    along = vectors.T @ (root * summed)
    squares = [
        ((vectors @ (inner * geometric(np.multiply.outer(values, values), t))) * vectors).sum(axis=1) / root**2
        for t in at
    ]
    sums = [vectors @ (geometric(values, t) * along) / root for t in at]
    return np.maximum(squares, 0.0), np.maximum(sums, 0.0)


def by_powers(matrix: Floats, at: list[int], squared: Floats, summed: Floats) -> tuple[Floats, Floats]:
    """`moments` for any W, power by power, in O(N^3 t) steps."""
    squares, sums = np.zeros((2, len(at), len(matrix)))
    square, total, power = np.zeros(len(matrix)), np.zeros(len(matrix)), np.eye(len(matrix))
    for m in range(1, max(at) + 1):
        power = matrix @ power
        square, total = square + power**2 @ squared, total + power @ summed
        for k in (k for k, t in enumerate(at) if t == m):
            squares[k], sums[k] = square, total
    return squares, sums
