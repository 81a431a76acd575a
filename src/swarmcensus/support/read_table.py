"""Tables as spreadsheets, pandas, R and tools of networks write them: text files, Parquet files and data frames.

A table is understood by the names of its columns, or as options say. What could be read in two ways is refused.
"""

import csv
import re
from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from swarmcensus.support.errors import TableError
from swarmcensus.support.formatting import counted
from swarmcensus.support.hints import did_you_mean
from swarmcensus.support.options import option, wrong_option
from swarmcensus.support.texts import read_text

if TYPE_CHECKING:
    import pandas as pd

SEPARATORS = "\t;,"  # the first that is in the line with the names; else spaces
COMMENT = re.compile("%|#(?!n/a)", re.IGNORECASE)  # #N/A is a missing value of spreadsheets
MISSING = ("", "na", "n/a", "#n/a", "nan", "nat", "null", "none", "<na>")
NUMBER = re.compile(r"[+-]?(\d+(?:\.\d*)?|\.\d+)(e[+-]?\d+)?", re.ASCII | re.IGNORECASE)
WHOLE = re.compile(r"^([0-9]+)\.0+$")
THOUSANDS = re.compile(r"[+-]?[1-9]\d{0,2}[.,]\d{3}", re.ASCII)  # or three decimals
SEPARATOR_LINE = re.compile('"?sep=."?', re.IGNORECASE)  # the first line of a table for Excel
OTHERS = re.compile(r"<|\*|%%matrixmarket|>>|/\*|(di)?graph\b|strict\b|creator\b|[{\[]", re.IGNORECASE)
MOST_WHOLE = 2.0**53  # beyond it, not every whole number is a float
MOST_SHOWN = 200  # characters of a row in a message
UNNAMED = "Unnamed: 0"  # as pandas calls a first column without a name
COUNTS = (UNNAMED, "index")  # names of a first column that may count the rows


