"""The layout that all figures share: panels in rows and columns, their captions, a key, and pages.

A kind draws into panels of a usual size. `add_key` then measures once what stands around them, and gives all their
places. What a page has no room for is on further pages, of which `pages_of` knows the parts.
"""

from __future__ import annotations

import itertools
import string
from collections.abc import Mapping, Sequence
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
from numpy.typing import NDArray

from swarmcensus.figures.page import (
    RENDERING,
    SHEET,
    SLACK,
    SPACING,
    caption_letters,
    formula_width,
    in_lines,
    letters,
    page,
    scale,
    title_letters,
    width_of,
    wrapped,
)
from swarmcensus.figures.styles import Strip
from swarmcensus.support.errors import InputError
from swarmcensus.support.options import wrong_option

Scale = Literal["log", "log-y", "linear"]  # both axes are logarithmic, only the y axis, neither
Place = tuple[int, int]  # row and column

MOST_PANELS, MOST_COLUMNS = 120, 6
FINE = 300  # dots per inch at which texts are measured
# Inches, with letters of the usual size:
LEFT = 0.65  # about the room for the y axis and its name
KEY = 1.6  # the room for a key on the right
EDGE = 0.1  # around all
GAP = 0.14  # between panels with all that belongs to them
INNER = 0.07  # under a panel that shares the axis of the one below
LEAST, LEAST_OF_GRID = 1.75, 1.3  # the width of a panel that a page of given width may have
NARROWEST = 0.8  # the same if there is a single column
LOWEST = 0.6  # of its usual height that a panel has at least, so that all fit a page
POOLED = "select some of the settings, draw all into one with cols=[]"  # advice on how to get fewer panels
UNRUN = "no trial has been run"
NOTHING = "nothing to draw: no trial of these settings has been run"


class Part(NamedTuple):
    """A page of a figure: its place on the figure in inches, and its panels."""

    box: Bbox
    artists: list[Axes]


class Key(NamedTuple):
    """The key of a figure: its title and its entries."""

    heading: str
    entries: Mapping[str, Artist]

    def draw(self, ax: Axes, room: float, ncols: int = 1) -> Legend:
        """Draw it, `ncols` names side by side, each in lines of at most `room` points."""
        title = in_lines(self.heading, ncols * (room + 3 * letters()), letters())
        named = (str(each.get_label()) if isinstance(each, Strip) else name for name, each in self.entries.items())
        names = [in_lines(name, room, letters()) for name in named]
        legend = Legend(
            ax, list(self.entries.values()), names, title=title, ncols=ncols,
            loc="upper left", borderaxespad=0, borderpad=0, frameon=False, title_fontsize=letters(),
            fontsize=letters(), alignment="left", handlelength=1.2, columnspacing=1.0,
        )  # fmt: skip
        for text in legend.get_texts():
            text.set_parse_math(False)
        legend._legend_handle_box.align = "top"  # type: ignore[attr-defined]  # of columns
        ax.legend_ = legend
        legend.set_clip_on(False)  # a tight figure, as in a notebook, leaves out what its axes clip
        return legend


@dataclass
class Sheet:
    """Panels of a figure before they have their places."""

    axes: dict[Place, Axes]
    captions: dict[Place, str]
    rows: dict[int, str]  # labels of rows, if columns have the captions
    wide: float
    high: NDArray[np.float64]  # of each row
    least: float | None
    key_right: bool
    title: str


_SHEETS: WeakKeyDictionary[Figure, Sheet] = WeakKeyDictionary()
_PARTS: WeakKeyDictionary[Figure, list[Part]] = WeakKeyDictionary()


def pages_of(figure: Figure) -> list[Part]:
    """The pages of a figure that is higher than a page; none if one has room for all."""
    return _PARTS.get(figure, [])


