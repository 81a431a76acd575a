"""Figures are written as files."""

from __future__ import annotations

import contextlib
import io
import itertools
import logging
import numbers
import os
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

import matplotlib as mpl
from matplotlib.figure import Figure

from swarmcensus.figures import captions
from swarmcensus.figures.page import drawing
from swarmcensus.figures.sheets import Part, pages_of
from swarmcensus.support.control_characters import printable
from swarmcensus.support.errors import InputError
from swarmcensus.support.files import atomic_write
from swarmcensus.support.options import wrong_option

LOG = logging.getLogger(__name__)
CAPTION = ".caption.txt"  # the ending of the file of a caption
DPI = 150  # unless a style says otherwise
MOST_PIXELS = 400_000_000  # 1.6 GB while a figure is drawn
# Text stays text, which editors can alter, and the same figure gives the same bytes:
SAVED: Any = {"svg.fonttype": "none", "pdf.fonttype": 42, "ps.fonttype": 42, "svg.hashsalt": "swarmcensus"}


def checked_dpi(dpi: float) -> float:
    """The dots per inch. Raises InputError for impossible ones."""
    if isinstance(dpi, bool) or not isinstance(dpi, numbers.Real) or not 10 <= dpi <= 2400:
        raise wrong_option("dpi", dpi, "should be 10 to 2400 dots per inch")
    return dpi


def save(
    figure: Figure, path: str | Path, formats: Sequence[str] = (), dpi: float | None = None, *, captioned: bool = True
) -> list[Path]:
    """Write a figure in the format of the path's suffix, and return the paths written.

    Without a suffix, `path`.png and `path`.svg are written; with `formats`, one file for each. A file appears whole or
    not at all. A figure that is higher than a page is cut: its pages are `path`-1.png, `path`-2.png and so on. PNGs
    have `dpi` dots per inch, as do the layers of single dots inside an SVG or PDF, where everything else is lines and
    text. The default is matplotlib's `savefig.dpi` if that is a number, else 150. The same figure gives the same bytes.
    A draft of its caption goes to the file's name and .caption.txt, or for several formats to `path`.caption.txt, if
    `sc.plot` drew the figure, unless `captioned` is False. Remarks on what it lacks or pools go to the log.

    Raises InputError for what is no figure and no path, for a format that matplotlib cannot write, for another `dpi`
    than 10 to 2,400, for more than 400 million pixels, and for a path that cannot be written.
    """
    if not isinstance(figure, Figure):
        raise wrong_option("figure", type(figure).__name__, "should be a figure that sc.plot or matplotlib has drawn")
    if not isinstance(path, str | os.PathLike) or not Path(path).name:
        raise wrong_option("path", path, "should be the name of a file, such as 'lines.png'")
    if isinstance(formats, str) or not isinstance(formats, Sequence) or not all(isinstance(f, str) for f in formats):
        raise wrong_option("formats", formats, "should be a list of endings, such as ['png', 'pdf']")
    usual = mpl.rcParams["savefig.dpi"]
    dots = checked_dpi(DPI if isinstance(usual, str) else float(usual)) if dpi is None else checked_dpi(dpi)
    wide, high = (round(dots * inches) for inches in figure.get_size_inches().tolist())
    if wide * high > MOST_PIXELS:
        raise wrong_option("dpi", dots, f"these are {wide:,} x {high:,} pixels, more than {MOST_PIXELS:,}")
    path, known = Path(path), figure.canvas.get_supported_filetypes()
    suffix = path.suffix.lower().lstrip(".")
    if not formats and suffix.isalpha():
        path, formats = path.with_suffix(""), (suffix,)
    for extension in formats:
        if extension not in known:
            only = ", ".join(sorted(known))
            raise InputError(f"cannot write {extension!r} files, only {only}", key="formats", value=extension)
    endings = formats or ("png", "svg")
    of = path.with_name(f"{path.name}.{endings[0]}") if len(endings) == 1 else path  # x.png and x.pdf may differ
    if captioned and caption_file(of).is_dir():
        raise InputError(f"cannot write {caption_file(of)}: it is a folder", file=caption_file(of))
    pages: list[tuple[str, Part | None]] = [(f"-{k}", page) for k, page in enumerate(pages_of(figure), 1)]
    pages = pages or [("", None)]
    paths = [path.with_name(f"{path.name}{number}.{ending}") for ending in endings for number, _ in pages]
    for place, (extension, (_, page)) in zip(paths, itertools.product(endings, pages), strict=True):
        with atomic_write(place) as temporary, drawing(SAVED), _alone(figure, page):
            temporary.write_bytes(_written(figure, extension, dots, page))
    return [*paths, *(write_caption(figure, of, paths[0].name) if captioned else [])]


def caption_file(path: Path) -> Path:
    """The file of the caption of what is in another file."""
    return path.with_name(f"{path.name}{CAPTION}")


def write_caption(figure: Figure, path: Path, name: str = "") -> list[Path]:
    """Write the caption of a figure, if it has one, next to its file, and its remarks to the log. Returns its path."""
    if not (text := captions.caption(figure)):
        return []
    with atomic_write(caption_file(path)) as temporary:
        temporary.write_text(printable(text), encoding="utf-8")
    for remark in captions.remarks_on(figure):
        LOG.info("%s: %s", name, remark)
    return [caption_file(path)]


@contextlib.contextmanager
def _alone(figure: Figure, page: Part | None) -> Iterator[None]:
    """Hide what stands on other pages of a figure."""
    others = [each for part in pages_of(figure) if page is not None and part is not page for each in part.artists]
    for artist in others:
        artist.set_visible(False)
    try:
        yield
    finally:
        for artist in others:
            artist.set_visible(True)


def _written(figure: Figure, extension: str, dots: float, page: Part | None) -> bytes:
    """The bytes of a page of a figure, or of all of it."""
    undated = {"svg": {"Date": None}, "pdf": {"CreationDate": None}}.get(extension)
    drawn = io.BytesIO()  # a full disk confuses matplotlib's writer of PDFs
    box = None if page is None else page.box
    figure.savefig(drawn, format=extension, dpi=dots, metadata=undated, bbox_inches=box)
    data = drawn.getvalue()
    # XML allows no control characters, and names in others' results may hold some
    return printable(data.decode()).encode() if extension == "svg" else data
