"""The layout that all figures share: panels in rows and columns, their captions, a key, and pages.

A kind draws into panels of a usual size. `add_key` then measures once what stands around them, and gives all their
places. What a page has no room for is on further pages, of which `pages_of` knows the parts.
"""

from __future__ import annotations

import re
import string
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Any, Literal, NamedTuple
from weakref import WeakKeyDictionary

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.legend import Legend
from matplotlib.transforms import Bbox

from swarmcensus.figures.page import (
    RENDERING,
    SHEET,
    SPACING,
    caption_letters,
    letters,
    page,
    scale,
    title_letters,
    width_of,
    wrapped,
)
from swarmcensus.support.errors import InputError
from swarmcensus.support.options import wrong_option

Scale = Literal["log", "log-y", "linear"]  # both axes are logarithmic, only the y axis, neither
Own = Axes | Sequence[Axes] | None  # the caller's axes, one per panel; None: a new figure
Place = tuple[int, int]  # row and column

MOST_PANELS, MOST_COLUMNS = 120, 6
# Inches, with letters of the usual size:
LEFT = 0.65  # about the room for the y axis and its name
KEY = 1.6  # the room for a key on the right
EDGE = 0.1  # around all
GAP = 0.14  # between panels with all that belongs to them
INNER = 0.07  # under or beside a panel that shares the axis of its neighbour
LEAST, LEAST_OF_GRID = 1.75, 1.3  # the width of a panel that a page of given width may have
NARROWEST = 0.8  # the same if there is a single column
LOWEST = 0.6  # of its usual height that a panel has at least, so that all fit a page
TALLEST = 1.35  # the same at most, so that a key fits
POOLED = "select some of the settings, draw all into one with cols=[]"  # advice on how to get fewer panels
UNRUN = "no trial has been run"
NOTHING = "nothing to draw: no trial of these settings has been run"


class Part(NamedTuple):
    """A page of a figure: its place on the figure in inches, and what stands on it."""

    box: Bbox
    artists: list[Artist]


@dataclass
class Sheet:
    """Panels of a figure before they have their places."""

    axes: dict[Place, Axes]
    captions: dict[Place, str]
    rows: list[str]  # labels of rows, if columns have the captions
    wide: float
    high: list[float]  # of each row
    least: float | None  # share of the height that panels have at least; None: it follows from what is in them
    key_right: bool
    title: str
    math: bool


_SHEETS: WeakKeyDictionary[Figure, Sheet] = WeakKeyDictionary()
_PARTS: WeakKeyDictionary[Figure, list[Part]] = WeakKeyDictionary()


def pages_of(figure: Figure) -> list[Part]:
    """The pages of a figure that is higher than a page; none if one has room for all."""
    return _PARTS.get(figure, [])


