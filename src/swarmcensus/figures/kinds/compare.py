"""Forest plot: differences between brains and one of them, with intervals."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Unpack

import numpy as np
import xarray as xr
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.ticker import FuncFormatter, MaxNLocator
from numpy.typing import NDArray

from swarmcensus.analysis import Effect, comparison, effects, in_worlds_too_few, too_few
from swarmcensus.figures.axes import short
from swarmcensus.figures.captions import NEVER, captioned, on_edges, unlearnt, with_numbers
from swarmcensus.figures.coordinates import caption_of
from swarmcensus.figures.lettering import SPACING, width_of, wrapped
from swarmcensus.figures.page import PageOptions, letters, on_page, page, scale
from swarmcensus.figures.panels import Names
from swarmcensus.figures.sheets import Own, add_key, layout, name_axes, say_empty, sheet, show_range, tick
from swarmcensus.figures.styles import Look, add_dots, key_mark, looks_of_contenders, outlined_dot
from swarmcensus.support.errors import InputError
from swarmcensus.support.formatting import counted
from swarmcensus.support.intervals import Floats
from swarmcensus.worlds import MOVING

MOST_ROWS = 40
NUMBERLESS = "no pair of trials has numbers"
APART = "\u2003"  # a wide space, which SVG does not shorten
SIZE = 5.0  # points: a dot
WIDE, LINE = 2.7, 0.15  # inches: a panel's width, and a contender's height in a row
NAME = 150.0  # points: the width of a row's name, which may take two lines
NAME_SHARE = 0.33  # of a page's width, the most that names take
STRANGE = (
    "some are told apart although the interval holds 0: the test is of signed ranks of the trials' differences, the "
    "interval of their median or mean"
)
SPREAD = 40.0  # ratio of the largest number to the median difference from which on the axis is not linear


@on_page
def compare(
    results: xr.Dataset,
    *,
    metric: Names = None,
    factor: Names = None,
    against: str | None = None,
    by: Names = None,
    title: str | None = None,
    ax: Own = None,
    **more: Unpack[PageOptions],
) -> Figure:
    """Draw the differences that `sc.compare` finds between brains, or levels of a factor, with their 95 % intervals.

    Each measure has a panel, and each world a row. A row has a dot for each contender: its value minus that of the
    contender `against`. Full dots mean a significant difference, after correction for all tests. An arrow at the edge
    is an infinite difference. If there is only one row, each contender gets a row of its own.

    - `metric`: measures, as in `sc.compare`; by default the usual ones.
    - `factor`: coordinates that are compared, as in `sc.compare`; by default brains.
    - `against`: the contender that others are compared with; by default the study's first.
    - `by`: coordinates. Worlds with equal values in these are pooled into one row: each trial then counts with the
      median of its differences in these worlds, or the mean of shares. An empty list pools all worlds.
    - `title`: the title of the figure.
    - `ax`: axes of your own, one for each measure. Leave room for the names of rows on their left.
    - `width`, `height`, `font_size`, `labels`: the page, and names of brains (see `PageOptions`).

    Raises InputError as `sc.compare` does, for more than 40 rows and for coordinates in which worlds do not differ.
    """
    standings = comparison.compare(results, metric or (), against=against, factor=factor or ())
    worlds = standings.grid.worlds
    by = [by] if isinstance(by, str) else by
    if by is None and len(worlds) > MOST_ROWS:
        differ = ", ".join(dict.fromkeys(name for world in worlds for name in world))
        many = f"{len(worlds):,} worlds are more than the {MOST_ROWS} rows that have room"
        raise InputError(f"{many}: pool them with by, or select some; they differ in {differ}", key="by")
    reference = standings.against or 0
    rows, every = effects(standings, reference, by)
    few = in_worlds_too_few(standings.contests)
    if by is not None:  # other tests: one for each row, contender and measure
        tests = sum(int((~np.isnan(effect.value)).sum()) for effect in every)
        few = too_few(int(standings.contests[0].trials.max()), tests, "compare fewer measures or rows")
    if len(rows) > MOST_ROWS:
        many = f"{counted(len(rows), 'row')} are more than the {MOST_ROWS} that have room"
        raise InputError(f"{many}: name other coordinates by", key="by")
    others = [k for k in range(len(standings.contenders)) if k != reference]
    every_look = list(looks_of_contenders(standings.contenders, standings.grid.factor, [results]).values())
    looks = [every_look[k] for k in others]
    every_world = f"all {counted(len(worlds), 'world')}" * (len(worlds) > 1)
    texts = [
        caption_of(world) + f" ({counted(count, 'world')})" * (count > 1) if world else every_world
        for world, count in rows
    ]
    single = len(rows) == 1
    caption = f", {texts[0]}" if single and texts[0] else ""
    if single:  # contenders are the rows
        texts = [look.name for look in looks]
    room = min(NAME * scale(), 72 * NAME_SHARE * (page().width or np.inf))
    labels = ["\n".join(wrapped(text, room, letters(), 2)) for text in texts]
    longest = max(width_of(line, letters()) for text in labels for line in text.split("\n"))
    least = 0.28 if any("\n" in text for text in labels) else 0.2
    row = scale() * max(LINE * (1 if single else len(looks)) + 0.08, least)
    has = [not np.isnan(effect.value[:, others]).all() for effect in every]
    kept, numberless = with_numbers(ax, [effect.measure.label for effect in every], has, NUMBERLESS)
    drawn = [every[k] for k in kept]
    captions = [effect.measure.label + caption for effect in drawn]
    left, size = scale() * 0.25 + longest / 72, (scale() * WIDE, row * len(labels) + 0.1)
    wide = layout(len(drawn), size=size, left=left).wide
    shown = [
        (100.0 if effect.measure.share else 1.0) * np.stack([effect.value, effect.low, effect.high])[..., others]
        for effect in drawn
    ]
    bends = [_bend(*parts) for parts in shown]
    ticks = standings.grid.common.get("topology") == MOVING
    names = [_axis_name(effect, wide, bend, ticks) for effect, bend in zip(drawn, bends, strict=True)]
    lines = max(name.count("\n") for name in names) if ax is None else 0
    below = 0.05 + lines * SPACING * (letters() + 1) / 72
    axes = sheet(ax, captions, title, size=size, left=left, below=below, fewer="name one metric")
    for place, effect, name, bend, (value, low, high) in zip(axes, drawn, names, bends, shown, strict=True):
        apart = effect.apart[:, others]
        if np.isnan(value).all():
            say_empty(place, NUMBERLESS)
            continue
        _difference_axis(place, bend, value, low, high)
        for k, look in enumerate(looks):
            aside = float(k) if single else (k - (len(looks) - 1) / 2) * 0.72 / len(looks)
            y: Floats = np.arange(1.0 if single else len(labels)) + aside
            _draw(place, y, value[:, k], low[:, k], high[:, k], apart[:, k], look)
        for edge in np.arange(1, len(labels)) - 0.5:
            place.axhline(edge, color="0.9", linewidth=0.6, zorder=0)
        place.axvline(0.0, color="0.45", linewidth=0.8, zorder=1)
        place.set_ylim(len(labels) - 0.5, -0.5)
        leftmost = not place.get_label()  # panels with a left neighbour have the label INNER
        place.set_yticks(range(len(labels)), labels if leftmost else [""] * len(labels), parse_math=False)
        name_axes(place, name, "")
        place.tick_params(axis="y", length=0)
        place.spines["left"].set_visible(False)
    against = every_look[reference].name.replace("$", r"\$")
    add_key(axes, f"difference from {against}", _entries([] if single else looks, drawn, others))
    measures = [effect.measure.name for effect in drawn]
    strange = any((effect.apart & (effect.low <= 0) & (effect.high >= 0))[:, others].any() for effect in drawn)
    remarks = [numberless, few, on_edges([results], measures), unlearnt([results], measures, NEVER)]
    return captioned(axes, compare, [results], [*remarks, STRANGE * strange])


def _axis_name(effect: Effect, wide: float, bend: float, ticks: bool) -> str:
    """The name of a measure's axis of `wide` inches: what it is, which way is better, and where it is not linear."""
    unit = "points of %" if effect.measure.share else "" if effect.measure.unit == "1" else effect.measure.unit
    unit = "ticks" if unit == "rounds" and ticks else unit
    better, worse = ("← better", "worse →") if effect.measure.low else ("← worse", "better →")
    measure = effect.measure.label + f" ({unit})" * bool(unit)
    name = f"{better}{APART}Δ {measure}{APART}{worse}"
    name = name if width_of(name, letters() + 1) <= 72 * wide else f"Δ {measure}\n{better}{APART}{worse}"
    return f"{name}\nlogarithmic beyond ±{short(bend)}" if np.isfinite(bend) else name


