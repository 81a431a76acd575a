"""The figures: one function per kind, from a study's results or a trace to a matplotlib Figure.

All use matplotlib's object-oriented interface only (no pyplot): no display, no global state, any thread.
`save` writes what they return. `panels` picks the numbers, `sheets` knows how panels look.
"""

from __future__ import annotations

import json
from collections.abc import Sequence
from typing import Any

import matplotlib as mpl
import numpy as np
import xarray as xr
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from matplotlib.colors import AsinhNorm
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch
from matplotlib.ticker import FixedLocator
from numpy.typing import NDArray

from swarmcensus.errors import InputError
from swarmcensus.metrics import right_bin
from swarmcensus.panels import Cloud, Panel, Shares, cloud_of, panels_of, require, shares_of, truth_of, unit_of, varies
from swarmcensus.sheets import (
    SMALL,
    Look,
    Scale,
    add_key,
    caption_panels,
    count_axis,
    error_axis,
    halo,
    label_dots,
    looks_of,
    name_axes,
    new_sheet,
    palette,
    save,
    say_empty,
    solid_dot,
)

__all__ = ["Panel", "curves", "decisions", "decisions_grid", "heatmap", "panels_of", "save", "scatter",
           "scatter_grid"]  # fmt: skip

NOTHING = "nothing to draw: no trial of these settings has been run"
LABELS = 0.25  # inches over a scatter panel for the names of its medians
TURNS = 6
MOST_CHECKPOINTS = 12
MOST_LINES = 100  # robots that `curves` draws one by one; a larger swarm is drawn as bands


def scatter(
    results: xr.Dataset,
    *,
    local: bool = False,
    title: str | None = None,
    axes: Axes | None = None,
    error_limit: float | None = None,
    scale: Scale = "log",
) -> Figure:
    """Draw how fast and how well robots estimate: one dot a robot and trial, and the medians.

    The panel of the paper's Figs. 2, 3 and 5. x is the convergence K in communication rounds, or in ticks of
    robots that move (`local`: of the local estimate, in observations), y the error |x^K - f|; solid, outlined
    dots, named above the panel, are the medians of the sensor accuracies, whose colours `sheets.looks_of`
    explains. All settings of `results` share the panel. Both axes begin at 0; with `scale` "log" they are
    logarithmic above 1 and 0.01, with "log-y" the error alone is; "linear" is the paper's. Dots above
    `error_limit` are counted instead of drawn. In `axes` of your own, leave room for the key on their right.

    Raises InputError if `results` lacks a variable or holds no finished trial.
    """
    panel = Panel(title or "", results, local, error_limit)
    return _scatter([panel], [axes] if axes else new_sheet(1, above=LABELS), scale)


def scatter_grid(
    panels: Sequence[Panel | tuple[Any, ...]], *, title: str | None = None, scale: Scale = "log"
) -> Figure:
    """Draw several `scatter` panels, (a), (b), ..., with one key: the paper's Figs. 2, 3 and 5.

    A panel is a `Panel` or a tuple (caption, results[, local[, error_limit]]). So that panels compare, those
    of one unit have the same x axis, and those without an `error_limit` of their own the same y axis. A panel
    without finished trials says so.

    Raises InputError if there are no panels or more than 24, or if none holds a finished trial.
    """
    axes = new_sheet(len(panels), title, above=LABELS)
    return _scatter([Panel(*panel) for panel in panels], axes, scale)


def _scatter(panels: list[Panel], axes: list[Axes], scale: Scale) -> Figure:
    clouds = [cloud_of(panel.results, panel.local) for panel in panels]
    units = [unit_of(panel.results, panel.local) for panel in panels]
    looks = looks_of((accuracy for cloud in clouds for accuracy in cloud), "o")
    if not looks:
        raise InputError(NOTHING)
    free = [cloud for panel, cloud in zip(panels, clouds, strict=True) if panel.error_limit is None]
    highest = max((error.max() for cloud in free for _, error in cloud.values()), default=0.0)
    for panel, cloud, unit, ax in zip(panels, clouds, units, axes, strict=True):
        if not cloud:
            say_empty(ax)
            continue
        alike = [i for i, other in enumerate(units) if other == unit and clouds[i]]
        low = min(when.min() for i in alike for when, _ in clouds[i].values())
        count_axis(ax, low, max(_horizon(panels[i]) for i in alike), scale)
        error_axis(ax, max(1.08 * highest, 1e-3) if panel.error_limit is None else panel.error_limit, scale)
        symbol = r"\hat{x}" if panel.local else "x"
        name_axes(ax, f"convergence $K$ ({unit})", rf"error $|{symbol}^K - f\,|$")
        _draw_cloud(ax, cloud, looks)
    caption_panels(axes, [panel.caption for panel in panels], LABELS)
    entries: dict[str, Artist] = {look.name: solid_dot(look, 6, 0.8) for look in looks.values()}
    entries["median, named\nat the top"] = solid_dot(Look("", "", "#bbbbbb", "o"), 6, 0.8)
    entries["one robot, one trial"] = Line2D([], [], linestyle="", marker="o", markersize=2.4, color="0.6")
    if scale != "linear":
        bent = "axes are linear to\n1 and 0.01" if scale == "log" else "errors are linear to\n0.01"
        entries[f"{bent}, then\nlogarithmic"] = Line2D([], [], linestyle="")
    add_key(axes, "sensor accuracy", entries)
    return axes[0].figure.canvas.figure


