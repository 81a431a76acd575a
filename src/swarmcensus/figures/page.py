"""The page that a figure is made for: its width and height, its letters, how texts fit, and the names of brains.

Every kind of figure takes the options of `PageOptions`, and draws with the values of `page()`.
"""

from __future__ import annotations

import contextlib
import functools
import inspect
import numbers
import os
import re
import textwrap
import threading
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from contextvars import ContextVar
from pathlib import Path
from types import UnionType
from typing import Any, Literal, NamedTuple, TypedDict, TypeVar, Union, get_args, get_origin, get_type_hints

import matplotlib as mpl
import numpy as np
import xarray as xr
from matplotlib.colors import to_rgb
from matplotlib.figure import Figure
from matplotlib.font_manager import FontProperties
from matplotlib.legend import Legend
from matplotlib.lines import Line2D
from matplotlib.textpath import text_to_path

from swarmcensus.summaries import with_labels
from swarmcensus.support.errors import InputError
from swarmcensus.support.hints import did_you_mean
from swarmcensus.support.options import wrong_option

WIDTHS = {"column": 3.5, "double": 7.2, "slide": 10.0}  # inches
SLIDE_LETTERS = 13.0  # points, legible from the last row of a room
HIGHEST, SLIDE_HEIGHT = 9.0, 7.5  # inches: what a page of a journal has room for, and a slide
LETTERS = 7.5  # points: ticks and keys, unless a style or an option says otherwise
SPACING = 1.2  # line height, as a multiple of the font size
SLACK = 1.03  # of what is measured: renderers round to their pixels
LEAST_LAST = 4  # letters: the end of a word that is broken
SHEET = "sheet"  # the label of figures made here
SIZES, FONTS = (2.0, 60.0), (4.0, 40.0)  # inches, and points

Width = float | Literal["column", "double", "slide"]


class PageOptions(TypedDict, total=False):
    """The options that every kind of figure takes in addition to its own.

    - `width`: inches, or "column" (3.5), "double" (7.2) or "slide" (10, with larger letters).
    - `height`: inches; by default as high as the panels need. With a `width`, what a page of 9 inches (a slide of 7.5)
      has no room for is on further pages, which `save` writes as numbered files.
    - `font_size`: points of ticks and keys; captions are larger. By default matplotlib's `font.size` if a style sets
      it, else 7.5.
    - `labels`: names of brains in the figure, by their names in the results.
    """

    width: Width | None
    height: float | None
    font_size: float | None
    labels: Mapping[str, str] | None


class Page(NamedTuple):
    """Width and height in inches, and the size of letters in points."""

    width: float | None = None
    height: float | None = None
    letters: float | None = None

    @property
    def highest(self) -> float:
        """The height in inches at which a figure is cut: that of a page, or of a slide."""
        return SLIDE_HEIGHT if self.width == WIDTHS["slide"] else HIGHEST


USUAL = Page()
TYPES: dict[Any, tuple[Any, str]] = {  # of options: what a value must be an instance of, and its name in messages
    bool: (bool, "True or False"), int: (numbers.Integral, "a whole number"), float: (numbers.Real, "a number"),
    str: (str, "a text"), Path: (os.PathLike, "a path"), Sequence: ((Collection, np.ndarray), "a list"),
}  # fmt: skip
# matplotlib's settings and its reader of formulas are global: threads that draw texts or save take turns.
RENDERING = threading.RLock()
# Settings that figures do not follow. Names of brains are no LaTeX, sheets have their own layout, and axes formulas:
OWN: Any = {
    "text.usetex": False, "text.parse_math": True, "figure.constrained_layout.use": False, "figure.autolayout": False,
    "savefig.bbox": None,
}  # fmt: skip
_PAGE: ContextVar[Page] = ContextVar("page", default=USUAL)
Kind = TypeVar("Kind", bound=Callable[..., Any])


def page() -> Page:
    """The page of the figure that is being drawn."""
    return _PAGE.get()


