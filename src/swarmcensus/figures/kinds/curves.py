"""Curves of one trial: every robot's estimate, round by round."""

from __future__ import annotations

from typing import Any, Unpack

import numpy as np
import xarray as xr
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

from swarmcensus.analysis import ALONE, SWARM, expect
from swarmcensus.figures.axes import count_axis
from swarmcensus.figures.captions import captioned, without_theory
from swarmcensus.figures.groups import truth_of, truths_of
from swarmcensus.figures.one_trial import is_trace, trace_of
from swarmcensus.figures.page import PageOptions, ink, on_dark, on_page
from swarmcensus.figures.sheets import Scale, add_key, name_axes, sheet
from swarmcensus.figures.styles import palette
from swarmcensus.figures.theory_lines import STYLES, THIN, sample
from swarmcensus.results import Brains
from swarmcensus.summaries import honest_in, require
from swarmcensus.support.bins import right_bin, right_bins
from swarmcensus.support.errors import InputError

HALVES = {ALONE: "theory: middle half of robots alone", SWARM: "theory: middle half of all readings at once"}
MOST_TIMES = 40  # rounds at which theory is computed
MOST_LINES = 100  # robots that are all drawn as lines; a larger swarm is drawn as bands and FEW_LINES lines
FEW_LINES = 30


