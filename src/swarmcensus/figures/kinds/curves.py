"""One trial as it unfolds: every robot's estimate, round by round."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

from swarmcensus.basics.bins import right_bin, right_bins
from swarmcensus.basics.errors import InputError
from swarmcensus.explaining.expectations import ALONE, SWARM, Expectation, expect
from swarmcensus.figures.clouds import truth_of, truths_of
from swarmcensus.figures.looks import LIES, palette
from swarmcensus.figures.scenes import is_trace, trace_of
from swarmcensus.figures.sheets import Drawn, Own, Scale, add_key, count_axis, drawn_on, name_axes, sheet, show_range
from swarmcensus.figures.theory_lines import STYLES, THIN, sample, untold
from swarmcensus.results.replaying import honest_in
from swarmcensus.results.selecting import require

HALVES = {ALONE: "theory: middle half of robots alone", SWARM: "theory: middle half at the bound of the whole swarm"}
MOST_TIMES = 40  # at which theory is asked
MOST_LINES = 100  # robots that are drawn one by one; a larger swarm is drawn as bands


def curves(
    results: xr.Dataset,
    *,
    setting: int | None = None,
    trial: int = 0,
    brain: str | Path | None = None,
    scale: Scale = "log",
    theory: bool = False,
    title: str | None = None,
    ax: Own = None,
) -> Drawn:
    """Draw one trial as it unfolds: each robot's estimate against the communication round or tick.

    `results` is a trace of `sc.replay` or `sc.infer`, or a study's results: then `setting` (by default the first) and
    `trial` are replayed, with the file `brain` where the brain is one of your own.

    x is the round or tick (0: before any observation), y the estimated fill ratio; bold is the median over robots,
    dashed the true fill ratio (`trace.attrs["fill_ratio"]`, if known, or `trace["fill_ratio"]` where it changes),
    shaded the right one of 10 (or `trace.attrs["bins"]`) bins. Up to 100 robots are thin lines; of more, 30 are, and
    bands hold the middle 50 % and 90 %, as the key says. With `theory`, half of all robots alone are expected between
    two dotted lines, and half of all estimates that are as good as the bound of the whole swarm between two dashed
    ones; that needs a study's results, not a trace. Without a `title` it is `trace.attrs["title"]`. Shows round by
    round what the paper's Sec. III describes. In axes of your own, `ax`, leave room for the key on their right.

    Raises InputError if a trace lacks the estimates or has none, and as `sc.replay` does.
    """
    trace = results if is_trace(results) else trace_of(results, setting, trial, brain)
    require(trace, "estimate", "round", dimensions=("round", "robot"))
    honest = honest_in(trace)
    others = trace["estimate"].transpose("round", "robot").isel(robot=~honest)
    estimate = trace["estimate"].transpose("round", "robot").isel(robot=honest)
    estimate = estimate.dropna("round", how="all").dropna("robot", how="all")
    if not estimate.size:
        raise InputError("nothing to draw: the trace holds no estimate")
    rounds, x = estimate["round"].values, estimate.values
    caption = str(trace.attrs.get("title", "")) if title is None else title
    expected = _expected(results, trace, rounds[-1]) if theory else None
    if expected is not None and not expected.lines:
        caption = untold(caption, next(iter(expected.absent.values())))
    (place,) = axes = sheet(ax, [caption], None)
    robots = x.shape[1]
    shown = np.arange(robots)
    colour = palette(11)[3]
    entries: dict[str, Artist] = {}
    if robots > MOST_LINES:
        shown = np.linspace(0, robots - 1, 30).round().astype(int)
        for percent, shade in ((90, 0.18), (50, 0.32)):
            low, high = np.nanpercentile(x, [50 - percent / 2, 50 + percent / 2], axis=1)
            place.fill_between(rounds, low, high, color=colour, alpha=shade, linewidth=0, label=f"{percent} %")
            entries[f"middle {percent} %"] = Patch(color=colour, alpha=shade, linewidth=0)
    if robots > 1:
        lines = LineCollection(
            [np.stack([rounds, x[:, i]], 1) for i in shown], linewidths=0.5, colors=colour, rasterized=True,
            alpha=float(np.clip(3 / np.sqrt(shown.size), 0.3, 0.7)), label="robots",
        )  # fmt: skip
        place.add_collection(lines)
        some = "each of" if shown.size == robots else f"{shown.size} of"
        whom = "robots" if honest.all() else "honest robots"
        entries[f"{some} {robots:,} {whom}"] = Line2D([], [], linewidth=0.7, color=colour)
    if not honest.all():
        drawn = others[:, :MOST_LINES].values.T
        liars = [np.stack([others["round"].values, line], 1) for line in drawn]
        place.add_collection(LineCollection(liars, linewidths=0.8, colors=LIES, linestyles=":", label="not honest"))
        entries[f"{others.shape[1]:,} that are not honest"] = Line2D([], [], linewidth=0.9, color=LIES, linestyle=":")
    if expected is not None:
        entries |= _draw_theory(place, expected)
    (middle,) = place.plot(rounds, np.nanmedian(x, axis=1), color="black", linewidth=1.6, label="median")
    whose = ("median robot" if honest.all() else "median honest robot") if robots > 1 else "the robot"
    entries[whose] = middle
    if "fill_ratio" in trace.attrs:
        bins = int(trace.attrs.get("bins", 10))
        right, dashed = _draw_truth(place, trace, bins)
        entries |= {"true fill ratio": dashed, f"right bin of {bins}": right}
    count_axis(place, rounds[0], rounds[-1], scale)
    show_range(place, "y", 0, 1)
    note = " (logarithmic above 1)" if scale == "log" else ""
    unit = "tick" if trace["round"].attrs.get("units") == "ticks" else "communication round"
    name_axes(place, f"{unit}{note}", "estimated fill ratio $x$")
    add_key([place], "", entries)
    return drawn_on(axes, ax)


def _expected(results: xr.Dataset, trace: xr.Dataset, last: int) -> Expectation:
    """What theory says of the trace's setting, up to a round."""
    if results is trace:
        raise InputError("theory needs a study's results, not a trace: draw curves of results, with setting and trial")
    times = np.unique(np.geomspace(1, max(last, 1), MOST_TIMES).astype(int)).tolist()
    return expect(results, int(trace.attrs["setting"]), times, (ALONE, SWARM))


