"""The figures: one function per kind, from a study's results or a trace to a matplotlib Figure.

All use matplotlib's object-oriented interface only (no pyplot): no display, no global state, any thread.
`save` writes what they return.
"""

from __future__ import annotations

import os
import threading
import uuid
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any, NamedTuple

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

from swarmcensus import panels as sheets
from swarmcensus.errors import InputError
from swarmcensus.panels import Panel, panels_of, require

__all__ = ["Panel", "curves", "decisions", "decisions_grid", "heatmap", "panels_of", "save", "scatter", "scatter_grid"]

NOTHING = "nothing to draw: no trial of these settings has been run"
LABELS = 0.25  # inches over a scatter panel for the names of its medians
TURNS = 6
MOST_CHECKPOINTS = 12
MOST_LINES = 100  # robots that `curves` draws one by one; a larger swarm is drawn as bands

Cloud = dict[str, tuple[NDArray[np.float64], NDArray[np.float64]]]  # accuracy -> convergence, error
Shares = dict[str, tuple[NDArray[np.float64], NDArray[np.bool_]]]  # accuracy -> right, whether all are

# matplotlib's settings belong to the whole process: threads that save at the same time take turns.
_settings = threading.Lock()


def scatter(
    results: xr.Dataset,
    *,
    local: bool = False,
    title: str | None = None,
    axes: Axes | None = None,
    error_limit: float | None = None,
    scale: sheets.Scale = "log",
) -> Figure:
    """Draw how fast and how well robots estimate: one dot a robot and trial, and the medians.

    The panel of the paper's Figs. 2, 3 and 5. x is the convergence K in communication rounds (`local`: of
    the local estimate, in observations), y the error |x^K - f|; solid, outlined, labelled dots are the
    medians of the sensor accuracies, whose colours `panels.looks` explains. All settings of `results`
    share the panel. Both axes begin at 0; with `scale` "log" they are logarithmic above 1 and 0.01, "linear"
    is the paper's. Dots above `error_limit` are counted instead of drawn. In `axes` of your own, leave room
    for the key on their right.

    Raises InputError if `results` lacks a variable or holds no finished trial.
    """
    panel = Panel(title or "", results, local, error_limit)
    return _scatter([panel], [axes] if axes else sheets.sheet(1, above=LABELS)[1], scale)


def scatter_grid(
    panels: Sequence[Panel | tuple[Any, ...]], *, title: str | None = None, scale: sheets.Scale = "log"
) -> Figure:
    """Draw several `scatter` panels, (a), (b), ..., with one key: the paper's Figs. 2, 3 and 5.

    A panel is a `Panel` or a tuple (caption, results[, local[, error_limit]]). So that panels compare, those
    of one unit have the same x axis, and those without an `error_limit` of their own the same y axis. A panel
    without finished trials says so.

    Raises InputError if there are no panels or more than 24, or if none holds a finished trial.
    """
    axes = sheets.sheet(len(panels), title, above=LABELS)[1]
    return _scatter([Panel(*panel) for panel in panels], axes, scale)


