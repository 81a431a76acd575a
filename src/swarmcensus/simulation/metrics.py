"""The paper's metrics (Sec. IV-A) of curves of estimates; the engine computes the same numbers during a run."""

import numpy as np

from swarmcensus.support.bins import right_bin
from swarmcensus.support.quantities import half_width


def convergence(curves: np.ndarray, delta: float = 0.01) -> np.ndarray:
    """The earliest index K with |x^K - x^k| < delta for all k >= K, for each column; the last if none.

    `curves` is (index, robot), index 0 before any observation. K is not monotone: K may qualify where K + 1
    does not. Paper, Sec. IV-A.
    """
    high = np.maximum.accumulate(curves[::-1])[::-1]
    low = np.minimum.accumulate(curves[::-1])[::-1]
    near = (high - curves < delta) & (curves - low < delta)
    near[-1] = True
    return np.asarray(near.argmax(axis=0))


def error_at(curves: np.ndarray, index: np.ndarray, fill_ratio: float | np.ndarray) -> np.ndarray:
    """The accuracy |x^K - f| of each column at its index K; f may differ by column. Paper, Sec. IV-A."""
    return np.asarray(np.abs(np.take_along_axis(curves, index[np.newaxis], axis=0)[0] - fill_ratio))


def agreement(curves: np.ndarray, delta: float = 0.01) -> float:
    """The first index from which on the disagreement of curves (index, robot) stays within delta; infinite if none.

    The disagreement is half the width of the middle 90 % of the estimates.
    """
    apart = np.flatnonzero(half_width(curves) > delta)
    since = int(apart[-1]) + 1 if apart.size else 0
    return float(since) if since < len(curves) else np.inf


def correct(estimates: np.ndarray, fill_ratio: float, bins: int = 10) -> np.ndarray:
    """The fraction of robots (last axis) whose estimate lies in the right bin; consensus is 1."""
    low, high = right_bin(fill_ratio, bins)
    return np.asarray(np.mean((estimates >= low) & (estimates < high), axis=-1))