def sheet(
    captions: Sequence[str], title: str | None, *, rows: Sequence[str] = (),
    size: tuple[float, float | Sequence[float]] | None = None, least: float | None = LOWEST, left: float = LEFT,
    key: bool = True, fewer: str = "select some of the settings", shape: tuple[float, float] | None = None,
) -> list[Axes]:  # fmt: skip
    """Return the panels of a new figure, with these captions.

    - `rows`: the label of each panel's row. Panels with the same caption then stand in a column, if columns have room;
      else rows and columns are exchanged, or panels have captions of their own.
    - `size`: a panel's width in inches, and its height, or that of each panel, which then are in one column (the
      default depends on their number).
    - `least`: the share of the height that is left if a page has no room; None if it follows from what is in a panel.
    - `left`: about the room for the y axis, in inches with letters of the usual size.
    - `key`: whether there may be one on the right.
    - `shape`: a panel's usual width and height in inches, with letters of the usual size, in place of `size`.

    Raises InputError for no panel and for more than 120; the message says how to get `fewer` panels.
    """
    joined = [", ".join(filter(None, pair)) for pair in zip(rows, captions, strict=True)] if rows else [*captions]
    if not 1 <= len(captions) <= MOST_PANELS:
        raise InputError(f"a figure holds 1 to {MOST_PANELS} panels, not {len(captions)}: {fewer}")
    times, count = scale(), len(captions)
    shape = shape or (4.4, 3.2) if count == 1 else (3.1, 2.4) if _usual_columns(count) <= 3 else (2.5, 1.9)
    usual = size[0] if size else times * shape[0]
    single = size is not None and not isinstance(size[1], int | float) and not rows
    places, turned, key_right = _places(captions, rows, left, key, 1 if single else _usual_columns(count))
    columns = 1 + max(column for _, column in places)
    wide = usual if page().width is None else _fits(columns, left, KEY if key_right else EDGE)
    high = np.broadcast_to(size[1] if size else wide * shape[1] / shape[0], count)
    width = page().width or times * (left + KEY + columns * GAP) + columns * wide
    figure = Figure(figsize=(width, 6.0))
    FigureCanvasAgg(figure)
    figure.set_gid(SHEET)
    sizes = zip(high.tolist(), joined, strict=True)  # places follow once all is drawn
    axes = [figure.add_axes((0.1, 0.1, wide / width, tall / 6.0), label=name) for tall, name in sizes]
    over, aside = (rows, captions) if turned else (captions, rows)
    in_grid = turned is not None
    highs = {row: tall for (row, _), tall in zip(places, high.tolist(), strict=True)}
    labels = {row: text for (row, _), text in zip(places, aside, strict=True)} if in_grid else {}
    named = dict(zip(places, over if in_grid else joined, strict=True))
    _SHEETS[figure] = Sheet(
        dict(zip(places, axes, strict=True)), named, labels, wide, np.array([highs[row] for row in sorted(highs)]),
        least, key_right, title or "",
    )  # fmt: skip
    return axes


def _usual_columns(count: int) -> int:
    return count if count <= 3 else {4: 2, 5: 3, 6: 3, 9: 3}.get(count, 4)


def _fits(columns: int, left: float, margin: float) -> float:
    """The width of panels that so many columns leave on a page, in inches; endless on a free one."""
    used = scale() * (left + margin + (columns - 1) * GAP)
    return ((page().width or np.inf) - used) / columns


def _places(
    captions: Sequence[str], rows: Sequence[str], left: float, key: bool, most: int
) -> tuple[list[Place], bool | None, bool]:
    """The row and column of each panel, whether they are exchanged, and whether the key is on the right.

    None of the first two if there are no labels of rows, or no room for as many columns.
    """
    over, down = [*dict.fromkeys(captions)], [*dict.fromkeys(rows)]
    margins = (KEY, EDGE) if key else (EDGE,)
    for columns, turned in ((len(over), False), (len(down), True)) if rows else ():
        for margin in margins:
            if columns <= MOST_COLUMNS and _fits(columns, left, margin) >= scale() * LEAST_OF_GRID:
                places = [(down.index(row), over.index(text)) for row, text in zip(rows, captions, strict=True)]
                return [place[::-1] if turned else place for place in places], turned, key and margin == KEY
    tries = [(n, margin) for n in range(most, 0, -1) for margin in margins]
    columns, margin = next((one for one in tries if _fits(one[0], left, one[1]) >= scale() * LEAST), tries[-1])
    return [divmod(k, columns) for k in range(len(captions))], None, key and margin == KEY


def figure_of(axes: Sequence[Axes]) -> Figure:
    """The figure that these axes are on."""
    return axes[0].figure.canvas.figure


def _lettered(captions: Sequence[str]) -> list[str]:
    """Captions with (a), (b), ... before them if there are several."""
    every = itertools.chain(string.ascii_lowercase, map("".join, itertools.product(string.ascii_lowercase, repeat=2)))
    lettered = [f"({letter}) {text}" for letter, text in zip(every, captions, strict=False)]
    return lettered if len(captions) > 1 else [*captions]


