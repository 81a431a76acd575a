"""Heatmap: medians in a grid of two coordinates, such as sensor accuracy and fill ratio."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial
from typing import Any, Unpack

import matplotlib as mpl
import numpy as np
import xarray as xr
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.colors import AsinhNorm, Normalize, to_hex
from matplotlib.figure import Figure
from matplotlib.patches import Patch
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
    letters,
    on_page,
    scale,
    width_of,
    wrapped,
)
from swarmcensus.figures.sheets import add_key, name_axes, sheet
from swarmcensus.figures.styles import OFF, Strip, looks_of
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
from swarmcensus.support.options import wrong_option

Z = ("convergence_error", "convergence_round")  # the panels by default
LARGEST = (9.0, 7.0)  # inches: the largest panel; if it has too many cells, they are smaller and have no numbers
ROW, LINE = 0.25, 0.13  # inches: the height of a row, and the least of one that has a name or a number
NARROW = 0.4  # inches: a cell with a number
GREY = "0.9"
NAME = 120.0  # points: the longest name of a row
NAME_WIDTH = 34.0  # points: of a name under a column; longer names slant
USUAL = "accuracy", "fill_ratio"  # in rows and in columns
BLANK = "grey: no finished trial with a number"
UNCOLOURED = "grey: robots never learnt (K = 0) or settled far off"


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
    **more: Unpack[PageOptions],
) -> Figure:
    """Draw medians, or means of shares, over robots and trials in a grid of two coordinates.

    The left panel shows the error |x^K - f|, and the right one the convergence K in communication rounds, or in ticks
    if robots move. A colour bar for each says which colours are best. Cells contain their numbers if these fit. Grey
    cells have no finished trial, or a K that is early because robots never learnt or settled far off. A heatmap extends
    the paper's Figs. 2 to 5 to all fill ratios f.

    - `x`, `y`: the coordinates in columns and in rows; by default the two that vary, with names such as those of brains
      in rows. If fewer do, they are the fill ratio and the accuracy; if more do, these two if they vary.
    - `z`: draw one panel only, of any quantity that brains are compared by, such as "final_error", "error_90" or
      "correct".
    - `rows`, `cols`: coordinates; each combination of their values has panels. By default all others that vary.
    - `title`: the title of the figure.
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
    if not np.isfinite([values[-1] for values, *_ in maps]).any() and not any(misled for _, misled, _ in maps):
        raise nothing_of(results, "z", measured[-1].name)
    names = ["".join(wrapped(look.name, NAME * scale(), letters(), 1)) for look in down.values()]
    named_columns, named_rows = not places_of(across)[1], not places_of(down)[1]
    widest = max(width_of(look.name, letters()) for look in across.values())
    narrow = NARROW * scale()
    cell = max(narrow, (min(widest, NAME_WIDTH if named_columns else np.inf) + letters()) / 72)  # inches
    high = max(ROW * scale() * len(names), 0.75)
    size = min(max(cell * len(across), 2.4), LARGEST[0]), high if named_rows else min(high, LARGEST[1])
    left = 0.55 + max(width_of(name, letters()) for name in names) / 72 / scale()
    panels = [(part, k, found[0][k]) for part, found in zip(parts, maps, strict=True) for k in range(len(measured))]
    called = [_name_of(results, measure) for measure in measured]
    captions = [called[k] for _, k, *_ in panels]
    worlds = [", ".join(filter(None, (part.row, part.caption))) for part, *_ in panels if len(parts) > 1]
    if z and worlds:  # panels of one measure are a table of worlds
        worlds, captions = rows_of(parts), [part.caption for part in parts]
    axes = sheet(
        captions, title, rows=worlds, size=size, least=LINE / ROW, left=left, key=False,
        fewer="choose z, such as convergence_error",
    )  # fmt: skip
    wide, tall = (float(side) / axes[0].figure.dpi for side in axes[0].bbox.size)
    numbered = wide >= narrow * len(across) and tall >= LINE * scale() * len(names)
    texts, columns = [look.name.removeprefix(OFF) for look in across.values()], _labelled(len(across), wide / cell)
    lines = _labelled(len(names), np.inf if named_rows else 1.01 * tall / (LINE * scale()))
    every = np.stack([values for values, *_ in maps], axis=1)  # (measure, panel, y, x)
    colours = [_colours_of(*each) for each in zip(measured, called, every, strict=True)]
    for (_, k, values), place in zip(panels, axes, strict=True):
        shades, text, _ = colours[k]
        _draw_cells(place, values, shades, text if numbered else None)
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
    of_k = [results] if "convergence_round" in shown else []
    says_so, blank = any(misled for _, misled, _ in maps), any(lacks for *_, lacks in maps)
    remarks = [hidden_tail(results, shown, "z"), misleading(of_k), on_edges([results], shown), BLANK * blank]
    remarks.append(UNCOLOURED if says_so else unlearnt([results], shown, "it counts as never"))
    entries: dict[str, Artist] = {strip.longest: strip for *_, strip in colours if strip}
    entries |= {why: Patch(color=GREY) for why, there in ((UNCOLOURED, says_so), (BLANK, blank)) if there}
    add_key(axes, "", entries, below=True)
    return captioned(axes, heatmap, [results], remarks, [f"Colours: {'; '.join(called)}."])


