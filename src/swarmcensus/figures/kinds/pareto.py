"""Quality against what it costs, in each world, and the front of brains that none is both better and cheaper than."""

from __future__ import annotations

import xarray as xr

from swarmcensus.comparing.comparison import compare
from swarmcensus.figures.pareto_fronts import draw_pareto
from swarmcensus.figures.sheets import Drawn, Own


def pareto(
    results: xr.Dataset,
    *,
    metric: str = "final_error",
    cost: str = "bytes_sent",
    title: str | None = None,
    ax: Own = None,
) -> Drawn:
    """Draw a measure of `sc.compare` against a cost, a panel for each world, with its Pareto front.

    `cost` is "bytes_sent", "messages_sent", "memory_bytes" or "message_bytes". Upright lines are 95 % intervals over
    trials. Raises InputError as `sc.compare` does, for a cost that is not there and for more than 24 worlds.
    """
    return draw_pareto(compare(results, metric), cost, title, ax, [results])
