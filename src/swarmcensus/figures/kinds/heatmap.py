"""Heatmap: medians in a grid of two coordinates, such as sensor accuracy and fill ratio."""

from __future__ import annotations

import re
from collections.abc import Callable, Sequence
from functools import partial
from typing import Any, Unpack

import matplotlib as mpl
import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.colors import AsinhNorm, Colormap, Normalize
from matplotlib.figure import Figure
from matplotlib.patches import Patch
from matplotlib.transforms import ScaledTranslation, blended_transform_factory
from numpy.typing import NDArray

from swarmcensus.figures.axes import name_columns, places_of
from swarmcensus.figures.captions import captioned, hidden_tail, misleading, nothing_of, on_edges, unlearnt
from swarmcensus.figures.coordinates import (
    Names,
    check_coordinates,
    of_contenders,
    panels_of,
    rows_of,
    texts_of,
    varies,
)
from swarmcensus.figures.groups import unit_of
from swarmcensus.figures.page import (
    PageOptions,
    caption_letters,
    letters,
    on_page,
    page,
    scale,
    shortened_apart,
    width_of,
)
from swarmcensus.figures.sheets import Own, add_key, name_axes, sheet
from swarmcensus.figures.styles import OFF, looks_of
from swarmcensus.studies import title_of
from swarmcensus.summaries import (
    MEASURES,
    QUANTITIES_AT_K,
    Measure,
    cells,
    measures,
    never_learnt,
    settled_far_off,
    titles_in,
)
from swarmcensus.support.errors import InputError
from swarmcensus.support.formatting import fixed
from swarmcensus.support.hints import did_you_mean
from swarmcensus.support.intervals import Floats
from swarmcensus.support.quantities import QUANTITIES

Z = ("convergence_error", "convergence_round")  # the panels by default
LARGEST = (9.0, 7.0)  # inches: the largest panel; if it has too many cells, they are smaller and have no numbers
ROW, LINE = 0.25, 0.13  # inches: the height of a row, and the least of one that has a name or a number
MARGIN = 0.35  # inches: about all that is right of the left panel's edge and no panel
NARROW = 0.4  # inches: a cell with a number
GREY = "0.9"
NAME = 120.0  # points: the longest name of a row
NAME_WIDTH = 34.0  # points: of a name under a column; longer names slant
USUAL = "accuracy", "fill_ratio"  # in rows and in columns
UNSEEN = r"[$\\{},]"  # signs of formulas that have no width
UNCOLOURED = "robots never learnt (K = 0) or settled far off"