def _horizon(panel: Panel) -> float:
    rounds = panel.results["rounds"]
    return float((rounds * panel.results["observations_per_round"] if panel.local else rounds).max())


def _draw_cloud(axes: Axes, cloud: Cloud, looks: dict[str, Look]) -> None:
    drawn = [text for text in looks if text in cloud]
    total = sum(when.size for when, _ in cloud.values())
    alpha = float(np.clip(25 / np.sqrt(total), 0.12, 0.6))
    distinct = {text: np.unique(np.stack(cloud[text]).round(9), axis=1, return_counts=True) for text in drawn}
    # In turns, a share of each accuracy's dots at a time, so that none lies on top of all others. Equal dots
    # (fully connected robots agree) are drawn once, as opaque as all of them: their soft edges would add up
    # to squares.
    for turn in range(TURNS):
        for text in drawn:
            (when, error), copies = (values[..., turn::TURNS] for values in distinct[text])
            for count in np.unique(copies):
                axes.plot(
                    when[copies == count], error[copies == count], "o", markersize=2.4, markeredgewidth=0,
                    color=looks[text].colour, alpha=1 - (1 - alpha) ** count, rasterized=True, zorder=2,
                    label=f"dots {text}",
                )  # fmt: skip
    medians = [(float(np.median(cloud[text][0])), float(np.median(cloud[text][1]))) for text in drawn]
    for text, (x, y) in zip(drawn, medians, strict=True):
        dot = solid_dot(looks[text], 6, 0.8)
        dot.set(xdata=[x], ydata=[y], label=f"median {text}", zorder=4, path_effects=halo(2.4))
        axes.add_line(dot)
    label_dots(axes, medians, [looks[text].short for text in drawn])
    above = sum(int((error > axes.get_ylim()[1]).sum()) for _, error in cloud.values())
    if above:
        axes.text(
            0.02, 0.98, f"{above:,} of {total:,} dots\nlie above", va="top", transform=axes.transAxes,
            fontsize=SMALL - 1, color="0.3", path_effects=halo(2), zorder=6,
        )  # fmt: skip


def decisions(results: xr.Dataset, *, title: str | None = None, axes: Axes | None = None) -> Figure:
    """Draw which share of the robots chooses the right bin after so many rounds, or ticks of robots that move.

    The panel of the paper's Fig. 4. A column is a checkpoint, evenly spaced (where there are more than 12, or
    than fit, the axis says how many are shown), and holds a diamond for each sensor accuracy, side by side in
    the key's order, so that none hides another. y is the percentage of right robots over all trials; a
    vertical bar through a diamond says that all robots of all trials are right. In `axes` of your own, leave
    room for the key on their right.

    Raises InputError if `results` lacks a variable or holds no finished trial.
    """
    return _decisions([Panel(title or "", results)], [axes] if axes else new_sheet(1))


def decisions_grid(panels: Sequence[Panel | tuple[Any, ...]], *, title: str | None = None) -> Figure:
    """Draw several `decisions` panels, (a), (b), ..., with one key: the paper's Fig. 4.

    A panel is a `Panel` or a tuple (caption, results). A panel without finished trials says so.

    Raises InputError if there are no panels or more than 24, or if none holds a finished trial.
    """
    return _decisions([Panel(*panel) for panel in panels], new_sheet(len(panels), title))


def _decisions(panels: list[Panel], axes: list[Axes]) -> Figure:
    shares = [shares_of(panel.results) for panel in panels]
    looks = looks_of((accuracy for share in shares for accuracy in share), "d")
    if not looks:
        raise InputError(NOTHING)
    for panel, share, ax in zip(panels, shares, axes, strict=True):
        if share:
            _draw_shares(ax, panel.results["checkpoint"].values, share, looks, unit_of(panel.results))
        else:
            say_empty(ax)
    caption_panels(axes, [panel.caption for panel in panels])
    entries: dict[str, Artist] = {look.name: solid_dot(look, 6, 0.4) for look in looks.values()}
    bar = Line2D([], [], linestyle="", marker="|", markersize=10, color="0.3")
    add_key(axes, "sensor accuracy", entries | {"all robots of all\ntrials are right": bar})
    return axes[0].figure.canvas.figure