def _draw_theory(ax: Axes, found: Expectation) -> dict[str, Artist]:
    """Theory's middle halves, and what the key says of them."""
    for name, line in found.lines.items():
        for ends in (line.low, line.high):
            ax.plot(found.times, ends, color="black", linewidth=THIN, linestyle=STYLES[name], label=f"theory {name}")
    return {HALVES[name]: sample(name) for name in found.lines}


def _draw_truth(ax: Axes, trace: xr.Dataset, bins: int) -> tuple[Artist, Artist]:
    """The right bin, shaded, and the true fill ratio, dashed; where that changes, both as they change."""
    truths = truths_of(trace)
    shade: dict[str, Any] = {"fc": "0.92", "ec": "0.5", "lw": 0.6, "ls": ":", "zorder": 0, "label": "bin"}
    dash: dict[str, Any] = {"color": "#d55e00", "ls": (0, (4, 2)), "lw": 1.2, "zorder": 3, "label": "truth"}
    if truths is None:
        truth = truth_of(trace)
        bottom, top = np.clip(right_bin(truth, bins), 0, 1)
        return ax.axhspan(bottom, top, **shade), ax.axhline(truth, **dash)
    rounds, ends = trace["round"].values, np.clip(right_bins(truths, bins), 0, 1)
    (dashed,) = ax.plot(rounds, truths, drawstyle="steps-pre", **dash)  # a round's floor is there from its begin
    return ax.fill_between(rounds, ends[:, 0], ends[:, 1], step="pre", **shade), dashed
