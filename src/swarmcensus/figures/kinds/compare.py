"""By how much brains differ from one of them, with intervals: a forest plot."""

from __future__ import annotations

import xarray as xr

from swarmcensus.basics.errors import InputError
from swarmcensus.comparing import comparison
from swarmcensus.comparing.effects import effects
from swarmcensus.figures.effect_lines import MOST_ROWS, draw_effects
from swarmcensus.figures.panels import Names
from swarmcensus.figures.sheets import Drawn, Own


def compare(
    results: xr.Dataset,
    *,
    metric: Names = None,
    against: str | None = None,
    by: Names = None,
    title: str | None = None,
    ax: Own = None,
) -> Drawn:
    """Draw what `sc.compare` finds: differences of brains, paired trial by trial, with their 95 % intervals.

    There is a panel for each measure, named by `metric` as in `sc.compare`, a row for each world, and in it a dot for
    each contender: its number less that of `against`, by default of the study's first contender. Dots are full where
    both are told apart, after a correction for all tests. With `by`, names of coordinates, worlds that are alike in
    these are one row: of each trial the median of its differences in these worlds counts, or the mean of shares; an
    empty list pools all of them. Where there is one row, contenders have rows of their own. An arrow at the edge is an
    infinite difference. Axes of your own, `ax`, hold a panel each: leave room for rows' names on the left.

    Raises InputError as `sc.compare` does, for more than 40 rows and for coordinates in which worlds do not differ.
    """
    found = comparison.compare(results, metric or (), against=against)
    by = [by] if isinstance(by, str) else by
    if by is None and len(found.field.worlds) > MOST_ROWS:
        names = ", ".join(dict.fromkeys(name for world in found.field.worlds for name in world))
        raise InputError(
            f"{len(found.field.worlds):,} worlds are more than the {MOST_ROWS} rows that have room: pool them with by, "
            f"or select some; they differ in {names}"
        )
    mark = found.against or 0
    rows, drawn = effects(results, found, mark, by)
    return draw_effects(found, mark, rows, drawn, title, ax, [results])
