"""Average ranks of brains over trials and worlds, with bars over those that are not told apart."""

from __future__ import annotations

import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from swarmcensus.figures.panels import Names
from swarmcensus.figures.rank_lines import draw_ranks
from swarmcensus.figures.sheets import say_lacking
from swarmcensus.results.comparing import compare


def ranks(results: xr.Dataset, *, metric: Names = None, title: str | None = None, ax: Axes | None = None) -> Figure:
    """Draw the critical-difference diagram of `sc.compare`: a line for each measure, the best brain on its left.

    `metric` names measures, as "correct" or ["final_error", "my_metric:low"], by default the usual ones: all of them
    are corrected for. Raises InputError as `sc.compare` does, and where no world has been met by all contenders.
    """
    figure = draw_ranks(compare(results, metric or ()), title, ax)
    say_lacking([figure.axes[-1]], [results])
    return figure
