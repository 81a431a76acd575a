"""Text from others' files on a terminal: control characters in it are shown and not executed by the terminal."""

import contextlib
import re
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any, TextIO, cast

if TYPE_CHECKING:
    import pandas as pd

# the control characters C0, DEL and C1 except tabs and line ends, and marks that change the direction of text
DIRECTIONS = "\u061c\u200e\u200f\u202a-\u202e\u2066-\u2069"
CONTROL = re.compile(f"[\x00-\x08\x0b\x0c\x0e-\x1f\x7f-\x9f{DIRECTIONS}]|\r(?!\n)")

FORMULA = ("=", "+", "-", "@", "\t", "\r", "'")  # how formulas of spreadsheets begin, and what marks such texts


def printable(text: str) -> str:
    r"""The text with control characters as JSON escapes them, such as \u001b."""
    return CONTROL.sub(lambda found: f"\\u{ord(found[0]):04x}", text)


def spreadsheet_text(value: Any) -> Any:
    """A cell of CSV: a text that spreadsheets may take for a formula has an apostrophe before it."""
    if not isinstance(value, str) or not value.startswith(FORMULA) or len(value) == 1:
        return value
    try:
        float(value)
    except ValueError:
        return f"'{value}"
    return value


def write_csv(frame: "pd.DataFrame", path: Path) -> None:
    """Write the columns of a data frame as CSV, with texts as `spreadsheet_text` has them."""
    texts = [name for name in frame.columns if frame[name].dtype.kind == "O"]
    safe = {name: frame[name].map({text: spreadsheet_text(text) for text in frame[name].unique()}) for name in texts}
    frame.assign(**safe).to_csv(path, index=False, lineterminator="\n")


class Escaping:
    """A stream of printable text on top of `unescaped`, which only tables write to, for their own colours."""

    def __init__(self, unescaped: TextIO) -> None:
        """Write to this stream."""
        self.unescaped = unescaped

    def write(self, text: str) -> int:
        """Write text; what ends all colours, as libraries write when Python ends, stays as it is."""
        return self.unescaped.write(text if text == "\x1b[0m" else printable(text))

    def __getattr__(self, name: str) -> object:
        """Everything else is the stream's."""
        return getattr(self.unescaped, name)


@contextlib.contextmanager
def escaping() -> Iterator[None]:
    """Escape what is written to standard output and error while the block lasts."""
    before = sys.stdout, sys.stderr
    sys.stdout, sys.stderr = (cast(TextIO, Escaping(stream)) for stream in before)
    try:
        yield
    finally:
        sys.stdout, sys.stderr = before