def _scatter(panels: list[Panel], axes: list[Axes], scale: sheets.Scale) -> Figure:
    clouds = [_cloud(panel.results, panel.local) for panel in panels]
    looks = sheets.looks((accuracy for cloud in clouds for accuracy in cloud), "o")
    if not looks:
        raise InputError(NOTHING)
    free = [cloud for panel, cloud in zip(panels, clouds, strict=True) if panel.error_limit is None]
    highest = max((error.max() for cloud in free for _, error in cloud.values()), default=0.0)
    for panel, cloud, ax in zip(panels, clouds, axes, strict=True):
        if not cloud:
            sheets.say_empty(ax)
            continue
        alike = [i for i, other in enumerate(panels) if other.local == panel.local and clouds[i]]
        low = min(when.min() for i in alike for when, _ in clouds[i].values())
        sheets.count_axis(ax, low, max(_horizon(panels[i]) for i in alike), scale)
        sheets.error_axis(ax, panel.error_limit or max(1.08 * highest, 1e-3), scale)
        unit, symbol = ("observations", r"\hat{x}") if panel.local else ("communication rounds", "x")
        sheets.name_axes(ax, f"convergence $K$ ({unit})", rf"error $|{symbol}^K - f\,|$")
        _draw_cloud(ax, cloud, looks)
    sheets.caption_panels(axes, [panel.caption for panel in panels], LABELS)
    entries: dict[str, Artist] = {look.name: sheets.dot(look, 6) for look in looks.values()}
    entries["median, named\nat the top"] = sheets.dot(sheets.Look("", "", "#bbbbbb", "o"), 6)
    entries["one robot, one trial"] = Line2D([], [], linestyle="", marker="o", markersize=2.4, color="0.6")
    if scale == "log":
        entries["axes are linear to\n1 and 0.01, then\nlogarithmic"] = Line2D([], [], linestyle="")
    sheets.key(axes, "sensor accuracy", entries)
    return axes[0].figure.canvas.figure


def _cloud(results: xr.Dataset, local: bool) -> Cloud:
    """Convergence and error of all robots in all finished trials, by accuracy."""
    names = ("convergence_round", "convergence_error")
    if local:
        names = ("local_convergence_step", "local_convergence_error")
    require(results, *names, "accuracy", "rounds", "observations_per_round")
    when, error = (results[name].transpose("setting", ...).values for name in names)
    done = (when >= 0) & np.isfinite(error)
    return {
        accuracy: (when[mine][done[mine]].astype(float), error[mine][done[mine]])
        for accuracy, mine in _settings_by_accuracy(results)
        if done[mine].any()
    }


def _settings_by_accuracy(results: xr.Dataset) -> list[tuple[str, NDArray[np.bool_]]]:
    accuracy = results["accuracy"].values.astype(str)
    return [(text, accuracy == text) for text in dict.fromkeys(accuracy.tolist())]


def _horizon(panel: Panel) -> float:
    rounds = panel.results["rounds"]
    return float((rounds * panel.results["observations_per_round"] if panel.local else rounds).max())


def _draw_cloud(axes: Axes, cloud: Cloud, looks: dict[str, sheets.Look]) -> None:
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
        dot = sheets.dot(looks[text], 6)
        dot.set(xdata=[x], ydata=[y], label=f"median {text}", zorder=4, path_effects=sheets.halo(2.4))
        axes.add_line(dot)
    sheets.label_dots(axes, medians, [looks[text].short for text in drawn])
    above = sum(int((error > axes.get_ylim()[1]).sum()) for _, error in cloud.values())
    if above:
        axes.text(
            0.02, 0.98, f"{above:,} of {total:,} dots\nlie above", va="top", transform=axes.transAxes,
            fontsize=sheets.SMALL - 1, color="0.3", path_effects=sheets.halo(2),
        )  # fmt: skip


def decisions(results: xr.Dataset, *, title: str | None = None, axes: Axes | None = None) -> Figure:
    """Draw which share of the robots chooses the right bin after so many communication rounds.

    The panel of the paper's Fig. 4. A column is a checkpoint (evenly spaced; of more than 12 a choice, which
    the axis says) and holds a diamond for each sensor accuracy, side by side in the key's order, so that none
    hides another; y is the percentage of right robots over all trials. A vertical bar through a diamond says
    that all robots of all trials are right. In `axes` of your own, leave room for the key on their right.

    Raises InputError if `results` lacks a variable or holds no finished trial.
    """
    return _decisions([Panel(title or "", results)], [axes] if axes else sheets.sheet(1)[1])


def decisions_grid(panels: Sequence[Panel | tuple[Any, ...]], *, title: str | None = None) -> Figure:
    """Draw several `decisions` panels, (a), (b), ..., with one key: the paper's Fig. 4.

    A panel is a `Panel` or a tuple (caption, results). A panel without finished trials says so.

    Raises InputError if there are no panels or more than 24, or if none holds a finished trial.
    """
    axes = sheets.sheet(len(panels), title)[1]
    return _decisions([Panel(*panel) for panel in panels], axes)


