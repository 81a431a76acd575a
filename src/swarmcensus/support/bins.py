"""The bins of the fill ratio that robots decide between."""

import functools

import numpy as np


@functools.lru_cache(maxsize=1024)
def right_bin(fill_ratio: float, bins: int = 10) -> tuple[float, float]:
    """The half-open interval of estimates that decide for the bin of `fill_ratio`.

    Bins are [0, 1/B), [1/B, 2/B), ..., and the last one is closed (paper, Sec. IV-A). The interval of the first bin
    begins at minus infinity, and that of the last one ends at infinity.
    """
    k, ends = bin_of(fill_ratio, bins), [-np.inf, *(np.arange(1, bins) / bins).tolist(), np.inf]
    return ends[k], ends[k + 1]


def bin_of(fill_ratio: float, bins: int) -> int:
    """The number of the bin, from 0 on."""
    return min(int(np.searchsorted(np.arange(bins + 1) / bins, fill_ratio, side="right")) - 1, bins - 1)


def on_edges(fill_ratios: np.ndarray, bins: int) -> np.ndarray:
    """Which fill ratios lie on the edge between two bins: about half of good estimates are in the wrong one."""
    return np.isin(fill_ratios, np.arange(1, bins) / bins)


def right_bins(fill_ratios: np.ndarray, bins: int) -> np.ndarray:
    """`right_bin` of several fill ratios, (fill ratio, 2)."""
    return np.array([right_bin(float(f), bins) for f in fill_ratios]).reshape(-1, 2)