def name_axes(axes: Axes, x: str, y: str) -> None:
    """Write the axis labels, and hide the top and right spines."""
    axes.set_xlabel(x, fontsize=letters() + 1)
    axes.set_ylabel(y, fontsize=letters() + 1)
    axes.tick_params(labelsize=letters())
    axes.spines[["top", "right"]].set_visible(False)


def add_key(axes: Sequence[Axes], title: str, entries: Mapping[str, Artist], *, below: bool = False) -> None:
    """Give all panels their places, with one key that hides no data: to the right of the first row, or `below`.

    Everything else must have been drawn. Axes that neighbours share are named once, at the bottom and on the left.
    """
    figure: Any = figure_of(axes)
    for ax in axes:
        for axis, room in zip((ax.xaxis, ax.yaxis), ax.bbox.size * 72 / figure.dpi, strict=True):
            name = axis.get_label_text()
            longest = max((formula_width(word, letters() + 1) for word in name.split() if "$" not in name), default=0.0)
            axis.label.set_text(in_lines(name, max(longest, float(room)), letters() + 1))
    with RENDERING:
        dpi, figure.dpi = figure.dpi, FINE  # at few dots per inch letters are wider or narrower than in print
        _Placing(figure, _SHEETS.pop(figure), Key(title, entries), below).place()
        figure.dpi = dpi


def _share(axes: Mapping[Place, Axes], which: Literal["x", "y"]) -> None:
    """Leave out the names and numbers of axes that a neighbour shows."""
    for ax in _inner(axes, which):
        (ax.set_xlabel if which == "x" else ax.set_ylabel)("")
        ax.tick_params(axis=which, **{"labelbottom" if which == "x" else "labelleft": False})


def _inner(axes: Mapping[Place, Axes], which: Literal["x", "y"]) -> list[Axes]:
    """The axes with a neighbour on the left, or below, that has the same y or x axis.

    All panels of a row, or column, show numbers if one of them has a neighbour with other ones.
    """
    step, line = ((1, 0), 0) if which == "x" else ((0, -1), 1)
    same = {}
    for (row, column), ax in axes.items():
        other = axes.get((row + step[0], column + step[1]))
        if other is not None and other.axison:
            same[row, column] = _alike(ax, other, which)
    return [axes[place] for place in same if all(is_same for at, is_same in same.items() if at[line] == place[line])]


def _alike(ax: Axes, other: Axes, which: Literal["x", "y"]) -> bool:
    one, two = (getattr(each, f"{which}axis") for each in (ax, other))
    if not np.allclose(one.get_view_interval(), two.get_view_interval()) or one.get_scale() != two.get_scale():
        return False
    texts = [[text.get_text() for text in axis.get_ticklabels()] for axis in (one, two)]
    return texts[0] == texts[1] and (which == "y" or one.get_label_text() == two.get_label_text())


