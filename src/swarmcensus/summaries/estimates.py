"""The estimate of a cell: the value of a quantity in one setting, or in several, and its interval over trials.

Summaries, comparisons, figures, LaTeX and JSON take their numbers from here (docs/comparing.md).
"""

from collections.abc import Iterator, Sequence
from typing import NamedTuple

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from swarmcensus.results import bounds_in, robots_in
from swarmcensus.summaries import measures
from swarmcensus.support.bootstrap import Statistic
from swarmcensus.support.intervals import Floats, estimate_pooled
from swarmcensus.support.quantities import PER_CHECKPOINT, QUANTITIES

Places = NDArray[np.intp]


class Cells(NamedTuple):
    """The values of cells and the ends of their intervals, each (cell,)."""

    value: Floats
    low: Floats
    high: Floats


def cells(
    data: xr.Dataset,
    name: str,
    groups: Sequence[Places] | None = None,
    *,
    statistic: Statistic | None = None,
    checkpoint: int | None = None,
    intervals: bool = True,
) -> Cells:
    """The median or mean of a quantity over all robots of all trials, and its 95 % interval over trials, by cell.

    A cell is a setting, or the settings at the places of a group. What is measured at checkpoints is taken at round
    `checkpoint`, by default at the last one that a setting reaches; shares of swarms of several sizes count robots.
    Values are NaN without a number, and intervals for too few trials, or if settings or robots lack trials that others
    have. Without `intervals` there are none, which takes much less time. Raises InputError.
    """
    statistic, share = statistic or measures.statistic_of(name), measures.is_share(name)
    of_robots = name in QUANTITIES and QUANTITIES[name].dims == PER_CHECKPOINT and share
    robots, found = robots_in(data).values, []
    for rows, values in _samples(data, name, groups, checkpoint):
        sizes = robots[rows]
        if of_robots and sizes.min() < sizes.max():
            values = np.where(np.arange(sizes.max()) < sizes[:, np.newaxis, np.newaxis], values, np.nan)
        found.append(estimate_pooled(values, statistic, share, intervals))
    value, low, high = np.array(found).reshape(-1, 3).T
    least, most = bounds_in(data, name)
    if isinstance(most, np.ndarray) and groups is not None:
        most = np.array([most[rows].max() for rows in groups])
    return Cells(value, np.clip(low, least, most), np.clip(high, least, most))


def _samples(
    data: xr.Dataset, name: str, groups: Sequence[Places] | None, checkpoint: int | None
) -> Iterator[tuple[Places, Floats]]:
    """The places of each cell's settings, and its numbers (setting, trial, robot)."""
    if groups is not None:
        yield from ((rows, measures.sample(data, name, rows, checkpoint)) for rows in groups)
        return
    for block in measures.blocks(data):
        values = measures.sample(data, name, block, checkpoint)
        yield from zip(block[:, np.newaxis], values[:, np.newaxis], strict=True)
