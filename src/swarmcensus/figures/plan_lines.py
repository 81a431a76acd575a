"""Picture of a plan: the minutes that swarms of each size need, one line per brain and world, and theory."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from numpy.typing import NDArray

from swarmcensus.figures.axes import coordinate_axis, measured_axis
from swarmcensus.figures.page import drawing
from swarmcensus.figures.sheets import add_key, figure_of, name_axes, sheet
from swarmcensus.figures.styles import Look, add_dots, key_mark, looks_of, outlined_dot, shifted
from swarmcensus.search import Need, Plan
from swarmcensus.support.errors import InputError

# All lengths are in points.
SIZE = 5.0  # of a dot
BESIDE = 7.0  # between the dots of lines, if there is one size of swarms
NEXT = 2.5  # the same if there are several sizes,
FEW = 2  # and more lines than these

Line = tuple[str, str]  # brain and world


@drawing()
def draw_plan(plan: Plan, title: str | None = None) -> Figure:
    """Draw the minutes that a plan needs against the number of robots.

    Full dots were simulated and reach the goal. Bars are 95 % intervals over trials; a bar to the edge has no upper
    end. A hollow dot does not reach the goal even in the longest time. Grey lines are theory.

    Raises InputError if the plan has no rows.
    """
    if not plan.needs:
        raise InputError("there is nothing to draw: the plan has no rows")
    mission, looks, entries = plan.mission, _looks(plan), dict[str, Artist]()
    caption = f"{100 * mission.wanted.probability:g} % of robots {mission.goal}"
    [axes] = sheet([caption], title)
    every = [minutes for row in plan.needs for minutes in (row.minutes, row.theory.pooled, row.theory.alone)]
    measured_axis([axes], every, [end for row in plan.needs for end in (row.minutes_low, row.minutes_high) if end])
    sizes = {size for row in plan.needs for size in (row.robots, row.robots_low, row.robots_high) if size is not None}
    across = looks_of(map(str, sorted(sizes)), "o", "robots")
    coordinate_axis([axes], "robots", across, 4.0 * NEXT * (len(looks) > FEW))
    one_size = len({row.robots for row in plan.needs}) == 1
    step = np.array([BESIDE if one_size else NEXT * (len(looks) > FEW), 0.0])  # from line to line: to the right, and up
    if plan.question == "how many":
        step = np.array([0.0, BESIDE / 2.0])
    for k, (line, look) in enumerate(looks.items()):
        aside = step * (k - (len(looks) - 1) / 2.0)
        _draw(axes, [row for row in plan.needs if row.line == line], look, aside)
        entries[look.name] = outlined_dot(look, SIZE, 0.4)
    if any(row.minutes_low or row.robots_low for row in plan.needs):
        entries["95 % interval"] = key_mark("|")
    if any(row.answer != "reached" for row in plan.needs):
        entries["hollow: not reached by then"] = key_mark("o", SIZE, mfc="white")
    for which, style, name in (("alone", ":", "a robot alone"), ("pooled", "--", "all readings at once")):
        for world in dict.fromkeys(row.place for row in plan.needs):
            rows = [row for row in plan.needs if row.place == world]
            minutes = {row.robots: float(getattr(row.theory, which)) for row in rows}
            entries[f"theory: {name}"] = _draw_theory(axes, minutes, style)
    name_axes(axes, "robots", "time needed (minutes)")
    add_key([axes], "", entries)
    return figure_of([axes])


def _looks(plan: Plan) -> dict[Line, Look]:
    """The look of each line: of brains, or of worlds if these vary."""
    lines = list(dict.fromkeys(row.line for row in plan.needs))
    brains, places = ({line[k] for line in lines} for k in (0, 1))
    names = [
        brain if len(places) == 1 else place if len(brains) == 1 else f"{brain}, {place}" for brain, place in lines
    ]
    looks = looks_of(names, "o", "brain" if len(places) == 1 else "topology")
    return {line: looks[name] for line, name in zip(lines, names, strict=True)}


def _draw_theory(axes: Axes, minutes: dict[int, float], dashes: str) -> Line2D:
    """Draw minutes by robots, or a horizontal line through the whole panel if there is one size of swarms."""
    style: dict[str, Any] = {"color": "0.5", "linewidth": 1.0, "linestyle": dashes, "zorder": 1}
    if len(minutes) == 1:
        return axes.axhline(*minutes.values(), **style)
    return axes.add_line(Line2D(*zip(*sorted(minutes.items()), strict=True), **style))


def _draw(axes: Axes, rows: list[Need], look: Look, aside: NDArray[np.float64]) -> None:
    """Draw one line through the rows that reach the goal, moved by `aside` points (right, up) to hide no other line."""
    rows = sorted(rows, key=lambda row: row.robots)
    reached = [row for row in rows if row.answer == "reached"]
    place: dict[str, Any] = {"transform": shifted(axes.transData, axes, *aside.tolist())}
    bar: dict[str, Any] = {"colors": look.colour, "linewidths": 1.0, "zorder": 2.5, **place}
    axes.plot([r.robots for r in reached], [r.minutes for r in reached], color=look.colour, lw=1.0, zorder=2, **place)
    for row in rows:
        if row.minutes_low is not None:
            axes.vlines(row.robots, row.minutes_low, row.minutes_high or axes.get_ylim()[1], **bar)
        if row.robots_low is not None:
            axes.hlines(row.minutes, row.robots_low, row.robots_high or axes.get_xlim()[1], **bar)
        dot = outlined_dot(look, SIZE, 0.4, hollow=0.0 if row.answer == "reached" else 1.2)
        add_dots(axes, dot, [row.robots], [row.minutes], zorder=3, **place)
