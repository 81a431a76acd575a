"""Lines of times that may never come, drawn as steps: the share of trials in which each has come by each round."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
import xarray as xr
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

from swarmcensus.analysis import Comparison, is_time
from swarmcensus.figures.axes import count_axis
from swarmcensus.figures.captions import NEVER, captioned, unlearnt
from swarmcensus.figures.coordinates import Names, worlds_apart
from swarmcensus.figures.page import drawing
from swarmcensus.figures.sheets import add_key, name_axes, sheet
from swarmcensus.figures.styles import Look, looks_of_contenders
from swarmcensus.support.options import wrong_option
from swarmcensus.support.quantities import QUANTITIES
from swarmcensus.worlds import MOVING

if TYPE_CHECKING:
    import pandas as pd

DASH = 6.0  # points: of lines that lie on each other
BAND, MOST_BANDS = 0.15, 8  # opacity of intervals, and the most contenders that have them
APART, SIZE = 0.25, 4.5  # between markers of a line, as a share of the axes' diagonal; points of a marker


@drawing()
def draw_steps(
    standings: Comparison, title: str | None = None, results: Sequence[xr.Dataset] = (),
    rows: Names = None, cols: Names = None,
) -> Figure:  # fmt: skip
    """Draw the share of trials in which a time has come by each round, one panel for each world of a comparison.

    A trial in which it never comes stays in the share, so its line ends below 100 %. Bands are 95 % intervals over
    trials, round by round; more than 8 contenders have none. Lines at 0 % have none, and lines that lie on each other
    have one, and are dashed.

    The first measure that is a time is drawn. Raises InputError without any.
    """
    names = [measure.name for measure in standings.measures]
    name = next(filter(is_time, names), None)
    if name is None:
        known = ", ".join(filter(is_time, QUANTITIES))
        raise wrong_option("y", ", ".join(names), f"steps are of times that may never come: {known}")
    captions, labels = worlds_apart(standings.grid.worlds, rows, cols)
    table = standings.profiles
    table = table[table["measure"] == name]
    looks = looks_of_contenders(standings.contenders, standings.grid.factor, results)
    axes = sheet(captions, title, rows=labels)
    lines: dict[str, Artist] = {}
    label = standings.measures[names.index(name)].label
    unit = "tick" if standings.grid.common.get("topology") == MOVING else "round"
    for world, place in enumerate(axes):
        here = table[table["world"] == world]
        rows_of = {str(contender): rows for contender, rows in here.groupby("contender", sort=False)}
        dashes = _dashes_of({who: rows[["round", "share"]].to_numpy().tobytes() for who, rows in rows_of.items()})
        for k, contender in enumerate(standings.contenders):
            if contender in rows_of:
                look = looks[contender]
                start = k / len(standings.contenders) * APART  # so that no marker hides another
                # lines on each other have one band
                banded = dashes[contender] is None and len(standings.contenders) <= MOST_BANDS
                _draw(place, rows_of[contender], look, start, dashes[contender] or look.line, banded=banded)
                lines[look.name] = Line2D([], [], c=look.colour, marker=look.marker, ls=look.line, lw=1.6, ms=SIZE)
        count_axis(place, 0.0, float(np.nanmax(standings.rounds[world])), "linear")
        place.set_ylim(-3, 103)
        name_axes(place, label if label.endswith(unit) else f"{label} ({unit})", "share of trials (%)")
    never = [looks[name].name for name, most in table.groupby("contender")["share"].max().items() if most == 0.0]
    if table["share_low"].notna().any() and len(standings.contenders) <= MOST_BANDS:
        lines["95 % interval"] = Patch(color="0.4", alpha=2 * BAND, linewidth=0)
    add_key(axes, ", ".join(standings.grid.factor) or "brain", lines)
    remarks = [f"never, in any trial: {', '.join(never)}" if never else "", unlearnt(results, [name], NEVER)]
    return captioned(axes, draw_steps, results, remarks)


def _dashes_of(lines: Mapping[str, bytes]) -> dict[str, Any]:
    """The dashes of lines that lie on each other, which stand in each other's gaps; None for the first and for others.

    `lines` are the bytes of the points of each line.
    """
    dashes: dict[str, Any] = {}
    for name, points in lines.items():
        same = [other for other, its in lines.items() if its == points]
        place = same.index(name)
        dashes[name] = (place * DASH, (DASH, (len(same) - 1) * DASH)) if place else None
    return dashes


def _draw(axes: Axes, rows: pd.DataFrame, look: Look, start: float, style: Any, *, banded: bool) -> None:
    """One contender's steps, and its band unless it never gets there; its first marker is at the share `start`."""
    x, share, low, high = (rows[name].to_numpy() for name in ("round", "share", "share_low", "share_high"))
    axes.step(
        x, 100 * share, where="post", color=look.colour, linewidth=1.6, marker=look.marker, markersize=SIZE,
        markevery=(start, APART), linestyle=style,
    )  # fmt: skip
    if banded and np.isfinite(low).all() and (share > 0).any():
        axes.fill_between(x, 100 * low, 100 * high, step="post", color=look.colour, alpha=BAND, linewidth=0)