class Table(NamedTuple):
    """Columns of texts, or of what a data frame has; missing cells are NA."""

    source: str  # the file or the argument, for messages
    frame: "pd.DataFrame"  # its index are the numbers of lines in a file, or of rows
    named: bool = True  # whether columns have names, or else numbers
    unit: str = "row"  # "line" in a text file
    separator: str = ""
    decimal: str | None = None  # the mark of decimals; None: a comma if it can be nothing else
    gap: int = 0  # the number of the first empty line between rows; 0 if there is none

    @property
    def names(self) -> list[str]:
        """The names of the columns; of columns without names their numbers."""
        return [str(name) for name in self.frame.columns]

    def texts(self, name: str) -> np.ndarray:
        """The cells of a column as texts, whole numbers without decimals; empty where they are missing."""
        import pandas as pd

        codes, distinct = pd.factorize(np.asarray(self.frame[name]))
        texts = [text if self.separator in (";", "\t") else WHOLE.sub(r"\1", text) for text in map(_text, distinct)]
        texts = ["" if text.lower() in MISSING else text for text in texts]
        return np.asarray(np.array([*texts, ""], object)[codes])

    def values(self, name: str, right: str, words: Mapping[str, float] = {}) -> np.ndarray:
        """The numbers of a column, or what its words stand for; NaN where a cell is missing. Raises InputError."""
        import pandas as pd

        texts = self.texts(name)
        distinct = [text for text in pd.unique(texts) if text]
        mark, numbers = self._mark(name, distinct), {"": np.nan}
        for text in distinct:
            number = str(words.get(text.lower(), text.replace(mark, ".")))
            if not NUMBER.fullmatch(number):
                raise self.wrong(int(np.argmax(texts == text)), name, right)
            numbers[text] = float(number)
        return np.asarray(pd.Series(texts, dtype=object).map(numbers).to_numpy(np.float64))

    def whole(self, name: str) -> np.ndarray:
        """The whole numbers from 0 of a column. Raises InputError."""
        right = "a whole number from 0"
        values = self.values(name, right)
        wrong = ~((values >= 0.0) & (values < MOST_WHOLE) & (values == np.floor(values)))
        if wrong.any():
            raise self.wrong(int(np.argmax(wrong)), name, right)
        return values.astype(np.int64)

    def _mark(self, name: str, texts: Sequence[str]) -> str:
        """The mark of decimals in a column. Raises InputError if it may be one of thousands."""
        if self.decimal is not None or self.separator not in (";", "\t"):
            return self.decimal or "."
        marked = [text for text in texts if re.search("[.,]", text)]
        if marked and all(map(THOUSANDS.fullmatch, marked)):
            row = int(np.argmax(self.texts(name) == marked[0]))
            right = f"without a mark of thousands; {option('decimal', marked[0][-4])} if it has decimals"
            raise self.wrong(row, name, right)
        return "," if any("," in text for text in marked) and not any("." in text for text in marked) else "."

    def where(self, row: int) -> str:
        """A row, for messages."""
        return f"{self.source}, {self.unit} {self.frame.index[row]}"

    def wrong(self, row: int, name: str, right: str) -> TableError:
        """The error of a cell that is not what it should be."""
        cell = _text(self.frame[name].iloc[row])
        return self.error(row, f"{cell!r}: should be {right}", name if self.named else None, cell)

    def error(self, row: int, what: str, key: str | None = None, value: str | None = None) -> TableError:
        """The error of a row; of a cell, `key` is the column's name and `value` the cell."""
        return TableError.of(self.source, f"column {key!r}: {what}" if key else what, key, value, where=self.where(row))

    def refused(self, what: str) -> TableError:
        """The error of a table that does not fit, with its first row."""
        cells = [_text(value) for value in self.frame.iloc[0]] if len(self.frame) else self.names
        if self.named and len(self.frame):
            cells = [f"{name} = {cell}" for name, cell in zip(self.names, cells, strict=True)]
        shown = ", ".join(cells) or "empty"
        shown = f"{shown[:MOST_SHOWN]} ..." if len(shown) > MOST_SHOWN else shown
        there = "Its first row is" if len(self.frame) else "It has no rows, and the columns" if cells else "It is"
        return TableError.of(self.source, f"{what}. {there} {shown}")

    def ambiguous(self, names: str, rows: str) -> TableError:
        """The error of a first row that may be the numbers of columns, and so names, or values."""
        line = self.separator.join(self.names if self.named else map(_text, self.frame.iloc[0]))
        advice = f"if names, write {names} instead; if {rows}, add a line {names} above it"
        where = self.source if self.named else self.where(0)
        return TableError.of(self.source, f"{line!r} may be names of columns or {rows}: {advice}", where=where)

    def counts(self, name: str, starts: Iterable[int] = (0,)) -> bool:
        """Whether a column counts the rows."""
        texts = self.texts(name)
        return any(np.array_equal(texts, [str(k + first) for k in range(len(texts))]) for first in starts)

    def column(self, asked: str, said: str | None, obvious: Sequence[str]) -> str | None:
        """The name of a column: what the option `asked` has `said`, or the one with an obvious name; None without one.

        Raises InputError if there is no such column, or more than one.
        """
        if said is not None:
            if said not in self.names:
                besides = " that does more than count the rows" if said in COUNTS else ""
                known = did_you_mean(said, self.names) or f"should be one of {', '.join(map(repr, self.names))}"
                raise wrong_option(asked, said, f"{self.source} has no such column{besides}: {known.strip()}")
            return said
        found = [name for name in self.names if plain(name) in obvious] if self.named else []
        if len(found) > 1:
            several = " and ".join(map(repr, found))
            raise self.refused(f"columns {several} are there: say which is meant with {option(asked, found[0])}")
        return found[0] if found else None

    def plain_names(self) -> dict[str, str]:
        """The names of the columns by their `plain` forms. Raises InputError if two are alike."""
        names = {plain(name): name for name in self.names}
        if again := next((name for name in self.names if names[plain(name)] != name), None):
            raise self.refused(f"columns {again!r} and {names[plain(again)]!r} have one name: leave one of them out")
        return names

    def without(self, *names: str) -> "Table":
        """The table without some columns."""
        return self._replace(frame=self.frame.drop(columns=list(names)))


