"""Line plot: any measured variable against any coordinate, with one line per value of another coordinate."""

from __future__ import annotations

import itertools
from collections import defaultdict
from collections.abc import Collection, Mapping, Sequence
from functools import partial
from typing import Any, Literal, NamedTuple, Unpack

import numpy as np
import xarray as xr
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from swarmcensus.analysis import Cost, comparison, is_time
from swarmcensus.figures import beliefs
from swarmcensus.figures.axes import coordinate_axis, measured_axis, name_of, places_of
from swarmcensus.figures.captions import (
    captioned,
    hidden_tail,
    misleading,
    nothing_of,
    on_edges,
    pooled_over,
    unlearnt,
    with_numbers,
)
from swarmcensus.figures.columns import columns_grid
from swarmcensus.figures.coordinates import (
    Names,
    check_coordinates,
    coordinates_of,
    from_nobody,
    listed,
    panels_of,
    rows_of,
    texts_of,
    varies,
)
from swarmcensus.figures.groups import groups_of, unit_of
from swarmcensus.figures.page import PageOptions, on_page, scale
from swarmcensus.figures.sheets import POOLED, add_key, name_axes, sheet
from swarmcensus.figures.steps import draw_steps
from swarmcensus.figures.styles import (
    OFF,
    ONE_END,
    ONE_SIDED,
    Look,
    add_dots,
    add_endless,
    draw_intervals,
    endless_high,
    endless_mark,
    key_mark,
    key_of,
    looks_of,
    outlined_dot,
    palette,
    shifted,
)
from swarmcensus.studies import title_of
from swarmcensus.summaries import (
    QUANTITIES_AT_K,
    learnt_cells,
    measures,
    never_learnt,
    require,
    titles_in,
)
from swarmcensus.support.errors import InputError
from swarmcensus.support.hints import did_you_mean
from swarmcensus.support.intervals import Floats
from swarmcensus.support.options import option, wrong_option
from swarmcensus.support.quantities import BEST, PER_ROBOT, PER_TRIAL, SEARCHED

SIDES = {"setting", "checkpoint", "trial", "robot"}  # the dimensions that a drawn variable may have
NUMBERLESS = "no trial has numbers of"
SOLID = "-"
# All lengths are in points.
SIZE = 5.0  # of a dot
WIDTH = 1.0  # of a line
BESIDE = 5.0  # between dots with the same x; less if there are many lines
ROOM, SLOT = 60.0, 0.7  # the most that all dots with the same x span, if x has names; and of the distance of two
NEAR = 9.0  # the same if x has numbers
FIRST = ("agreement_round", "right_consensus_round")  # of times

Statistic = Literal["median", "mean"]
Form = Literal["lines", "columns", "steps"]
Points = dict[str, Floats]  # value of the x coordinate as text -> numbers of `_series`


