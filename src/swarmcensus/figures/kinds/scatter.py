"""How fast and how well robots estimate: a dot for each."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import xarray as xr
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.backend_bases import RendererBase
from matplotlib.collections import LineCollection
from matplotlib.lines import Line2D
from numpy.typing import NDArray

from swarmcensus.basics.errors import InputError
from swarmcensus.explaining.expectations import ALONE, SWARM
from swarmcensus.figures.clouds import Cloud, Cross, cloud_of, crosses_of, unit_of
from swarmcensus.figures.coordinates import check_coordinates
from swarmcensus.figures.lettering import width_of
from swarmcensus.figures.looks import Look, halo, keyed, looks_of, median_dot, solid_dot
from swarmcensus.figures.panels import Names, Panel, panels_of
from swarmcensus.figures.sheets import (
    NOTHING,
    POOLED,
    SMALL,
    Drawn,
    Own,
    Scale,
    add_key,
    count_axis,
    drawn_on,
    error_axis,
    name_axes,
    say_empty,
    say_lacking,
    say_pooled,
    sheet,
)
from swarmcensus.figures.theory_lines import GREY, STYLES, THIN, Curves, curves_of, shared, told
from swarmcensus.figures.theory_lines import entries as theory_entries

LABELS = 0.25  # inches over a scatter panel for the names of its medians, if they are short
TURNS = 6
EARLY = 0.05  # of the dots: if what is left of them spans less than half a decade, the axis is linear


def scatter(
    results: xr.Dataset,
    *,
    color: str = "accuracy",
    panels: Names = None,
    local: bool = False,
    error_limit: float | None = None,
    scale: Scale = "log",
    theory: bool = False,
    title: str | None = None,
    ax: Own = None,
) -> Drawn:
    """Draw how fast and how well robots estimate: one dot a robot and trial, and the medians.

    The paper's Figs. 2, 3 and 5. x is the convergence K in communication rounds, or in ticks of robots that move
    (`local`: of the local estimate, in observations), y the error |x^K - f|; outlined dots, named above the panel, are
    the medians of the values of the coordinate `color`: rings where robots' accuracies differ, so that they hide no
    other. A thin cross through a median is its 95 % interval over trials on both axes, where there are 6 trials or
    more, of swarms of one size. Of too many medians the panel names some, and the key says so. There is a panel for
    each combination of the coordinates `panels`, by default of all others that vary; those of one unit share their
    axes. With `scale` "log" both axes are logarithmic, above 1 and 0.01, and x begins where the data do (and is linear
    where all but the earliest 5 % span less than half a decade); with "log-y" the error alone is, and x begins at 0;
    "linear" is the paper's. With `theory`, dots lie at the median error that is expected of robots alone after the last
    round, and dashes at that of the bound of all readings of the swarm (not with `local`). Dots above `error_limit` are
    counted instead of drawn. Axes of your own, `ax`, hold a panel each: leave room for the key on their right.

    Raises InputError if there is no such coordinate, `results` lacks a variable or holds no finished trial, and for
    more than 24 panels.
    """
    check_coordinates(results, color=color, panels=panels)
    parts = [p._replace(local=local, error_limit=error_limit) for p in panels_of(results, (color,), panels)]
    return scatter_grid(parts, color=color, scale=scale, theory=theory, title=title, ax=ax)


def scatter_grid(
    panels: Sequence[Panel | tuple[Any, ...]],
    *,
    color: str = "accuracy",
    scale: Scale = "log",
    theory: bool = False,
    title: str | None = None,
    ax: Own = None,
) -> Drawn:
    """Draw `scatter` panels of one's own choice, (a), (b), ..., with one key.

    A panel is a `Panel` or a tuple (caption, results[, local[, error_limit]]). So that panels compare, those
    of one unit have the same x axis, and those without an `error_limit` of their own the same y axis. A panel
    without finished trials says so.

    Raises InputError if there are no panels or more than 24, or if none holds a finished trial.
    """
    drawn = [Panel(*panel) for panel in panels]
    clouds = [cloud_of(panel.results, panel.local, color) for panel in drawn]
    units = [unit_of(panel.results, panel.local) for panel in drawn]
    looks = looks_of((value for cloud in clouds for value in cloud), "o", color)
    if drawn and not looks:
        raise InputError(NOTHING)
    expected: list[Curves] = [{} for _ in drawn]
    if theory:
        for k, panel in enumerate(drawn):
            names = (ALONE,) if panel.local else (ALONE, SWARM)
            expected[k], why = curves_of(panel.results, color, None, names)
            drawn[k] = told(panel, why)
    captions = [panel.caption for panel in drawn]
    above = max([LABELS, *((width_of(look.short, NAMES) + 5) / 72 for look in looks.values())])
    axes = sheet(ax, captions, title, above=above, fewer=POOLED)
    free = [cloud for panel, cloud in zip(drawn, clouds, strict=True) if panel.error_limit is None]
    highest = max((error.max() for cloud in free for _, error in cloud.values()), default=0.0)
    crossed, all_named = False, True
    for panel, cloud, unit, curves, place in zip(drawn, clouds, units, expected, axes, strict=True):
        if not cloud:
            say_empty(place)
            continue
        alike = [i for i, other in enumerate(units) if other == unit and clouds[i]]
        low = min(when.min() for i in alike for when, _ in clouds[i].values())
        early = float(np.quantile(np.concatenate([when for i in alike for when, _ in clouds[i].values()]), EARLY))
        count_axis(place, low, max(_horizon(drawn[i]) for i in alike), scale, early)
        error_axis(place, max(1.08 * highest, 1e-3) if panel.error_limit is None else panel.error_limit, scale)
        symbol = r"\hat{x}" if panel.local else "x"
        name_axes(place, f"convergence $K$ ({unit})", rf"error $|{symbol}^K - f\,|$")
        crosses = crosses_of(panel.results, panel.local, color)
        crossed = crossed or bool(crosses)
        all_named &= _draw_cloud(place, cloud, crosses, looks)
        same = shared(curves)
        apart = {text: {n: line for n, line in lines.items() if n not in same} for text, lines in curves.items()}
        for text, lines in ({"": same} | apart).items():
            for name, line in lines.items():
                place.axhline(
                    line.median_error[-1], color=looks[text].colour if text else GREY, linewidth=THIN,
                    linestyle=STYLES[name], zorder=3.2, label=f"theory {name} {text}".rstrip(),
                    path_effects=halo(THIN + 0.8),
                )  # fmt: skip
    heading, named = keyed(looks, color)
    entries: dict[str, Artist] = {look.name: median_dot(look, 6, 0.8) for look in named.values()}
    median = "median, named\nat the top" if all_named else "median; some are\nnamed at the top"
    entries[median] = solid_dot(Look("", "", "#bbbbbb", "o"), 6, 0.8)
    if crossed:
        entries["its 95 % interval"] = Line2D([], [], linestyle="", marker="+", markersize=9, color="black", mew=0.8)
    entries["one robot, one trial"] = Line2D([], [], linestyle="", marker="o", markersize=2.4, color="0.6")
    entries |= theory_entries(expected)
    if scale != "linear":
        from_0 = any(one.get_xscale() == "asinh" and one.get_xlim()[0] < 1 for one in axes)
        bent = "axes are linear to\n1 and 0.01" if from_0 else "errors are linear to\n0.01"
        entries[f"{bent}, then\nlogarithmic"] = Line2D([], [], linestyle="")
    add_key(axes, heading, entries)
    say_lacking(axes, [panel.results for panel in drawn])
    say_pooled(axes, [panel.results for panel in drawn], [color])
    return drawn_on(axes, ax)


def _horizon(panel: Panel) -> float:
    rounds = panel.results["rounds"]
    return float((rounds * panel.results["observations_per_round"] if panel.local else rounds).max())


def _draw_cloud(axes: Axes, cloud: Cloud, crosses: dict[str, Cross], looks: dict[str, Look]) -> bool:
    """Draw what a panel holds; returns whether all of its medians are named."""
    drawn = [text for text in looks if text in cloud]
    total = sum(when.size for when, _ in cloud.values())
    alpha = float(np.clip(25 / np.sqrt(total), 0.12, 0.6))
    distinct = {text: np.unique(np.stack(cloud[text]).round(9), axis=1, return_counts=True) for text in drawn}
    # In turns, a share of each accuracy's dots at a time, so that none lies on top of all others, and those of
    # spread accuracies below them. Equal dots (fully connected robots agree) are drawn once, as opaque as all of
    # them: their soft edges would add up to squares.
    for turn in range(TURNS):
        for text in drawn:
            (when, error), copies = (values[..., turn::TURNS] for values in distinct[text])
            for count in np.unique(copies):
                axes.plot(
                    when[copies == count], error[copies == count], "o", markersize=2.4, markeredgewidth=0,
                    color=looks[text].colour, alpha=1 - (1 - alpha) ** count, rasterized=True,
                    zorder=1.9 if looks[text].spread else 2,
                    label=f"dots {text}",
                )  # fmt: skip
    medians = [(float(np.median(cloud[text][0])), float(np.median(cloud[text][1]))) for text in drawn]
    for text, (x, y) in zip(drawn, medians, strict=True):
        dot = median_dot(looks[text], 6, 0.8)
        dot.set(xdata=[x], ydata=[y], label=f"median {text}", zorder=4, path_effects=halo(2.4))
        axes.add_line(dot)
        if text in crosses:
            left, right, low, high = crosses[text]
            thin: dict[str, Any] = {"color": looks[text].colour, "linewidth": 0.8, "path_effects": halo(1.6)}
            axes.plot([left, right], [y, y], label=f"cross {text}", **thin, zorder=3.5)
            axes.plot([x, x], [low, high], label=f"cross {text}", **thin, zorder=3.5)
    all_named = label_dots(axes, medians, [looks[text].short for text in drawn])
    beyond = sum(int((error > axes.get_ylim()[1]).sum()) for _, error in cloud.values())
    if beyond:
        axes.text(
            0.02, 0.98, f"{beyond:,} of {total:,} dots\nlie above", va="top", transform=axes.transAxes,
            fontsize=SMALL - 1, color="0.3", path_effects=halo(2), zorder=6,
        )  # fmt: skip
    return all_named


MOST_NAMED = 24  # dots of a panel
NAMES = SMALL - 1.5  # points: names of dots over a panel


class _Leaders(LineCollection):
    """Lines from names over the axes down to dots, wherever these are when they are drawn."""

    def __init__(self, axes: Axes, starts: NDArray[np.float64], dots: NDArray[np.float64]) -> None:
        super().__init__([], linewidths=0.35, colors="0.3", zorder=3, transform=axes.transAxes, clip_on=False)
        self.starts, self.dots = starts, dots
        self.lead(axes)

    def lead(self, axes: Axes) -> None:
        self.set_segments(list(np.stack([self.starts, _ends_of(axes, self.dots)], axis=1)))

    def draw(self, renderer: RendererBase) -> None:
        # Limits that are shared, or zoomed, may be others than they were.
        assert isinstance(self.axes, Axes)
        self.lead(self.axes)
        super().draw(renderer)


def _ends_of(axes: Axes, dots: Sequence[tuple[float, float]] | NDArray[np.float64]) -> NDArray[np.float64]:
    """Where dots are upon the axes, those beyond at their edge."""
    ends = axes.transAxes.inverted().transform(axes.transData.transform(dots))
    return np.asarray(np.clip(ends, 0, 1), np.float64)


def label_dots(axes: Axes, dots: Sequence[tuple[float, float]], texts: Sequence[str]) -> bool:
    """Write texts[i] above the axes, upright, with a thin line down to dots[i] (data coordinates).

    There they cover no data, and stand in the order of the dots, as straight above them as their size allows.
    Of more than fit some are named, evenly chosen, and far apart: their lines would hide what is below. The axes must
    have their final limits and size. Returns whether all are named.
    """
    size = NAMES
    width, height = np.array([axes.bbox.width, axes.bbox.height]) * 72 / axes.figure.dpi
    ends = _ends_of(axes, dots)
    order = np.argsort(ends[:, 0], kind="stable")
    if len(order) > min(MOST_NAMED, 1 + width / (1.2 * size)):
        few = int(1 + width / (4 * size))
        order = order[np.linspace(0, len(order) - 1, few).round().astype(int)]
    ends, texts = ends[order], [texts[i] for i in order]
    # Neighbours stand at least a line apart: pushing all to the right does it, so does pushing all to the
    # left, and so does the mean of both.
    steps = np.arange(len(ends)) * 1.2 * size / width
    wanted = ends[:, 0] - steps
    right, left = np.maximum.accumulate(wanted), np.minimum.accumulate(wanted[::-1])[::-1]
    places = np.clip((right + left) / 2, 0, max(0, 1 - steps[-1])) + steps
    starts = np.stack([places, np.full(len(ends), 1 + 2 / height)], axis=1)
    axes.add_collection(_Leaders(axes, starts, np.array(dots)[order]), autolim=False)
    for place, text in zip(places, texts, strict=True):
        axes.text(
            place, 1 + 3 / height, text, rotation=90, ha="center", va="bottom", fontsize=size,
            transform=axes.transAxes,
        )  # fmt: skip
    return len(order) == len(dots)