def _decisions(panels: list[Panel], axes: list[Axes]) -> Figure:
    shares = [_shares(panel.results) for panel in panels]
    looks = sheets.looks((accuracy for share in shares for accuracy in share), "d")
    if not looks:
        raise InputError(NOTHING)
    for panel, share, ax in zip(panels, shares, axes, strict=True):
        if share:
            _draw_shares(ax, panel.results["checkpoint"].values, share, looks)
        else:
            sheets.say_empty(ax)
    sheets.caption_panels(axes, [panel.caption for panel in panels])
    entries: dict[str, Artist] = {look.name: sheets.dot(look, 6, 0.4) for look in looks.values()}
    entries["all robots of all\ntrials are right"] = Line2D([], [], linestyle="", marker="|", color="0.3", ms=10)
    sheets.key(axes, "sensor accuracy", entries)
    return axes[0].figure.canvas.figure


def _shares(results: xr.Dataset) -> Shares:
    """The fraction of right robots at each checkpoint (NaN: never run), and whether it is all of them."""
    require(results, "correct", "checkpoint", "accuracy", "robots")
    correct = results["correct"].transpose("setting", "trial", "checkpoint").values
    known = np.isfinite(correct)
    robots = known * results["robots"].values[:, None, None]
    right = np.nan_to_num(correct) * robots
    shares = {}
    for accuracy, mine in _settings_by_accuracy(results):
        asked = robots[mine].sum((0, 1))
        if asked.any():
            share = np.full(asked.shape, np.nan)
            np.divide(right[mine].sum((0, 1)), asked, out=share, where=asked > 0)
            shares[accuracy] = (share, ((correct[mine] == 1) | ~known[mine]).all((0, 1)))
    return shares


def _draw_shares(axes: Axes, checkpoints: NDArray[Any], shares: Shares, looks: dict[str, sheets.Look]) -> None:
    known = np.flatnonzero(np.any([np.isfinite(right) for right, _ in shares.values()], axis=0))
    kept = known[np.unique(np.linspace(0, known.size - 1, min(known.size, MOST_CHECKPOINTS)).astype(int))]
    column = np.arange(kept.size)
    step = 0.86 / len(looks)
    room = axes.bbox.width * 72 / axes.figure.dpi / kept.size * step
    size = float(np.clip(room / 0.9, 2.5, 7))
    for i, (text, look) in enumerate(looks.items()):
        if text not in shares:
            continue
        right, all_right = (values[kept] for values in shares[text])
        x = column + (i - (len(looks) - 1) / 2) * step
        some = np.isfinite(right)
        full = some & all_right
        axes.plot(
            x[full], 100 * right[full], "|", markersize=6 + 2 * size, markeredgewidth=1, zorder=3,
            color=look.colour, label=f"all right {text}", clip_on=False,
        )  # fmt: skip
        diamonds = sheets.dot(look, size, 0.06 * size)
        diamonds.set(xdata=x[some], ydata=100 * right[some], label=f"right {text}", zorder=4, clip_on=False)
        axes.add_line(diamonds)
    for edge in column[1:] - 0.5:
        axes.axvline(edge, color="0.88", linewidth=0.6, zorder=0)
    axes.axhline(100, color="0.88", linewidth=0.6, zorder=0)
    axes.set_xlim(-0.5, kept.size - 0.5)
    axes.set_ylim(0, 108)
    axes.set_xticks(column, [f"{checkpoints[c]:,}" for c in kept])
    axes.tick_params(axis="x", length=0)
    axes.yaxis.set_major_locator(FixedLocator([0, 20, 40, 60, 80, 100]))
    note = f"; {kept.size} of {known.size} checkpoints" if kept.size < known.size else ""
    sheets.name_axes(axes, f"communication rounds{note}", "robots in the right bin (%)")


