"""Scatter plot of convergence and error: one dot per robot and trial."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, Unpack

import numpy as np
import xarray as xr
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.backend_bases import RendererBase
from matplotlib.collections import LineCollection
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from numpy.typing import NDArray

from swarmcensus.analysis import ALONE, SWARM
from swarmcensus.figures.captions import (
    captioned,
    left_out,
    misleading,
    pooled_over,
    unlearnt,
    with_numbers,
    without_theory,
)
from swarmcensus.figures.coordinates import check_coordinates
from swarmcensus.figures.groups import Cloud, Cross, Dot, cloud_of, crosses_of, unit_of
from swarmcensus.figures.lettering import width_of
from swarmcensus.figures.page import PageOptions, drawing, letters, on_page
from swarmcensus.figures.panels import Names, Panel, panels_of
from swarmcensus.figures.sheets import (
    INNER,
    NOTHING,
    POOLED,
    UNRUN,
    Own,
    Scale,
    add_key,
    count_axis,
    error_axis,
    layout,
    name_axes,
    say_empty,
    second_line,
    sheet,
)
from swarmcensus.figures.styles import Look, halo, keyed, looks_of, median_dot, solid_dot
from swarmcensus.figures.theory_lines import (
    GREY,
    STYLES,
    THIN,
    Curves,
    curves_of,
    entries as theory_entries,
    shared,
)
from swarmcensus.results import SETTLING, titles_in
from swarmcensus.support.errors import InputError
from swarmcensus.support.options import wrong_option

LABELS = 0.25  # inches over a panel for the names of its medians, if they are short
MOST_NAMED = 24  # medians of a panel
CLAIM: dict[str, Any] = {"color": "#d55e00", "linewidth": 1.0, "linestyle": (0, (6, 2)), "zorder": 3.1}
TURNS = 6  # turns in which the dots of all colours are drawn
EARLY = 0.05  # share of the dots that may lie further left: x is linear if the others span less than half a decade


@on_page
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
    **more: Unpack[PageOptions],
) -> Figure:
    """Draw how fast and how well robots estimate: one dot per robot and trial, and the medians.

    x is the convergence K in communication rounds, or in ticks if robots move. y is the error |x^K - f|. Outlined dots
    are the medians for each value of `color`; if these are numbers, they stand above the panel too. Medians are rings
    where accuracies differ between robots. If a panel has too many medians, it names some of them, and the key says so.
    A thin cross through a median is its 95 % interval over trials on both axes. It needs at least 6 trials and swarms
    of one size. The paper's Figs. 2, 3 and 5 are such plots.

    - `color`: the coordinate shown by colour.
    - `panels`: coordinates; each combination of their values has a panel. By default all other coordinates that vary.
      Panels with the same unit share their axes.
    - `local`: draw local instead of informed estimates, with K in observations.
    - `error_limit`: the highest error drawn. Dots above it are counted instead.
    - `scale`: "log" makes both axes logarithmic, x above 1 and y above 0.01; x begins where the data begin, and is
      linear if all but the earliest 5 % of the dots span less than half a decade. "log-y" makes only y logarithmic.
      "linear" makes neither logarithmic, as in the paper. With "log-y" and "linear", x begins at 0.
    - `theory`: add the median error expected after the last round: dotted for robots alone, dashed for all readings
      of the swarm at once (not with `local`).
    - `title`: the title of the figure.
    - `ax`: axes of your own, one for each panel. Leave room for the key on their right.
    - `width`, `height`, `font_size`, `labels`: the page, and names of brains (see `PageOptions`).

    Raises InputError for an unknown coordinate, for results that lack a variable or a finished trial, and for more than
    24 panels.
    """
    check_coordinates(results, color=color, panels=panels)
    if error_limit is not None and not 0.0 < error_limit < np.inf:
        raise wrong_option("error_limit", error_limit, "should be a number above 0")
    parts = [p._replace(local=local, error_limit=error_limit) for p in panels_of(results, (color,), panels)]
    return scatter_grid(parts, color=color, scale=scale, theory=theory, title=title, ax=ax)


@drawing()
def scatter_grid(
    panels: Sequence[Panel | tuple[Any, ...]],
    *,
    color: str = "accuracy",
    scale: Scale = "log",
    theory: bool = False,
    title: str | None = None,
    ax: Own = None,
    claimed: str = "",
) -> Figure:
    """Draw `scatter` panels that the caller chooses, (a), (b), ..., with one key.

    A panel is a `Panel` or a tuple (caption, results[, local[, error_limit[, claim]]]). Panels with the same unit have
    the same x axis. Panels without an `error_limit` have the same y axis. A panel without finished trials says so. A
    claim is a horizontal line, of which the key says what is `claimed`.

    Raises InputError if there are no panels or more than 24, or if none holds a finished trial.
    """
    drawn = [Panel(*panel) for panel in panels]
    clouds = [cloud_of(panel.results, panel.local, color) for panel in drawn]
    every_caption = [panel.caption for panel in drawn]
    kept = with_numbers(ax, every_caption, [bool(cloud) for cloud in clouds])
    drawn, clouds = [drawn[k] for k in kept], [clouds[k] for k in kept]
    units = [unit_of(panel.results, panel.local) for panel in drawn]
    looks = looks_of(
        (value for cloud in clouds for value in cloud), "o", color, titles_in(*(panel.results for panel in drawn))
    )
    if drawn and not looks:
        raise InputError(NOTHING)
    expected: list[Curves] = [{} for _ in drawn]
    remarks: list[str] = []
    if theory:
        for k, panel in enumerate(drawn):
            kinds = (ALONE,) if panel.local else (ALONE, SWARM)
            expected[k], why = curves_of(panel.results, color, None, kinds)
            remarks.append(without_theory(panel.caption, why))
    captions = [panel.caption for panel in drawn]
    named_above = any(look.short for look in looks.values())
    above = max((width_of(look.short, _name_letters()) + 5) / 72 for look in looks.values()) if named_above else 0.0
    above = max(above, LABELS) if named_above else 0.0
    names = [f"convergence $K$ ({unit})" for unit in units]
    below = second_line(names, layout(len(drawn)).wide) if ax is None and drawn else 0.0
    axes = sheet(ax, captions, title, above=above, below=below, fewer=POOLED)
    free = [cloud for panel, cloud in zip(drawn, clouds, strict=True) if panel.error_limit is None]
    highest = max((error.max() for cloud in free for _, error in cloud.values()), default=0.0)
    crossed, all_named = False, True
    for panel, cloud, unit, name, curves, place in zip(drawn, clouds, units, names, expected, axes, strict=True):
        if not cloud:
            say_empty(place)
            continue
        same_unit = [i for i in range(len(units)) if units[i] == unit and clouds[i]]
        low = min(when.min() for i in same_unit for when, _ in clouds[i].values())
        early = float(np.quantile(np.concatenate([when for i in same_unit for when, _ in clouds[i].values()]), EARLY))
        count_axis(place, low, max(_horizon(drawn[i]) for i in same_unit), scale, early)
        error_axis(place, max(1.08 * highest, 1e-3) if panel.error_limit is None else panel.error_limit, scale)
        symbol = r"\hat{x}" if panel.local else "x"
        if len(free) == len(clouds) and ax is None:  # its left neighbour has the same axis
            place.tick_params(axis="y", labelleft=place.get_label() != INNER)
        name_axes(place, name, rf"error $|{symbol}^K - f\,|$")
        crosses = crosses_of(panel.results, panel.local, color)
        crossed = crossed or any(cross is not None for _, cross in crosses.values())
        all_named &= _draw_cloud(place, cloud, crosses, looks)
        _draw_theory(place, curves, looks)
        if panel.claim is not None:
            place.axhline(panel.claim, **CLAIM)
    heading, named = keyed(looks, color)
    entries: dict[str, Artist] = {look.name: median_dot(look, 6, 0.8) for look in named.values()}
    at_top = "median, named\nat the top" if all_named else "median; some are\nnamed at the top"
    median = at_top if named_above else "median"
    entries[median] = solid_dot(Look("", "", "#bbbbbb", "o"), 6, 0.8)
    if crossed:
        entries["its 95 % interval"] = Line2D([], [], linestyle="", marker="+", markersize=9, color="black", mew=0.8)
    entries["one robot, one trial"] = Line2D([], [], linestyle="", marker="o", markersize=2.4, color="0.6")
    entries |= theory_entries(expected)
    if any(panel.claim is not None for panel in drawn):
        entries[claimed] = Line2D([], [], **CLAIM)
    if scale != "linear":
        from_0 = any(place.get_xscale() == "asinh" and place.get_xlim()[0] < 1 for place in axes)
        linear_part = "axes are linear to\nK = 1, error 0.01" if from_0 else "errors are linear to\n0.01"
        entries[f"{linear_part}, then\nlogarithmic"] = Line2D([], [], linestyle="")
    add_key(axes, heading, entries)
    parts = [panel.results for panel in drawn]
    remarks += left_out(every_caption, kept, UNRUN), pooled_over(parts, [color])
    informed = [panel.results for panel in drawn if not panel.local]
    remarks += misleading(informed), unlearnt(informed, SETTLING, "no median is drawn")
    return captioned(axes, scatter, parts, remarks)


def _name_letters() -> float:
    """The size in points of names of medians over a panel."""
    return letters() - 1.5


def _horizon(panel: Panel) -> float:
    """The largest possible convergence."""
    rounds = panel.results["rounds"]
    return float((rounds * panel.results["observations_per_round"] if panel.local else rounds).max())


def _draw_theory(axes: Axes, curves: Curves, looks: dict[str, Look]) -> None:
    """Draw the expected errors after the last round; lines that all values of the colour share are grey."""
    same = shared(curves)
    different = {text: {n: line for n, line in lines.items() if n not in same} for text, lines in curves.items()}
    for text, lines in ({"": same} | different).items():
        for name, line in lines.items():
            axes.axhline(
                line.median_error[-1], color=looks[text].colour if text else GREY, linewidth=THIN,
                linestyle=STYLES[name], zorder=3.2, label=f"theory {name} {text}".rstrip(),
                path_effects=halo(THIN + 0.8),
            )  # fmt: skip


def _draw_cloud(axes: Axes, cloud: Cloud, crosses: dict[str, tuple[Dot, Cross | None]], looks: dict[str, Look]) -> bool:
    """Draw the dots and medians of a panel. Returns whether all of its medians are named."""
    drawn = [text for text in looks if text in cloud]
    total = sum(when.size for when, _ in cloud.values())
    alpha = float(np.clip(25 / np.sqrt(total), 0.12, 0.6))
    distinct = {text: np.unique(np.stack(cloud[text]).round(9), axis=1, return_counts=True) for text in drawn}
    # Colours take turns, each drawing a share of its dots, so that no colour covers all others; spread accuracies lie
    # below the rest. Equal dots (fully connected robots agree) are drawn once, with the opacity of all of them, since
    # their soft edges would add up to squares.
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
    with_median = [text for text in drawn if text in crosses]
    for text in with_median:
        (x, y), cross = crosses[text]
        dot = median_dot(looks[text], 6, 0.8)
        dot.set(xdata=[x], ydata=[y], label=f"median {text}", zorder=4, path_effects=halo(2.4))
        axes.add_line(dot)
        if cross is not None:
            left, right, low, high = cross
            thin: dict[str, Any] = {"color": looks[text].colour, "linewidth": 0.8, "path_effects": halo(1.6)}
            axes.plot([left, right], [y, y], label=f"cross {text}", **thin, zorder=3.5)
            axes.plot([x, x], [low, high], label=f"cross {text}", **thin, zorder=3.5)
    named = [text for text in with_median if looks[text].short]
    all_named = True
    if named:
        all_named = label_dots(axes, [crosses[text][0] for text in named], [looks[text].short for text in named])
    beyond = sum(int((error > axes.get_ylim()[1]).sum()) for _, error in cloud.values())
    if beyond:
        axes.text(
            0.02, 0.98, f"{beyond:,} of {total:,} dots\nlie above", va="top", transform=axes.transAxes,
            fontsize=letters() - 1, color="0.3", path_effects=halo(2), zorder=6,
        )  # fmt: skip
    return all_named


class _Leaders(LineCollection):
    """Lines from names over the axes down to dots. They are computed when drawn, as the axes' limits may change."""

    def __init__(self, axes: Axes, starts: NDArray[np.float64], dots: NDArray[np.float64]) -> None:
        super().__init__([], linewidths=0.35, colors="0.3", zorder=3, transform=axes.transAxes, clip_on=False)
        self.starts, self.dots = starts, dots
        self.connect(axes)

    def connect(self, axes: Axes) -> None:
        self.set_segments(list(np.stack([self.starts, _ends_of(axes, self.dots)], axis=1)))

    def draw(self, renderer: RendererBase) -> None:
        # Shared or zoomed axes may have new limits.
        assert isinstance(self.axes, Axes)
        self.connect(self.axes)
        super().draw(renderer)


