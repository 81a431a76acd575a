"""Where medians hide a tail: settings in which many robots err much more than the median robot."""

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from swarmcensus.summaries import measures
from swarmcensus.summaries.estimates import cells
from swarmcensus.support.bootstrap import centres

TAIL_QUANTITY = "error_90"  # the quantity that is shown next to a median
TIMES = 4.0  # a robot is far off if its error is more than so many times the median; 0.7 % are if errors are normal
LEAST = 0.05  # share of robots far off that is called a tail


def far_off(data: xr.Dataset) -> NDArray[np.float64]:
    """The share of robots, over all trials, with a final error above four times the median, (setting,).

    NaN without a trial.
    """
    limits, shares = TIMES * cells(data, "final_error", intervals=False).value, []
    for rows in measures.blocks(data):
        errors = measures.sample(data, "final_error", rows)
        beyond = np.where(np.isnan(errors), np.nan, errors > limits[rows, np.newaxis, np.newaxis])
        shares.append(centres(beyond.reshape(len(rows), -1), "mean"))
    return np.concatenate(shares)


def has_tail(data: xr.Dataset) -> NDArray[np.bool_]:
    """The settings with a tail, (setting,): at least 5 % of the robots are far off."""
    if measures.missing_inputs(data, TAIL_QUANTITY):
        return np.zeros(data.sizes["setting"], np.bool_)
    return np.asarray(far_off(data) >= LEAST)


def shows_tail(data: xr.Dataset) -> bool:
    """Whether tables of these settings show the tail next to the median: if any has one, or any robot lies."""
    lies = "liars" in data.coords and bool((data["liars"].values > 0).any())
    return not measures.missing_inputs(data, TAIL_QUANTITY) and (lies or bool(has_tail(data).any()))
