"""Where medians hide a tail: settings in which many robots err much more than the median robot."""

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from swarmcensus.results import measures
from swarmcensus.results.summaries import cells
from swarmcensus.results.values import robots_in

TAIL = "error_90"  # the quantity that is shown next to a median
TIMES = 4.0  # a robot is far off if its error is more than so many times the median; 0.7 % are if errors are normal
LEAST = 0.05  # share of robots far off that is called a tail


def far_off(data: xr.Dataset) -> NDArray[np.float64]:
    """The share of robots, over all trials, with a final error above four times the median, (setting,).

    NaN without a trial.
    """
    made = measures.with_measure(data, "final_error")["final_error"].transpose("setting", "trial", "robot").values
    exists = np.arange(made.shape[2]) < robots_in(data).values[:, np.newaxis, np.newaxis]
    known = exists & ~np.isnan(made)
    with np.errstate(invalid="ignore"):
        beyond = known & (made > TIMES * cells(data, "final_error")[0][:, np.newaxis, np.newaxis])
        return np.asarray(beyond.sum(axis=(1, 2)) / known.sum(axis=(1, 2)))


def has_tail(data: xr.Dataset) -> NDArray[np.bool_]:
    """The settings with a tail, (setting,): at least 5 % of the robots are far off."""
    if measures.lacks(data, TAIL):
        return np.zeros(data.sizes["setting"], np.bool_)
    return np.asarray(far_off(data) >= LEAST)


def shows_tail(data: xr.Dataset) -> bool:
    """Whether tables of these settings show the tail next to the median: if any has one, or any robot lies."""
    lies = "liars" in data.coords and bool((data["liars"].values > 0).any())
    return not measures.lacks(data, TAIL) and (lies or bool(has_tail(data).any()))