def sheet(
    ax: Own,
    captions: Sequence[str],
    title: str | None,
    *,
    rows: Sequence[str] = (),
    size: tuple[float, float | Sequence[float]] | None = None,
    least: float | None = LOWEST,
    left: float = LEFT,
    key: bool = True,
    columns: int | None = None,
    math: bool = False,
    fewer: str = "select some of the settings",
) -> list[Axes]:
    """Return panels with these captions: the caller's own axes, or a new figure with room for a key.

    - `rows`: the label of each panel's row. Panels with the same caption then stand in a column, if columns have room.
    - `size`: a panel's width in inches, and its height, or that of each panel (the default depends on their number).
    - `least`: the share of the height that is left if a page has no room; None if it follows from what is in a panel.
    - `left`: about the room for the y axis, in inches with letters of the usual size.
    - `key`: whether there will be one on the right; `columns`: the most columns.
    - `math`: whether text between dollar signs in captions is a formula.

    A title is the caption of the caller's single axes, and stands over the figure of several. Raises InputError for no
    panel, for more than 120, for a page too narrow, and if there are not as many axes as panels; the message says how
    to get `fewer` panels.
    """
    joined = [", ".join(filter(None, pair)) for pair in zip(rows, captions, strict=True)] if rows else [*captions]
    if ax is not None:
        own = own_axes(ax, len(captions), fewer)
        if title and len(own) > 1:
            own[0].figure.suptitle(title, fontsize=title_letters(), parse_math=False)
        if title is None or len(own) > 1 or not title:
            _caption(own, joined, own[0].bbox.width / own[0].figure.dpi, math=math)
        else:
            _caption(own, [title], own[0].bbox.width / own[0].figure.dpi)
        return own
    if not 1 <= len(captions) <= MOST_PANELS:
        raise InputError(f"a figure holds 1 to {MOST_PANELS} panels, not {len(captions)}: {fewer}")
    places, wide, key_right, turned = _places(captions, rows, size[0] if size else None, scale() * left, key, columns)
    count, times = 1 + max(column for _, column in places), scale()
    usual = _usual(len(captions))
    wide_of_page = page().width or scale() * left + count * wide + (count - 1) * times * GAP + times * KEY
    high = size[1] if size else wide * usual[1] / usual[0]
    figure = Figure(figsize=(wide_of_page, 6.0))
    FigureCanvasAgg(figure)
    figure.set_gid(SHEET)
    axes = [
        figure.add_axes(
            ((times * left + column * (wide + times * GAP)) / wide_of_page, 0.1, wide / wide_of_page, tall / 6.0)
        )
        for (_, column), tall in zip(places, _each(high, len(places)), strict=True)
    ]
    over, aside = (rows, captions) if turned else (captions, rows)
    named = dict(zip(places, joined if turned is None else over, strict=True))
    for one, name in zip(axes, joined, strict=True):
        one.set_label(name)  # what captions of files say
    highs = {row: tall for (row, _), tall in zip(places, _each(high, len(places)), strict=True)}
    labels = {} if turned is None else {row: text for (row, _), text in zip(places, aside, strict=True)}
    _SHEETS[figure] = Sheet(
        dict(zip(places, axes, strict=True)), named, [labels[row] for row in sorted(labels)], wide,
        [highs[row] for row in sorted(highs)], least, key_right, title or "", math,
    )  # fmt: skip
    return axes


def _each(value: float | Sequence[float], count: int) -> list[float]:
    return [value] * count if isinstance(value, int | float) else list(value)


def _usual(count: int) -> tuple[float, float]:
    """The usual width and height of one of so many panels, in inches with letters of the usual size."""
    columns = _usual_columns(count)
    return (4.4, 3.2) if count == 1 else (3.1, 2.4) if columns <= 3 else (2.5, 1.9)


def _usual_columns(count: int) -> int:
    return count if count <= 3 else {4: 2, 5: 3, 6: 3, 9: 3}.get(count, 4)


def _places(
    captions: Sequence[str], rows: Sequence[str], wide: float | None, left: float, key: bool, most: int | None
) -> tuple[list[Place], float, bool, bool | None]:
    """The row and column of each panel, the width of a panel in inches, and whether the key is on its right.

    The last value says whether rows are columns, so that all fit; None if there are no rows with labels.
    """
    times, width = scale(), page().width
    over, down = [*dict.fromkeys(captions)], [*dict.fromkeys(rows)]
    grid = [(down.index(row), over.index(text)) for row, text in zip(rows, captions, strict=True)] if rows else []
    usual = wide or times * _usual(len(captions))[0]
    right = times * (KEY if key else EDGE)

    def fits(columns: int, margin: float) -> float:
        return usual if width is None else (width - left - margin - (columns - 1) * times * GAP) / columns

    tries = [(len(over), grid, False), (len(down), [(column, row) for row, column in grid], True)] if grid else []
    for columns, places, turned in tries:
        for margin in (right, times * EDGE):
            if columns <= MOST_COLUMNS and fits(columns, margin) >= times * LEAST_OF_GRID:
                return places, fits(columns, margin), key and margin == right, turned
    last = min(most or _usual_columns(len(captions)), len(captions))
    tried = [(n, fits(n, margin), margin) for n in range(last, 0, -1) for margin in (right, times * EDGE)]
    columns, wide, margin = next((one for one in tried if one[1] >= times * LEAST), tried[-1])
    return [divmod(k, columns) for k in range(len(captions))], wide, key and margin == right, None


