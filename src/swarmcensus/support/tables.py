"""Tables as spreadsheets, pandas, R and tools of networks write them: text files with any usual separator, data frames.

A table is understood by the names of its columns. What could be read in two ways is refused.
"""

import codecs
import csv
import functools
import re
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any, NamedTuple, NoReturn

import numpy as np

from swarmcensus.support.errors import InputError, TableError
from swarmcensus.support.formatting import counted

SEPARATORS = "\t;,"  # the first that is there; else spaces
COMMENTS = ("#", "%")
MISSING = ("", "na", "n/a", "#n/a", "nan", "null", "none", "<na>")
TRUTHS = {"true": 1.0, "false": 0.0}
WORDS = dict.fromkeys(MISSING, np.nan) | TRUTHS
NUMBER = re.compile(r"[+-]?(\d+\.?\d*|\.\d+)(e[+-]?\d+)?", re.ASCII)
THREE_DIGITS = re.compile(r"[+-]?\d+[.,]\d{3}", re.ASCII)  # decimals, or the end of thousands
SEPARATOR_LINE = re.compile('"?sep=."?', re.IGNORECASE)  # the first line of a table for Excel
ATTRIBUTES = re.compile(r"\s*\{(.*)\}$")  # of an edge, as networkx writes them
ROW_NUMBERS = ("", "unnamed0", "index")  # names of a column that counts rows, in pandas and R
MOST_WHOLE = 2.0**53  # beyond it, not every whole number is a float
FORMATS = {  # how files begin that are no tables
    "<": "XML, such as GraphML or GEXF",
    "*": "a network of Pajek",
    "%%matrixmarket": "a matrix of Matrix Market",
    ">>": "graph6 or sparse6",
    "/*": "DOT",
    "graph": "GML or DOT",
    "digraph": "DOT",
    "strict": "DOT",
    "creator": "GML",
    "{": "JSON",
    "[": "JSON",
}
AS_TABLE = "should be a table: save it as CSV in UTF-8 (a graph by networkx.write_edgelist(graph, path, data=False))"


class ReadTable(NamedTuple):
    """Columns of cells: texts of a file, or values of a data frame. All rows have the same length."""

    source: str  # the file or the argument, for messages
    names: list[str] | None  # of the columns, or None without a header
    rows: list[list[Any]]
    lines: Sequence[int] = ()  # the number of each row's line in its file
    separator: str = ""
    gap: int = 0  # the number of the first empty line between rows; 0 if there is none

    def where(self, row: int) -> str:
        """A row, for messages."""
        return f"{self.source}, line {self.lines[row]}" if self.lines else f"{self.source}, row {row}"

    def column(self, k: int, right: str = "a number") -> np.ndarray:
        """A column's numbers, NaN where a cell is empty or NA. Raises InputError."""
        cells = [str(row[k]) for row in self.rows]
        digits = "".join(cells)
        if all(cells) and digits.isascii() and digits.isdigit():  # as most tables are: quickly
            return np.array(list(map(float, cells)))
        out = np.empty(len(cells))
        for n, cell in enumerate(cells):
            try:
                out[n] = number(cell, self.has_commas)
            except ValueError:
                raise self.wrong(n, k, right) from None
        return out

    def whole(self, k: int) -> np.ndarray:
        """A column's whole numbers from 0. Raises InputError."""
        right = "a whole number from 0"
        values = self.column(k, right)
        wrong = ~((values >= 0.0) & (values < MOST_WHOLE) & (values == np.floor(values)))
        if wrong.any():
            raise self.wrong(int(np.argmax(wrong)), k, right)
        cells = {str(row[k]) for row in self.rows}
        unclear = {cell for cell in cells if cell.strip().lower() in TRUTHS}
        marked = {cell for cell in cells if THREE_DIGITS.fullmatch(cell.strip())}
        if self.has_commas and len(marked) < len(cells):  # else all cells have three decimals
            unclear |= marked
            right += ", without a mark of thousands or decimals"
        if unclear:
            raise self.wrong(next(n for n, row in enumerate(self.rows) if str(row[k]) in unclear), k, right)
        return values.astype(np.int64)

    def wrong(self, row: int, k: int, right: str) -> InputError:
        """The error for a cell that is not what it should be."""
        cell = str(self.rows[row][k]).strip()
        return self.error(row, f"{cell!r}: should be {right}", self.names[k] if self.names else None, cell)

    def error(self, row: int, what: str, key: str | None = None, value: str | None = None) -> TableError:
        """The error of a row; of a cell, `key` is the column's name and `value` the cell."""
        return TableError.of(self.source, what, key, value, where=self.where(row))

    def counts(self, k: int, starts: tuple[int, ...] = (0,)) -> bool:
        """Whether a column counts the rows."""
        try:
            values = self.whole(k)
        except InputError:
            return False
        return any(np.array_equal(values, np.arange(len(values)) + first) for first in starts)

    def without(self, *columns: int) -> "ReadTable":
        """The table without some columns."""
        if not columns:
            return self
        kept = [k for k in range(self.width) if k not in columns]
        names = self.names and [self.names[k] for k in kept]
        return self._replace(names=names, rows=[[row[k] for k in kept] for row in self.rows])

    @property
    def width(self) -> int:
        """How many columns there are."""
        return len(self.names if self.names is not None else self.rows[0] if self.rows else ())

    @property
    def has_commas(self) -> bool:
        """Whether numbers may have decimal commas."""
        return self.separator in (";", "\t")

    def is_empty(self, k: int) -> bool:
        """Whether no cell of a column has a value."""
        return all(str(row[k]).strip().lower() in MISSING for row in self.rows)

    def heading(self) -> list[float]:
        """The numbers of the first row, without an empty cell in front as pandas writes it."""
        cells = [number(cell, True) for cell in self.rows[0]]
        return cells[1:] if len(cells) > 1 and np.isnan(cells[0]) else cells

    def named_by_first_row(self) -> "ReadTable":
        """The table with the first row as names."""
        return _without_row_numbers(self._replace(names=self.rows[0], rows=self.rows[1:], lines=self.lines[1:]))

    def check_heading(self, names: str, rows: str) -> None:
        """Raise InputError if the first row may be the numbers of the columns, and so names, or values."""
        cells = self.heading()
        if cells == list(range(len(cells))):
            shown = self.separator.join(self.rows[0])
            advice = f"if names, write {names} instead; if {rows}, add a line {names} above it"
            raise self.error(0, f"{shown!r} may be names of columns or {rows}: {advice}")

    def refuse(self, columns: Sequence[int], right: str) -> NoReturn:
        """Raise InputError for columns that are not understood, or for too many without names."""
        if not self.names:
            there = counted(self.width, "column")
            raise TableError.of(self.source, f"{there} without names: the first line should name {right}")
        names = ", ".join(repr(self.names[k]) for k in columns)
        several = "s" * (len(columns) > 1)
        raise TableError.of(self.source, f"column{several} {names}: there should be {right}, and no others")


