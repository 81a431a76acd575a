"""The goal of a mission, which tells which estimates are right."""

import math
from dataclasses import dataclass
from statistics import NormalDist

import numpy as np
from numpy.typing import NDArray

from swarmcensus.studies import Wanted
from swarmcensus.support.bins import right_bin
from swarmcensus.support.quantities import as_wanted

POINTS = 51  # fill ratios of the range that are examined
NORMAL = NormalDist()


@dataclass(frozen=True)
class Goal:
    """Estimates within an error of the truth, or in its bin, as a study wants them."""

    wanted: Wanted

    def region(self, truth: float) -> tuple[float, float]:
        """The interval of right estimates; it is unbounded on a side where estimates are cut to 0 or 1."""
        if self.wanted.bins is not None:
            return right_bin(truth, self.wanted.bins)
        assert self.wanted.error is not None
        low, high = truth - self.wanted.error, truth + self.wanted.error
        return (-math.inf if low <= 0.0 else low), (math.inf if high >= 1.0 else high)

    def right(self, estimates: NDArray[np.float64], truths: NDArray[np.float64]) -> NDArray[np.bool_]:
        """Which estimates (..., trial, robot) are right, given the truth of each trial (trial,)."""
        goal = np.array(self.wanted.goal, np.float64)
        return np.asarray(as_wanted(estimates, truths[:, np.newaxis], goal) == 1.0)

    def normal_share(self, sd: float, truth: float) -> float:
        """The share of right robots, if estimates are normal about the truth and cut to [0, 1]."""
        low, high = self.region(truth)
        if sd == 0.0:
            return 1.0
        return NORMAL.cdf((high - truth) / sd) - NORMAL.cdf((low - truth) / sd)

    def candidates(self, low: float, high: float) -> NDArray[np.float64]:
        """Fill ratios of a range at least `margin` away from all edges, with both ends and those closest to edges."""
        fill_ratios = np.linspace(low, high, POINTS)
        bins, margin = self.wanted.bins, self.wanted.margin
        if bins is None:
            return np.unique(fill_ratios)
        edges = np.arange(1, bins) / bins
        near = np.concatenate([edges - margin, edges + margin])
        fill_ratios = np.unique(np.concatenate([fill_ratios, near[(near >= low) & (near <= high)]]))
        distance = np.abs(fill_ratios[:, np.newaxis] - edges).min(axis=1)
        return np.asarray(fill_ratios[distance >= margin - 1e-12])

    def __str__(self) -> str:
        """The goal in words."""
        wanted = self.wanted
        if wanted.error is not None:
            return f"within {wanted.error:g} of the truth"
        aside = f", {wanted.margin:g} or further from its edges" if wanted.margin else ""
        return f"in the right half{aside}" if wanted.bins == 2 else f"in the right one of {wanted.bins} bins{aside}"