def curves(trace: xr.Dataset, *, title: str | None = None, scale: sheets.Scale = "log") -> Figure:
    """Draw one trial as it unfolds: each robot's estimate against the communication round.

    x is the round (0: before any observation), y the estimated fill ratio; bold is the median over robots,
    dashed the true fill ratio (`trace.attrs["fill_ratio"]`, where known), shaded the right one of 10 bins. Up
    to 100 robots are thin lines; of more, 30 are, and bands hold the middle 50 % and 90 %, which the key says.

    Raises InputError if `trace` lacks the estimates or has none. Source: replay of the paper's trials.
    """
    require(trace, "estimate", "round", dimension="round")
    estimate = trace["estimate"].transpose("round", "robot").dropna("round", how="all").dropna("robot", how="all")
    if not estimate.size:
        raise InputError("nothing to draw: the trace holds no estimate")
    figure, (ax,) = sheets.sheet(1)
    rounds = estimate["round"].values
    x = estimate.values
    robots = x.shape[1]
    entries: dict[str, Artist] = {}
    colour = sheets.palette(11)[3]
    shown = np.arange(robots)
    if robots > MOST_LINES:
        shown = np.linspace(0, robots - 1, 30).round().astype(int)
        for percent, low, high, shade in ((90, 0.05, 0.95, 0.18), (50, 0.25, 0.75, 0.32)):
            edges = np.nanquantile(x, [low, high], axis=1)
            ax.fill_between(rounds, *edges, color=colour, alpha=shade, linewidth=0, label=f"{percent} %")
            entries[f"middle {percent} %"] = Patch(color=colour, alpha=shade, linewidth=0)
    if robots > 1:
        alpha = float(np.clip(3 / np.sqrt(shown.size), 0.3, 0.7))
        lines = [np.stack([rounds, x[:, i]], 1) for i in shown]
        ax.add_collection(
            LineCollection(lines, linewidths=0.5, colors=colour, alpha=alpha, rasterized=True, label="robots")
        )
        name = f"{shown.size} of {robots:,} robots" if shown.size < robots else f"each of {robots} robots"
        entries[name] = Line2D([], [], linewidth=0.7, color=colour)
    middle = ax.plot(rounds, np.nanmedian(x, axis=1), color="black", linewidth=1.6, label="median")
    entries["median robot" if robots > 1 else "the robot"] = middle[0]
    truth = trace.attrs.get("fill_ratio")
    if truth is not None:
        low = min(np.floor(round(10 * float(truth), 9)), 9) / 10
        ax.axhspan(low, low + 0.1, color="0.9", linewidth=0, zorder=0, label="bin")
        entries["true fill ratio"] = ax.axhline(
            float(truth), color="#d55e00", linestyle=(0, (4, 2)), linewidth=1.2, label="truth", zorder=3
        )
        entries["right bin of 10"] = Patch(color="0.9", linewidth=0)
    sheets.count_axis(ax, rounds[0], rounds[-1], scale)
    ax.set_ylim(0, 1)
    sheets.name_axes(ax, "communication round", "estimated fill ratio $x$")
    sheets.caption_panels([ax], [title if title is not None else str(trace.attrs.get("title", ""))])
    sheets.key([ax], "", entries)
    return figure