@on_page
def lines(
    results: xr.Dataset,
    *,
    y: str | None = None,
    x: str | None = None,
    color: str | None = None,
    rows: Names = None,
    cols: Names = None,
    statistic: Statistic | None = None,
    form: Form | None = None,
    theory: bool = False,
    title: str | None = None,
    **more: Unpack[PageOptions],
) -> Figure:
    """Draw a variable against a coordinate.

    Each value of another coordinate has a line. Each dot is the median or mean over robots and trials. A thin vertical
    line through a dot is its 95 % interval over trials. It needs at least 6 trials. Lines join the dots if `x` has
    numbers. They break where nothing has been run. An infinity sign at the top means that the statistic is infinite,
    for instance because half of the robots never do what is measured. Settings that differ in no drawn coordinate are
    pooled, and the caption says so.

    - `y`: a variable measured in every trial, or a measure of `sc.compare`, such as "final_error"; by default
      "convergence_error", and of the log of a search the best number so far, by generation. A variable measured
      at checkpoints is taken at the last checkpoint of each setting, unless one of the coordinates is "checkpoint".
    - `x`: a coordinate; by default the numeric one with the most values. "belief" is the assumed minus the true
      accuracy; beliefs that are drawn at random stand on the right.
    - `color`: the coordinate with one line for each value; by default another one that varies, the accuracy first. If
      `x` is "liars", it is the adversary, and each line begins at the setting without liars.
    - `rows`, `cols`: coordinates; each combination of their values has a panel. By default all others that vary.
    - `statistic`: "median" or "mean". By default it is the mean for shares and for what is sent, else the median.
    - `form`: "lines"; "columns", evenly spaced, of the shares of right robots at checkpoints, as in the paper's Fig. 4
      (the default if `x` is "checkpoint"); or "steps", the share of trials in which a time that may never come, such
      as "agreement_round", has come by each round, by `color`, with 95 % intervals over trials in bands.
    - `theory`: with columns the expected shares, dotted for robots alone, dashed for all readings of the swarm at once;
      with beliefs the errors predicted after endless observation (`asymptote`), dashed, in place of lines.
    - `title`: the title of the figure.
    - `width`, `height`, `font_size`, `labels`: the page, and names of brains (see `PageOptions`).

    Raises InputError for an unknown variable or coordinate, for results without a finished trial, for more than 120
    panels, for a form that does not go with the variable, and for beliefs if all robots know their sensors.
    """
    if form == "steps":
        return _steps(results, y, x, color, rows, cols, title)
    if form == "columns" or (form is None and x == "checkpoint" and y in (None, "correct")):
        if y not in (None, "correct") or x not in (None, "checkpoint"):
            raise wrong_option("form", form, "goes with y = correct and x = checkpoint")
        color = color or "accuracy"
        check_coordinates(results, color=color, rows=rows, cols=cols)
        parts = panels_of(results, (color,), rows, cols)
        return columns_grid(parts, color=color, theory=theory, title=title)
    data, y, x, color, statistic = _chosen(results, y, x, color, rows, cols, statistic, theory)
    by, of_beliefs = [x, *([color] if color else [])], x == "belief"
    parts = panels_of(data, [*by, *["assumed_accuracy"] * of_beliefs], rows, cols)
    costs = beliefs.costs_in(results, parts) if of_beliefs else [[] for _ in parts]
    panels = [
        _Panel(beliefs.series_of(each) if of_beliefs else _series(part.results, y, x, color, statistic), each)
        for part, each in zip(parts, costs, strict=True)
    ]
    has = [not np.isnan([value for value, *_ in panel.numbers()]).all() for panel in panels]
    if not any(has):
        raise nothing_of(results, "y", y)
    captions = [part.caption for part in parts]
    numberless, parts, panels = with_numbers(captions, has, f"{NUMBERLESS} {y}", parts, panels)
    every = np.array([numbers for panel in panels for numbers in panel.numbers()]).T
    of_x = (text for panel in panels for points in panel.series.values() for text in points)
    across, looks = looks_of(of_x, "o", x, titles_in(results)), {"": Look("", "", palette(11)[3], "o")}
    if color:
        looks = looks_of(itertools.chain(*(panel.series for panel in panels)), "o", color, titles_in(results))
    axes = sheet([part.caption for part in parts], title, rows=rows_of(parts), fewer=POOLED)
    endless = [sum(bool(np.isposinf([*each.values()]).any()) for each in panel.series.values()) for panel in panels]
    reach = every[1:3].ravel().tolist() + [cost.predicted for panel in panels for cost in panel.costs if theory]
    measured_axis(axes, every[0].tolist(), reach, more=endless_high(max(endless), axes[0]), linear=of_beliefs)
    places, are_numbers = places_of(across, mixed=of_beliefs)
    step = 0.0 if of_beliefs else sideways(axes[0], len(across), are_numbers, len(looks))
    middle, full = (len(looks) - 1) / 2, 1.0 if measures.is_share(y) else np.nan
    coordinate_axis(axes, x, across, step * middle)
    # if x and colour are the same, no two dots have the same x
    asides = [step * (line - middle) * (x != color) for line in range(len(looks))]
    for panel, place in zip(panels, axes, strict=True):
        _draw(place, panel, looks, places, asides, joined=are_numbers, theory=theory, full=full)
        name = f"{title_of(x)}, error" if all(text.startswith(OFF) for text in across) else title_of(x)
        name = beliefs.X_NAME if of_beliefs else unit_of(results) if x == "checkpoint" else name
        name_axes(place, name, name_of(results, y, statistic))
    lined = are_numbers and any(look.line != SOLID for look in looks.values())
    heading, entries = key_of(looks, color, partial(key_dot, lined=lined)) if color else ("", {})
    say_marks(entries, every, statistic, full)
    if theory and any(np.isfinite(cost.predicted) for panel in panels for cost in panel.costs):
        entries["predicted, after\nendless observation"] = Line2D([], [], **beliefs.PREDICTED, color="0.3")
    add_key(axes, heading, entries)
    remarks = [
        numberless,
        hidden_tail(results, [y], "y") if statistic == "median" else "",
        pooled_over([part.results for part in parts], by),
        misleading([results] if y == "convergence_round" else []),
        unlearnt([results], [y], "drawn as infinite"),
        on_edges([results], [y]),
    ]
    return captioned(axes, lines, [results], remarks)