def plain(name: str) -> str:
    """A column's name in small letters and digits alone: "Robot_0" is robot0."""
    return "".join(filter(str.isalnum, name.lower()))


def in_order(name: str) -> list[Any]:
    """A key that sorts names as people count: robot 2 comes before robot 10."""
    parts = re.split(r"(\d+)", name)
    return [(len(part.lstrip("0")), part.lstrip("0")) if k % 2 else part for k, part in enumerate(parts)]


def is_frame(value: Any) -> bool:
    """Whether a value is a data frame."""
    return hasattr(value, "columns") and hasattr(value, "to_numpy")


def frame_table(frame: Any, source: str) -> Table:
    """A data frame of pandas, or of another library that makes one, as a table; its index unless it counts the rows."""
    if not hasattr(frame, "reset_index"):
        frame = frame.to_pandas()
    unnamed = frame.index.names == [None]
    counts = unnamed and np.array_equal(frame.index, np.arange(len(frame)))
    frame = (frame.rename_axis(UNNAMED) if unnamed else frame).reset_index(drop=counts, allow_duplicates=True)
    return _check_names(Table(source, frame.set_axis([str(name) for name in frame.columns], axis=1)))


def read_table(
    path: str | Path, known: Callable[[str], bool], decimal: str | None = None,
    edges: Callable[[str], str] | None = None,
) -> Table:  # fmt: skip
    """Read a table from a text file or a Parquet file; `edges` changes the lines of a table of links first.

    Separators are tabs, semicolons, commas or spaces. Lines that begin with # or % are comments. The first row, if it
    has more than numbers, or else the last comment above it, names the columns: `known` says of a `plain` name in a
    comment whether it does. Raises InputError.
    """
    import pandas as pd

    if Path(path).suffix.lower() in (".parquet", ".pq"):
        return _parquet(path)
    lines = read_text(path, kind=TableError, most=None).split("\n")
    lines[0] = "" if SEPARATOR_LINE.fullmatch(lines[0].strip()) else lines[0]
    lines = [line.strip(" ") for line in lines]
    comments = {n: line for n, line in enumerate(lines, start=1) if COMMENT.match(line)}
    numbers = [n for n, line in enumerate(lines, start=1) if line and n not in comments]
    if not numbers:
        return Table(str(path), pd.DataFrame(), False, "line")
    if OTHERS.match(first := next(line for line in lines if line)) or OTHERS.match(first := lines[numbers[0] - 1]):
        raise TableError.of(path, f"is no table, but a file that begins with {first[:40]!r}: save it as CSV")
    texts = [edges(lines[n - 1]) if edges else lines[n - 1] for n in numbers]
    first, last = (re.sub('"[^"]*"', "_", text) for text in (texts[0], texts[-1]))
    separator = next((mark for mark in SEPARATORS if mark in first), " " if len(last.split()) > 1 else "")
    if separator == "," and decimal == ",":
        raise wrong_option("decimal", ",", f"{path} has commas between its columns")
    try:
        rows = list(_rows(texts, separator))
    except csv.Error as error:
        raise TableError.of(path, f"cannot be read as CSV: {error}") from error
    if len(rows) != len(texts):
        raise TableError.of(path, "cannot be read as CSV: a cell in quotes goes on in the next line")
    begin = numbers[0]
    head = next(_rows([line.lstrip("#% ") for line in lines[: begin - 1] if line][-1:], separator), [])
    if named := _is_head(rows[0]):
        names, numbers = _names(rows.pop(0), rows), numbers[1:]
    elif named := len(head) == len(rows[0]) and all(known(plain(name)) for name in head):
        names = head
    else:
        names = list(map(str, range(len(rows[0]))))
    for n, line in comments.items():
        cells, is_close = line[1:].split(separator.strip() or None), not line[1:2].isspace()
        is_row = is_close and len(cells) == len(names) and n > begin - 2 * (not named)
        is_node = edges and separator == " " and len(cells) == 1 and (n > begin or NUMBER.fullmatch(cells[0]))
        if is_row or is_node:
            right = "write comments above all rows, names that begin so in quotes, and igraph's LGL as pairs of nodes"
            raise TableError.of(path, f"{line!r} may be no comment: {right}", where=f"{path}, line {n}")
    for number, row in zip(numbers, rows, strict=True):
        if len(row) == len(names) + 1 and not row[-1]:  # a separator at the end
            row.pop()
        if len(row) != len(names):
            there = f"{counted(len(row), 'value')}{f' separated by {separator!r}' if separator else ''}"
            raise TableError.of(path, f"{there} where there should be {len(names)}", where=f"{path}, line {number}")
    gap = next((n for n in range(numbers[0] + 1, numbers[-1]) if not lines[n - 1]), 0) if numbers else 0
    frame = pd.DataFrame(rows, index=numbers, columns=names, dtype=object)
    return _check_names(Table(str(path), frame, named, "line", separator, decimal, gap))