def own_axes(ax: Axes | Sequence[Axes], panels: int, fewer: str) -> list[Axes]:
    """The caller's axes as a list. Raises InputError if there is not one for each panel."""
    own: list[Axes] = np.ravel(np.asarray(ax, object)).tolist()
    if strange := next((type(each).__name__ for each in own if not hasattr(each, "get_figure")), None):
        raise InputError.at("ax", strange, "should be matplotlib Axes, or a list of them")
    if len(own) != panels and panels == 1:
        raise InputError(f"ax has {len(own)} axes, but this is one panel: give one of them", key="ax")
    if len(own) != panels:
        holds = "ax holds one panel" if len(own) == 1 else f"ax has {len(own)} axes"
        raise InputError(f"{holds}, not {panels}: {fewer}, or give a list of {panels} axes", key="ax")
    return own


def figure_of(axes: Sequence[Axes]) -> Figure:
    """The figure that these axes are on, which a kind of figure returns: a new one, or the caller's."""
    return axes[0].figure.canvas.figure


def figure_is_ours(axes: Axes) -> bool:
    """Whether axes are on a sheet that was made here, and not on the caller's figure."""
    return axes.figure.canvas.figure.get_gid() == SHEET


def _caption(
    axes: Sequence[Axes], captions: Sequence[str], room: float, pad: float = 0.0, *, math: bool = False
) -> None:
    """Write captions of at most `room` inches over panels, with (a), (b), ... if there are several."""
    for one, text in zip(axes, _lettered(captions), strict=True):
        lines = text if math else "\n".join(wrapped(text, 72 * room, caption_letters()))
        one.set_title(lines, loc="left", fontsize=caption_letters(), pad=6 + 72 * pad, parse_math=math)
        one.set_label(" ".join(text.split()))


def _lettered(captions: Sequence[str]) -> list[str]:
    if not 1 < len(captions) <= len(string.ascii_lowercase):
        return [*captions]
    return [f"({letter}) {text}" for letter, text in zip(string.ascii_lowercase, captions, strict=False)]


def name_axes(axes: Axes, x: str, y: str) -> None:
    """Write the axis labels, and hide the top and right spines."""
    axes.set_xlabel(x, fontsize=letters() + 1)
    axes.set_ylabel(y, fontsize=letters() + 1)
    axes.tick_params(labelsize=letters())
    axes.spines[["top", "right"]].set_visible(False)


def say_empty(axes: Axes, why: str = UNRUN) -> None:
    """Write into an empty panel of the caller why it is empty."""
    axes.text(0.5, 0.5, why, ha="center", transform=axes.transAxes, fontsize=letters() + 1)
    axes.set_axis_off()


def add_key(axes: Sequence[Axes], title: str, entries: dict[str, Artist], *, below: bool = False) -> None:
    """Give all panels their places, with one key that hides no data: to the right of the first row, or `below`.

    Everything else must have been drawn. Axes that neighbours share are named once, at the bottom and on the left.
    """
    figure: Any = figure_of(axes)
    for ax in axes:
        size = ax.bbox.size * 72 / figure.dpi
        for axis, room in zip((ax.xaxis, ax.yaxis), size, strict=True):
            name = axis.get_label_text()
            longest = max((_width(word, letters() + 1) for word in name.split() if "$" not in name), default=0.0)
            axis.label.set_text(_in_lines([name], max(longest, float(room)), letters() + 1)[0])
    if figure not in _SHEETS:
        _share({_own_place(ax, k): ax for k, ax in enumerate(axes)}, "y", own=True)
        _share({_own_place(ax, k): ax for k, ax in enumerate(axes)}, "x", own=True)
        if entries:
            _own_key(axes, title, entries)
        return
    with RENDERING:
        _Placing(figure, _SHEETS.pop(figure)).place(title, entries, below)


def _own_place(ax: Axes, k: int) -> Place:
    place = ax.get_subplotspec()
    return (place.rowspan.start, place.colspan.start) if place else (0, 2 * k)  # not next to each other


