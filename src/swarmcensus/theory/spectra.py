"""How fast and how well a network mixes: its stationary law and relaxation time."""

import math

import numpy as np
from numpy.typing import ArrayLike

from swarmcensus.support.errors import InputError
from swarmcensus.support.intervals import Floats
from swarmcensus.theory.matrices import balance, checked, spectrum_of


def stationary_law(matrix: ArrayLike) -> Floats:
    """The stationary distribution pi (robot,), pi' W = pi': the weights of robots' old readings in every robot's sums.

    For equal-neighbour means on an undirected graph, pi_i is proportional to d_i + 1. Raises InputError for a network
    that is not connected, which has no single such distribution.
    """
    found = _check_connected(checked(matrix))
    d = balance(found)
    if d is not None:
        return np.asarray(d / d.sum())
    system = np.vstack([found.T - np.eye(len(found)), np.ones(len(found))])
    law = np.linalg.lstsq(system, np.append(np.zeros(len(found)), 1.0), rcond=None)[0]
    return np.asarray(np.maximum(law, 0.0) / np.maximum(law, 0.0).sum())


def stationary_efficiency(matrix: ArrayLike) -> float:
    """The share of a swarm's readings, of equal sensors, that a late estimate is worth: 1 / (N sum pi_i^2).

    1 if all robots hear equally many. Raises InputError for a network that is not connected.
    """
    law = stationary_law(matrix)
    return float(1.0 / (len(law) * (law**2).sum()))


def relaxation_time(matrix: ArrayLike) -> float:
    """The rounds -1 / ln |l| in which late differences fall to 1 / e; 0 if one round removes them.

    Raises InputError for a network that is not connected.
    """
    connected = _check_connected(checked(matrix))
    found = spectrum_of(connected)
    values = np.sort(np.abs(np.linalg.eigvals(connected) if found is None else found.values))
    second = float(values[-2]) if values.size > 1 else 0.0
    return 0.0 if second < 1e-12 else math.inf if second >= 1.0 - 1e-15 else -1.0 / math.log(second)


def _check_connected(matrix: Floats) -> Floats:
    """The matrix itself. Raises InputError unless messages of every robot reach every other."""
    hears = matrix > 0.0
    for way in (hears, hears.T):
        reached = np.zeros(len(matrix), np.bool_)
        reached[0] = True
        edge = reached
        while edge.any():
            edge = way[edge].any(axis=0) & ~reached
            reached = reached | edge
        if not reached.all():
            other = int(np.flatnonzero(~reached)[0])
            to, of = (0, other) if way is hears else (other, 0)
            cut = f"the network is not connected: nothing from robot {of} ever reaches robot {to}"
            raise InputError(cut, key="matrix")
    return matrix