class _Placing:
    """The places that follow from what stands around the panels of a sheet. All lengths are in inches."""

    def __init__(self, figure: Any, of: Sheet, key: Key, below: bool) -> None:
        """Measure what stands around each panel, and the key."""
        self.figure, self.sheet, self.key = figure, of, key
        self.gap, self.corner = GAP * scale(), of.axes[0, 0]
        _share(of.axes, "y")
        columns = 1 + max(column for _, column in of.axes)
        self.around = np.zeros((len(of.high), columns, 4))  # on the left, under, on the right and over each panel
        for place, ax in of.axes.items():
            tight = (
                ax.get_tightbbox(figure.canvas.get_renderer(), bbox_extra_artists=[*ax.texts, *ax.child_axes])
                or ax.bbox
            )
            box = Bbox.union([tight, ax.bbox])
            self.around[place] = SLACK * np.array([*(ax.bbox.p0 - box.p0), *(box.p1 - ax.bbox.p1)]) / figure.dpi
        self.left, self.right = self.around[..., 0].max(axis=0), self.around[..., 2].max(axis=0)
        self.over = self.around[..., 3].max(axis=1)
        # labels may be as long as a panel with what stands over it; a word may reach into the gap between panels, and
        # panels are a little higher for it, before it is broken
        words = {
            row: max((width_of(w, caption_letters()) for w in text.split()), default=0.0)
            for row, text in of.rows.items()
        }
        lacking = np.array([word / 72 - of.high[row] - self.over[row] - self.gap for row, word in words.items()])
        of.high[:] += max(0.0, lacking[lacking < of.high.max() / 4].max(initial=0.0))
        rooms = 72 * (of.high + self.over)
        for row, word in words.items():
            rooms[row] = max(rooms[row], min(word, rooms[row] + 72 * self.gap))
        self.labels = {row: wrapped(text, rooms[row], caption_letters()) for row, text in of.rows.items()}
        self.right[-1] += self._lines(max(map(len, self.labels.values()), default=0), caption_letters())
        self.inside = float(self.left.sum() + self.right.sum() + (columns - 1) * self.gap)
        self.legend: Legend | None = None
        if (key.heading or key.entries) and of.key_right and not below:
            self.legend = key.draw(self.corner, 72 * KEY * scale() - 3 * letters())
        tallest = of.high.sum() + self.gap * len(of.high)
        if self.legend and (self._size()[1] > tallest or self._wide() < NARROWEST * scale()):
            self.corner.legend_ = self.legend = None
        self.on_right = self.legend is not None
        self.wide = self._wide()
        if self.wide < NARROWEST * scale():
            needed = (page().width or 0.0) + (NARROWEST * scale() - self.wide) * columns + 0.05
            raise wrong_option("width", page().width, f"this figure needs {needed:.1f} inches at least")
        aside = self._size()[0] + self.gap if self.legend else 0.0
        self.width = page().width or self.inside + aside + 2 * EDGE + columns * self.wide
        if self.legend is None and (key.heading or key.entries):
            self.legend = self._below(self.corner)
        self.title = wrapped(of.title, 72 * (self.width - 4 * EDGE), title_letters(), 3)

    def _lines(self, count: int, size: float) -> float:
        """The height of lines of text, with some room; 0 for none."""
        return (6 + SPACING * size * count) / 72 if count else 0.0

    def _size(self) -> tuple[float, float]:
        """The width and height of the key."""
        if self.legend is None:
            return 0.0, 0.0
        box = self.legend.get_window_extent(self.figure.canvas.get_renderer())
        return SLACK * box.width / self.figure.dpi, SLACK * box.height / self.figure.dpi

    def _wide(self) -> float:
        """The width of a panel."""
        if (width := page().width) is None:
            return self.sheet.wide
        aside = self._size()[0] + self.gap if self.legend else 0.0
        return (width - self.inside - aside - 2 * EDGE) / self.around.shape[1]

    def _below(self, ax: Axes) -> Legend:
        """The key under all panels, with names side by side if they are short."""
        room, handle = 72 * (self.width - 2 * EDGE), 3.0 * letters()
        key = Key(self.key.heading.replace("\n", " "), {k.replace("\n", " "): v for k, v in self.key.entries.items()})
        widths = [width_of(name, letters()) + handle for name in key.entries]
        columns = min(max(1, len(widths)), int(room / min(max(widths, default=room), room / 2)))
        return key.draw(ax, room / columns - handle, columns)

    def _captions(self, row: int, *, first: bool) -> float:
        """The height of the captions of a row; in a grid only the `first` row has some."""
        texts = [text for place, text in self.sheet.captions.items() if place[0] == row and (first or not self.labels)]
        lines = [wrapped(f"(m) {text}", 72 * self.wide, caption_letters()) for text in texts if text]
        return self._lines(max(map(len, lines), default=0), caption_letters())

    def _under(self, rows: Sequence[int]) -> list[float]:
        """What is under each row of a page, of which all but the lowest leave out what those below them have."""
        here = {place: ax for place, ax in self.sheet.axes.items() if place[0] in rows}
        inner = _inner(here, "x")
        under = {at: INNER * scale() if ax in inner else self.around[at][1] for at, ax in here.items()}
        return [max(float(high) for place, high in under.items() if place[0] == row) for row in rows]

    def _rest(self, rows: Sequence[int]) -> float:
        """The height of a page with these rows that is no panels."""
        over = sum(float(self.over[row]) + self._captions(row, first=row == rows[0]) for row in rows)
        key = 0.0 if self.on_right else self._size()[1] + (self.gap if self.legend else 0.0)
        inside = over + sum(self._under(rows)) + self.gap * (len(rows) - 1)
        return self._lines(len(self.title), title_letters()) + inside + key + 2 * EDGE

    def _pages(self) -> list[tuple[list[int], NDArray[np.float64]]]:
        """The rows of each page, and the heights of their panels."""
        every, least, height = [*range(len(self.sheet.high))], self.sheet.least, page().height
        high = self.sheet.high * (self.wide / self.sheet.wide if least == LOWEST else 1.0)
        room = ((height or page().highest) - self._rest(every)) / high.sum()
        if height is not None:
            if least is None:
                raise wrong_option("height", height, "the height of this figure follows from the names in it")
            if (low := 0.5 * scale() / float(high.min())) > room:
                needed = height + (low - room) * high.sum() + 0.05
                raise wrong_option("height", height, f"this figure needs {needed:.1f} inches at least")
            return [(every, room * high)]
        if room >= (least or 1.0):
            return [(every, min(1.0, room) * high)]
        pages: list[list[int]] = []
        for row in every:
            longer = [*(pages[-1] if pages else []), row]
            fits = bool(pages) and self._rest(longer) + high[longer].sum() <= page().highest
            pages[-1:] = [longer] if fits or not pages else [pages[-1], [row]]
        rooms = [(page().highest - self._rest(rows)) / high[rows].sum() for rows in pages]
        least = 0.75 * (least or 4 / 3)  # of a row that is higher than a page
        return [(rows, max(min(1.0, room), least) * high[rows]) for rows, room in zip(pages, rooms, strict=True)]

    def place(self) -> None:
        """Set the size of the figure and the place of everything on it."""
        pages = self._pages()
        heights = [page().height or self._rest(rows) + float(high.sum()) for rows, high in pages]
        top = total = sum(heights)
        self.figure.set_size_inches(self.width, total)
        x = EDGE + np.cumsum(self.left) + np.cumsum([0.0, *(self.right[:-1] + self.gap + self.wide)])
        lettered = _lettered([*self.sheet.captions.values()])
        for ax, text in zip(self.sheet.axes.values(), [] if self.labels else lettered, strict=False):
            ax.set_label(" ".join(text.split()))
        letters_of = dict(zip(self.sheet.captions, lettered, strict=True))
        parts = []
        for (rows, high), tall in zip(pages, heights, strict=True):
            self._write_title(x[0] / self.width, (top - EDGE) / total)
            y = top - EDGE - self._lines(len(self.title), title_letters())
            here = {place: ax for place, ax in self.sheet.axes.items() if place[0] in rows}
            for row, inches, under in zip(rows, high.tolist(), self._under(rows), strict=True):
                y -= self.over[row] + self._captions(row, first=row == rows[0]) + inches
                for (_, column), ax in ((at, ax) for at, ax in here.items() if at[0] == row):
                    ax.set_position((x[column] / self.width, y / total, self.wide / self.width, inches / total))
                y -= under + self.gap
            _share(here, "x")
            self._put_key(here[min(here)], float(x[-1]) + self.wide + float(self.right[-1]) + self.gap, y, total)
            for row in rows:
                self._write_captions({at: ax for at, ax in here.items() if at[0] == row}, letters_of, row == rows[0])
            parts.append(Part(Bbox.from_bounds(0.0, top - tall, self.width, tall), [*here.values()]))
            top -= tall
        if len(parts) > 1:
            _PARTS[self.figure] = parts

    def _write_title(self, x: float, y: float) -> None:
        if self.title:
            longest = max(width_of(line, title_letters()) for line in self.title) / 72 / self.width
            x = x if x + longest < 1.0 else EDGE / self.width
            self.figure.text(x, y, "\n".join(self.title), va="top", fontsize=title_letters(), parse_math=False)

    def _write_captions(self, axes: dict[Place, Axes], lettered: dict[Place, str], first: bool) -> None:
        (row, column), last = max(axes.items())
        texts = {at: self.sheet.captions[at] * first for at in axes} if self.labels else lettered
        for at, ax in axes.items():
            lines = "\n".join(wrapped(texts[at], 72 * self.wide, caption_letters()))
            style: dict[str, Any] = {"fontsize": caption_letters(), "parse_math": False}
            ax.set_title(lines, loc="left", pad=6 + 72 * float(self.over[row]), **style)
        if self.labels:
            right = 6 + 72 * float(self.around[:, column, 2].max())
            last.annotate(
                "\n".join(self.labels[row]), (1.0, 0.5), (right, 0), rotation=270, xycoords="axes fraction",
                textcoords="offset points", va="center", fontsize=caption_letters(), parse_math=False,
            )  # fmt: skip

    def _put_key(self, corner: Axes, right: float, foot: float, total: float) -> None:
        """Put the key on a page: the one that was measured on the first, a copy on the others."""
        if self.legend is None:
            return
        if corner is not self.corner:
            room = 72 * KEY * scale() - 3 * letters()
            self.legend = self.key.draw(corner, room) if self.on_right else self._below(corner)
        where = (right / self.width, corner.get_position().y1) if self.on_right else (EDGE / self.width, foot / total)
        self.legend.set_bbox_to_anchor(where, self.figure.transFigure)