def _draw_shares(axes: Axes, checkpoints: NDArray[Any], shares: Shares, looks: dict[str, Look], unit: str) -> None:
    known = np.flatnonzero(np.any([np.isfinite(right) for right, _ in shares.values()], axis=0))
    width = axes.bbox.width * 72 / axes.figure.dpi
    widest = max(2 * len(looks), 0.7 * SMALL * len(f"{checkpoints.max():,}"))  # of markers and of tick labels
    columns = min(known.size, MOST_CHECKPOINTS, max(1, int(width / widest)))
    kept = known[np.linspace(known.size - 1, 0, columns).round().astype(int)[::-1]]
    size = float(np.clip(width / columns / len(looks), 2, 7))  # the thin diamond is 0.85 times as wide
    for i, (text, look) in enumerate(looks.items()):
        if text not in shares:
            continue
        right, all_right = (values[kept] for values in shares[text])
        x = np.arange(columns) + (i - (len(looks) - 1) / 2) * 0.86 / len(looks)
        some = np.isfinite(right)
        axes.plot(
            x[all_right], 100 * right[all_right], "|", markersize=6 + 2 * size, color=look.colour, zorder=3,
            markeredgewidth=np.clip(0.25 * size, 0.6, 1.2), label=f"all right {text}", clip_on=False,
        )  # fmt: skip
        diamonds = solid_dot(look, size, 0.06 * size)
        diamonds.set(xdata=x[some], ydata=100 * right[some], label=f"right {text}", zorder=4, clip_on=False)
        axes.add_line(diamonds)
    for edge in np.arange(1, columns) - 0.5:
        axes.axvline(edge, color="0.88", linewidth=0.6, zorder=0)
    axes.axhline(100, color="0.88", linewidth=0.6, zorder=0)
    axes.set_xlim(-0.5, columns - 0.5)
    axes.set_ylim(0, 108)
    axes.set_xticks(np.arange(columns), [f"{checkpoints[c]:,}" for c in kept])
    axes.tick_params(axis="x", length=0)
    axes.yaxis.set_major_locator(FixedLocator([0, 20, 40, 60, 80, 100]))
    note = f"; {columns} of {known.size} checkpoints" if columns < known.size else ""
    name_axes(axes, f"{unit}{note}", "robots in the right bin (%)")


def curves(trace: xr.Dataset, *, title: str | None = None, scale: Scale = "log") -> Figure:
    """Draw one trial as it unfolds: each robot's estimate against the communication round or tick.

    x is the round or tick (0: before any observation), y the estimated fill ratio; bold is the median over robots,
    dashed the true fill ratio (`trace.attrs["fill_ratio"]`, if known), shaded the right one of 10 (or
    `trace.attrs["bins"]`) bins. Up to 100 robots are thin lines; of more, 30 are, and bands hold the middle
    50 % and 90 %, as the key says. Without a `title` it is `trace.attrs["title"]`. Shows round by round what
    the paper's Sec. III describes.

    Raises InputError if `trace` lacks the estimates or has none.
    """
    require(trace, "estimate", "round", dimensions=("round", "robot"))
    estimate = trace["estimate"].transpose("round", "robot")
    estimate = estimate.dropna("round", how="all").dropna("robot", how="all")
    if not estimate.size:
        raise InputError("nothing to draw: the trace holds no estimate")
    (ax,) = new_sheet(1)
    rounds, x = estimate["round"].values, estimate.values
    robots = x.shape[1]
    shown = np.arange(robots)
    colour = palette(11)[3]
    entries: dict[str, Artist] = {}
    if robots > MOST_LINES:
        shown = np.linspace(0, robots - 1, 30).round().astype(int)
        for percent, shade in ((90, 0.18), (50, 0.32)):
            low, high = np.nanpercentile(x, [50 - percent / 2, 50 + percent / 2], axis=1)
            ax.fill_between(rounds, low, high, color=colour, alpha=shade, linewidth=0, label=f"{percent} %")
            entries[f"middle {percent} %"] = Patch(color=colour, alpha=shade, linewidth=0)
    if robots > 1:
        lines = LineCollection(
            [np.stack([rounds, x[:, i]], 1) for i in shown], linewidths=0.5, colors=colour, rasterized=True,
            alpha=float(np.clip(3 / np.sqrt(shown.size), 0.3, 0.7)), label="robots",
        )  # fmt: skip
        ax.add_collection(lines)
        some = "each of" if shown.size == robots else f"{shown.size} of"
        entries[f"{some} {robots:,} robots"] = Line2D([], [], linewidth=0.7, color=colour)
    (middle,) = ax.plot(rounds, np.nanmedian(x, axis=1), color="black", linewidth=1.6, label="median")
    entries["median robot" if robots > 1 else "the robot"] = middle
    if "fill_ratio" in trace.attrs:
        truth, bins = truth_of(trace), int(trace.attrs.get("bins", 10))
        bottom, top = np.clip(right_bin(truth, bins), 0, 1)
        right = ax.axhspan(bottom, top, fc="0.92", ec="0.5", lw=0.6, ls=":", zorder=0, label="bin")
        dashed = ax.axhline(truth, color="#d55e00", ls=(0, (4, 2)), lw=1.2, zorder=3, label="truth")
        entries |= {"true fill ratio": dashed, f"right bin of {bins}": right}
    count_axis(ax, rounds[0], rounds[-1], scale)
    ax.set_ylim(0, 1)
    note = " (logarithmic above 1)" if scale == "log" else ""
    unit = "tick" if trace["round"].attrs.get("units") == "ticks" else "communication round"
    name_axes(ax, f"{unit}{note}", "estimated fill ratio $x$")
    caption_panels([ax], [str(trace.attrs.get("title", "")) if title is None else title])
    add_key([ax], "", entries)
    return ax.figure.canvas.figure


