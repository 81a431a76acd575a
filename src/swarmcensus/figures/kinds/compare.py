"""By how much brains differ from one of them, with intervals: a forest plot."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import xarray as xr
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.lines import Line2D
from matplotlib.ticker import FixedLocator, FuncFormatter, MaxNLocator, NullFormatter, NullLocator
from numpy.typing import NDArray

from swarmcensus.basics.errors import InputError
from swarmcensus.basics.formatting import counted
from swarmcensus.comparing import comparison
from swarmcensus.comparing.effects import Effect, effects
from swarmcensus.comparing.standings import Standings
from swarmcensus.figures.axes import short
from swarmcensus.figures.coordinates import caption_of
from swarmcensus.figures.lettering import width_of, wrapped
from swarmcensus.figures.looks import Look, looks_of, palette, solid_dot
from swarmcensus.figures.panels import Names
from swarmcensus.figures.sheets import (
    SMALL,
    Drawn,
    Own,
    add_key,
    drawn_on,
    name_axes,
    say_empty,
    say_lacking,
    sheet,
    show_range,
)


def compare(
    results: xr.Dataset,
    *,
    metric: Names = None,
    against: str | None = None,
    by: Names = None,
    title: str | None = None,
    ax: Own = None,
) -> Drawn:
    """Draw what `sc.compare` finds: differences of brains, paired trial by trial, with their 95 % intervals.

    There is a panel for each measure, named by `metric` as in `sc.compare`, a row for each world, and in it a dot for
    each contender: its number less that of `against`, by default of the study's first contender. Dots are full where
    both are told apart, after a correction for all tests. With `by`, names of coordinates, worlds that are alike in
    these are one row: of each trial the median of its differences in these worlds counts, or the mean of shares; an
    empty list pools all of them. Where there is one row, contenders have rows of their own. An arrow at the edge is an
    infinite difference. Axes of your own, `ax`, hold a panel each: leave room for rows' names on the left.

    Raises InputError as `sc.compare` does, for more than 40 rows and for coordinates in which worlds do not differ.
    """
    found = comparison.compare(results, metric or (), against=against)
    by = [by] if isinstance(by, str) else by
    if by is None and len(found.field.worlds) > MOST_ROWS:
        names = ", ".join(dict.fromkeys(name for world in found.field.worlds for name in world))
        raise InputError(
            f"{len(found.field.worlds):,} worlds are more than the {MOST_ROWS} rows that have room: pool them with by, "
            f"or select some; they differ in {names}"
        )
    mark = found.against or 0
    rows, drawn = effects(results, found, mark, by)
    return draw_effects(found, mark, rows, drawn, title, ax, [results])


MOST_ROWS = 40
SIZE = 5.0  # points: a dot
WIDE, LINE = 2.7, 0.15  # inches: a panel, and a contender's line in a row
NAME = 150.0  # points: of a row's name, which takes two lines
SPREAD = 40.0  # how far the farthest end is, in usual differences, where the axis is no longer linear
Floats = NDArray[np.float64]


def draw_effects(
    found: Standings,
    mark: int,
    rows: Sequence[tuple[dict[str, Any], int]],
    effects: Sequence[Effect],
    title: str | None,
    ax: Own,
    results: Sequence[xr.Dataset],
) -> Drawn:
    """Draw the effects of a comparison, a panel for each measure; see `compare`. Raises InputError."""
    if len(rows) > MOST_ROWS:
        raise InputError(
            f"{counted(len(rows), 'row')} are more than the {MOST_ROWS} that have room: name other coordinates by"
        )
    others = [k for k in range(len(found.contenders)) if k != mark]
    names = [found.contenders[k] for k in others]
    looks = list(looks_of(names, "o", "brain").values())
    texts = [_named(world, count, len(found.field.worlds)) for world, count in rows]
    alone = len(rows) == 1
    caption = f", {texts[0]}" if alone and texts[0] else ""
    if alone:  # contenders are the rows, and all look alike
        texts, looks = names, [Look("", "", palette(11)[3], "o")]
    labels = ["\n".join(wrapped(text, NAME, SMALL, 2)) for text in texts]
    longest = max(width_of(line, SMALL) for text in labels for line in text.split("\n"))
    row = max(LINE * len(looks) + 0.08, 0.28 if any("\n" in text for text in labels) else 0.2)
    captions = [one.measure.label + caption for one in effects]
    axes = sheet(
        ax, captions, title, size=(WIDE, row * len(labels) + 0.1), left=0.25 + longest / 72, below=0.05,
        fewer="name one metric",
    )  # fmt: skip
    for place, effect in zip(axes, effects, strict=True):
        times = 100.0 if effect.measure.share else 1.0
        value, low, high = (times * part[:, others] for part in (effect.value, effect.low, effect.high))
        apart = effect.apart[:, others]
        if alone:
            value, low, high, apart = value.T, low.T, high.T, apart.T
        if np.isnan(value).all():
            say_empty(place, "no pair of trials has numbers")
            continue
        _difference_axis(place, value, low, high)
        for k, look in enumerate(looks):
            y: Floats = np.arange(len(labels), dtype=np.float64) + (k - (len(looks) - 1) / 2) * 0.72 / len(looks)
            _draw(place, y, value[:, k], low[:, k], high[:, k], apart[:, k], look)
        for edge in np.arange(1, len(labels)) - 0.5:
            place.axhline(edge, color="0.9", linewidth=0.6, zorder=0)
        place.axvline(0.0, color="0.45", linewidth=0.8, zorder=1)
        place.set_ylim(len(labels) - 0.5, -0.5)
        named = not place.get_label()  # as those have that stand right of another
        place.set_yticks(range(len(labels)), labels if named else [""] * len(labels), parse_math=False)
        unit = "points of %" if effect.measure.share else "" if effect.measure.unit == "1" else effect.measure.unit
        better, worse = ("← better", "worse →") if effect.measure.low else ("← worse", "better →")
        of = effect.measure.label + f" ({unit})" * bool(unit)
        name_axes(place, f"{better}    Δ {of}    {worse}", "")
        place.tick_params(axis="y", length=0)
        place.spines["left"].set_visible(False)
    add_key(axes, f"less {found.contenders[mark]}", _entries(looks, effects, others))
    say_lacking(axes, results)
    return drawn_on(axes, ax)


def _named(world: dict[str, Any], count: int, worlds: int) -> str:
    if not world:
        return f"all {counted(worlds, 'world')}" if worlds > 1 else ""
    return caption_of(world) + (f" ({counted(count, 'world')})" if count > 1 else "")


def _entries(looks: Sequence[Look], effects: Sequence[Effect], others: Sequence[int]) -> dict[str, Artist]:
    entries: dict[str, Artist] = {look.name: solid_dot(look, SIZE, 0.6) for look in looks if look.name}
    apart = np.concatenate([one.apart[:, others][~np.isnan(one.value[:, others])] for one in effects])
    grey = Look("", "", "0.4", "o")
    if apart.any():
        entries["told apart, corrected\nfor all tests"] = solid_dot(grey, SIZE, 0.6)
    if not apart.all():
        entries["not told apart"] = _dot(grey, False)
    if any(np.isfinite(one.low).any() for one in effects):
        entries["95 % interval"] = Line2D([], [], color="0.4", linewidth=1.2)
    if any(np.isinf(one.value).any() for one in effects):
        entries["infinite"] = Line2D([], [], linestyle="", marker=">", markersize=SIZE, color="0.4")
    return entries


def _dot(look: Look, apart: bool) -> Line2D:
    dot = solid_dot(look, SIZE, 0.6)
    if not apart:
        dot.set(markerfacecolor="white", markeredgecolor=look.colour, markeredgewidth=1.2)
    return dot


def _difference_axis(axes: Axes, *numbers: Floats) -> None:
    """Give the axes an x axis with 0 on it: linear, or where few differences are far from all others, bent about 0."""
    every = np.concatenate([part.ravel() for part in numbers])
    every = every[np.isfinite(every)]
    sizes = np.abs(numbers[0][np.isfinite(numbers[0]) & (numbers[0] != 0)])
    usual, most = (float(np.median(sizes)), float(np.abs(every).max())) if sizes.size else (1.0, 1.0)
    least, top = min(0.0, *every.tolist(), 0.0), max(0.0, *every.tolist(), 0.0)
    axes.xaxis.set_major_locator(MaxNLocator(5, steps=[1, 2, 5, 10]))
    if most >= SPREAD * usual:
        axes.set_xscale("asinh", linear_width=usual)
        decades = 10.0 ** np.arange(np.ceil(np.log10(usual)), np.log10(most) + 1)
        decades = decades[:: max(1, -(-len(decades) // 3))]
        axes.xaxis.set_major_locator(FixedLocator([*-decades[::-1], 0.0, *decades]))
        axes.xaxis.set_minor_locator(NullLocator())
        axes.xaxis.set_minor_formatter(NullFormatter())
        show_range(axes, "x", 1.5 * least - 0.3 * usual, 1.5 * top + 0.3 * usual)
    else:
        room = 0.06 * (top - least) or 1.0
        show_range(axes, "x", least - room, top + room)
    axes.xaxis.set_major_formatter(FuncFormatter(lambda value, _: short(value)))


def _draw(
    axes: Axes, y: Floats, value: Floats, low: Floats, high: Floats, apart: NDArray[np.bool_], look: Look
) -> None:
    """Draw one contender's differences in all rows, as far as the axes reach."""
    left, right = axes.get_xlim()
    axes.hlines(
        y, np.maximum(low, left), np.minimum(high, right), colors=look.colour, linewidths=1.2,
        label=f"interval {look.name}", zorder=2,
    )  # fmt: skip
    for told in (True, False):
        there = np.isfinite(value) & (apart == told)
        if not there.any():
            continue
        dots = _dot(look, told)
        dots.set(xdata=value[there], ydata=y[there], zorder=3, label=f"{'apart' if told else 'level'} {look.name}")
        axes.add_line(dots)
    for sign, marker, edge in ((-1.0, "<", 0.0), (1.0, ">", 1.0)):
        there = np.isinf(value) & (np.sign(value) == sign)
        if not there.any():
            continue
        axes.plot(
            np.full(there.sum(), edge), y[there], marker=marker, markersize=SIZE, linestyle="", color=look.colour,
            transform=axes.get_yaxis_transform(), clip_on=False, label=f"infinite {look.name}", zorder=3,
        )  # fmt: skip