@functools.lru_cache(1 << 16)
def number(text: str, comma: bool) -> float:
    """A cell's number, with `comma` also one with a decimal comma; NaN for an empty cell or NA. Raises ValueError."""
    text = text.strip().lower()
    if text in WORDS:
        return WORDS[text]
    text = text.replace(",", ".") if comma else text
    if not NUMBER.fullmatch(text):
        raise ValueError
    return float(text)


def plain(name: str) -> str:
    """A column's name in small letters and digits alone: "Robot_0" is robot0."""
    return "".join(filter(str.isalnum, name.lower()))


def is_frame(value: Any) -> bool:
    """Whether a value is a data frame."""
    return hasattr(value, "columns") and hasattr(value, "to_numpy")


def frame_table(frame: Any, source: str) -> ReadTable:
    """A data frame as a table, with its index if that has a name."""
    if any(name is not None for name in getattr(getattr(frame, "index", None), "names", ())):
        frame = frame.reset_index()
    return _without_row_numbers(ReadTable(source, [str(name) for name in frame.columns], frame.to_numpy().tolist()))


def read_table(path: str | Path, known: Callable[[str], bool], *, ignore_attributes: bool = False) -> ReadTable:
    """Read a table from a text file; attributes of networkx's edges are refused, or left out.

    Separators are tabs, semicolons, commas or spaces; numbers may have decimal commas, but not between commas. Lines
    that begin with # or % are comments. The last one before the rows may name the columns: `known` says of a `plain`
    name whether it is a column's. Raises InputError.
    """
    lines = _text(Path(path)).replace("\r\n", "\n").replace("\r", "\n").split("\n")
    lines = [line.strip(" ") for line in lines]
    lines[0] = "" if SEPARATOR_LINE.fullmatch(lines[0]) else lines[0]
    numbers = [n for n, line in enumerate(lines, start=1) if line and not line.startswith(COMMENTS)]
    if not numbers:
        return ReadTable(str(path), None, [])
    texts = [_without_attributes(path, n, lines[n - 1], ignore_attributes) for n in numbers]
    starts = (lines[0].lower(), texts[0].lower())
    if kind := next((kind for start, kind in FORMATS.items() if any(line.startswith(start) for line in starts)), ""):
        raise TableError.of(path, f"looks like {kind}: {AS_TABLE}")
    separator = _separator(texts)
    comments = [line.lstrip("".join(COMMENTS) + " ") for line in lines[: numbers[0] - 1] if line]
    rows, heads = (_cells(path, some, separator) for some in (texts, comments[-1:]))
    names = None
    if not all(map(is_number, rows[0])):
        names, rows, numbers = rows[0], rows[1:], numbers[1:]
    elif heads and len(heads[0]) == len(rows[0]):
        are_known = [known(plain(name)) for name in heads[0]]
        if all(are_known) or (any(are_known) and separator != " "):
            names = heads[0]
    odd = next((k for k, row in enumerate(rows) if len(row) != len(rows[0])), None)
    if odd is not None:
        wrong = counted(len(rows[odd]), "value")
        raise TableError(f"{path}, line {numbers[odd]}: {wrong} where there were {len(rows[0])}", file=path)
    first, last = (numbers[0], numbers[-1]) if numbers else (0, 0)
    gap = next((n for n in range(first + 1, last) if not lines[n - 1]), 0)
    table = ReadTable(str(path), names, rows, numbers, separator, gap)
    return table if names is None else _without_row_numbers(_with_names_for_all(table))