def heatmap(results: xr.Dataset, *, title: str | None = None) -> Figure:
    """Draw medians over robots and trials for every sensor accuracy (rows) and fill ratio (columns).

    Left the error |x^K - f|, right the convergence in rounds, or ticks of robots that move. Each cell says its
    number; darker is larger, and grey is a cell without a finished trial. It extends the paper's Figs. 2 to 5 to all f.

    Raises InputError if another coordinate varies, or if there is no finished trial.
    """
    require(results, "fill_ratio")
    for name, values in varies(results, apart_from={"accuracy", "fill_ratio"}).items():
        several = ", ".join(str(value) for value in dict.fromkeys(values))
        one = next(value for value in values if value is not None)
        raise InputError(
            f"a heatmap shows accuracy and fill_ratio, but {name} varies too ({several}): "
            f"select one: --where '{name} == {json.dumps(one)}', "
            f"or in Python results.isel(setting=(results.{name} == {one!r}).values)"
        )
    ratios = np.unique(results["fill_ratio"].values)
    clouds = [cloud_of(results.isel(setting=results["fill_ratio"].values == f), local=False) for f in ratios]
    looks = looks_of((accuracy for cloud in clouds for accuracy in cloud), "o")
    if not looks:
        raise InputError(NOTHING)
    medians = np.full((2, len(looks), ratios.size), np.nan)
    for column, cloud in enumerate(clouds):
        for row, accuracy in enumerate(looks):
            if accuracy in cloud:
                when, error = cloud[accuracy]
                medians[:, row, column] = np.median(error), np.median(when)
    size = (max(0.4 * ratios.size, 2.4), max(0.25 * len(looks), 0.75))
    axes = new_sheet(2, title, size=size, left=1.25, right=0.15)
    _draw_cells(axes[0], medians[0], 0.01, ".3f" if np.nanmax(medians[0]) >= 0.1 else ".4f")
    _draw_cells(axes[1], medians[1], 1.0, ",.0f")
    for ax in axes:
        ax.set_xticks(np.arange(ratios.size), [f"{ratio:g}" for ratio in ratios])
        ax.set_yticks(np.arange(len(looks)), [look.name if ax is axes[0] else "" for look in looks.values()])
        name_axes(ax, "fill ratio $f$", "sensor accuracy")
        ax.tick_params(length=0)
        ax.spines[:].set_visible(False)
    caption_panels(axes, [r"median error $|x^K - f\,|$", f"median convergence $K$ ({unit_of(results).split()[-1]})"])
    return axes[0].figure.canvas.figure


def _draw_cells(axes: Axes, values: NDArray[np.float64], linear: float, style: str) -> None:
    colours = mpl.colormaps["viridis_r"].with_extremes(bad="0.9")
    norm = AsinhNorm(linear_width=linear, vmin=np.nanmin(values), vmax=np.nanmax(values))
    image = axes.imshow(values, cmap=colours, norm=norm, aspect="auto", origin="lower")
    red, green, blue, _ = np.moveaxis(image.to_rgba(values), -1, 0)
    bright = 0.2126 * red**2.2 + 0.7152 * green**2.2 + 0.0722 * blue**2.2 > 0.18  # WCAG: black reads better
    for row, column in np.argwhere(np.isfinite(values)):
        text = f"{values[row, column]:{style}}"
        axes.text(
            column, row, text.removeprefix("0") if "." in text else text, ha="center", va="center",
            fontsize=SMALL - 1, color="black" if bright[row, column] else "white",
        )  # fmt: skip