def heatmap(results: xr.Dataset, *, title: str | None = None) -> Figure:
    """Draw medians over robots and trials for every sensor accuracy (rows) and fill ratio (columns).

    Left the error |x^K - f|, right the convergence in communication rounds. Each cell says its number; darker
    is larger, and grey is a cell without a finished trial. It extends the paper's Figs. 2 to 5 to all f.

    Raises InputError if another coordinate varies, or if there is no finished trial.
    """
    require(results, "fill_ratio")
    for name, values in sheets.varies(results, {"accuracy", "fill_ratio"}).items():
        several = ", ".join(str(value) for value in dict.fromkeys(values))
        one = next(value for value in values if value is not None)
        raise InputError(
            f"a heatmap shows accuracy and fill_ratio, but {name} varies too ({several}): "
            f"select one, e.g. results.isel(setting=(results.{name} == {one!r}).values)"
        )
    ratios = np.unique(results["fill_ratio"].values)
    clouds = [_cloud(results.isel(setting=results["fill_ratio"].values == ratio), False) for ratio in ratios]
    looks = sheets.looks((accuracy for cloud in clouds for accuracy in cloud), "o")
    if not looks:
        raise InputError(NOTHING)
    medians = np.full((2, len(looks), ratios.size), np.nan)
    for column, cloud in enumerate(clouds):
        for row, accuracy in enumerate(looks):
            if accuracy in cloud:
                when, error = cloud[accuracy]
                medians[:, row, column] = np.median(error), np.median(when)
    size = (max(0.4 * ratios.size, 2.4), max(0.25 * len(looks), 0.75))
    figure, axes = sheets.sheet(2, title, size=size, left=1.25, right=0.15)
    decimals = 3 if np.nanmax(medians[0]) >= 0.1 else 4
    _draw_cells(axes[0], medians[0], 0.01, [f"{value:.{decimals}f}" for value in medians[0].flat])
    _draw_cells(axes[1], medians[1], 1.0, [f"{value:,.0f}" for value in medians[1].flat])
    for ax in axes:
        ax.set_xticks(np.arange(ratios.size), [f"{ratio:g}" for ratio in ratios])
        ax.set_yticks(np.arange(len(looks)), [look.name for look in looks.values()] if ax is axes[0] else [])
        sheets.name_axes(ax, "fill ratio $f$", "sensor accuracy")
        ax.tick_params(length=0)
        ax.spines[:].set_visible(False)
    sheets.caption_panels(axes, ["median error $|x^K - f\\,|$", "median convergence $K$ (communication rounds)"])
    return figure


def _draw_cells(axes: Axes, values: NDArray[np.float64], linear: float, texts: list[str]) -> None:
    colours = mpl.colormaps["viridis_r"].with_extremes(bad="0.9")
    norm = AsinhNorm(linear_width=linear, vmin=np.nanmin(values), vmax=np.nanmax(values))
    image = axes.imshow(values, cmap=colours, norm=norm, aspect="auto", origin="lower")
    red, green, blue, _ = np.moveaxis(image.to_rgba(values), -1, 0)
    bright = (0.2126 * red**2.2 + 0.7152 * green**2.2 + 0.0722 * blue**2.2 > 0.18).ravel()
    for i, text in enumerate(texts):
        row, column = divmod(i, values.shape[1])
        if np.isfinite(values[row, column]):
            axes.text(
                column, row, text.removeprefix("0") if "." in text else text, ha="center", va="center",
                fontsize=sheets.SMALL - 1, color="black" if bright[i] else "white",
            )  # fmt: skip


def save(figure: Figure, stem: Path, formats: Sequence[str] = ("png", "svg")) -> list[Path]:
    """Write a figure to `stem`.png, `stem`.svg, ... and return these paths.

    Each file appears whole or not at all, in place of an older one. PNGs have 150 dots an inch, and so have
    the layers of single dots inside an SVG or PDF; all else there is lines and text. The same figure gives
    the same bytes.

    Raises InputError for a format that matplotlib cannot write, OSError where the disk says no.
    """
    known = figure.canvas.get_supported_filetypes()
    for suffix in formats:
        if suffix not in known:
            raise InputError(f"cannot write {suffix!r} files; figures can be {', '.join(sorted(known))}")
    paths = []
    for suffix in formats:
        path = stem.with_name(f"{stem.name}.{suffix}")
        path.parent.mkdir(parents=True, exist_ok=True)
        unfinished = path.with_name(f".{path.name}.{uuid.uuid4().hex}")
        dateless = {"svg": {"Date": None}, "pdf": {"CreationDate": None}}.get(suffix, {})
        try:
            with _settings, mpl.rc_context({"svg.hashsalt": "swarmcensus"}):
                figure.savefig(unfinished, format=suffix, dpi=150, metadata=dateless)
            os.replace(unfinished, path)
        finally:
            unfinished.unlink(missing_ok=True)
        paths.append(path)
    return paths
