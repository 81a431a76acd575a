"""Whether contenders rank alike over all trials: Friedman's test by permutation, and groups that are not told apart.

Friedman, "The use of ranks to avoid the assumption of normality", 1937. Trials are the blocks; where contenders met in
several worlds, a trial's ranks are summed over these, for trial 7 of two worlds may share readings and networks.
"""

import numpy as np
from numpy.typing import NDArray

PERMUTATIONS = 9999
SEED = 2023

Floats = NDArray[np.float64]


def friedman(ranks: Floats, permutations: int = PERMUTATIONS) -> tuple[float, float]:
    """The statistic Q of `ranks` (trial, contender) and its p by permuting contenders within trials.

    Q is Friedman's, corrected for ties, where rows are the ranks 1 .. k of one world, and is defined likewise for sums
    of ranks over worlds: (k - 1) x the sum of squares of the contenders' totals, from their mean, over that of all
    numbers, from their trials' means. NaN and 1 where no trial ranks any above another. The same ranks give the same p.
    """
    off = ranks - ranks.mean(axis=1, keepdims=True)
    spread = float((off**2).sum())
    if spread <= 0:
        return float("nan"), 1.0
    contenders = ranks.shape[1]
    seen = float((off.sum(axis=0) ** 2).sum())
    random, farther = np.random.default_rng(SEED), 0
    step = max(1, 2**21 // off.size)
    for first in range(0, permutations, step):
        some = np.broadcast_to(off, (min(step, permutations - first), *off.shape))
        sums = random.permuted(some, axis=2).sum(axis=1)
        farther += int(((sums**2).sum(axis=1) >= seen * (1 - 1e-9)).sum())
    return (contenders - 1) * seen / spread, (1 + farther) / (1 + permutations)


def groups(order: list[int], apart: NDArray[np.bool_]) -> list[list[int]]:
    """The longest runs of `order`, of two or more, in which no two are `apart` (contender, contender)."""
    found: list[list[int]] = []
    for start in range(len(order)):
        end = start + 1
        while end < len(order) and not apart[order[end], order[start:end]].any():
            end += 1
        if end - start > 1 and not (found and set(order[start:end]) <= set(found[-1])):
            found.append(order[start:end])
    return found
