"""Uniform, "U(lo, hi)", between two bounds, as in the paper's heterogeneous swarms."""

import math

import numpy as np

from swarmcensus.engine import compile_world

LETTER = "U"


def check(lo: float, hi: float) -> None:
    """Refuse bounds in the wrong order."""
    if lo > hi:
        raise ValueError("it needs lo <= hi")


def quantile(u: np.ndarray, lo: float, hi: float) -> np.ndarray:
    """The value below which a share u lies."""
    return lo + (hi - lo) * u


def moments(lo: float, hi: float) -> tuple[float, float]:
    """The mean and the standard deviation."""
    return (lo + hi) / 2.0, (hi - lo) / math.sqrt(12.0)


def draw(key: np.ndarray, first_trial: int, out: np.ndarray, lo: float, hi: float) -> None:
    """Draw quantiles of uniform numbers, bit for bit as `quantile` gives them, but faster."""
    compile_world().draw_uniform(key, first_trial, lo, hi, out)
