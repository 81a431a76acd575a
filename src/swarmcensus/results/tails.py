"""Where medians hide a tail: settings in which a tenth of the robots err much more than the median robot."""

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from swarmcensus.results import measures
from swarmcensus.results.estimates import cells

TIMES = 4.0  # error_90 over the median error; about 2.4 where errors are normal
TAIL = "error_90"


def has_tail(data: xr.Dataset) -> NDArray[np.bool_]:
    """The settings with a tail, (setting,): a tenth of the robots err at least four times as much as the median."""
    if measures.lacks(data, TAIL):
        return np.zeros(data.sizes["setting"], np.bool_)
    tail, middle = (cells(data, name, intervals=False).value for name in (TAIL, "final_error"))
    return np.asarray((tail >= TIMES * middle) & (tail > 0.0))


def shows_tail(data: xr.Dataset) -> bool:
    """Whether tables of these settings show the tail next to the median: if any has one, or any robot lies."""
    lies = "members" in data.coords and "liars" in data.coords and bool((data["liars"].values > 0).any())
    return not measures.lacks(data, TAIL) and (lies or bool(has_tail(data).any()))
