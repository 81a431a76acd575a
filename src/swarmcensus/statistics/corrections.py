"""Correction of p-values for multiple tests. Holm, "A simple sequentially rejective multiple test procedure", 1979."""

import numpy as np
from numpy.typing import NDArray


def holm(p: NDArray[np.float64]) -> NDArray[np.float64]:
    """Holm's corrected p-values, in the shape of `p`; NaN stays NaN and does not count as a test.

    The chance that any true null hypothesis has a corrected p-value of `a` or less is at most `a`, whatever the
    dependence between the tests.
    """
    flat = p.ravel()
    known = np.flatnonzero(~np.isnan(flat))
    order = known[np.argsort(flat[known], kind="stable")]
    corrected = np.full(flat.size, np.nan)
    steps = flat[order] * np.arange(order.size, 0, -1)
    corrected[order] = np.minimum(1.0, np.maximum.accumulate(steps))
    return corrected.reshape(p.shape)


def fewest_trials(tests: int, level: float) -> int:
    """The fewest trials with which one of `tests` sign-flip tests can reach `level` after Holm's correction.

    All n differences have the same sign by chance in 2 of 2^n cases.
    """
    return int(np.ceil(1 + np.log2(max(tests, 1) / level)))
