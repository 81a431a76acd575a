"""Heatmap: medians in a grid of two coordinates, such as sensor accuracy and fill ratio."""

from __future__ import annotations

import re
from collections.abc import Callable
from functools import partial
from typing import Any, Unpack

import matplotlib as mpl
import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.colors import AsinhNorm, Colormap, Normalize
from matplotlib.figure import Figure
from matplotlib.patches import Patch
from numpy.typing import NDArray

from swarmcensus.figures.axes import SLANT, names_of, places_of
from swarmcensus.figures.captions import captioned, hidden_tail, misleading, nothing_of, on_edges, unlearnt
from swarmcensus.figures.coordinates import check_coordinates, of_contenders, texts_of, varies
from swarmcensus.figures.groups import unit_of
from swarmcensus.figures.heights import HIGHEST
from swarmcensus.figures.lettering import SPACING, shortened_apart, width_of, write_numbers
from swarmcensus.figures.page import PageOptions, caption_letters, letters, on_page, page, scale
from swarmcensus.figures.panels import select_some
from swarmcensus.figures.sheets import INNER, Own, add_key, caption_panels, layout, name_axes, sheet
from swarmcensus.figures.styles import looks_of
from swarmcensus.studies import title_of
from swarmcensus.summaries import (
    MEASURES,
    QUANTITIES_AT_K,
    Measure,
    TooMuch,
    cells,
    measures,
    never_learnt,
    settled_far_off,
    titles_in,
)
from swarmcensus.support.errors import InputError
from swarmcensus.support.formatting import fixed
from swarmcensus.support.hints import did_you_mean
from swarmcensus.support.quantities import QUANTITIES

Z = ("convergence_error", "convergence_round")  # the panels by default
LARGEST = (9.0, 7.0)  # inches: the largest panel; if it has too many cells, they are smaller and have no numbers
ROW, LINE = 0.25, 0.13  # inches: the height of a row, and the least of one that has a name or a number
OVER_MAP = 1.35  # inches over and under a panel
GREY = "0.9"
NAME = 120.0  # points: the longest name of a row
NAME_WIDTH = 34.0  # points: of a name under a column; longer names slant
USUAL = "accuracy", "fill_ratio"  # in rows and in columns
UNSEEN = r"[$\\{},]"  # signs of formulas that have no width
ABOVE = 0.3  # inches over a panel for the colour bar
MOST_NAMED = 8  # values of a coordinate in a message
UNCOLOURED = "robots never learnt (K = 0) or settled far off"