def _own_key(axes: Sequence[Axes], title: str, entries: dict[str, Artist]) -> None:
    places = [ax.get_subplotspec() for ax in axes]
    last = [ax for ax, place in zip(axes, places, strict=True) if place and place.is_last_col()]
    corner = last[0] if last else axes[-1]
    room = (corner.figure.bbox.width - corner.bbox.x0 - 1.02 * corner.bbox.width) * 72 / corner.figure.dpi
    room = max(room - 3 * letters(), 60.0)
    legend = corner.legend(
        list(entries.values()), _in_lines(entries, room), title=_in_lines([title], room)[0], loc="upper left",
        bbox_to_anchor=(1.02, 1.01), **_style(),
    )  # fmt: skip
    for text in legend.get_texts():
        text.set_parse_math(False)


def _style() -> dict[str, Any]:
    """The style of keys."""
    return {
        "borderaxespad": 0, "borderpad": 0, "frameon": False, "title_fontsize": letters(), "fontsize": letters(),
        "alignment": "left", "handlelength": 1.2,
    }  # fmt: skip


def _in_lines(names: Iterable[str], room: float, size: float = 0.0) -> list[str]:
    """Names in lines of at most `room` points; one with a formula breaks behind commas and before its unit."""
    size, fitted = size or letters(), []
    for name in names:
        lines: list[str] = []
        for line in name.split("\n"):
            parts = [line]
            if _width(line, size) > room and "$" in line.replace(r"\$", ""):
                formula, *parts = re.split(r" (?=\()|(?<=,) ", line)
                lines.append(formula)
            for part in parts:
                lines += wrapped(part, room, size) if _width(part, size) > room else [part]
        fitted.append("\n".join(lines))
    return fitted


def _width(name: str, size: float) -> float:
    return width_of(re.sub(r"[$\\{},]", "", name), size)  # a formula is no wider than its letters


def _share(axes: dict[Place, Axes], which: Literal["x", "y"], *, own: bool = False) -> None:
    """Leave out the names and numbers of y axes that a left neighbour has too, or of x axes that one below has.

    On the caller's own axes, these are left out only if they share the axis.
    """
    for ax in _inner(axes, which, own=own):
        (ax.set_xlabel if which == "x" else ax.set_ylabel)("")
        ax.tick_params(axis=which, **{"labelbottom" if which == "x" else "labelleft": False})


def _inner(axes: dict[Place, Axes], which: Literal["x", "y"], *, own: bool = False) -> list[Axes]:
    """The axes with a neighbour on the left, or below, that has the same y or x axis."""
    step = (1, 0) if which == "x" else (0, -1)
    found = []
    for (row, column), ax in axes.items():
        other = axes.get((row + step[0], column + step[1]))
        shared = ax.get_shared_x_axes() if which == "x" else ax.get_shared_y_axes()
        if other is not None and other.axison and (not own or shared.joined(ax, other)) and _alike(ax, other, which):
            found.append(ax)
    return found


def _alike(ax: Axes, other: Axes, which: Literal["x", "y"]) -> bool:
    one, two = (getattr(each, f"{which}axis") for each in (ax, other))
    if not np.allclose(one.get_view_interval(), two.get_view_interval()) or one.get_scale() != two.get_scale():
        return False
    texts = [[text.get_text() for text in axis.get_ticklabels()] for axis in (one, two)]
    return texts[0] == texts[1] and (which == "y" or one.get_label_text() == two.get_label_text())