def letters() -> float:
    """The size in points of ticks and keys."""
    if (chosen := page().letters) is not None:
        return chosen
    size = float(mpl.rcParams["font.size"])
    return LETTERS if size == mpl.rcParamsDefault["font.size"] else size


def ink() -> str:
    """The colour of lines that must stand out from the paper: that of texts, which a dark style makes light."""
    return str(mpl.rcParams["text.color"])


def on_dark() -> bool:
    """Whether a style makes paper dark and texts light."""
    return max(to_rgb(ink())) > 0.5


def caption_letters() -> float:
    """The size in points of captions of panels."""
    return letters() + 1.5


def title_letters() -> float:
    """The size in points of a figure's title."""
    return letters() + 3.0


def scale() -> float:
    """The factor by which letters, and the room that they need, are larger than usual."""
    return letters() / LETTERS


@contextlib.contextmanager
def drawing(more: Any = None) -> Iterator[None]:
    """Draw in a block with matplotlib's settings, except those that figures do not follow, and with `more`."""
    with RENDERING, mpl.rc_context(OWN | (more or {})):
        yield


def on_page(draw: Kind) -> Kind:
    """Let a kind of figure take the options of `PageOptions`. Raises InputError for impossible and unknown ones."""
    known = [name for name, each in inspect.signature(draw).parameters.items() if each.kind != each.VAR_KEYWORD][1:]
    known += PageOptions.__annotations__
    try:
        hints = get_type_hints(draw)
    except (NameError, TypeError):  # of another package, whose annotations are its own business
        hints = {}

    @functools.wraps(draw)
    def drawn(results: xr.Dataset, **options: Any) -> Any:
        if wrong := next((name for name in options if name not in known), None):
            there = f"{did_you_mean(wrong, known)}there are {', '.join(known)}"
            raise InputError(f"{draw.__name__} has no option {wrong!r}: {there}", key=wrong)
        for name, value in options.items():
            _check_type(name, value, hints.get(name))
        given = {name: options.pop(name, None) for name in PageOptions.__annotations__}
        labels = given.pop("labels")
        if labels is not None and not isinstance(labels, Mapping):
            should = "should be names by names, such as {'minimalistic': 'Ours'}"
            raise InputError(f"labels={labels!r}: {should}", key="labels", value=labels)
        if labels:
            results = with_labels(results, labels)
        wanted = _page_of(**given)
        with drawing(), _turned(wanted):
            figure = draw(results, **options)
        if not isinstance(figure, Figure) or wanted == USUAL:
            return figure
        larger = (wanted.letters or LETTERS) / LETTERS
        if figure.get_gid() != SHEET:  # kinds of other packages know no page
            wide, high = figure.get_size_inches()
            figure.set_size_inches(wanted.width or wide, wanted.height or high)
        elif larger > 1.0:  # smaller letters leave lines as they are
            _thicken(figure, larger)
        return figure

    return drawn  # type: ignore[return-value]


def _check_type(name: str, value: Any, hint: Any) -> None:
    """Raise InputError if the value of an option is none of the literals or plain types of its annotation."""
    hints = get_args(hint) if get_origin(hint) in (Union, UnionType) else (hint,)
    literals = [each for one in hints if get_origin(one) is Literal for each in get_args(one)]
    types = [get_origin(one) or one for one in hints if get_origin(one) is not Literal]
    optional, types = type(None) in types, [one for one in types if one is not type(None)]
    if not {*types} <= {*TYPES} or (value is None and optional) or value in literals:
        return
    if any(isinstance(value, TYPES[one][0]) and isinstance(value, bool) == (one is bool) for one in types):
        return
    should = [f"one of {', '.join(literals)}"] * bool(literals) + [TYPES[one][1] for one in types]
    raise wrong_option(name, value, f"should be {' or '.join(should)}")


