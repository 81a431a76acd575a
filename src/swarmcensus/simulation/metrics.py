"""The paper's metrics (Sec. IV-A), defined on any curve of estimates; the engine computes the same as it goes."""

import functools

import numpy as np


def convergence(curves: np.ndarray, delta: float = 0.01) -> np.ndarray:
    """The earliest index K with |x^K - x^k| < delta for all k >= K, for each column; the last if none.

    `curves` is (index, robot), index 0 before any observation. K is not monotone: K may qualify where K + 1
    does not. Paper, Sec. IV-A.
    """
    high = np.maximum.accumulate(curves[::-1])[::-1]
    low = np.minimum.accumulate(curves[::-1])[::-1]
    near = (high - curves < delta) & (curves - low < delta)
    near[-1] = True
    index: np.ndarray = near.argmax(axis=0)
    return index


def error_at(curves: np.ndarray, index: np.ndarray, fill_ratio: float) -> np.ndarray:
    """The accuracy |x^K - f| of each column at its index K. Paper, Sec. IV-A."""
    error: np.ndarray = np.abs(np.take_along_axis(curves, index[np.newaxis], axis=0)[0] - fill_ratio)
    return error


@functools.lru_cache(maxsize=1024)
def right_bin(fill_ratio: float, bins: int = 10) -> tuple[float, float]:
    """The half-open interval of estimates that decide for the bin of `fill_ratio`; infinite at the ends.

    Bins are [0, 1/B), [1/B, 2/B), ..., and the last one is closed. Paper, Sec. IV-A.
    """
    edges = np.arange(bins + 1) / bins
    k = min(int(np.searchsorted(edges, fill_ratio, side="right")) - 1, bins - 1)
    return (
        -np.inf if k == 0 else float(edges[k]),
        np.inf if k == bins - 1 else float(edges[k + 1]),
    )


def right_bins(fill_ratios: np.ndarray, bins: int) -> np.ndarray:
    """The same of several fill ratios, (fill ratio, 2)."""
    return np.array([right_bin(float(f), bins) for f in fill_ratios]).reshape(-1, 2)


def correct(estimates: np.ndarray, fill_ratio: float, bins: int = 10) -> np.ndarray:
    """The fraction of robots (last axis) whose estimate lies in the right bin; consensus is 1."""
    low, high = right_bin(fill_ratio, bins)
    share: np.ndarray = np.mean((estimates >= low) & (estimates < high), axis=-1)
    return share