@on_page
def heatmap(
    results: xr.Dataset,
    *,
    x: str | None = None,
    y: str | None = None,
    z: str | None = None,
    rows: Names = None,
    cols: Names = None,
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
    - `rows`, `cols`: coordinates; each combination of their values has panels. By default all others that vary.
    - `title`: the title of the figure.
    - `ax`: axes of your own, one for each panel.
    - `width`, `height`, `font_size`, `labels`: the page, and names of brains (see `PageOptions`).

    Raises InputError for an unknown coordinate, if settings in a cell differ in another one, and for results without a
    finished trial.
    """
    check_coordinates(results, x=x, y=y, rows=rows, cols=cols)
    x, y = _axes_of(results, x, y)
    if x == y:
        raise InputError(f"x and y are both {x!r}: a heatmap needs two coordinates", key="y", value=y)
    parts = panels_of(results, {x, y}, rows, cols)
    if mixed := next((names for part in parts if (names := list(varies(part.results, {x, y})))), []):
        also = f"{', '.join(mixed)} {'varies' if len(mixed) == 1 else 'vary'} too"
        raise InputError(f"a panel shows {y} and {x}, but {also}: name it in rows or cols", key="cols")
    results = of_contenders(results, {x, y})
    across = looks_of(texts_of(results, x).tolist(), "o", x, titles_in(results))
    down = looks_of(texts_of(results, y).tolist(), "o", y, titles_in(results))
    measured = [_measure(results, z)] if z else [MEASURES[name] for name in Z]
    maps = [_maps(of_contenders(part.results, {x, y}), x, y, [*across], [*down], measured) for part in parts]
    known: NDArray[np.bool_] = np.asarray(np.isfinite([values[-1] for values, _ in maps]).any(axis=(0, 2)))
    if not known.any():
        raise nothing_of(results, "z", measured[-1].name)
    looks = [look for look, there in zip(down.values(), known, strict=True) if there]
    names = shortened_apart([look.name for look in looks], NAME * scale(), letters())
    named_columns, named_rows = not places_of(across)[1], not places_of(down)[1]
    widest = max(width_of(look.name, letters()) for look in across.values())
    narrow = NARROW * scale()
    cell = max(narrow, (min(widest, NAME_WIDTH if named_columns else np.inf) + letters()) / 72)  # inches
    high = max(ROW * scale() * len(looks), 0.75)
    size = min(max(cell * len(across), 2.4), LARGEST[0]), high if named_rows else min(high, LARGEST[1])
    left = 0.55 + max(width_of(name, letters()) for name in names) / 72 / scale()
    panels = [(part, k, values[k][known], misled[k][known]) for part, (values, misled) in zip(parts, maps, strict=True)
              for k in range(len(measured))]  # fmt: skip
    room = 72 * min(size[0], (page().width or np.inf) - scale() * left - MARGIN)
    captions = [_caption(results, measured[k], room) for _, k, *_ in panels]
    worlds = [", ".join(filter(None, (part.row, part.caption))) for part, *_ in panels if len(parts) > 1]
    if z and worlds:  # panels of one measure are a table of worlds
        worlds, named = rows_of(parts), [part.caption.replace("$", r"\$") for part in parts]
        captions = ["\n".join(filter(None, pair)) for pair in zip(named, captions, strict=True)]
    axes = sheet(
        ax, captions, title, rows=worlds, size=size, least=LINE / ROW, left=left, key=False, math=True,
        fewer="choose z, such as convergence_error",
    )  # fmt: skip
    wide, tall = (float(side) / axes[0].figure.dpi for side in axes[0].bbox.size)
    numbered = wide >= narrow * len(across) and (ax is not None or tall >= LINE * scale() * len(looks))
    texts, columns = [look.name.removeprefix(OFF) for look in across.values()], _labelled(len(across), wide / cell)
    lines = _labelled(len(names), np.inf if named_rows else 1.01 * tall / (LINE * scale()))
    fair = [np.array([np.where(misled[k], np.nan, values[k]) for values, misled in maps]) for k in range(len(measured))]
    for (_, k, values, misled), place in zip(panels, axes, strict=True):
        _draw_cells(place, values, measured[k], numbered, misled, fair[k])
        if named_rows:  # the first name on top
            place.invert_yaxis()
        place.set_xticks(columns, [texts[k] for k in columns], parse_math=False)
        if named_columns:
            name_columns(place, x, texts)
        place.set_yticks(lines, [names[k] for k in lines], parse_math=False)
        name_axes(place, title_of(x), title_of(y))
        place.tick_params(length=0)
        place.spines[:].set_visible(False)
    shown = [measure.name for measure in measured]
    of_k = any(map(_is_of_k, measured))
    remarks = [hidden_tail(results, shown, "z"), misleading([results] if of_k else []), on_edges([results], shown)]
    uncoloured = f"{'in brackets' if numbered else 'grey'}: {UNCOLOURED}"
    says_so = any(misled.any() for *_, misled in panels)
    remarks.append(uncoloured if says_so else unlearnt([results], shown, "it counts as never"))
    add_key(axes, "", {uncoloured: Patch(color=GREY)} if says_so and ax is None else {}, below=True)
    return captioned(axes, heatmap, [results], remarks)


def _maps(
    results: xr.Dataset, x: str, y: str, across: Sequence[str], down: Sequence[str], measured: Sequence[Measure]
) -> tuple[Floats, NDArray[np.bool_]]:
    """The numbers of each measure in a world, (measure, y, x), and which of them say nothing of robots that settle."""
    texts, downwards = texts_of(results, x), texts_of(results, y)
    grid = [(text, value) for text in across for value in dict.fromkeys(downwards[texts == text].tolist())]
    groups = [np.flatnonzero((texts == text) & (downwards == value)) for text, value in grid]
    found = [cells(results, measure.name, groups, intervals=False).value for measure in measured]
    early, unmoved = settled_far_off(results, opinions=True), never_learnt(results, groups)
    numbers = np.full((len(measured), len(down), len(across)), np.nan)
    misled = np.zeros(numbers.shape, np.bool_)  # K or the agreement round says nothing
    for (text, value), group, still, *of_cell in zip(grid, groups, unmoved, *found, strict=True):
        at = ..., down.index(value), across.index(text)
        numbers[at] = of_cell
        misled[at] = [(still and m.name in QUANTITIES_AT_K) or (_is_of_k(m) and early[group].any()) for m in measured]
    return numbers, misled


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


def _draw_cells(
    axes: Axes, values: NDArray[np.float64], measure: Measure, numbered: bool, misled: NDArray[np.bool_],
    among: NDArray[np.float64],
) -> None:  # fmt: skip
    """Draw the cells of a panel; those that are `misled` have no colour, and their numbers are in brackets.

    Colours are for the numbers `among` which these are.
    """
    times = 100.0 if measure.share else 1.0
    values = times * values
    fair = np.where(misled, np.nan, values)
    every = times * among
    has_fair = bool(np.isfinite(every).any())
    known = every[np.isfinite(every)] if has_fair else values[np.isfinite(values)]
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
        red, green, blue, _ = np.moveaxis(image.to_rgba(fair), -1, 0)
        bright = 0.2126 * red**2.2 + 0.7152 * green**2.2 + 0.0722 * blue**2.2 > 0.18  # WCAG: black reads better
        style: dict[str, Any] = {"ha": "center", "va": "center", "fontsize": letters() - 1}
        for row, column in np.argwhere(np.isfinite(values)):
            number, says_nothing = text(values[row, column]), np.isnan(fair[row, column])
            colour = "0.3" if says_nothing else "black" if bright[row, column] else "white"
            axes.text(column, row, f"({number})" if says_nothing else number, color=colour, **style)


def _draw_scale(axes: Axes, norm: Normalize, colours: Colormap, text_of: Callable[[float], str], low: bool) -> None:
    """Draw the colour bar over a panel, with the best and the worst number at its ends."""
    left, right = ("best", "worst") if low else ("worst", "best")
    panel: Any = axes.transAxes
    over = axes.figure.dpi_scale_trans + ScaledTranslation(0, 1, panel)  # inches from the panel's top
    bar = axes.inset_axes((0, 6 / 72, 1, 5 / 72), transform=blended_transform_factory(panel, over))
    bar.imshow(np.linspace(0, 1, 256)[np.newaxis], cmap=colours, aspect="auto", extent=(0, 1, 0, 1))
    bar.set_axis_off()
    style: dict[str, Any] = {"va": "bottom", "fontsize": letters() - 1, "transform": bar.transAxes}
    bar.text(0.0, 1.4, f"{left} {text_of(float(norm.vmin or 0))}", ha="left", **style)
    bar.text(1.0, 1.4, f"{text_of(float(norm.vmax or 0))} {right}", ha="right", **style)