def _entries(looks: Sequence[Look], effects: Sequence[Effect], others: Sequence[int]) -> dict[str, Artist]:
    """The entries of the key."""
    entries: dict[str, Artist] = {look.name: _dot(look, True) for look in looks if look.name}
    apart = np.concatenate([effect.apart[:, others][~np.isnan(effect.value[:, others])] for effect in effects])
    grey = Look("", "", "0.4", "o")
    if apart.any():
        entries["told apart (signed ranks, corrected)"] = _dot(grey, True)
    if not apart.all():
        entries["not told apart"] = _dot(grey, False)
    if any(np.isfinite(effect.low).any() for effect in effects):
        entries["95 % interval, not corrected"] = Line2D([], [], color="0.4", linewidth=1.2)
    if any(np.isinf(effect.value).any() for effect in effects):
        entries["infinite"] = key_mark(">", SIZE, "0.4")
    return entries


def _dot(look: Look, apart: bool) -> Line2D:
    return outlined_dot(look, SIZE, 0.6, hollow=0.0 if apart else 1.2)


def _bend(value: Floats, *ends: Floats) -> float:
    """The size of differences beyond which their axis is logarithmic, if few are large; infinite if it is linear."""
    sizes = np.abs(value[np.isfinite(value) & (value != 0)])
    most = max((float(np.abs(part[np.isfinite(part)]).max(initial=0.0)) for part in (value, *ends)), default=0.0)
    if not sizes.size or most < SPREAD * float(np.median(sizes)):
        return np.inf
    return float(f"{np.median(sizes):.0e}")