def _parquet(path: str | Path) -> Table:
    import pandas as pd

    try:
        frame = pd.read_parquet(path)
    except ImportError:
        raise TableError.of(path, "parquet needs pyarrow: pip install 'swarmcensus[parquet]'") from None
    except Exception as error:  # pyarrow raises many
        raise TableError.of(path, f"cannot be read as Parquet: {getattr(error, 'strerror', None) or error}") from error
    return frame_table(frame, str(path))


def _rows(lines: Sequence[str], separator: str) -> Iterator[list[str]]:
    """The cells of lines. pandas would fill up short rows, and take a column that has no name for an index."""
    return csv.reader(lines, delimiter=separator or "\t", skipinitialspace=True)


def _names(names: list[str], rows: list[list[str]]) -> list[str]:
    """As many names as columns: R names no row numbers, and a separator at the end makes a column."""
    while len(names) > 1 and not names[-1] and not any(row[len(names) - 1 :] not in ([], [""]) for row in rows):
        names = names[:-1]
    if rows and all(len(row) == len(names) + 1 and row[-1] for row in rows):
        names = ["", *names]
    return [names[0] or UNNAMED, *names[1:]]


def _check_names(table: Table) -> Table:
    """A table without a first column that counts rows and has no name. Raises InputError for equal names."""
    names = table.names
    if len({*names}) < len(names):
        twice = min(name for name, count in Counter(names).items() if count > 1)
        raise TableError.of(table.source, f"two columns are named {twice!r}: the first row should name all")
    is_count = names and names[0] in COUNTS and table.counts(names[0], (0, 1))
    return table.without(names[0]) if is_count and len(names) > 1 else table


def _is_head(cells: list[str]) -> bool:
    """Whether a first row has names: a text, or numbers that count columns, of over three or next to an empty cell."""
    cells = [cell.strip() for cell in cells]
    if any(cell.lower() not in MISSING and not NUMBER.fullmatch(cell.replace(",", ".")) for cell in cells):
        return True
    numbers = cells if cells[0] else cells[1:]
    is_count = any(numbers == [str(k + first) for k in range(len(numbers))] for first in (0, 1))
    return is_count and len(cells) > (3 if cells[0] else 1)


def _text(value: Any) -> str:
    """A cell as text: whole numbers without decimals, as they are among missing values in data frames."""
    return f"{value:.0f}" if isinstance(value, float) and value.is_integer() else str(value).strip()
