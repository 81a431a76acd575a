"""Texts are measured, wrapped and shortened to fit a width: names that users choose may have any length."""

from __future__ import annotations

import itertools
import re
from collections.abc import Callable, Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.font_manager import FontProperties
from matplotlib.image import AxesImage
from matplotlib.textpath import text_to_path
from numpy.typing import NDArray

SPACING = 1.2  # line height, as a multiple of the font size
MOST_LINES = 2  # of one long name; the middle of a longer one is left out
SLACK = 1.03  # renderers round widths to their pixels


def width_of(text: str, size: float) -> float:
    """The width in points of a line of text of `size` points; dollar signs are plain characters."""
    return SLACK * float(text_to_path.get_text_width_height_descent(text, FontProperties(size=size), ismath=False)[0])


def shortened(text: str, width: float, size: float) -> str:
    """The text, or its beginning and end with an ellipsis between them, no wider than `width` points."""
    if width_of(text, size) <= width:
        return text
    low, high = 1, len(text) - 1  # letters that are kept: the beginning gets the odd one
    while low < high:
        kept = (low + high + 1) // 2
        low, high = (kept, high) if width_of(_shorten_to(text, kept), size) <= width else (low, kept - 1)
    return _shorten_to(text, low)


def _shorten_to(text: str, letters: int) -> str:
    return text[: letters - letters // 2] + "…" + (text[-(letters // 2) :] if letters > 1 else "")


def shortened_apart(texts: Sequence[str], widths: float | Sequence[float], size: float) -> list[str]:
    """Different texts, each `shortened` to its width: where two would become the same, both are numbered."""
    widths = [widths] * len(texts) if isinstance(widths, int | float) else widths
    short = [shortened(text, width, size) for text, width in zip(texts, widths, strict=True)]
    repeated = {text for text in short if short.count(text) > 1}
    numbers = {text: itertools.count(1) for text in repeated}
    return [f"{shortened(text, 0.8 * width, size)} {next(numbers[s])}" if s in repeated else s
            for text, s, width in zip(texts, short, widths, strict=True)]  # fmt: skip


def wrapped(text: str, width: float, size: float, most: int = 6) -> list[str]:
    """The text in at most `most` lines, each at most `width` points wide.

    Lines break after commas, or else at spaces. A name longer than a line breaks after a punctuation mark if it can,
    and one longer than two lines is `shortened`. If there are still too many lines, the longest parts are shortened,
    and finally the whole text.
    """
    lines, share = _lines(text, width, size), 1.0
    while len(lines) > most and share > 0.1:
        share *= 0.7
        parts = [shortened(part, share * width, size) for part in _parts(text)]
        lines = _lines(" ".join(parts), width, size)
    share = 1.0
    while len(lines) > most:
        share *= 0.7
        lines = _lines(shortened(" ".join(_parts(text)), share * most * width, size), width, size)
    return lines


def _parts(text: str) -> list[str]:
    return re.split(r"(?<=,) ", " ".join(text.split()))


def _lines(text: str, width: float, size: float) -> list[str]:
    lines = [""]
    for part in _parts(text):
        if _put(lines, part, width, size):
            continue
        if width_of(part, size) <= width:
            lines.append(part)
            continue
        for word in part.split(" "):
            if not _put(lines, word, width, size):
                begun = lines.pop() + " " if 0.0 < width_of(lines[-1], size) < 0.25 * width else ""
                lines += _broken(begun + word, width, size)
    return [line for line in lines if line]


def _put(lines: list[str], part: str, width: float, size: float) -> bool:
    """Append a part to the last line if it fits, and return whether it does."""
    longer = f"{lines[-1]} {part}".lstrip()
    if width_of(longer, size) > width:
        return False
    lines[-1] = longer
    return True


def _broken(word: str, width: float, size: float) -> list[str]:
    """A name longer than a line, in at most MOST_LINES lines that end after a punctuation mark if possible."""
    # Each line but the last may lose the letters after its last mark.
    word = shortened(word, (MOST_LINES - 0.4) * width, size)
    lines = []
    while width_of(word, size) > width:
        fit = max(k for k in range(1, len(word)) if k == 1 or width_of(word[:k], size) <= width)
        marks = [k for k in range(int(0.6 * fit), fit + 1) if word[k - 1] in "_-,;:./()…"]
        fit = marks[-1] if marks else fit
        lines.append(word[:fit])
        word = word[fit:]
    return [*lines, word]


def write_numbers(
    axes: Axes, image: AxesImage, values: NDArray[np.float64], as_text: Callable[[float], str], size: float
) -> None:
    """Write each finite value (row, column) into its cell."""
    red, green, blue, _ = np.moveaxis(image.to_rgba(values), -1, 0)
    bright = 0.2126 * red**2.2 + 0.7152 * green**2.2 + 0.0722 * blue**2.2 > 0.18  # WCAG: black reads better
    for row, column in np.argwhere(np.isfinite(values)):
        axes.text(
            column, row, as_text(values[row, column]), ha="center", va="center",
            fontsize=size, color="black" if bright[row, column] else "white",
        )  # fmt: skip
