"""Scatter plot of convergence and error: one dot per robot and trial."""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from typing import Any, Unpack

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patheffects import withStroke

from swarmcensus.figures.axes import count_axis, error_axis, measured_axis, name_of, number_axis
from swarmcensus.figures.captions import captioned, misleading, nothing_of, pooled_over, unlearnt, with_numbers
from swarmcensus.figures.coordinates import Names, Panel, check_coordinates, coordinates_of, panels_of, rows_of
from swarmcensus.figures.groups import Cloud, Cross, Dot, cloud_of, crosses_of, groups_of, unit_of
from swarmcensus.figures.kinds.lines import measured, numeric_names
from swarmcensus.figures.page import PageOptions, drawing, letters, on_page, width_of
from swarmcensus.figures.sheets import NOTHING, POOLED, UNRUN, Scale, add_key, name_axes, sheet
from swarmcensus.figures.styles import Look, add_dots, halo, key_mark, key_of, looks_of, median_dot, outlined_dot
from swarmcensus.figures.theory_lines import THIN, Curves, curves_of, entries as theory_entries, lines_to_draw
from swarmcensus.studies import title_of
from swarmcensus.summaries import SETTLING_TIMES, measures, selecting, titles_in
from swarmcensus.support.errors import InputError
from swarmcensus.support.options import wrong_option
from swarmcensus.support.quantities import SEARCHED

NAMES = 1.5  # points by which their letters are smaller than those of ticks
CLAIM: dict[str, Any] = {"color": "#d55e00", "linewidth": 1.0, "linestyle": (0, (6, 2)), "zorder": 3.1}
TURNS = 6  # turns in which the dots of all colours are drawn
EARLY = 0.05  # share of the dots that may lie further left: x is linear if the others span less than half a decade


@on_page
def scatter(
    results: xr.Dataset,
    *,
    x: str | None = None,
    y: str | None = None,
    color: str | None = None,
    rows: Names = None,
    cols: Names = None,
    local: bool = False,
    error_limit: float | None = None,
    scale: Scale = "log",
    theory: bool = False,
    title: str | None = None,
    **more: Unpack[PageOptions],
) -> Figure:
    """Draw how fast and how well robots estimate: one dot per robot and trial, and the medians.

    x is the convergence K in communication rounds, or in ticks if robots move. y is the error |x^K - f|. Outlined dots
    are the medians for each value of `color`; if these are numbers, and far enough from each other, they are named.
    Medians are rings where accuracies differ between robots.
    A thin cross through a median is its 95 % interval over trials on both axes. It needs at least 6 trials and swarms
    of one size. The paper's Figs. 2, 3 and 5 are such plots.

    - `x`: a coordinate with numbers, such as a brain's parameter: then each dot is a trial, and its height its
      number of `y`. Of the log of a search, dots are candidates, and it is by default the first parameter.
    - `y`: with `x`, a variable or measure as in `lines`; by default the final error, or what a search was by.
    - `color`: the coordinate shown by colour; by default the accuracy, or the generation of a search.
    - `rows`, `cols`: coordinates; each combination of their values has a panel. By default all others that vary.
      Panels with the same unit share their axes.
    - `local`: draw local instead of informed estimates, with K in observations.
    - `error_limit`: the highest error drawn. Dots above it are counted instead.
    - `scale`: "log" makes both axes logarithmic, x above 1 and y above 0.01; x begins where the data begin, and is
      linear if all but the earliest 5 % of the dots span less than half a decade. "log-y" makes only y logarithmic.
      "linear" makes neither logarithmic, as in the paper. With "log-y" and "linear", x begins at 0.
    - `theory`: add the median error expected after the last round: dotted for robots alone, dashed for all readings
      of the swarm at once (not with `local`).
    - `title`: the title of the figure.
    - `width`, `height`, `font_size`, `labels`: the page, and names of brains (see `PageOptions`).

    Raises InputError for an unknown coordinate, for results that lack a variable or a finished trial, and for more than
    120 panels.
    """
    if x is not None or SEARCHED in results.attrs:
        if local or theory or error_limit is not None:
            raise InputError("scatter: local, theory and error_limit go with convergence on the x axis", key="x")
        return _against(results, x, y, color, rows, cols, title)
    color = color or "accuracy"
    check_coordinates(results, color=color, rows=rows, cols=cols)
    if y is not None:
        raise wrong_option("y", y, "goes with x, the coordinate on the other axis")
    if error_limit is not None and not 0.0 < error_limit < np.inf:
        raise wrong_option("error_limit", error_limit, "should be a number above 0")
    parts = [p._replace(local=local, error_limit=error_limit) for p in panels_of(results, (color,), rows, cols)]
    return scatter_grid(parts, color=color, scale=scale, theory=theory, title=title)


