"""A plan: how many minutes swarms of each size need, a line a brain and world, and what theory says."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.transforms import ScaledTranslation
from numpy.typing import NDArray

from swarmcensus.basics.errors import InputError
from swarmcensus.figures.axes import coordinate_axis, measured_axis, names_of
from swarmcensus.figures.looks import Look, looks_of, solid_dot
from swarmcensus.figures.sheets import add_key, name_axes, sheet
from swarmcensus.planning.plans import Plan, Row

SIZE = 5.0  # points: a dot
BESIDE = 7.0  # apart, where there is one size
NEXT, FEW = 2.5, 2  # apart where there are several sizes, and more lines than these
WIDE = 310.0  # and the panel
ALIKE = 0.02  # of theory's minutes: a line for both

Line = tuple[str, str, float | None]


def draw_plan(found: Plan, title: str | None = None, ax: Axes | None = None) -> Figure:
    """Draw robots against minutes: dots are simulated, their bars 95 % intervals over trials, to the edge where
    nothing is surely enough.

    A hollow dot was not simulated, or does not reach the goal at the longest time. Raises InputError where there is
    nothing to draw.
    """
    if not found.rows:
        raise InputError("there is nothing to draw: the plan has no rows")
    mission, looks, entries = found.mission, _looks(found), dict[str, Artist]()
    caption = f"{100 * mission.wanted.confidence:g} % of robots {mission.goal}"
    [axes] = sheet(ax, [caption], title)
    every = [minutes for row in found.rows for minutes in (row.minutes, row.theory.pooled, row.theory.alone)]
    measured_axis([axes], every, [end for row in found.rows for end in (row.minutes_low, row.minutes_high) if end])
    sizes = {size for row in found.rows for size in (row.robots, row.robots_low, row.robots_high) if size is not None}
    across = looks_of(map(str, sorted(sizes)), "o", "robots")
    coordinate_axis(axes, "robots", across, names_of(across, WIDE), 4.0 * NEXT * (len(looks) > FEW))
    step = np.array([NEXT * (len(looks) > FEW), 0.0])  # to the right, and up
    if found.question == "how many":
        step = np.array([0.0, BESIDE / 2.0])
    elif len({row.robots for row in found.rows}) == 1:
        step = np.array([BESIDE, 0.0])
    for k, (of, look) in enumerate(looks.items()):
        aside = step * (k - (len(looks) - 1) / 2.0)
        _draw(axes, [row for row in found.rows if _line(row) == of], look, aside)
        entries[look.name] = solid_dot(look, SIZE, 0.4)
    if any(row.minutes_low or row.robots_low for row in found.rows):
        entries["95 % interval"] = Line2D([], [], linestyle="", marker="|", markersize=10, color="0.3")
    if any(row.answer != "reached" for row in found.rows):
        hollow = Line2D([], [], linestyle="", marker="o", markersize=SIZE, color="0.3", markerfacecolor="white")
        entries["hollow: theory alone, or not reached by then"] = hollow
    for which, style, told in (("alone", ":", "a robot alone"), ("pooled", "--", "all readings at once")):
        for minutes in _theories(found, which):
            line = _line_of_theory(axes, minutes)
            line.set(linestyle=style)
            entries[f"theory: {told}"] = line
    name_axes(axes, "robots", "minutes")
    add_key([axes], "", entries)
    figure: Figure = axes.figure.canvas.figure
    return figure


def _line(row: Row) -> Line:
    """Which line a row is of: brain, network and density."""
    return row.brain, row.topology, row.density


def _looks(found: Plan) -> dict[Line, Look]:
    """How each line looks: of several brains in several worlds, its colour is of the world, its marker of the brain."""
    free, lines = found.mission.free, list(dict.fromkeys(map(_line, found.rows)))
    worlds = {}
    for line in lines:
        name = [line[1]] if len(free.topology) > 1 else []
        if line[2] is not None and len(free.density or ()) > 1:
            name.append(f"D = {line[2]:g}")
        worlds[line] = ", ".join(name)
    brains = looks_of((brain for brain, *_ in lines), "o", "brain")
    places = looks_of(worlds.values(), "o", "topology")
    if len(places) == 1:
        return {line: brains[line[0]] for line in lines}
    if len(brains) == 1:
        return {line: places[worlds[line]] for line in lines}
    found_looks = {}
    for line in lines:
        brain, place = brains[line[0]], places[worlds[line]]
        found_looks[line] = Look(f"{brain.name}, {place.name}", place.short, place.colour, brain.marker)
    return found_looks


def _theories(found: Plan, which: str) -> list[dict[int, float]]:
    """What theory says of worlds, minutes by robots: one for all that agree."""
    every: list[dict[int, float]] = []
    for world in dict.fromkeys(_line(row)[1:] for row in found.rows):
        told = {row.robots: float(getattr(row.theory, which)) for row in found.rows if _line(row)[1:] == world}
        alike = [one for one in every if all(math.isclose(one.get(n, m), m, rel_tol=ALIKE) for n, m in told.items())]
        if not alike:
            every.append(told)
        else:
            alike[0].update(told)
    return every


def _line_of_theory(axes: Axes, minutes: dict[int, float]) -> Line2D:
    """Minutes by robots; of one size, from wall to wall."""
    sizes, line = sorted(minutes), Line2D([], [], color="0.5", linewidth=1.0, zorder=1)
    line.set(xdata=sizes, ydata=[minutes[size] for size in sizes])
    if len(sizes) == 1:
        line.set(xdata=[0.0, 1.0], ydata=[*minutes.values()] * 2, transform=axes.get_yaxis_transform())
    axes.add_line(line)
    return line


def _draw(axes: Axes, rows: list[Row], look: Look, aside: NDArray[np.float64]) -> None:
    """One line, `aside` points (right, up) beside where it belongs: through what is reached, in order of size."""
    rows = sorted(rows, key=lambda row: row.robots)
    there = [row for row in rows if row.answer == "reached"]
    place: dict[str, Any] = {
        "transform": axes.transData + ScaledTranslation(aside[0] / 72, aside[1] / 72, axes.figure.dpi_scale_trans)
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
