"""Friedman's test by permutation, and groups of contenders that do not differ significantly.

Friedman, "The use of ranks to avoid the assumption of normality", 1937. Trials are the blocks. If contenders met in
several worlds, the ranks of a trial are summed over the worlds, because worlds may share the readings and networks of a
trial.
"""

import numpy as np
from numpy.typing import NDArray

PERMUTATIONS = 9999
SEED = 2023

Floats = NDArray[np.float64]


def friedman(ranks: Floats, permutations: int = PERMUTATIONS) -> tuple[float, float]:
    """The statistic Q of `ranks` (trial, contender), and its p-value by permuting contenders within trials.

    Q = (k - 1) x (sum of squares of the contenders' totals about their mean) / (sum of squares of all ranks about the
    mean of their trial). For the ranks 1 .. k of one world, this is Friedman's statistic, corrected for ties. Returns
    NaN and 1 if all ranks are equal in every trial. The same ranks always give the same p-value.
    """
    off = ranks - ranks.mean(axis=1, keepdims=True)
    spread = float((off**2).sum())
    if spread <= 0:
        return float("nan"), 1.0
    contenders = ranks.shape[1]
    observed = float((off.sum(axis=0) ** 2).sum())
    generator, extreme = np.random.default_rng(SEED), 0
    step = max(1, 2**21 // off.size)
    for first in range(0, permutations, step):
        copies = np.broadcast_to(off, (min(step, permutations - first), *off.shape))
        sums = generator.permuted(copies, axis=2).sum(axis=1)
        extreme += int(((sums**2).sum(axis=1) >= observed * (1 - 1e-9)).sum())
    return (contenders - 1) * observed / spread, (1 + extreme) / (1 + permutations)


def groups(order: list[int], apart: NDArray[np.bool_]) -> list[list[int]]:
    """The maximal runs of two or more contenders in `order`, no two of which are `apart` (contender, contender)."""
    runs: list[list[int]] = []
    for start in range(len(order)):
        end = start + 1
        while end < len(order) and not apart[order[end], order[start:end]].any():
            end += 1
        if end - start > 1 and not (runs and set(order[start:end]) <= set(runs[-1])):
            runs.append(order[start:end])
    return runs