@on_page
def heatmap(
    results: xr.Dataset,
    *,
    x: str | None = None,
    y: str | None = None,
    z: str | None = None,
    title: str | None = None,
    ax: Own = None,
    **more: Unpack[PageOptions],
) -> Figure:
    """Draw medians, or means of shares, over robots and trials in a grid of two coordinates.

    The left panel shows the error |x^K - f|, and the right one the convergence K in communication rounds, or in ticks
    if robots move. The colour bar over a panel says which colours are best. Cells contain their numbers if these fit.
    Grey cells have no finished trial, or a K that is early because robots never learnt or settled far off, which is in
    brackets. A heatmap extends the paper's Figs. 2 to 5 to all fill ratios f.

    - `x`, `y`: the coordinates in columns and in rows; by default the two that vary, with names such as those of brains
      in rows. If fewer do, they are the fill ratio and the accuracy; if more do, these two if they vary.
    - `z`: draw one panel only, of any quantity that brains are compared by, such as "final_error", "error_90" or
      "correct".
    - `title`: the title of the figure.
    - `ax`: axes of your own, one for each panel.
    - `width`, `height`, `font_size`, `labels`: the page, and names of brains (see `PageOptions`).

    Raises InputError for an unknown coordinate, if another coordinate varies too, and for results without a finished
    trial.
    """
    check_coordinates(results, x=x, y=y)
    x, y = _axes_of(results, x, y)
    if x == y:
        raise InputError(f"x and y are both {x!r}: a heatmap needs two coordinates", key="y", value=y)
    if varying := varies(results, apart_from={x, y}):
        listed = []
        for name, of_settings in varying.items():
            distinct = [str(value) for value in dict.fromkeys(of_settings) if value is not None]
            listed.append(f"{name} ({', '.join(distinct[:MOST_NAMED])}{', ...' * (len(distinct) > MOST_NAMED)})")
        vary = f"{', '.join(listed)} {'varies' if len(varying) == 1 else 'vary'} too"
        raise TooMuch(f"a heatmap shows {y} and {x}, but {vary}", select_some(results, {x, y}, 1))
    results = of_contenders(results, {x, y})
    texts, downwards = texts_of(results, x), texts_of(results, y)
    across = looks_of(texts.tolist(), "o", x, titles_in(results))
    measured = [_measure(results, z)] if z else [MEASURES[name] for name in Z]
    grid = [(text, value) for text in across for value in dict.fromkeys(downwards[texts == text].tolist())]
    groups = [np.flatnonzero((texts == text) & (downwards == value)) for text, value in grid]
    found = [cells(results, measure.name, groups, intervals=False).value for measure in measured]
    drawn = {value for (_, value), number in zip(grid, found[-1], strict=True) if np.isfinite(number)}
    looks = looks_of((value for _, value in grid if value in drawn), "o", y, titles_in(results))
    if not looks:
        raise nothing_of(results, "z", measured[-1].name)
    numbers = np.full((len(measured), len(looks), len(across)), np.nan)
    early, unmoved = settled_far_off(results, opinions=True), never_learnt(results, groups)
    misled = np.zeros(numbers.shape, np.bool_)  # K or the agreement round says nothing
    for (text, value), group, still, *of_cell in zip(grid, groups, unmoved, *found, strict=True):
        if value in looks:
            at = ..., [*looks].index(value), [*across].index(text)
            numbers[at] = of_cell
            misled[at] = [
                (still and m.name in QUANTITIES_AT_K) or (_is_of_k(m) and early[group].any()) for m in measured
            ]
    names = shortened_apart([look.name for look in looks.values()], NAME * scale(), letters())
    widest = max(width_of(look.name, letters()) for look in across.values())
    named_columns, named_rows = not places_of(across)[1], not places_of(looks)[1]
    widest = min(widest, NAME_WIDTH) if named_columns else widest
    narrow = 0.4 * scale()  # inches: a cell with a number
    cell = max(narrow, (widest + letters()) / 72)  # inches
    lowest = LINE * scale() * len(looks)  # inches: a panel with numbers or names in all rows
    size = (max(cell * len(across), 2.4), max(ROW * scale() * len(looks), 0.75))
    numbered = size[0] <= LARGEST[0] and size[1] <= LARGEST[1]
    size = min(size[0], LARGEST[0]), min(size[1], LARGEST[1])
    left = scale() * 0.55 + max(width_of(name, letters()) for name in names) / 72
    left = left if page().width else max(1.25 * scale(), left)  # room for a title on the left
    room = layout(len(measured), size=size, left=left, key=False)
    if named_rows and page().width:  # lower rows rather than fewer names
        size = size[0], max(lowest, min(size[1], HIGHEST / room.rows - OVER_MAP * scale()))
        room = layout(len(measured), size=size, left=left, key=False)
    under = names_of(across, 72 * room.wide, 72 * left)
    size = room.wide, room.high
    axes = sheet(
        ax, [""] * len(measured), title, size=size, left=left, key=False, above=ABOVE * scale(), below=under.room,
        fewer="choose z, such as convergence_error",
    )  # fmt: skip
    if ax is not None:
        size = axes[0].bbox.width / axes[0].figure.dpi, axes[0].bbox.height / axes[0].figure.dpi
        numbered, under = True, names_of(across, 72 * size[0])
    numbered = numbered and size[0] >= narrow * len(across) and size[1] >= lowest
    needed = cell  # inches of a name under a column
    if named_columns:
        needed = SPACING * letters() / 72 / np.sin(np.radians(SLANT)) if under.slanted else 0.0
    columns = _labelled(len(across), size[0] / needed if needed else np.inf)
    rows = _labelled(len(names), 1.01 * size[1] / (LINE * scale()))
    crowded = y if named_rows and len(rows) < len(looks) else ""
    crowded = x if named_columns and len(columns) < len(across) else crowded
    if crowded and ax is None:
        hint = f"names have more room in rows: y={crowded}" if crowded == x else "select some"
        raise InputError(f"a panel has no room for all names of {crowded}; {hint}", key="y", value=y)
    for measure, values, place, without in zip(measured, numbers, axes, misled, strict=True):
        draw_cells(place, values, measure, numbered, without)
        if named_rows:  # the first name on top
            place.invert_yaxis()
        place.set_xticks(columns, [under.texts[k] for k in columns], parse_math=False, **under.style)
        place.set_yticks(rows, [names[k] * (place.get_label() != INNER) for k in rows], parse_math=False)
        name_axes(place, title_of(x), title_of(y))
        place.tick_params(length=0)
        place.spines[:].set_visible(False)
    captions = [_caption(results, measure, 72 * axes[0].bbox.width / axes[0].figure.dpi) for measure in measured]
    if ax is None or not title or len(axes) > 1:
        caption_panels(axes, captions, ABOVE * scale(), math=True)
    shown = [measure.name for measure in measured]
    of_k = any(map(_is_of_k, measured))
    remarks = [hidden_tail(results, shown, "z"), misleading([results] if of_k else []), on_edges([results], shown)]
    uncoloured = f"{'in brackets' if numbered else 'grey'}: {UNCOLOURED}"
    remarks.append(uncoloured if misled.any() else unlearnt([results], shown, "it counts as never"))
    if misled.any() and ax is None:
        add_key(axes, "", {uncoloured: Patch(color=GREY)}, below=True)
    return captioned(axes, heatmap, [results], remarks)