def _chosen(
    results: xr.Dataset, y: str | None, x: str | None, color: str | None, rows: Names, cols: Names,
    statistic: Statistic | None, theory: bool,
) -> tuple[xr.Dataset, str, str, str | None, Statistic]:  # fmt: skip
    """What is drawn: numbers, their name, both coordinates and the statistic. Raises InputError."""
    of_beliefs = x == "belief"
    if theory and not of_beliefs:
        raise wrong_option("theory", True, "goes with x = checkpoint or x = belief")
    if of_beliefs:
        if y not in (None, "final_error") or color not in (None, "accuracy") or statistic == "mean":
            raise wrong_option("x", x, "draws the median final_error, by accuracy")
        results, y = beliefs.with_beliefs(results), "final_error"
    if y is None and SEARCHED in results.attrs:
        stays = {"setting", "trial", "brain", "robots", "generation", x}
        results = results.drop_vars({*results.coords} - stays)
        y, x = BEST + results.attrs[SEARCHED], x or "generation"
    y = measures.name_of(results, y or "convergence_error", numeric_names(results))
    check_coordinates(results, also=("checkpoint",), x=x, color=color, rows=rows, cols=cols)
    in_panels = {*(listed(rows) or ()), *(listed(cols) or ())}
    data = measured(results, y, "checkpoint" in {x, color, *in_panels})
    check_coordinates(data, x=x, color=color, rows=rows, cols=cols)
    data = from_nobody(data) if x == "liars" else data
    return data, y, *_axes_of(data, x, color, in_panels), statistic or measures.statistic_of(y)


class _Panel(NamedTuple):
    """What a panel shows: the points of each line, and the costs of beliefs."""

    series: dict[str, Points]
    costs: list[Cost]

    def numbers(self) -> list[Floats]:
        """The numbers of all points."""
        return [numbers for points in self.series.values() for numbers in points.values()]


def _draw(
    axes: Axes, panel: _Panel, looks: Mapping[str, Look], places: Mapping[str, float], asides: Sequence[float], *,
    joined: bool, theory: bool, full: float,
) -> None:  # fmt: skip
    """Draw the lines of a panel, each moved by as many points as `asides` say."""
    numbers = {value: _numbers(panel.series.get(value, {}), places) for value in looks}
    if theory:
        beliefs.draw_predicted(axes, panel.costs, looks)
    signs = defaultdict[float, list[Look]](list)
    sizes = np.linspace(*(beliefs.SIZES if panel.costs else (SIZE, SIZE)), len(looks))
    for (value, look), aside, size in zip(looks.items(), asides, sizes, strict=True):
        draw_line(axes, numbers[value], look.line if joined and not theory else None, look, aside, full, size)
        for at in numbers[value][0, np.isposinf(numbers[value][1])].tolist():
            signs[at].append(look)
    add_endless(axes, signs)


