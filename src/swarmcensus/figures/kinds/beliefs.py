"""The cost of wrong beliefs: final error against the error of robots' belief in their sensors."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, Unpack

import numpy as np
import xarray as xr
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.ticker import FuncFormatter, MaxNLocator

from swarmcensus.analysis import Cost, accuracy_of, costs, costs_of, goes_to
from swarmcensus.figures.captions import captioned, with_numbers
from swarmcensus.figures.lettering import SPACING
from swarmcensus.figures.page import PageOptions, letters, on_page
from swarmcensus.figures.panels import panels_of
from swarmcensus.figures.sheets import NOTHING, UNRUN, Own, add_key, name_axes, say_empty, sheet, show_range
from swarmcensus.figures.styles import Look, add_dots, key_mark, keyed, looks_of, outlined_dot
from swarmcensus.support.errors import InputError
from swarmcensus.worlds import Accuracy

DASHED: dict[str, Any] = {"linestyle": (0, (4, 2)), "linewidth": 0.9}
ON_AXES = {"accuracy", "assumed_accuracy"}  # coordinates that do not make panels
MARKERS = "osD^vPXp"
TICKS = MaxNLocator(4, steps=[1, 2, 2.5, 5, 10])
FINE = 401  # points of a dashed line
BESIDE = 0.3  # distance of the columns of random beliefs, as a share of the range of x


@on_page
def beliefs(results: xr.Dataset, *, title: str | None = None, ax: Own = None, **more: Unpack[PageOptions]) -> Figure:
    """Draw the error of final estimates against the error of the robots' belief in their sensors.

    x is the assumed minus the true accuracy. y is the median of |x - f| over robots and trials, with its 95 % interval
    by bootstrap over trials. Beliefs that differ from robot to robot, or from sensor to sensor, stand in columns of
    their own on the right. Thin dashed lines are the errors that theory predicts after endless observation
    (`asymptote`). If there is no prediction, solid lines join the medians. Each fill ratio has a panel, and
    so has each value of other coordinates that vary. All panels share their axes.

    - `title`: the title of the figure.
    - `ax`: axes of your own, one for each panel. Leave room for the key on their right.
    - `width`, `height`, `font_size`, `labels`: the page, and names of brains (see `PageOptions`).

    Raises InputError if all robots know their sensors, if a belief is off by different amounts for black and white, for
    results without a finished trial, and for more than 24 panels.
    """
    costs(results)
    panels = panels_of(results, ON_AXES)
    drawn = [[cost for cost in costs_of(panel.results) if np.isfinite(cost.median)] for panel in panels]
    kept, unrun = with_numbers(ax, [panel.caption for panel in panels], list(map(bool, drawn)), UNRUN)
    panels, drawn = [panels[k] for k in kept], [drawn[k] for k in kept]
    every = [cost for group in drawn for cost in group]
    if not every:
        raise InputError(NOTHING)
    looks = looks_of((cost.accuracy for cost in every), "o")
    looks = {text: look._replace(marker=MARKERS[k % 8]) for k, (text, look) in enumerate(looks.items())}
    columns = list(dict.fromkeys(cost.belief for cost in every if cost.error is None))
    errors = sorted({cost.error for cost in every if cost.error is not None}) or [0.0]
    span = max(errors[-1] - errors[0], 0.05)
    places = {belief: errors[-1] + BESIDE * span * (k + 1) for k, belief in enumerate(columns)}
    below = 2.0 * SPACING * letters() / 72 if places else 0.0
    axes = sheet(ax, [panel.caption for panel in panels], title, below=below)
    top = 1.08 * max(max(np.nanmax([c.median, c.high, c.predicted]) for c in every), 1e-3)
    for place, group in zip(axes, drawn, strict=True):
        if not group:
            say_empty(place)
            continue
        same_line = _coinciding(group, 0.002 * top)
        for k, (text, look) in enumerate(looks.items()):
            same = [cost for cost in group if cost.accuracy == text]
            size = 6.5 - 3.0 * k / max(len(looks) - 1, 1)  # so that no dot hides another
            _draw_fixed(place, sorted((c.error, c) for c in same if c.error is not None), look, size, same_line)
            aside = (k - (len(looks) - 1) / 2) * 0.5 * BESIDE * span / len(looks)
            in_columns = [c for c in same if c.error is None]
            _draw_points(place, [places[c.belief] + aside for c in in_columns], in_columns, look, size)
        if places:
            place.axvline(errors[-1] + 0.4 * BESIDE * span, color="0.8", linewidth=0.6, zorder=0)
        right = max([errors[-1], *places.values()]) + (0.12 if places else 0.05) * span
        show_range(place, "x", errors[0] - 0.05 * span, right)
        show_range(place, "y", -0.01 * top, top)
        shown = [x for x in TICKS.tick_values(errors[0], errors[-1]) if errors[0] <= x <= errors[-1]]
        names = [f"{x:+.3g}" if x else "0" for x in shown]
        for belief in places:
            text = belief.removeprefix("error=").replace(".0,", ",").replace(",", ", ")
            names.append(f"{text}\nrandom\nerror" if belief.startswith("error=") else f"all\nbelieve\n{text}")
        place.set_xticks([*shown, *places.values()], names)
        place.yaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
        name_axes(place, "belief: assumed minus true accuracy", r"final error $|x - f\,|$, median")
    heading, named = keyed(looks)
    entries: dict[str, Artist] = {look.name: outlined_dot(look, 5, 0.6) for look in named.values()}
    if any(np.isfinite(cost.low) for cost in every):
        entries["95 % interval"] = key_mark("|", 9)
    if any(not np.isfinite(cost.predicted) and cost.error is not None for cost in every):
        entries["solid: joins medians"] = Line2D([], [], color="0.3", linewidth=0.8)
    if any(np.isfinite(cost.predicted) for cost in every):
        entries["predicted, after\nendless observation"] = Line2D([], [], **DASHED, color="0.3")
    add_key(axes, heading, entries)
    return captioned(axes, beliefs, [panel.results for panel in panels], [unrun])


def _coinciding(group: list[Cost], near: float) -> list[str]:
    """The accuracies of a panel with predicted lines that coincide with the first one; none if no other does."""
    lines: dict[str, dict[float | None, float]] = {}
    for cost in (cost for cost in group if np.isfinite(cost.predicted)):
        lines.setdefault(cost.accuracy, {})[cost.error] = cost.predicted
    first: dict[float | None, float] = next(iter(lines.values()), {})
    same = [t for t, line in lines.items() if all(abs(first.get(x, np.inf) - y) < near for x, y in line.items())]
    return same if len(same) > 1 else []


def _draw_fixed(axes: Axes, points: list[tuple[float, Cost]], look: Look, size: float, same: Sequence[str]) -> None:
    """Draw the beliefs of one accuracy that are off by the same error in all robots, and the predicted line.

    Lines of the accuracies `same` coincide: each has its dashes in the gaps of the others.
    """
    if not points:
        return
    x, group = [error for error, _ in points], [cost for _, cost in points]
    first = group[0]
    if np.isfinite(first.predicted):
        true = accuracy_of(first.accuracy)
        assert isinstance(true, Accuracy)
        fine = np.linspace(x[0], x[-1], FINE)
        off = np.abs(goes_to(true, fine, first.fill_ratio) - first.fill_ratio)
        dashes = DASHED
        if first.accuracy in same:
            dashes = DASHED | {"linestyle": (-6 * same.index(first.accuracy), (4, 6 * len(same) - 4))}
        axes.plot(fine, off, **dashes, color=look.colour, label=f"predicted {first.accuracy}", zorder=2)
    else:
        axes.plot(x, [cost.median for cost in group], color=look.colour, linewidth=0.8, zorder=2)
    _draw_points(axes, x, group, look, size)


def _draw_points(axes: Axes, x: list[float], group: list[Cost], look: Look, size: float) -> None:
    axes.vlines(x, [c.low for c in group], [c.high for c in group], colors=look.colour, linewidths=1.2, zorder=3)
    medians, style = [cost.median for cost in group], {"zorder": 4, "clip_on": False}
    add_dots(axes, outlined_dot(look, size, 0.5), x, medians, label=f"median {look.name}", **style)