class _Placing:
    """What stands around the panels of a sheet, in inches, and the places that follow from it."""

    def __init__(self, figure: Any, of: Sheet) -> None:
        self.figure, self.sheet, self.times = figure, of, scale()
        self.rows = 1 + max(row for row, _ in of.axes)
        self.columns = 1 + max(column for _, column in of.axes)
        _share(of.axes, "y")
        renderer, dpi = figure.canvas.get_renderer(), figure.dpi
        self.around: dict[Place, Any] = {}  # left, under, right and over each panel
        for place, ax in of.axes.items():
            box = ax.get_tightbbox(renderer, bbox_extra_artists=[*ax.texts, *ax.child_axes])
            box = ax.bbox if box is None else Bbox.union([box, ax.bbox])
            self.around[place] = (
                np.array([ax.bbox.x0 - box.x0, ax.bbox.y0 - box.y0, box.x1 - ax.bbox.x1, box.y1 - ax.bbox.y1]) / dpi
            )

    def place(self, title: str, entries: dict[str, Artist], below: bool) -> None:
        """Give all panels and the key their places, on as many pages as needed."""
        corner, width = self.sheet.axes[0, 0], page().width
        self.key: list[Legend] = []
        self.heading, self.entries = title, entries
        if (entries or title) and self.sheet.key_right and not below:
            self.key = self._key_right(corner)
        wide = self._wide()
        tallest = self.rows * max(self.sheet.high) * TALLEST + 0.5 * (self.rows - 1)
        if self.key and self._size(self.key[0])[1] > tallest and self.sheet.least is not None:
            self._forget_key()
            wide = self._wide()
        self.width = width or self._aside() + self.columns * wide
        if not self.key and (entries or title):
            self.key = self._key_below(corner)
        self._put(wide, self._heights(wide))

    def _forget_key(self) -> None:
        for key in self.key:
            key.remove()
        self.key, self.sheet.key_right = [], False

    def _most(self, side: int, *, row: int | None = None, column: int | None = None) -> float:
        """The most that stands at a side (0: left, 1: under, 2: right, 3: over) of the panels of a row or column."""
        return max(
            (
                float(all_sides[side])
                for (i, j), all_sides in self.around.items()
                if row in (None, i) and column in (None, j)
            ),
            default=0.0,
        )

    def _aside(self) -> float:
        """All inches of the width that are no panels."""
        gaps = [
            self._most(2, column=j) + self._most(0, column=j + 1) + GAP * self.times for j in range(self.columns - 1)
        ]
        right = self._size(self.key[0])[0] + GAP * self.times if self.key and self.sheet.key_right else 0.0
        return (
            self._most(0, column=0)
            + sum(gaps)
            + self._most(2, column=self.columns - 1)
            + self._of_rows()
            + right
            + 2 * EDGE
        )

    def _of_rows(self) -> float:
        """The width of the labels of rows."""
        lines = max((len(self._row_lines(k)) for k in range(len(self.sheet.rows))), default=0)
        return (6 + SPACING * caption_letters() * lines) / 72 if lines else 0.0

    def _row_lines(self, row: int) -> list[str]:
        return wrapped(self.sheet.rows[row], 72 * self.sheet.high[row], caption_letters())

    def _wide(self) -> float:
        """The width of a panel."""
        if (width := page().width) is None:
            return self.sheet.wide
        wide = (width - self._aside()) / self.columns
        if wide < NARROWEST * self.times and self.key:
            self._forget_key()
            wide = (width - self._aside()) / self.columns
        if wide < NARROWEST * self.times:
            needed = width + (NARROWEST * self.times - wide) * self.columns
            raise wrong_option("width", width, f"this figure needs {needed + 0.05:.1f} inches at least")
        return wide

    def _over(self, wide: float, row: int, *, first: bool) -> float:
        """The inches over the panels of a row, with their captions; in a grid only the `first` row has some."""
        room = 72 * (wide + (GAP * self.times if self.columns > 1 else 0.0))
        texts = [text for (i, _), text in self.sheet.captions.items() if i == row and (first or not self.sheet.rows)]
        lines = [
            text.split("\n") if self.sheet.math else wrapped(f"(m) {text}", room, caption_letters())
            for text in texts
            if text
        ]
        most = max(map(len, lines), default=0)
        return self._most(3, row=row) + ((6 + SPACING * caption_letters() * most) / 72 if most else 0.02)

    def _under(self, rows: Sequence[int]) -> list[float]:
        """The inches under each row of a page, of which all but the lowest leave out what those below them have."""
        here = {place: ax for place, ax in self.sheet.axes.items() if place[0] in rows}
        inner = _inner(here, "x")
        high = {
            place: INNER * self.times if ax in inner else float(self.around[place][1]) for place, ax in here.items()
        }
        return [max(high[place] for place in here if place[0] == row) for row in rows]

    def _title(self) -> list[str]:
        return wrapped(self.sheet.title, 72 * (self.width - 2 * EDGE), title_letters(), 3) if self.sheet.title else []

    def _rest(self, rows: Sequence[int], wide: float) -> float:
        """The height of a page with these rows that is no panels."""
        over = sum(self._over(wide, row, first=row == rows[0]) for row in rows)
        title = len(self._title())
        title_high = (SPACING * title_letters() * title + 6) / 72 if title else 0.0
        gaps = GAP * self.times * (len(rows) - 1)
        return title_high + over + sum(self._under(rows)) + gaps + self._key_high() + 2 * EDGE

    def _key_high(self) -> float:
        if self.sheet.key_right or not self.key:
            return 0.0
        return sum(self._size(key)[1] + 0.06 * self.times for key in self.key)

    def _size(self, key: Legend) -> tuple[float, float]:
        box = key.get_window_extent(self.figure.canvas.get_renderer())
        return box.width / self.figure.dpi, box.height / self.figure.dpi

    def _heights(self, wide: float) -> list[tuple[list[int], list[float]]]:
        """The rows of each page, and the heights of their panels."""
        every, least, height = [*range(self.rows)], self.sheet.least, page().height
        high = np.array(self.sheet.high)
        if least == LOWEST:  # panels of the usual shape
            high = high * wide / self.sheet.wide
        if self.key and self.sheet.key_right and least is not None:
            lacks = (
                self._size(self.key[0])[1]
                - (self._rest(every, wide) - self._over(wide, 0, first=True) - self._under(every)[-1] - 2 * EDGE)
                - high.sum()
            )
            high = high * np.clip(1 + lacks / high.sum(), 1.0, TALLEST)
        if height is not None:
            if least is None:
                raise wrong_option("height", height, "the height of this figure follows from the names in it")
            room = (height - self._rest(every, wide)) / high.sum()
            if (low := 0.5 * self.times / float(high.min())) > room:
                needed = height + (low - room) * high.sum()
                raise wrong_option("height", height, f"this figure needs {needed + 0.05:.1f} inches at least")
            return [(every, (room * high).tolist())]
        highest = page().highest
        room = (highest - self._rest(every, wide)) / high.sum()
        if room >= 1.0 or (least is not None and room >= least):
            return [(every, (min(1.0, room) * high).tolist())]
        pages: list[list[int]] = [[0]]
        for row in every[1:]:
            longer = [*pages[-1], row]
            if self._rest(longer, wide) + high[longer].sum() <= highest:
                pages[-1] = longer
            else:
                pages.append([row])
        found = []
        for rows in pages:
            room = (highest - self._rest(rows, wide)) / high[rows].sum()
            found.append((rows, (max(min(1.0, room), (least or 1.0) * 0.75) * high[rows]).tolist()))
        return found

    def _key_right(self, corner: Axes) -> list[Legend]:
        room = 72 * KEY * self.times - 3 * letters()
        return [self._legend(corner, [*self.entries], self.heading, room, 1)]

    def _legend(self, ax: Axes, names: Sequence[str], heading: str, room: float, columns: int) -> Legend:
        legend = Legend(
            ax, [self.entries[name] for name in names], _in_lines(names, room),
            title=_in_lines([heading], room + 2 * letters())[0] or None, loc="upper left", ncols=columns,
            bbox_to_anchor=(0, 0), bbox_transform=self.figure.transFigure, columnspacing=1.0, **_style(),
        )  # fmt: skip
        for text in legend.get_texts():
            text.set_parse_math(False)
        ax.add_artist(legend)
        legend.set_clip_on(False)  # a tight figure, as in a notebook, leaves out what its axes clip
        return legend

    def _key_below(self, ax: Axes) -> list[Legend]:
        """Keys under all panels: one of short names side by side, and one of the others."""
        room, handle = 72 * (self.width - 2 * EDGE), 3.0 * letters()
        shown = {name.replace("\n", " "): artist for name, artist in self.entries.items()}
        self.entries = shown
        short = [name for name in shown if width_of(name, letters()) + handle <= (room - letters()) / 2]
        keys, heading = [], self.heading.replace("\n", " ")
        for group in (short, [name for name in shown if name not in short]) if shown else ([],):
            if group or not shown:
                lines = "\n".join(_in_lines(group, room - handle)).split("\n")
                widest = max(width_of(line, letters()) for line in lines) + handle + letters()
                columns = max(1, min(len(group), int((room + letters()) / widest)))
                keys.append(self._legend(ax, group, heading, room - handle, columns))
                heading = ""
        return keys

    def _put(self, wide: float, pages: list[tuple[list[int], list[float]]]) -> None:
        """Set the size of the figure and the place of everything on it."""
        heights = [page().height or self._rest(rows, wide) + sum(high) for rows, high in pages]
        total = sum(heights)
        self.figure.set_size_inches(self.width, total)
        lefts = [EDGE + self._most(0, column=0)]
        for j in range(1, self.columns):
            lefts.append(lefts[-1] + wide + self._most(2, column=j - 1) + GAP * self.times + self._most(0, column=j))
        room = wide + (GAP * self.times if self.columns > 1 else 0.0)
        top, parts = total, []
        for (rows, high), tall in zip(pages, heights, strict=True):
            artists: list[Artist] = self._write_title(top, total, lefts[0])
            y = top - EDGE - (self._rest(rows, wide) - self._rest_without_title(rows, wide))
            under = self._under(rows)
            here = {place: ax for place, ax in self.sheet.axes.items() if place[0] in rows}
            for k, row in enumerate(rows):
                y -= self._over(wide, row, first=k == 0) + high[k]
                for (_, j), ax in ((place, one) for place, one in here.items() if place[0] == row):
                    ax.set_position((lefts[j] / self.width, y / total, wide / self.width, high[k] / total))
                y -= under[k] + GAP * self.times
            _share(here, "x")
            artists += here.values()
            self._put_key(here, lefts[-1] + wide, top, y + GAP * self.times)
            self._write_captions(here, rows[0], room)
            parts.append(Part(Bbox.from_bounds(0.0, top - tall, self.width, tall), artists))
            top -= tall
        if len(parts) > 1:
            _PARTS[self.figure] = parts

    def _rest_without_title(self, rows: Sequence[int], wide: float) -> float:
        title = len(self._title())
        return self._rest(rows, wide) - ((SPACING * title_letters() * title + 6) / 72 if title else 0.0)

    def _write_title(self, top: float, total: float, left: float) -> list[Artist]:
        if not (lines := self._title()):
            return []
        x = EDGE if max(width_of(line, title_letters()) for line in lines) / 72 > self.width - left - EDGE else left
        place = x / self.width, (top - EDGE) / total
        return [self.figure.text(*place, "\n".join(lines), va="top", fontsize=title_letters(), parse_math=False)]

    def _write_captions(self, here: dict[Place, Axes], first: int, room: float) -> None:
        if not self.sheet.rows:
            every = _lettered([*self.sheet.captions.values()])
            texts = dict(zip(self.sheet.captions, every, strict=True))
        else:
            texts = {place: text if place[0] == first else "" for place, text in self.sheet.captions.items()}
        for (i, j), ax in here.items():
            text, pad = texts[i, j], 6 + 72 * self._most(3, row=i)
            lines = text if self.sheet.math else "\n".join(wrapped(text, 72 * room, caption_letters()))
            ax.set_title(lines, loc="left", fontsize=caption_letters(), pad=pad, parse_math=self.sheet.math)
            if not self.sheet.rows:
                ax.set_label(" ".join(text.split()))
            elif (i, j + 1) not in here:
                ax.annotate(
                    "\n".join(self._row_lines(i)), (1.0, 0.5), (6 + 72 * self._most(2, column=j), 0), rotation=270,
                    xycoords="axes fraction", textcoords="offset points", va="center", fontsize=caption_letters(),
                    parse_math=False, annotation_clip=False,
                )  # fmt: skip

    def _put_key(self, here: dict[Place, Axes], right: float, top: float, foot: float) -> None:
        """Put the key on a page: the one that was measured on the first, a copy on the others."""
        if not self.key:
            return
        corner = here[min(here)]
        if corner is not self.key[0].axes:
            self.key = self._key_right(corner) if self.sheet.key_right else self._key_below(corner)
        width, total = self.figure.get_size_inches()
        if self.sheet.key_right:
            x = right + self._most(2, column=self.columns - 1) + self._of_rows() + GAP * self.times
            self.key[0].set_bbox_to_anchor((x / width, corner.get_position().y1), self.figure.transFigure)
            return
        y = foot - 0.06 * self.times
        for key in self.key:
            key.set_bbox_to_anchor((EDGE / width, y / total), self.figure.transFigure)
            y -= self._size(key)[1] + 0.06 * self.times