@on_page
def curves(
    results: xr.Dataset,
    *,
    setting: int | None = None,
    trial: int = 0,
    brain_file: Brains = (),
    scale: Scale = "log",
    theory: bool = False,
    title: str | None = None,
    **more: Unpack[PageOptions],
) -> Figure:
    """Draw each robot's estimate in one trial against the communication round or tick.

    x is the round or tick, where 0 is before any observation. y is the estimated fill ratio. Thin lines are robots. In
    swarms of more than 100 robots, 30 of them are lines, and bands hold the middle 50 % and 90 % of all. The bold line
    is the median over robots; of opinions, it is the share for black, and robots have no lines. The true fill ratio is
    dashed, and the right bin is shaded, if the trace has them (`trace.attrs["fill_ratio"]`, or `trace["fill_ratio"]` if
    it changes; `trace.attrs["bins"]`, by default 10).

    - `results`: a trace from `sc.replay` or `sc.infer`, or a study's results, of which one trial is then replayed.
    - `setting`, `trial`: the trial to replay; by default the first trial of the first setting.
    - `brain_file`: the files of brains, adversaries and metrics of your own to replay with: one, or several.
    - `scale`: "log" makes x logarithmic above 1; "linear" does not.
    - `theory`: add the range in which theory expects the middle half of all estimates: dotted for robots alone, dashed
      for all readings of the swarm at once. This needs a study's results, not a trace.
    - `title`: the title of the figure; by default `trace.attrs["title"]`.
    - `width`, `height`, `font_size`, `labels`: the page, and names of brains (see `PageOptions`).

    Raises InputError if the trace has no estimates, and as `sc.replay` does.
    """
    trace = results if is_trace(results) else trace_of(results, setting, trial, brain_file)
    require(trace, "estimate", "round", dimensions=("round", "robot"))
    honest, estimate = honest_in(trace), trace["estimate"].transpose("round", "robot")
    of_liars, estimate = estimate.isel(robot=~honest), estimate.isel(robot=honest)
    estimate = estimate.dropna("round", how="all").dropna("robot", how="all")
    if not estimate.size:
        raise InputError("nothing to draw: the trace holds no estimate")
    rounds, x = estimate["round"].values, estimate.values
    caption = str(trace.attrs.get("title", "")) if title is None else title
    times = np.unique(np.geomspace(1, max(rounds[-1], 1), MOST_TIMES).astype(int)).tolist()
    expected = None
    if theory:
        if results is trace:
            why = "theory needs a study's results, not a trace: draw curves of results, with setting and trial"
            raise InputError(why, key="theory")
        expected = expect(results, int(trace.attrs["setting"]), times, (ALONE, SWARM))
    missing = "" if expected is None or expected.lines else next(iter(expected.absent.values()))
    (place,) = axes = sheet([caption], None)
    robots, opinions = x.shape[1], bool(trace.attrs.get("opinions", False))
    shown = np.arange(robots)
    colour = palette(11)[3]
    entries: dict[str, Artist] = {}
    if robots > MOST_LINES and not opinions:
        shown = np.linspace(0, robots - 1, FEW_LINES).round().astype(int)
        for percent, shade in ((90, 0.18), (50, 0.32)):
            low, high = np.nanpercentile(x, [50 - percent / 2, 50 + percent / 2], axis=1)
            place.fill_between(rounds, low, high, color=colour, alpha=shade, linewidth=0, label=f"{percent} %")
            entries[f"middle {percent} %"] = Patch(color=colour, alpha=shade, linewidth=0)
    if robots > 1 and not opinions:
        lines = LineCollection(
            [np.stack([rounds, x[:, i]], 1) for i in shown], linewidths=0.5, colors=colour, rasterized=True,
            alpha=float(np.clip(3 / np.sqrt(shown.size), 0.3, 0.7)), label="robots",
        )  # fmt: skip
        place.add_collection(lines)
        how_many = "each of" if shown.size == robots else f"{shown.size} of"
        kind = "robots" if honest.all() else "honest robots"
        entries[f"{how_many} {robots:,} {kind}"] = Line2D([], [], linewidth=0.7, color=colour)
    if not honest.all() and not opinions:
        crossed: dict[str, Any] = {"color": "0.4", "linestyle": ":", "linewidth": 0.8, "marker": "x", "markersize": 4}
        place.plot(
            of_liars["round"].values, of_liars[:, :MOST_LINES].values, markevery=0.15, label="not honest", **crossed
        )
        entries[f"{of_liars.shape[1]:,} that are not honest"] = Line2D([], [], **crossed)
    for which, line in expected.lines.items() if expected else ():
        entries[HALVES[which]] = sample(which)
        for ends in (line.low, line.high):
            place.plot(times, ends, color=ink(), linewidth=THIN, linestyle=STYLES[which], label=f"theory {which}")
    bold = np.nanmean(x, axis=1) if opinions else np.nanmedian(x, axis=1)
    (middle,) = place.plot(rounds, bold, color=ink(), linewidth=1.6, label="mean" if opinions else "median")
    who = "robot" if honest.all() else "honest robot"
    name = f"all {robots:,} {who}s" if opinions else f"median {who}"
    entries[name if robots > 1 else "the robot"] = middle
    if "fill_ratio" in trace.attrs:
        bins = int(trace.attrs.get("bins", 10))
        right, dashed = _draw_truth(place, trace, bins)
        entries |= {"true fill ratio": dashed, f"right bin of {bins}": right}
    count_axis(place, rounds[0], rounds[-1], scale)
    place.set_ylim(0, 1)
    note = " (logarithmic above 1)" if scale == "log" else ""
    unit = "tick" if trace["round"].attrs.get("units") == "ticks" else "communication round"
    name_axes(place, f"{unit}{note}", "share of opinions for black" if opinions else "estimated fill ratio $x$")
    add_key([place], "", entries)
    return captioned(axes, curves, remarks=[*trace.attrs.get("gaps", ()), without_theory("", missing)])


def _draw_truth(ax: Axes, trace: xr.Dataset, bins: int) -> tuple[Artist, Artist]:
    """Draw the right bin, shaded, and the true fill ratio, dashed, by round if it changes. Returns both artists."""
    truths = truths_of(trace)
    shade: dict[str, Any] = {"fc": "0.25" if on_dark() else "0.92", "ec": "0.5", "lw": 0.6, "ls": ":", "zorder": 0}
    shade |= {"label": "bin"}
    dash: dict[str, Any] = {"color": ink(), "ls": (0, (6, 3)), "lw": 1.2, "zorder": 3, "label": "truth"}
    if truths is None:
        truth = truth_of(trace)
        bottom, top = np.clip(right_bin(truth, bins), 0, 1)
        return ax.axhspan(bottom, top, **shade), ax.axhline(truth, **dash)
    rounds, ends = trace["round"].values, np.clip(right_bins(truths, bins), 0, 1)
    (dashed,) = ax.plot(rounds, truths, drawstyle="steps-pre", **dash)  # the floor changes at the beginning of a round
    return ax.fill_between(rounds, ends[:, 0], ends[:, 1], step="pre", **shade), dashed
