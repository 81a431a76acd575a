"""One rule for times of robots that never learnt, for comparisons and figures.

The estimate of a robot with K = 0 never left its first belief by delta. Where this holds of the median robot, K and the
agreement round do not say how fast robots learn, so they count as never: infinite.
"""

from collections.abc import Sequence
from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from swarmcensus.summaries import measures
from swarmcensus.summaries.estimates import Cells, Places, cells

K = "convergence_round"
SETTLING_TIMES = (K, "agreement_round")
QUANTITIES_AT_K = (*SETTLING_TIMES, "convergence_error")  # what says nothing of robots that never learnt


def never_learnt(data: xr.Dataset, groups: Sequence[Places] | None = None) -> NDArray[np.bool_]:
    """Cells whose median robot has K = 0, (cell,); see `cells` for groups."""
    if K not in data:
        return np.zeros(data.sizes["setting"] if groups is None else len(groups), np.bool_)
    return np.asarray(cells(data, K, groups, intervals=False).value == 0)


def learnt_cells(data: xr.Dataset, name: str, groups: Sequence[Places] | None = None, **more: Any) -> Cells:
    """The `cells` of a quantity, where K and the agreement round of robots that never learnt are infinite."""
    found = cells(data, name, groups, **more)
    if name not in SETTLING_TIMES:
        return found
    unmoved = never_learnt(data, groups)
    return Cells(*(np.where(unmoved, np.inf, part) for part in found))


def learnt_numbers(data: xr.Dataset, name: str) -> NDArray[np.float64]:
    """The number of each trial, (setting, trial), by the same rule."""
    found = measures.numbers(data, name)
    return np.where(measures.numbers(data, K) == 0, np.inf, found) if name in SETTLING_TIMES else found