@drawing()
def scatter_grid(
    panels: Sequence[Panel | tuple[Any, ...]],
    *,
    color: str = "accuracy",
    scale: Scale = "log",
    theory: bool = False,
    title: str | None = None,
    claimed: str = "",
) -> Figure:
    """Draw `scatter` panels that the caller chooses, (a), (b), ..., with one key.

    A panel is a `Panel` or a tuple (caption, results[, local[, error_limit[, claim]]]). Panels with the same unit have
    the same x axis. Panels without an `error_limit` have the same y axis. Panels without finished
    trials are left out. A claim is a horizontal line, of which the key says what is `claimed`.

    Raises InputError if there are no panels or too many, or if none holds a finished trial.
    """
    drawn = [Panel(*panel) for panel in panels]
    clouds = [cloud_of(panel.results, panel.local, color) for panel in drawn]
    captions, has = [panel.caption for panel in drawn], [*map(bool, clouds)]
    unrun, drawn, clouds = with_numbers(captions, has, UNRUN, drawn, clouds)
    units = [unit_of(panel.results, panel.local) for panel in drawn]
    parts = [panel.results for panel in drawn]
    looks = looks_of(itertools.chain(*clouds), "o", color, titles_in(*parts))
    if panels and not drawn:
        raise InputError(NOTHING)
    of_theory: list[tuple[Curves, str]] = [curves_of(panel, color) if theory else ({}, "") for panel in drawn]
    expected, remarks = [curves for curves, _ in of_theory], [why for _, why in of_theory]
    axes = sheet([panel.caption for panel in drawn], title, rows=rows_of(drawn), fewer=POOLED)
    free = [cloud for panel, cloud in zip(drawn, clouds, strict=True) if panel.error_limit is None]
    highest = max((error.max() for cloud in free for _, error in cloud.values()), default=0.0)
    per_round = [panel.results["observations_per_round"] if panel.local else 1 for panel in drawn]
    rounds = [float((part["rounds"] * times).max()) for part, times in zip(parts, per_round, strict=True)]
    crossed, named = False, True
    for panel, cloud, unit, curves, place in zip(drawn, clouds, units, expected, axes, strict=True):
        same_unit = [i for i in range(len(units)) if units[i] == unit and clouds[i]]
        when = np.concatenate([when for i in same_unit for when, _ in clouds[i].values()])
        longest = max(rounds[i] for i in same_unit)
        count_axis(place, when.min(), longest, scale, float(np.quantile(when, EARLY)))
        error_axis(place, max(1.08 * highest, 1e-3) if panel.error_limit is None else panel.error_limit, scale)
        symbol = r"\hat{x}" if panel.local else "x"
        name_axes(place, f"convergence $K$ ({unit})", rf"error $|{symbol}^K - f\,|$")
        crosses = crosses_of(panel.results, panel.local, color)
        crossed = crossed or any(cross is not None for _, cross in crosses.values())
        named &= _draw_cloud(place, cloud, crosses, looks)
        for _, line, style in lines_to_draw(curves, looks):  # the expected errors after the last round
            place.axhline(line.median_error[-1], **style, zorder=3.2, path_effects=halo(THIN + 0.8))
        if panel.claim is not None:
            place.axhline(panel.claim, **CLAIM)
    heading, entries = key_of(looks, color, lambda look: median_dot(look, 6, 0.8), named=named)
    median = f"median, named by its\n{title_of(color)}" if named else "median"
    entries[median] = outlined_dot(Look("", "", "#bbbbbb", "o"), 6, 0.8)
    if crossed:
        entries["its 95 % interval"] = key_mark("+", 9, "black", mew=0.8)
    entries["one robot, one trial"] = key_mark("o", 2.4, "0.6")
    entries |= theory_entries(expected)
    if any(panel.claim is not None for panel in drawn):
        entries[claimed] = Line2D([], [], **CLAIM)
    if scale != "linear":
        from_0 = any(place.get_xscale() == "asinh" and place.get_xlim()[0] < 1 for place in axes)
        linear_part = "axes are linear to\nK = 1, error 0.01" if from_0 else "errors are linear to\n0.01"
        entries[f"{linear_part}, then\nlogarithmic"] = Line2D([], [], linestyle="")
    add_key(axes, heading, entries)
    remarks += unrun, pooled_over(parts, [color])
    informed = [panel.results for panel in drawn if not panel.local]
    remarks += misleading(informed), unlearnt(informed, SETTLING_TIMES, "no median is drawn")
    return captioned(axes, scatter, parts, remarks)


