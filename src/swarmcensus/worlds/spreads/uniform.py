"""Uniform between two bounds, as in the paper's heterogeneous swarms."""

import numpy as np

LETTER = "U"


def check(lo: float, hi: float) -> None:
    """Refuse bounds in the wrong order."""
    if lo > hi:
        raise ValueError("it needs lo <= hi")


def quantile(u: np.ndarray, lo: float, hi: float) -> np.ndarray:
    """The value below which a share u lies."""
    return lo + (hi - lo) * u
