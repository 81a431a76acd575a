"""Anything that is measured against anything that varies: a line for each value of another coordinate."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import get_args

import numpy as np
import xarray as xr
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.lines import Line2D
from matplotlib.transforms import ScaledTranslation, Transform, blended_transform_factory
from numpy.typing import NDArray

from swarmcensus.basics.errors import InputError
from swarmcensus.figures.axes import coordinate_axis, measured_axis, name_of, names_of, places_of
from swarmcensus.figures.clouds import unit_of
from swarmcensus.figures.coordinates import check_coordinates, from_nobody, texts_of, title_of, varies
from swarmcensus.figures.looks import Look, keyed, looks_of, palette, solid_dot
from swarmcensus.figures.overlaps import Piece, Stretch, stretches
from swarmcensus.figures.panels import Names, panels_of
from swarmcensus.figures.series import Point, Statistic, measured, points_of
from swarmcensus.figures.sheets import (
    LEFT,
    NOTHING,
    POOLED,
    Drawn,
    Own,
    add_key,
    drawn_on,
    name_axes,
    say_empty,
    say_lacking,
    say_pooled,
    sheet,
)
from swarmcensus.results.measures import with_measure
from swarmcensus.results.values import SHARES

SIZE = 5.0  # points: a dot
WIDTH = 1.0  # points: a line
ENDLESS = r"$\infty$"
BESIDE = 5.0  # points between dots of one x: of many lines less
ROOM = 60.0  # points that all dots of one x take together at the most where x has names, and of
NEAR = 9.0  # numbers
WIDE, HIGH = 310.0, 230.0  # points: a panel that is alone
NARROW, LOW = 180.0, 137.0  # and the smallest of several


def lines(
    results: xr.Dataset,
    *,
    y: str = "convergence_error",
    x: str | None = None,
    color: str | None = None,
    panels: Names = None,
    statistic: Statistic | None = None,
    title: str | None = None,
    ax: Own = None,
) -> Drawn:
    """Draw what a variable comes to against a coordinate, a line for each value of another, with 95 % intervals.

    `y` is any variable that is measured in every trial, or a measure of `compare` as "final_error"; its `statistic`,
    "median" or "mean" (by default of `correct` and `coverage`), is over robots and trials. `x` and `color` are
    coordinates, by default the number with the most values, and what else varies, the accuracy first; against `liars`
    it is the `adversary`, and each one's line begins where nobody lies. For a variable of checkpoints `checkpoint` is
    one too, and otherwise the last that a setting reaches is meant. There is a panel for each combination of the
    coordinates `panels`, by default of all others that vary; settings that differ in nothing else are pooled. A thin
    upright line is the 95 % interval over trials, where there are 6 or more. A sign of infinity at the top says that
    the statistic is infinite, as where half of the robots never do what is measured. Lines join numbers, not names,
    break where nothing has been run, and are dashed where they would hide others. Axes of your own, `ax`, hold a panel
    each: leave room for the key on their right.

    Raises InputError for a variable or coordinate that is not there, if there is no finished trial, and for more than
    24 panels.
    """
    results = with_measure(results, y)
    check_coordinates(results, also=("checkpoint",), x=x, color=color, panels=panels)
    panels = [panels] if isinstance(panels, str) else panels
    data = measured(results, y, "checkpoint" in (x, color, *(panels or ())))
    check_coordinates(data, x=x, color=color, panels=panels)
    if x == "liars":
        data = from_nobody(data)
    x, color = _axes_of(data, x, color, panels or ())
    statistic = statistic or ("mean" if y in SHARES else "median")
    if statistic not in get_args(Statistic):
        raise InputError(f"statistic {statistic!r}: should be one of {', '.join(get_args(Statistic))}")
    parts = panels_of(data, (x, *([color] if color else [])), panels)
    series = [_series(part.results, y, x, color, statistic) for part in parts]
    every = [point for found in series for points in found.values() for point in points]
    if all(np.isnan(point.value) for point in every):
        raise InputError(NOTHING)
    across = looks_of((point.x for point in every), "o", x)
    looks = {"": Look("", "", palette(11)[3], "o")}
    if color:
        looks = looks_of((value for found in series for value in found), "o", color)
    under = names_of(across, NARROW if len(parts) > 1 else WIDE)
    beside = name_of(results, y, statistic, LOW if len(parts) > 1 else HIGH)
    left = LEFT + 0.17 * beside.count("\n")
    axes = sheet(ax, [part.caption for part in parts], title, left=left, below=under.room, fewer=POOLED)
    measured_axis(axes, [p.value for p in every], [end for p in every for end in (p.low, p.high)])
    middle = (len(looks) - 1) / 2
    room = ROOM / max(len(looks) - 1, 1)
    apart = min(BESIDE, room)
    are_numbers = places_of(across)[1]
    step = min(apart, NEAR / max(len(looks) - 1, 1)) if are_numbers else apart
    for found, place in zip(series, axes, strict=True):
        if all(np.isnan(point.value) for points in found.values() for point in points):
            say_empty(place, f"no trial has numbers of {y}")
            continue
        coordinate_axis(place, x, across, under, step * middle)
        numbers = {value: _numbers(found.get(value, []), across) for value in looks}
        joined = stretches({value: (one[0], _finite(one[1])) for value, one in numbers.items()}, _hider(place, step))
        for k, (value, look) in enumerate(looks.items()):
            aside = k - middle if x != color else 0.0  # else no two dots are of one x
            _draw(
                place,
                numbers[value],
                joined[value] if are_numbers else [],
                look,
                step * aside,
                min(2 * apart, room) * aside,
            )
        name_axes(place, unit_of(results) if x == "checkpoint" else title_of(x), beside)
    heading = ""
    entries: dict[str, Artist] = {}
    if color:
        heading, named = keyed(looks, color)
        entries |= {look.name: _dot(look) for look in named.values()}
    _say_marks(entries, every, statistic)
    add_key(axes, heading, entries)
    say_lacking(axes, [results])
    say_pooled(axes, [part.results for part in parts], [x, *([color] if color else [])])
    return drawn_on(axes, ax)


def _axes_of(data: xr.Dataset, x: str | None, color: str | None, panels: Sequence[str]) -> tuple[str, str | None]:
    varying = varies(data, [*panels, *(name for name in (x, color) if name)])
    if x is None:
        free = [name for name in varying if name != color]
        counts = {name: len(set(varying[name])) for name in free if places_of(texts_of(data, name).tolist())[1]}
        x = max(counts, key=lambda name: counts[name]) if counts else free[0] if free else "accuracy"
    if color is None:
        first = ("adversary", "accuracy") if x == "liars" else ("accuracy",)
        color = next((name for name in (*first, *varying) if name in varying and name != x), None)
    return x, color


def _series(part: xr.Dataset, y: str, x: str, color: str | None, statistic: Statistic) -> dict[str, list[Point]]:
    """The points of each line, by its value of `color`."""
    if color is None:
        return {"": points_of(part, y, x, statistic, share=y in SHARES)}
    texts = texts_of(part, color)
    return {
        text: points_of(part.isel(setting=texts == text), y, x, statistic, share=y in SHARES)
        for text in dict.fromkeys(texts.tolist())
    }


def _numbers(points: Sequence[Point], across: dict[str, Look]) -> NDArray[np.float64]:
    """Where points are, what they come to and the ends of their intervals (4, point), from left to right."""
    places, _ = places_of(across)
    ordered = sorted(points, key=lambda point: places[point.x])
    return np.array([(places[p.x], *p[1:]) for p in ordered]).reshape(-1, 4).T


def _finite(value: NDArray[np.float64]) -> NDArray[np.float64]:
    return np.where(np.isfinite(value), value, np.nan)


def _hider(axes: Axes, aside: float) -> Callable[[Piece], bool]:
    """Whether a line hides one of the same points that is drawn `aside` points beside it."""

    def hides(piece: Piece) -> bool:
        (x, y), (next_x, next_y) = axes.transData.transform(np.reshape(piece, (2, 2)))
        return bool(aside * abs(next_y - y) < WIDTH * np.hypot(next_x - x, next_y - y))

    return hides


def _draw(
    axes: Axes, numbers: NDArray[np.float64], joined: Sequence[Stretch], look: Look, aside: float, apart: float
) -> None:
    """Draw one line, `aside` points beside where it belongs, to hide no other, and `apart` what is infinite."""
    x, value, low, high = numbers
    shift: Transform = ScaledTranslation(aside / 72, 0, axes.figure.dpi_scale_trans)
    upright, label = axes.transData + shift, look.name
    for part in joined:
        axes.plot(
            part.x, part.y, color=look.colour, linewidth=WIDTH, linestyle=part.style, transform=upright,
            label=f"line {label}", zorder=2,
        )  # fmt: skip
    top = axes.get_ylim()[1]
    axes.vlines(
        x, low, np.minimum(high, top), colors=look.colour, linewidths=1.0, alpha=0.8, transform=upright,
        label=f"interval {label}", zorder=2.5,
    )  # fmt: skip
    dots = _dot(look)
    dots.set(xdata=x, ydata=_finite(value), label=f"{label}", transform=upright, zorder=3)
    axes.add_line(dots)
    endless = np.isposinf(value)
    if endless.any():
        edge: Transform = blended_transform_factory(axes.transData, axes.transAxes)
        edge += ScaledTranslation(apart / 72, -SIZE / 72, axes.figure.dpi_scale_trans)
        axes.plot(
            x[endless], np.ones(endless.sum()), linestyle="", marker=ENDLESS, markersize=SIZE + 3, color=look.colour,
            markeredgewidth=0.4, transform=edge, clip_on=False, label=f"infinite {label}", zorder=4,
        )  # fmt: skip


def _dot(look: Look) -> Line2D:
    return solid_dot(look, SIZE, 0.4)


def _say_marks(entries: dict[str, Artist], points: Sequence[Point], statistic: Statistic) -> None:
    if any(np.isfinite(point.low) for point in points):
        entries["95 % interval"] = Line2D([], [], linestyle="", marker="|", markersize=10, color="0.3")
    if any(np.isposinf(point.value) for point in points):
        entries[f"the {statistic} is infinite"] = Line2D(
            [], [], linestyle="", marker=ENDLESS, markersize=SIZE + 3, color="0.3", markeredgewidth=0.4
        )