def _separator(lines: list[str]) -> str:
    """What separates the cells of lines; nothing if there is one column."""
    sample = [re.sub('"[^"]*"', "_", line) for line in (lines[0], lines[-1])]
    found = next((mark for mark in SEPARATORS if any(mark in line for line in sample)), "")
    return found or (" " if len(sample[-1].split()) > 1 else "")


def _cells(path: str | Path, lines: list[str], separator: str) -> list[list[str]]:
    try:
        rows = list(csv.reader(lines, delimiter=separator or "\t", skipinitialspace=True))
    except csv.Error as error:
        raise TableError.of(path, f"cannot be read as CSV: {error}") from error
    if len(rows) != len(lines):
        raise TableError.of(path, "cannot be read as CSV: a cell in quotes goes on in the next line")
    return rows


def _text(path: Path) -> str:
    try:
        content = path.read_bytes()
        wide = content.startswith((codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE))
        text = content.decode("utf-16" if wide else "utf-8-sig")
    except OSError as error:
        raise TableError.of(path, f"cannot be read: {error.strerror or error}") from error
    except UnicodeDecodeError:
        text = "\0"
    if "\0" in text:
        raise TableError.of(path, f"cannot be read as text in UTF-8: {AS_TABLE}")
    return text


def _without_attributes(path: str | Path, line: int, text: str, ignore: bool) -> str:
    """A line of networkx's edge lists without the dictionary at its end, which should be empty unless `ignore`."""
    found = ATTRIBUTES.search(text) if text.endswith("}") else None
    if found is None or found.start() == 0:
        return text
    if found[1].strip() and not ignore:
        what = f"{found[0].strip()}: links have no attributes: write it with data=False"
        raise TableError.of(path, what, where=f"{path}, line {line}")
    return text[: found.start()]


def is_number(cell: str) -> bool:
    """Whether a cell is a number, or empty."""
    try:
        number(cell, True)
    except ValueError:
        return False
    return True


def _with_names_for_all(table: ReadTable) -> ReadTable:
    """A table with as many names as columns: R names no row numbers, and a separator at the end makes a column."""
    names, rows = table.names or [], table.rows
    width = len(rows[0]) if rows else len(names)
    while width and not any(names[width - 1 :]) and not any(row[width - 1] for row in rows):
        width -= 1
    names = names[:width] + [name for name in names[width:] if name]
    rows = rows if not rows or len(rows[0]) == width else [row[:width] for row in rows]
    if len(names) + 1 == width:
        names = ["", *names]
    if len(names) != width:
        names_there = counted(len(names), "name")
        raise table.error(0, f"{counted(width, 'value')} under {names_there}")
    return table._replace(names=names, rows=rows)


def _without_row_numbers(table: ReadTable) -> ReadTable:
    """A table without a first column that counts rows from 0 or 1. Raises InputError for names that are not unique."""
    names = [plain(name) for name in table.names or ()]
    if names and names[0] in ROW_NUMBERS:
        if not table.counts(0, (0, 1)):
            said = f"is named {table.names[0]!r}" if table.names and table.names[0] else "has no name"
            raise TableError.of(
                table.source,
                f"the first column {said}, and does not count rows: leave it out if it is an index "
                f"(index=False in pandas, row.names=FALSE in R), or name all columns by what they are",
            )
        table, names = table.without(0), names[1:]
    if twice := {name for name in names if names.count(name) > 1}:
        raise TableError.of(table.source, f"two columns are named {min(twice)!r}")
    return table