@contextlib.contextmanager
def _turned(wanted: Page) -> Iterator[None]:
    """Turn to another page for a block; without options, figures stay on the page of what draws them."""
    before = _PAGE.set(page() if wanted == USUAL else wanted)
    try:
        yield
    finally:
        _PAGE.reset(before)


def _page_of(width: Width | None, height: float | None, font_size: float | None) -> Page:
    inches = WIDTHS.get(width, width) if isinstance(width, str) else width
    sizes: dict[str, float | None] = {}
    for name, value in (("width", inches), ("height", height), ("font_size", font_size)):
        least, most, unit = (*FONTS, "points") if name == "font_size" else (*SIZES, "inches")
        fits = isinstance(value, numbers.Real) and not isinstance(value, bool) and least <= float(value) <= most
        if value is not None and not fits:
            names = f", or one of {', '.join(WIDTHS)}" if name == "width" else ""
            raise wrong_option(name, value, f"should be {least:g} to {most:g} {unit}{names}")
        sizes[name] = None if value is None else float(value)
    letters = SLIDE_LETTERS if width == "slide" and font_size is None else sizes["font_size"]
    return Page(sizes["width"], sizes["height"], letters)


def _thicken(figure: Figure, times: float) -> None:
    """Make lines and marks larger."""
    keys = [line for key in figure.findobj(Legend) for line in key.findobj(Line2D)]
    for line in [*(line for ax in figure.axes for line in ax.lines), *keys]:
        line.set(linewidth=times * line.get_linewidth(), markersize=times * line.get_markersize())
        line.set_markeredgewidth(times * line.get_markeredgewidth())
    for lines in [lines for ax in figure.axes for lines in ax.collections]:
        lines.set_linewidth((times * np.asarray(lines.get_linewidth())).tolist())


def width_of(text: str, size: float) -> float:
    """The width in points of a line of text of `size` points; dollar signs are plain characters."""
    return SLACK * float(text_to_path.get_text_width_height_descent(text, FontProperties(size=size), ismath=False)[0])


def wrapped(text: str, width: float, size: float, most: int = 6) -> list[str]:
    """The text in at most `most` lines, each at most `width` points wide.

    Lines break at spaces, and within words that are longer. A text that is still too long lacks its middle.
    """
    whole = shown = " ".join(text.split()).replace(" = ", "\N{NO-BREAK SPACE}=\N{NO-BREAK SPACE}")
    kept = len(whole)
    while len(lines := _lines(shown, width, size)) > most:
        kept = min(kept - 1, int(0.9 * kept))
        shown = f"{whole[: kept - kept // 2]}…{whole[len(whole) - kept // 2 :]}"
    return [line.replace("\N{NO-BREAK SPACE}", " ") for line in lines]


def _lines(text: str, width: float, size: float) -> list[str]:
    """The text in as few lines as fit, with about as many letters each, and some at the end of a broken word."""
    letters = int(1.5 * len(text) * width / max(width_of(text, size), width)) + 1
    while True:
        lines = textwrap.wrap(text, letters)
        short = len(lines) > 1 and len(lines[-1]) < LEAST_LAST < letters / 2 and text.endswith("".join(lines[-2:]))
        if letters == 1 or (not short and all(width_of(line, size) <= width for line in lines)):
            return lines
        letters -= 1


def in_lines(name: str, room: float, size: float) -> str:
    """A name in lines of at most `room` points; one with a formula breaks behind commas and before its unit."""
    lines: list[str] = []
    for line in name.split("\n"):
        fits = formula_width(line, size) <= room
        for part in [line] if fits or "$" not in line else re.split(r" (?=\()|(?<=,) ", line):
            lines += [part] if fits or "$" in part else wrapped(part, room, size)
    return "\n".join(lines)


def formula_width(name: str, size: float) -> float:
    """The width in points of a line that may hold a formula, which is no wider than its letters."""
    return width_of(re.sub(r"[$\\{},]", "", name), size)