def key_dot(look: Look, *, lined: bool) -> Line2D:
    """The dot of a line in the key, on a piece of it if it is `lined`."""
    dot = outlined_dot(look, SIZE, 0.4)
    if lined:
        dot.set(linestyle=look.line, color=look.colour, linewidth=WIDTH)
    return dot


def _steps(
    results: xr.Dataset, y: str | None, x: str | None, color: str | None, rows: Names, cols: Names, title: str | None,
) -> Figure:  # fmt: skip
    """Draw the shares of trials in which a time has come, by another coordinate."""
    if x is not None:
        raise wrong_option("x", x, "steps have rounds or ticks on their x axis")
    known = measures.known(results)
    times = [name for name in (*FIRST, *known) if name in known and is_time(name)]
    if y is None and not times:
        raise InputError("lines: these results have no times that may never come", key="form")
    try:
        found = comparison.compare(results, y or times[0], factor=color or ())
    except InputError as error:  # lines has no factor
        theirs, ours = (option(name, "?").partition("?")[0].replace("'", "") for name in ("factor", "color"))
        raise type(error)(str(error).replace(theirs, ours), key="color", value=error.value) from None
    return draw_steps(found, title, [results], rows, cols)


def _axes_of(data: xr.Dataset, x: str | None, color: str | None, panels: Collection[str]) -> tuple[str, str | None]:
    """The coordinates of the x axis and of the colour: the given ones, or the defaults that `lines` documents."""
    if x == "belief":
        return x, color or "accuracy"
    varying = varies(data, [*panels, *(name for name in (x, color) if name)])
    if x is None:
        free = [name for name in varying if name != color]
        counts = {name: len(set(varying[name])) for name in free if places_of(texts_of(data, name).tolist())[1]}
        x = max(counts, key=lambda name: counts[name]) if counts else free[0] if free else "accuracy"
    if color is None:
        first = ("adversary", "accuracy") if x == "liars" else ("accuracy",)
        color = next((name for name in (*first, *varying) if name in varying and name != x), None)
    return x, color


def _series(part: xr.Dataset, y: str, x: str, color: str | None, statistic: Statistic) -> dict[str, Points]:
    """The points of each line by its value of `color`, or by ""; settings with the same value of `x` are pooled.

    A point's numbers are the statistic, the ends of its 95 % interval, and whether an error at K is `unlearnt`: half of
    the robots never learnt (K = 0). The statistic may be infinite. It is NaN if nothing has been run. The ends are NaN
    if too few trials have been run.
    """
    points = {}
    for text, settings in (groups_of(part, color) if color else {"": slice(None)}).items():
        line = part.isel(setting=settings)
        groups = groups_of(line, x)
        found = learnt_cells(line, y, [*groups.values()], statistic=statistic)
        still = never_learnt(line, [*groups.values()]) & (y == "convergence_error")
        points[text] = dict(zip(groups, np.transpose([*found, still]), strict=True))
    return points


def _numbers(points: Points, places: Mapping[str, float]) -> Floats:
    """x and the numbers of each point, (5, point), from left to right."""
    ordered = sorted(points, key=lambda text: places[text])
    return np.array([(places[text], *points[text]) for text in ordered]).reshape(-1, 5).T


def sideways(axes: Axes, values: int, are_numbers: bool, lines: int) -> float:
    """How many points a line stands to the right of the one before, so that none hides another.

    The dots at one of so many `values` of x are nearer to each other than to those at the next.
    """
    slot = SLOT * axes.bbox.width * 72 / axes.figure.dpi / values
    return min(scale() * BESIDE, (scale() * NEAR if are_numbers else min(scale() * ROOM, slot)) / max(lines - 1, 1))


