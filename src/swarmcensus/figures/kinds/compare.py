"""Forest plot: differences between brains and one of them, with intervals."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Mapping, Sequence
from typing import NamedTuple, Unpack

import numpy as np
import xarray as xr
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.ticker import FixedLocator, MaxNLocator
from numpy.typing import NDArray

from swarmcensus.analysis import Effect, comparison, effects, in_worlds_too_few
from swarmcensus.figures.axes import Numbers, short, tick
from swarmcensus.figures.captions import NEVER, captioned, on_edges, unlearnt, with_numbers
from swarmcensus.figures.coordinates import Names, caption_of, check_worlds, listed
from swarmcensus.figures.page import PageOptions, letters, on_page, page, scale, width_of, wrapped
from swarmcensus.figures.sheets import add_key, name_axes, sheet
from swarmcensus.figures.styles import Look, add_dots, looks_of_contenders, outlined_dot, shifted
from swarmcensus.support.errors import InputError
from swarmcensus.support.intervals import Floats
from swarmcensus.worlds import MOVING

MOST_ROWS = 24  # of a panel, or as many as a page has lines for; others are in the next one
MANY_SHARE = 0.42  # the same of names of many contenders, in one line each
MOST_TOGETHER = 8  # contenders in a row; more have a row each
SQUEEZED = 0.85  # the share of its height that a row has at least
NUMBERLESS = "no pair of trials has a difference"
ENDLESS = ((-np.inf, "<", 0.0, "infinitely less"), (np.inf, ">", 1.0, "infinitely more"))  # each with its sign and edge
BOTH_NEVER = "no dot: half of the trials or more of both never come to it"
APART = "\u2003"  # a wide space, which SVG does not shorten
SIZE = 5.0  # points: a dot
WIDE, LINE = 2.7, 0.15  # inches: a panel's width, and a contender's height in a row
AROUND, ENTRY = 1.2, 0.2  # inches: about the height of what is around a panel, and of an entry of a key
NAME = 150.0  # points: the width of a row's name, which may take two lines
NAME_SHARE = 0.33  # of a page's width, the most that names take
SPREAD = 40.0  # ratio of the largest number to the median difference from which on the axis is not linear


@on_page
def compare(
    results: xr.Dataset,
    *,
    metric: Names = None,
    factor: Names = None,
    against: str | None = None,
    rows: Names = None,
    cols: Names = None,
    title: str | None = None,
    **more: Unpack[PageOptions],
) -> Figure:
    """Draw the differences between brains, or levels of a factor.

    Each measure has a panel, and each world a row. A row has a dot for each contender: its value minus that of the
    contender `against`. A line through a dot is its 95 % interval over trials, not corrected. Full dots mean a
    significant difference, after correction for all tests. A triangle at the edge is an infinite difference; there is
    no dot where both medians are infinite. If there is only one row, or more than 9 contenders, each contender has a
    row of its own, and each world a panel.

    - `metric`: measures, as in `sc.compare`; by default the usual ones.
    - `factor`: coordinates that are compared, as in `sc.compare`; by default brains.
    - `against`: the contender that others are compared with; by default the study's first.
    - `rows`, `cols`: the coordinates of worlds that have panels of their own, in rows and in columns.
    - `title`: the title of the figure.
    - `width`, `height`, `font_size`, `labels`: the page, and names of brains (see `PageOptions`).

    Raises InputError as `sc.compare` does, and for rows or columns in which worlds do not differ.
    """
    standings = comparison.compare(results, metric or (), against=against, factor=factor or ())
    worlds = standings.grid.worlds
    reference = standings.against or 0
    every, remark = effects(standings, reference), ""
    for k, contest in enumerate(standings.contests):
        endless = np.isinf(contest.values) & np.isinf(contest.values[:, [reference]])
        never = endless & (every[k].value == 0)
        every[k] = every[k]._replace(value=np.where(never, np.nan, every[k].value))
        remark = BOTH_NEVER if never.any() else remark
    others = [k for k in range(len(standings.contenders)) if k != reference]
    every_look = list(looks_of_contenders(standings.contenders, standings.grid.factor, [results]).values())
    looks = [every_look[k] for k in others]
    check_worlds(worlds, rows, cols)
    sides = listed(rows) or [], listed(cols) or []
    in_panels = defaultdict[tuple[str, str], dict[int, str]](dict)  # the rows of worlds, by the texts of both sides
    for k, world in enumerate(worlds):
        text = caption_of({name: value for name, value in world.items() if name not in (*sides[0], *sides[1])})
        down, over = (caption_of({name: world[name] for name in side if name in world}) for side in sides)
        in_panels[down, over][k] = text
    # each contender has a row
    apart_from_others = max(map(len, in_panels.values())) == 1 or len(others) > MOST_TOGETHER
    of_contenders = [look.name for look in looks] if apart_from_others else []
    many, dots = apart_from_others and len(looks) > MOST_TOGETHER, 1 if apart_from_others else len(looks)
    lines = ((page().height or page().highest) / scale() - AROUND - ENTRY * dots) / max(LINE * dots, 0.2)
    most = int(np.clip(lines / 0.75 / SQUEEZED, 1, MOST_ROWS))
    blocks = [block for at, texts in in_panels.items() for block in _blocks(*at, texts, of_contenders, most)]
    room = min(NAME * scale(), 72 * (MANY_SHARE if many else NAME_SHARE) * (page().width or np.inf))
    labels = [["\n".join(wrapped(text, room, letters(), 2 - many)) for text in block.names] for block in blocks]
    longest = max(width_of(line, letters()) for block in labels for text in block for line in text.split("\n"))
    least = 0.28 if any("\n" in text for block in labels for text in block) else 0.2
    tall = scale() * (LINE if many else max(LINE * dots + 0.08, least))
    has = [not np.isnan(effect.value[:, others]).all() for effect in every]
    if not any(has):
        raise InputError(f"nothing to draw: {NUMBERLESS}")
    numberless, drawn = with_numbers([effect.measure.label for effect in every], has, NUMBERLESS, every)
    panels = [(block, names, k) for block, names in zip(blocks, labels, strict=True) for k in range(len(drawn))]
    single, highs = len(blocks) == 1, [tall * len(names) + 0.1 for _, names, _ in panels]
    parts = [(drawn[k].measure.label, block.column, block.caption * single) for block, _, k in panels]
    captions = [", ".join(filter(None, each)) for each in parts]
    axes = sheet(
        captions, title, rows=[] if single else [block.caption for block, _, _ in panels],
        size=(scale() * WIDE, highs[0] if single else highs), least=SQUEEZED,
        left=0.25 + longest / 72 / scale(), fewer="name one metric",
    )  # fmt: skip
    shown = [(100.0 if effect.measure.share else 1.0) * np.stack(effect[1:4])[..., others] for effect in drawn]
    bends = [_bend(*parts) for parts in shown]
    ticks, wide = standings.grid.common.get("topology") == MOVING, axes[0].bbox.width / axes[0].figure.dpi
    for place, (block, names, which) in zip(axes, panels, strict=True):
        effect, bend = drawn[which], bends[which]
        value, low, high = (part[block.rows] for part in shown[which])
        told_apart = effect.apart[block.rows][:, others]
        _difference_axis(place, bend, *shown[which])
        for row, k in enumerate(block.contenders or range(len(looks))):
            aside = (k - (len(looks) - 1) / 2) * 0.72 / len(looks)
            y: Floats = np.array([float(row)]) if block.contenders else np.arange(float(len(names))) + aside
            _draw(place, y, value[:, k], low[:, k], high[:, k], told_apart[:, k], looks[k])
        for edge in np.arange(1, len(names)) - 0.5:
            place.axhline(edge, color="0.9", linewidth=0.6, zorder=0)
        place.axvline(0.0, color="0.45", linewidth=0.8, zorder=1)
        place.set_ylim(len(names) - 0.5, -0.5)
        place.set_yticks(range(len(names)), names, parse_math=False)
        name_axes(place, _axis_name(effect, wide * (1.0 if single else 0.9), bend, ticks), "")
        place.tick_params(axis="y", length=0)
        place.spines["left"].set_visible(False)
    against = every_look[reference].name.replace("$", r"\$")
    add_key(axes, f"difference from {against}", _entries([] if apart_from_others else looks, drawn, others))
    measures = [effect.measure.name for effect in drawn]
    remarks = [numberless, remark, in_worlds_too_few(standings.contests)]
    remarks += [on_edges([results], measures), unlearnt([results], measures, NEVER)]
    return captioned(axes, compare, [results], remarks, [f"Differences are from {every_look[reference].name}."])


class _Block(NamedTuple):
    """A panel's rows: their names, the rows of effects that are drawn, or one and the contenders drawn, captions."""

    names: list[str]
    rows: list[int]
    contenders: list[int]
    caption: str
    column: str


