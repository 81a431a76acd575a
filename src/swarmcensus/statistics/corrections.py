"""The correction of p-values for being many. Holm, "A simple sequentially rejective multiple test procedure", 1979."""

import numpy as np
from numpy.typing import NDArray


def holm(p: NDArray[np.float64]) -> NDArray[np.float64]:
    """The p-values, of any shape, for which all that are at most 0.05 hold together in 95 % of cases; NaN stay NaN.

    However the tests depend on one another, and whichever of their hypotheses are true, the chance that any true one is
    among those at most a level is at most that level. NaN is no test and is not corrected for.
    """
    flat = p.ravel()
    known = np.flatnonzero(~np.isnan(flat))
    order = known[np.argsort(flat[known], kind="stable")]
    corrected = np.full(flat.size, np.nan)
    steps = flat[order] * np.arange(order.size, 0, -1)
    corrected[order] = np.minimum(1.0, np.maximum.accumulate(steps))
    return corrected.reshape(p.shape)


def fewest_trials(tests: int, level: float) -> int:
    """How many trials a sign-flip test needs at the least to tell anything apart among so many tests, by Holm.

    All of n differences have one sign by chance in 2 of 2^n cases.
    """
    return int(np.ceil(1 + np.log2(max(tests, 1) / level)))