def draw_line(
    axes: Axes, numbers: Floats, joined: Any, look: Look, aside: float, full: float, size: float = SIZE
) -> None:
    """Draw one line, moved to the right by `aside` points, to hide no others; None: its points are not joined.

    Intervals of a share that is `full` have a lower end only.
    """
    x, value, low, high, unlearnt = numbers
    value = np.where(np.isfinite(value), value, np.nan)
    upright: dict[str, Any] = {"transform": shifted(axes.transData, axes, aside)}
    if joined is not None:
        axes.plot(x, value, color=look.colour, lw=WIDTH, ls=joined, label=f"line {look.name}", zorder=2, **upright)
    high, whole = np.minimum(high, axes.get_ylim()[1]), np.asarray(value == full)
    thin: dict[str, Any] = {"colors": look.colour, "linewidths": 1.0, "alpha": 0.8, **upright}
    draw_intervals(axes, x, low, high, whole, look.name, zorder=2.5, **thin)
    dots = outlined_dot(look, size, 0.4)
    add_dots(axes, dots, x, value, label=look.name, zorder=3, clip_on=False, **upright)
    if (first := unlearnt > 0).any():
        hollow = outlined_dot(look, SIZE, 0.4, hollow=1.2)
        add_dots(axes, hollow, x[first], value[first], label=f"unlearnt {look.name}", zorder=3.1, **upright)


def say_marks(entries: dict[str, Artist], numbers: Floats, statistic: Statistic, full: float) -> None:
    """Add the entries of a key for the marks of such lines."""
    value, low, _, unlearnt = numbers
    whole = value[np.isfinite(low)] == full
    if not whole.all():
        entries["95 % interval"] = key_mark("|")
    if whole.any():
        entries[f"dash-dotted: all, {ONE_END}"] = Line2D([], [], linestyle=ONE_SIDED, linewidth=1.0, color="0.3")
    if unlearnt.any():
        entries["white: never learnt (K = 0)"] = outlined_dot(Look("", "", "white", "o"), SIZE, 0.4)
    if np.isposinf(value).any():
        entries[f"the {statistic} is infinite"] = endless_mark()


def numeric_names(results: xr.Dataset) -> list[str]:
    """The names of all numeric variables that are measured in every trial, and of what is derived from them."""
    stored = [
        str(name)
        for name, variable in results.data_vars.items()
        if {"setting", "trial"} <= {*variable.dims} <= SIDES and variable.dtype.kind in "biuf"
    ]
    return [*stored, *measures.derivable(results)]


def measured(results: xr.Dataset, name: str, split: bool) -> xr.Dataset:
    """One quantity with the coordinates of the settings, as float64 (setting, trial, robot), NaN where nothing was run.

    What is recorded at checkpoints is taken at the last one that its setting reaches. With `split`, it is taken at
    each: settings are then repeated, with the additional coordinate `checkpoint`. Raises InputError for an unknown
    name.
    """
    require(results)
    if name not in (known := numeric_names(results)):
        here = f"{did_you_mean(name, known)}what is measured here is {', '.join(known)}"
        raise wrong_option("y", name, here)
    settings = results[coordinates_of(results)].drop_vars("checkpoint", errors="ignore")
    rows = np.arange(results.sizes["setting"])
    values = measures.sample(results, name, rows)
    if split and measures.at_checkpoints(results, name):
        recorded = results["checkpoint"].values
        rows, place = np.nonzero(recorded <= results["rounds"].values[:, np.newaxis])
        values = np.empty((rows.size, *values.shape[1:]))
        for k in np.unique(place):
            values[place == k] = measures.sample(results, name, rows[place == k], int(recorded[k]))
        settings = settings.isel(setting=rows).assign_coords(checkpoint=("setting", recorded[place]))
    found: dict[str, Any] = {name: (PER_ROBOT, values) if values.shape[2] > 1 else (PER_TRIAL, values[:, :, 0])}
    if name in QUANTITIES_AT_K:
        found.setdefault("convergence_round", results["convergence_round"].isel(setting=rows).variable)
    found |= {"honest": ("setting", results["honest"].values[rows])} if "honest" in results else {}
    return xr.Dataset(found, settings.coords, results.attrs)