def _blocks(row: str, column: str, worlds: Mapping[int, str], contenders: Sequence[str], most: int) -> list[_Block]:
    """The panels of each measure: one for each world if contenders have rows; else one for worlds that fit a page."""
    names = contenders or [*worlds.values()]
    portions = [part.tolist() for part in np.array_split(np.arange(len(names)), -(-len(names) // most))]
    blocks = []
    for world, text in worlds.items() if contenders else ((-1, ""),):
        for part in portions:
            some = f"{part[0] + 1} to {part[-1] + 1} of {len(names)} rows" * (not contenders and len(portions) > 1)
            caption = ", ".join(filter(None, (row, text, some)))
            drawn = [world] if contenders else [[*worlds][k] for k in part]
            blocks.append(_Block([names[k] for k in part], drawn, part if contenders else [], caption, column))
    return blocks


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
        entries["told apart (ranks and signs, corrected)"] = _dot(grey, True)
    if not apart.all():
        entries["not told apart"] = _dot(grey, False)
    if any((effect.low < effect.high)[:, others].any() for effect in effects):
        entries["95 % interval, not corrected"] = Line2D([], [], color="0.4", linewidth=1.2)
    for endless, marker, _, name in ENDLESS:
        if signs := [effect.apart[effect.value == endless].any() for effect in effects if endless in effect.value]:
            entries[name] = _dot(grey._replace(marker=marker), any(signs))
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
    axes.xaxis.set_major_locator(MaxNLocator(5, steps=[1, 2, 5, 10]) if least < top else FixedLocator([0.0]))
    if np.isfinite(bend):
        axes.set_xscale("asinh", linear_width=bend)
        axes.set_xlim(1.5 * least - 0.3 * bend, 1.5 * top + 0.3 * bend)
        decades = 10.0 ** np.arange(np.floor(np.log10(bend)), np.log10(max(top, -least)) + 1)
        sizes = np.outer([1.0, 5.0, 2.0], decades[::-1]).ravel()  # the coarsest first
        tick(axes, "x", [0.0, *np.stack([sizes, -sizes], axis=1).ravel().tolist()], short)
    else:
        room = 0.06 * (top - least) or 1.0
        axes.set_xlim(least - room, top + room)
    axes.xaxis.set_major_formatter(Numbers())


def _draw(
    axes: Axes, y: Floats, value: Floats, low: Floats, high: Floats, apart: NDArray[np.bool_], look: Look
) -> None:
    """Draw one contender's differences in all rows, cut at the limits of the axes."""
    left, right = axes.get_xlim()
    ends = np.maximum(low, left), np.minimum(high, right)
    axes.hlines(y, *ends, colors=look.colour, linewidths=1.2, label=f"interval {look.name}", zorder=2)
    for significant, kind in ((True, "apart"), (False, "level")):
        if (rows := np.isfinite(value) & (apart == significant)).any():
            add_dots(axes, _dot(look, significant), value[rows], y[rows], zorder=3, label=f"{kind} {look.name}")
        for endless, marker, edge, _ in ENDLESS:
            if (rows := (value == endless) & (apart == significant)).any():
                within = shifted(axes.get_yaxis_transform(), axes, 2 * SIZE * (0.5 - edge))
                sign = _dot(look._replace(marker=marker), significant)
                places = np.full(rows.sum(), edge), y[rows]
                add_dots(axes, sign, *places, transform=within, label=f"infinite {look.name}", zorder=3)
