"""A plan: how many minutes swarms of each size need, a line a brain, and what theory says at best and alone."""

from __future__ import annotations

from typing import Any

from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.transforms import ScaledTranslation

from swarmcensus.basics.errors import InputError
from swarmcensus.figures.axes import coordinate_axis, measured_axis, names_of
from swarmcensus.figures.looks import Look, looks_of, solid_dot
from swarmcensus.figures.sheets import add_key, name_axes, sheet
from swarmcensus.planning.plans import Plan, Row

SIZE = 5.0  # points: a dot
BESIDE = 7.0  # apart, where there is one size
WIDE = 310.0  # and the panel


def draw_plan(found: Plan, title: str | None = None, ax: Axes | None = None) -> Figure:
    """Draw robots against minutes: dots are simulated, their bars 95 % intervals over trials, to the edge where
    nothing is surely enough.

    A hollow dot was not simulated, or does not reach the goal at the longest time. Raises InputError where there is
    nothing to draw.
    """
    if not found.rows:
        raise InputError("there is nothing to draw: the plan has no rows")
    mission = found.mission
    caption = f"{100 * mission.wanted.confidence:g} % of robots {mission.goal}"
    [axes] = sheet(ax, [caption], title)
    every = [minutes for row in found.rows for minutes in (row.minutes, row.theory.pooled, row.theory.alone)]
    measured_axis([axes], every, [end for row in found.rows for end in (row.minutes_low, row.minutes_high) if end])
    sizes = {size for row in found.rows for size in (row.robots, row.robots_low, row.robots_high) if size is not None}
    across = looks_of(map(str, sorted(sizes)), "o", "robots")
    coordinate_axis(axes, "robots", across, names_of(across, WIDE), 0.0)
    looks = looks_of((row.brain for row in found.rows), "o", "brain")
    sure = sorted({row.robots: row.theory for row in found.rows}.items())
    entries: dict[str, Artist] = {}
    for k, (brain, look) in enumerate(looks.items()):
        aside = BESIDE * (k - (len(looks) - 1) / 2.0) * (len(sure) == 1)
        _draw(axes, [row for row in found.rows if row.brain == brain], look, aside)
        entries[look.name] = solid_dot(look, SIZE, 0.4)
    if any(row.minutes_low or row.robots_low for row in found.rows):
        entries["95 % interval"] = Line2D([], [], linestyle="", marker="|", markersize=10, color="0.3")
    if any(row.answer != "reached" for row in found.rows):
        hollow = Line2D([], [], linestyle="", marker="o", markersize=SIZE, color="0.3", markerfacecolor="white")
        entries["hollow: theory alone, or not reached by then"] = hollow
    for name, style, told in (("alone", ":", "a robot alone"), ("pooled", "--", "all readings at once")):
        sizes_of, minutes = [robots for robots, _ in sure], [getattr(theory, name) for _, theory in sure]
        line = Line2D(sizes_of, minutes, color="0.5", linewidth=1.0, zorder=1)
        line.set(linestyle=style)
        if len(sure) == 1:  # one size: from wall to wall
            line.set(xdata=[0.0, 1.0], ydata=minutes * 2, transform=axes.get_yaxis_transform())
        axes.add_line(line)
        entries[f"theory: {told}"] = line
    name_axes(axes, "robots", "minutes")
    add_key([axes], "", entries)
    figure: Figure = axes.figure.canvas.figure
    return figure


def _draw(axes: Axes, rows: list[Row], look: Look, aside: float) -> None:
    """One brain's line, `aside` points beside where it belongs: through what is reached, in order of size."""
    rows = sorted(rows, key=lambda row: row.robots)
    there = [row for row in rows if row.answer == "reached"]
    place: dict[str, Any] = {
        "transform": axes.transData + ScaledTranslation(aside / 72, 0, axes.figure.dpi_scale_trans)
    }
    bar: dict[str, Any] = {"colors": look.colour, "linewidths": 1.0, "zorder": 2.5, **place}
    axes.plot([r.robots for r in there], [r.minutes for r in there], color=look.colour, lw=1.0, zorder=2, **place)
    for row in rows:
        if row.minutes_low is not None:
            axes.vlines(row.robots, row.minutes_low, row.minutes_high or axes.get_ylim()[1], **bar)
        if row.robots_low is not None:
            axes.hlines(row.minutes, row.robots_low, row.robots_high or axes.get_xlim()[1], **bar)
        dot = solid_dot(look, SIZE, 0.4)
        dot.set(xdata=[row.robots], ydata=[row.minutes], zorder=3, **place)
        if row.answer != "reached":
            dot.set(markerfacecolor="white", markeredgecolor=look.colour, markeredgewidth=1.2)
        axes.add_line(dot)