def _is_of_k(measure: Measure) -> bool:
    return measure.name == "convergence_round"


def _measure(results: xr.Dataset, z: str) -> Measure:
    """The measure of the only panel. Raises InputError."""
    known = measures.known(results)
    name = measures.name_of(results, z, known)
    if name not in known:
        raise InputError.named("z", z, f"{did_you_mean(z, known)}should be one of {', '.join(known)}")
    return known[name]


def _caption(results: xr.Dataset, measure: Measure, room: float) -> str:
    """What a panel of `room` points shows, with its unit; in fewer words if there is no room for all."""
    axis = QUANTITIES[measure.name].axis if measure.name in QUANTITIES else ""
    label = measure.label.replace("$", r"\$")
    unit = unit_of(results).split()[-1] if measure.unit == "rounds" else "%" if measure.share else measure.unit
    names = [name for name in (axis, axis.replace("convergence ", ""), label) if name]
    texts = [f"{measure.statistic} {name}" + f" ({unit})" * (unit != "1") for name in names]
    return next((t for t in texts if width_of(f"(b) {re.sub(UNSEEN, '', t)}", caption_letters()) <= room), texts[-1])


def _axes_of(results: xr.Dataset, x: str | None, y: str | None) -> tuple[str, str]:
    """The coordinates of the columns and the rows: the given ones, or the defaults that `heatmap` documents."""
    given = {name for name in (x, y) if name}
    varying = [name for name in varies(results, given) if name not in given]
    usual = [name for name in USUAL if name not in given]
    free = list(dict.fromkeys([*(name for name in usual if name in varying), *varying, *usual]))
    names = [name for name in free[:2] if not places_of(texts_of(results, name).tolist())[1]]
    if names and not given:
        free.insert(0, free.pop(free.index(names[0])))
    y = y or free.pop(0)
    return x or free.pop(0), y


def _labelled(count: int, room: float) -> NDArray[np.int64]:
    """Which of `count` rows or columns are labelled, evenly chosen, if there is room for `room` labels."""
    return np.arange(0, count, max(1, int(np.ceil(count / max(room, 1.0)))))


def draw_cells(
    axes: Axes, values: NDArray[np.float64], measure: Measure, numbered: bool, misled: NDArray[np.bool_]
) -> None:
    """Draw the cells of a panel; those that are `misled` have no colour, and their numbers are in brackets."""
    values = 100.0 * values if measure.share else values
    fair = np.where(misled, np.nan, values)
    has_fair = bool(np.isfinite(fair).any())
    known = fair[np.isfinite(fair)] if has_fair else values[np.isfinite(values)]
    if np.isinf(values).any():
        why = f"{measure.label} is infinite in some cells, so its colours have no end: draw it with lines"
        raise InputError.named("z", measure.name, why)
    ends: dict[str, Any] = {"vmin": known.min(), "vmax": known.max()}
    decimals = 1 if measure.share else 0 if measure.unit != "1" else 3 if known.max() >= 0.1 else 4
    text = partial(fixed, decimals=decimals)
    colours = mpl.colormaps["viridis_r" if measure.low else "viridis"].with_extremes(bad=GREY)
    norm = Normalize(**ends) if measure.share else AsinhNorm(0.01 if measure.unit == "1" else 1.0, **ends)
    image = axes.imshow(fair, cmap=colours, norm=norm, aspect="auto", origin="lower")
    if has_fair:
        _draw_scale(axes, norm, colours, text, measure.low)
    if numbered:
        write_numbers(axes, image, fair, text, letters() - 1)
        for row, column in np.argwhere(np.isfinite(values) & np.isnan(fair)):
            number = f"({text(values[row, column])})"
            axes.text(column, row, number, ha="center", va="center", fontsize=letters() - 1, color="0.3")


def _draw_scale(axes: Axes, norm: Normalize, colours: Colormap, text_of: Callable[[float], str], low: bool) -> None:
    """Draw the colour bar over a panel, with the best and the worst number at its ends."""
    left, right = ("best", "worst") if low else ("worst", "best")
    high = axes.bbox.height * 72 / axes.figure.dpi
    bar = axes.inset_axes((0, 1 + 6 / high, 1, 5 / high))
    bar.imshow(np.linspace(0, 1, 256)[np.newaxis], cmap=colours, aspect="auto", extent=(0, 1, 0, 1))
    bar.set_axis_off()
    style: dict[str, Any] = {"va": "bottom", "fontsize": letters() - 1, "transform": bar.transAxes}
    bar.text(0.0, 1.4, f"{left} {text_of(float(norm.vmin or 0))}", ha="left", **style)
    bar.text(1.0, 1.4, f"{text_of(float(norm.vmax or 0))} {right}", ha="right", **style)