def _against(
    results: xr.Dataset, x: str | None, y: str | None, color: str | None, rows: Names, cols: Names, title: str | None,
) -> Figure:  # fmt: skip
    """Draw a dot for each trial, or candidate of a search: its number against a coordinate."""
    searched = SEARCHED in results.attrs
    x = x or next(name for name in coordinates_of(results) if name not in ("brain", "robots", "generation"))
    color = color or ("generation" if searched else "accuracy")
    y = measures.name_of(results, y or results.attrs.get(SEARCHED, "final_error"), numeric_names(results))
    check_coordinates(results, x=x, color=color, rows=rows, cols=cols)
    known = selecting.numbers(results[x].values)
    if not np.isfinite(known).any():
        raise wrong_option("x", x, "its values are no numbers: the kind lines has an axis of names")
    data = measured(results, y, split=False)
    looks = looks_of(groups_of(results, color), "o", color, titles_in(results))
    parts = panels_of(data, (x, color), rows, [] if searched and (rows, cols) == (None, None) else cols)
    found = [measures.numbers(part.results, y) for part in parts]
    axes = sheet([part.caption for part in parts], title, rows=rows_of(parts), fewer=POOLED)
    every = np.concatenate([each.ravel() for each in found])
    if not np.isfinite(every).any():
        raise nothing_of(results, "y", y)
    measured_axis(axes, every[np.isfinite(every)].tolist(), [])
    for part, number, place in zip(parts, found, axes, strict=True):
        for text, settings in groups_of(part.results, color).items():
            at = np.repeat(selecting.numbers(part.results[x].values[settings])[:, np.newaxis], number.shape[1], axis=1)
            finite = np.isfinite(number[settings]) & np.isfinite(at)
            add_dots(
                place, outlined_dot(looks[text], 4.0, 0.3), at[finite], number[settings][finite], label=f"dots {text}"
            )
        number_axis(place, known[np.isfinite(known)], results[x].attrs.get("log"))
        name_axes(place, title_of(x), name_of(results, y, "trials"))
    add_key(axes, *key_of(looks, color, lambda look: outlined_dot(look, 4.0, 0.3)))
    endless = f"{int(np.isinf(every).sum()):,} infinite numbers are not drawn" * bool(np.isinf(every).any())
    return captioned(axes, _against, [results], [endless, pooled_over([part.results for part in parts], [x, color])])


def _draw_cloud(axes: Axes, cloud: Cloud, crosses: dict[str, tuple[Dot, Cross | None]], looks: dict[str, Look]) -> bool:
    """Draw the dots and medians of a panel. Returns whether all its numbers are named."""
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
                    zorder=1.9 if looks[text].spread else 2, label=f"dots {text}",
                )  # fmt: skip
    with_median = [text for text in drawn if text in crosses]
    for text in with_median:
        (x, y), cross = crosses[text]
        dot = median_dot(looks[text], 6, 0.8)
        add_dots(axes, dot, [x], [y], label=f"median {text}", zorder=4, path_effects=halo(2.4))
        for ends in ((cross[:2], (y, y)), ((x, x), cross[2:])) if cross else ():
            axes.plot(
                *ends, label=f"cross {text}", color=looks[text].colour, lw=1.0, zorder=3.5, solid_capstyle="butt",
                path_effects=[*halo(3.4), withStroke(linewidth=2.0, foreground="black")],
            )  # fmt: skip
    medians = {looks[text].short: crosses[text][0] for text in with_median if looks[text].short}
    named = _name_medians(axes, medians) and all(text in crosses for text in drawn if looks[text].short)
    beyond = sum(int((error > axes.get_ylim()[1]).sum()) for _, error in cloud.values())
    if beyond:
        axes.text(
            0.02, 0.98, f"{beyond:,} of {total:,} dots\nlie above", va="top", transform=axes.transAxes,
            fontsize=letters() - 1, color="0.3", path_effects=halo(2), zorder=6,
        )  # fmt: skip
    return named


def _name_medians(axes: Axes, medians: dict[str, Dot]) -> bool:
    """Write its name over each median, if all names have room. Returns whether they have."""
    size, points = letters() - NAMES, 72 / axes.figure.dpi
    places = axes.transData.transform([*medians.values()]) * points if medians else np.empty((0, 2))
    boxes = [(width_of(text, size) + 2, 2.2 * size) for text in medians]
    for i, j in itertools.combinations(range(len(boxes)), 2):
        apart = np.abs(places[i] - places[j])
        if apart[0] < (boxes[i][0] + boxes[j][0]) / 2 and apart[1] < boxes[i][1]:
            return False
    for text, (x, y) in medians.items():
        axes.annotate(
            text, (x, y), (0, 5), textcoords="offset points", ha="center", va="bottom", fontsize=size,
            path_effects=halo(2.0), parse_math=False, zorder=5,
        )  # fmt: skip
    return bool(medians)