def _difference_axis(axes: Axes, bend: float, *numbers: Floats) -> None:
    """Give the axes an x axis with 0 on it for differences and the ends of their intervals, logarithmic beyond `bend`.

    An axis that is not linear has as many ticks at 1, 2 and 5 times powers of ten as there is room for.
    """
    every = np.concatenate([part.ravel() for part in numbers])
    every = every[np.isfinite(every)]
    least, top = min(0.0, *every.tolist(), 0.0), max(0.0, *every.tolist(), 0.0)
    axes.xaxis.set_major_locator(MaxNLocator(5, steps=[1, 2, 5, 10]))
    if np.isfinite(bend):
        axes.set_xscale("asinh", linear_width=bend)
        show_range(axes, "x", 1.5 * least - 0.3 * bend, 1.5 * top + 0.3 * bend)
        decades = 10.0 ** np.arange(np.floor(np.log10(bend)), np.log10(max(top, -least)) + 1)
        sizes = np.outer([1.0, 5.0, 2.0], decades[::-1]).ravel()  # the coarsest first
        tick(axes, "x", [0.0, *np.stack([sizes, -sizes], axis=1).ravel().tolist()], short)
    else:
        room = 0.06 * (top - least) or 1.0
        show_range(axes, "x", least - room, top + room)
    axes.xaxis.set_major_formatter(FuncFormatter(lambda value, _: short(value)))


def _draw(
    axes: Axes, y: Floats, value: Floats, low: Floats, high: Floats, apart: NDArray[np.bool_], look: Look
) -> None:
    """Draw one contender's differences in all rows, cut at the limits of the axes."""
    left, right = axes.get_xlim()
    ends = np.maximum(low, left), np.minimum(high, right)
    axes.hlines(y, *ends, colors=look.colour, linewidths=1.2, label=f"interval {look.name}", zorder=2)
    for significant, kind, inside in ((True, "apart", look.colour), (False, "level", "white")):
        if (rows := np.isfinite(value) & (apart == significant)).any():
            add_dots(axes, _dot(look, significant), value[rows], y[rows], zorder=3, label=f"{kind} {look.name}")
        for infinite, marker, edge in ((-np.inf, "<", 0.0), (np.inf, ">", 1.0)):
            if (rows := (value == infinite) & (apart == significant)).any():
                arrow = key_mark(marker, SIZE, look.colour, mfc=inside, transform=axes.get_yaxis_transform())
                places = np.full(rows.sum(), edge), y[rows]
                add_dots(axes, arrow, *places, clip_on=False, label=f"infinite {look.name}", zorder=3)