def _ends_of(axes: Axes, dots: Sequence[tuple[float, float]] | NDArray[np.float64]) -> NDArray[np.float64]:
    """The positions of dots in coordinates of the axes; dots outside are moved to the edge."""
    ends = axes.transAxes.inverted().transform(axes.transData.transform(dots))
    return np.asarray(np.clip(ends, 0, 1), np.float64)


def label_dots(axes: Axes, dots: Sequence[tuple[float, float]], texts: Sequence[str]) -> bool:
    """Write texts[i] above the axes, upright if they lack room, with a thin line down to dots[i] (data coordinates).

    Names cover no data there. They stand in the order of the dots, as straight above them as their size allows. If not
    all fit, a few evenly chosen dots are named, far apart, because their lines would hide the data. The axes must have
    their final limits and size. Returns whether all dots are named.
    """
    width, height = np.array([axes.bbox.width, axes.bbox.height]) * 72 / axes.figure.dpi
    ends = _ends_of(axes, dots)
    longest = max(width_of(text, _name_letters()) for text in texts) + 3  # points
    level = longest * len(texts) <= width
    step = longest if level else 1.2 * _name_letters()
    order = np.argsort(ends[:, 0], kind="stable")
    if len(order) > min(MOST_NAMED, 1 + width / (1.2 * _name_letters())):
        few = int(1 + width / (4 * _name_letters()))
        order = order[np.linspace(0, len(order) - 1, few).round().astype(int)]
    ends, texts = ends[order], [texts[i] for i in order]
    # Neighbours must stand at least a line apart. Pushing all to the right achieves this, and so does pushing all to
    # the left; the mean of both does too, and is closest to the dots.
    steps = np.arange(len(ends)) * step / width
    wanted = ends[:, 0] - steps
    right, left = np.maximum.accumulate(wanted), np.minimum.accumulate(wanted[::-1])[::-1]
    places = np.clip((right + left) / 2, 0, max(0, 1 - steps[-1])) + steps
    starts = np.stack([places, np.full(len(ends), 1 + 2 / height)], axis=1)
    axes.add_collection(_Leaders(axes, starts, np.array(dots)[order]), autolim=False)
    for place, text in zip(places, texts, strict=True):
        axes.text(
            place, 1 + 3 / height, text, rotation=0 if level else 90, ha="center", va="bottom",
            fontsize=_name_letters(), transform=axes.transAxes, parse_math=False,
        )  # fmt: skip
    return len(order) == len(dots)