def _maps(
    results: xr.Dataset, x: str, y: str, across: Sequence[str], down: Sequence[str], measured: Sequence[Measure]
) -> tuple[Floats, bool, bool]:
    """The numbers of each measure in a world, (measure, y, x), whether some are left out, and whether some lack.

    Shares are in %. Numbers that say nothing of robots that settle are left out.
    """
    texts, downwards = texts_of(results, x), texts_of(results, y)
    grid = [(text, value) for text in across for value in dict.fromkeys(downwards[texts == text].tolist())]
    groups = [np.flatnonzero((texts == text) & (downwards == value)) for text, value in grid]
    found = [cells(results, measure.name, groups, intervals=False).value for measure in measured]
    early, unmoved = settled_far_off(results, opinions=True), never_learnt(results, groups)
    numbers = np.full((len(measured), len(down), len(across)), np.nan)
    misled = False
    for (text, value), group, still, *of_cell in zip(grid, groups, unmoved, *found, strict=True):
        at = ..., down.index(value), across.index(text)
        nothing = {*(QUANTITIES_AT_K if still else ()), *(("convergence_round",) if early[group].any() else ())}
        says = np.array([np.nan if m.name in nothing else 100.0 if m.share else 1.0 for m in measured])
        numbers[at], misled = says * np.array(of_cell), misled or bool(np.isnan(says).any())
    return numbers, misled, len(grid) < numbers[0].size or bool(np.isnan(found).any())


def _measure(results: xr.Dataset, z: str) -> Measure:
    """The measure of the only panel. Raises InputError."""
    known = measures.known(results)
    name = measures.name_of(results, z, known)
    if name not in known:
        raise wrong_option("z", z, f"{did_you_mean(z, known)}should be one of {', '.join(known)}")
    return known[name]


def _name_of(results: xr.Dataset, measure: Measure) -> str:
    """What a panel shows, with its unit."""
    unit = unit_of(results).split()[-1] if measure.unit == "rounds" else "%" if measure.share else measure.unit
    return f"{measure.statistic} {measure.label}" + f" ({unit})" * (unit != "1")


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


def _colours_of(
    measure: Measure, name: str, values: Floats
) -> tuple[ScalarMappable, Callable[[float], str], Strip | None]:
    """The colours of a measure's numbers in all panels, how they are written, and the colour bar if there are any.

    Raises InputError if some are infinite.
    """
    if np.isinf(values).any():
        why = f"{measure.label} is infinite in some cells, so its colours have no end: draw it with lines"
        raise wrong_option("z", measure.name, why)
    known = values[np.isfinite(values)]
    ends: dict[str, Any] = {"vmin": known.min(), "vmax": known.max()} if known.size else {"vmin": 0.0, "vmax": 1.0}
    norm = Normalize(**ends) if measure.share else AsinhNorm(0.01 if measure.unit == "1" else 1.0, **ends)
    shades = mpl.colormaps["viridis_r" if measure.low else "viridis"].with_extremes(bad=GREY)
    text = partial(
        fixed, decimals=1 if measure.share else 0 if measure.unit != "1" else 3 if ends["vmax"] >= 0.1 else 4
    )
    low, high = ("best", "worst") if measure.low else ("worst", "best")
    lines = [f"{text(ends['vmax'])} {high}", name, f"{text(ends['vmin'])} {low}"]
    strip = Strip([to_hex(shade) for shade in shades(np.linspace(1, 0, 65))], lines)
    return ScalarMappable(norm, shades), text, strip if known.size else None


def _draw_cells(axes: Axes, values: Floats, shades: Any, text: Callable[[float], str] | None) -> None:
    """Draw the cells of a panel, perhaps with numbers."""
    image = axes.imshow(values, cmap=shades.cmap, norm=shades.norm, aspect="auto", origin="lower")
    red, green, blue, _ = np.moveaxis(image.to_rgba(values), -1, 0)
    bright = 0.2126 * red**2.2 + 0.7152 * green**2.2 + 0.0722 * blue**2.2 > 0.18  # WCAG: black reads better
    style: dict[str, Any] = {"ha": "center", "va": "center", "fontsize": letters() - 1}
    if not text:
        return
    for row, column in np.argwhere(np.isfinite(values)):
        axes.text(column, row, text(values[row, column]), color="black" if bright[row, column] else "white", **style)
