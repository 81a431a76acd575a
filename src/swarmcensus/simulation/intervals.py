"""Robots' intervals at checkpoints: room for how they do."""

import numpy as np

from swarmcensus.engine import Intervals
from swarmcensus.simulation.file_metrics import Truths
from swarmcensus.studies import Setting

ENDS = "interval_low", "interval_high"  # of a trace, besides a brain's own fields


def intervals_of(setting: Setting | None, checkpoints: np.ndarray, truths: Truths, trials: int) -> Intervals:
    """Room for the intervals of a setting's robots at checkpoints, where the fill ratios are truths(checkpoints)."""
    robots = setting.robots if setting and any(brain.has_interval for brain in setting.brains) else 0
    sure, wrong = np.full((trials, 2, checkpoints.size), np.nan), np.full((trials, 4), -1.0)
    return Intervals(checkpoints, truths(checkpoints), np.empty((2, robots)), np.empty(3), sure, wrong)


def no_intervals(trials: int = 1) -> Intervals:
    """No checkpoints, so that no robot is asked for an interval."""
    return intervals_of(None, np.empty(0, np.int64), lambda _: np.empty(0), trials)
