"""Average ranks of brains over trials and worlds, with bars over those that are not told apart."""

from __future__ import annotations

import xarray as xr

from swarmcensus.comparing.comparison import compare
from swarmcensus.figures.panels import Names
from swarmcensus.figures.rank_lines import draw_ranks
from swarmcensus.figures.sheets import Drawn, Own


def ranks(results: xr.Dataset, *, metric: Names = None, title: str | None = None, ax: Own = None) -> Drawn:
    """Draw the critical-difference diagram of `sc.compare`: a line for each measure, the best brain on its left.

    `metric` names measures, as "correct" or ["final_error", "my_metric:low"], by default the usual ones: all of them
    are corrected for. Raises InputError as `sc.compare` does, and where no world has been met by all contenders.
    """
    return draw_ranks(compare(results, metric or ()), title, ax, [results])
