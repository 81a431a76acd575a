"""A table as commands and pages show it: columns of texts, a title and notes; as TSV, Markdown, LaTeX and HTML.

`terminal.show` prints it for people. Programs get all digits instead: `tsv` here, and JSON by `answers`.
"""

import re
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import chain
from numbers import Number
from pathlib import Path
from typing import Any

from swarmcensus.support.control_characters import spreadsheet_text
from swarmcensus.support.templates import render

INTERVAL = "[95 %]"  # the head of a column of intervals
INTERVALS = "intervals"  # among what is left out: no such column is shown
ENDLESS = "[>="  # how an interval begins that has a lower end only
NOTHING, NEVER = "-", "never"  # cells without a value, and of a time that is not reached
STAYS, KEY, ASKED, REST = range(4)  # ranks: what is never left out, tells rows apart, was asked for, goes first
ESCAPED = {
    "\\": r"\textbackslash{}", "~": r"\textasciitilde{}", "^": r"\textasciicircum{}", "<": r"\textless{}",
    ">": r"\textgreater{}", "|": r"\textbar{}", **{mark: f"\\{mark}" for mark in "&%$#_{}"},
}  # fmt: skip


@dataclass(frozen=True)
class Column:
    """A column: its head, its cells, whether they are numbers, and its rank.

    On a narrow terminal columns of the last rank are left out first, those on the right before others. Each cell may
    have an interval, a mark such as "*", and may be `strong`, as the best of its column. `name` is that of the values
    in the rows that programs get.
    """

    head: str
    cells: Sequence[str]
    number: bool = True
    rank: int = KEY
    intervals: Sequence[str] = ()
    marks: Sequence[str] = ()
    strong: Sequence[bool] = ()
    interval_head: str = INTERVAL
    of: str = ""  # the head of the column that this one has the intervals of
    name: str = ""
    unit: str = ""
    meaning: str = ""

    @property
    def is_empty(self) -> bool:
        """Whether it is a column of numbers, not asked for, in which no row has one, or of times never reached."""
        says_nothing = len(self.cells) > 0 and {cell.lstrip("<>= ") for cell in self.cells} in ({NOTHING}, {NEVER})
        return self.number and self.rank != ASKED and says_nothing

    def plain(self) -> Iterator["Column"]:
        """This column with marks before its cells, and a column of its intervals if it has any."""
        cells = self.cells
        if any(self.marks):
            wide = max(map(len, cells))
            cells = [f"{mark or ' '} {cell:>{wide}}" for mark, cell in zip(self.marks, cells, strict=True)]
        yield Column(self.head, cells, self.number, self.rank, strong=self.strong)
        if any(self.intervals):
            yield Column(self.interval_head, self.intervals, rank=self.rank, of=self.head)


@dataclass(frozen=True)
class Table:
    """A table for people.

    `above` are lines between title and table. `notes` gives the lines below it, from the names of columns that were
    left out. `more` says where the rows are that are left out.
    With `folds`, long texts are folded before columns are left out.
    """

    columns: Sequence[Column]
    title: str = ""
    above: Sequence[str] = ()
    notes: Callable[[Collection[str]], Iterable[str]] = lambda left_out: ()
    more: str = ""
    folds: bool = False

    @classmethod
    def of_rows(cls, heads: Mapping[str, bool], rows: Iterable[Sequence[str]], **more: Any) -> "Table":
        """A table of rows with lines that may be folded; `heads` says of each column whether it holds numbers."""
        cells = list(map(list, zip(*rows, strict=True))) or [[] for _ in heads]
        columns = [Column(head, each, heads[head]) for head, each in zip(heads, cells, strict=True)]
        return cls(columns, **{"folds": True, **more})

    @classmethod
    def of(cls, rows: Sequence[Mapping[str, Any]]) -> "Table":
        """A plain table of rows, with numbers of four digits."""
        names = [*dict.fromkeys(chain.from_iterable(rows))]
        texts = [[_short(row.get(name)) for name in names] for row in rows]
        are_numbers = [all(isinstance(row.get(name), Number | None) for row in rows) for name in names]
        return cls.of_rows(dict(zip((name.replace("_", " ") for name in names), are_numbers, strict=True)), texts)

    def first(self, rows: int) -> "Table":
        """The table with so many rows at most (0: all)."""
        total = max((len(one.cells) for one in self.columns), default=0)
        if not 0 < rows < total:
            return self
        parts = ("cells", "intervals", "marks", "strong")
        columns = [replace(one, **{part: getattr(one, part)[:rows] for part in parts}) for one in self.columns]
        return replace(self, columns=columns, more=f"{rows:,} of {total:,}")

    @property
    def has_one_sided(self) -> bool:
        """Whether an interval has a lower end only."""
        return any(text.startswith(ENDLESS) for column in self.columns for text in column.intervals)

    def legend(self, left_out: Collection[str] = ()) -> str:
        """What columns mean that say it and are not left out, and what intervals are if any are shown."""
        kept = [one for one in self.columns if one.meaning and one.head not in left_out and not one.is_empty]
        said = "; ".join(f"{one.head}: {one.meaning}" for one in kept)
        return re.sub(rf"; {re.escape(INTERVAL)}[^;]*", "", said) if INTERVALS in left_out else said

    def plain(self) -> "Table":
        """The table with marks in their cells, intervals in columns of their own, and no columns that say nothing."""
        known = [column for column in self.columns if not column.is_empty]
        if not any(column.number for column in known):  # nothing else would be left
            known = [*self.columns]
        return replace(self, columns=[part for one in known for part in one.plain()])


def with_ends(row: Mapping[str, Any]) -> dict[str, Any]:
    """A row in which each interval, a tuple of value and ends, is three entries: `name`, `name_low`, `name_high`."""
    found: dict[str, Any] = {}
    for name, value in row.items():
        several = value if isinstance(value, tuple) else (value,)
        found |= zip((name, f"{name}_low", f"{name}_high"), several, strict=False)
    return found


def fields(rows: Iterable[Mapping[str, Any]]) -> Iterator[list[str]]:
    """Rows as lines of texts: a line of names, those of all rows in order, then a line for each row.

    Numbers have all digits and no commas; what a row lacks, and NaN, is an empty field.
    """
    listed = list(rows)
    names = dict.fromkeys(chain.from_iterable(listed))
    for line in (names, *([row.get(name) for name in names] for row in listed)):
        yield [spreadsheet_text(_field(value)) for value in line]


def tsv(rows: Iterable[Mapping[str, Any]]) -> Iterator[str]:
    """The same with tabs between the texts of a line."""
    return map("\t".join, fields(rows))


def _short(value: Any) -> str:
    """A value for people: four digits of a fraction, and a mark where there is no value."""
    value = value.item() if hasattr(value, "item") else value
    if isinstance(value, float) and value == value:
        return f"{value:#.4g}".rstrip(".")
    return f"{value:,}" if type(value) is int else _field(value) or NOTHING


def _field(value: Any) -> str:
    if hasattr(value, "item"):  # a number of NumPy
        value = value.item()
    if isinstance(value, Mapping):
        value = [f"{name}={_field(each).replace(', ', ',')}" for name, each in value.items()]  # as --parameter takes it
    if isinstance(value, list | tuple):
        value = ", ".join(map(_field, value))
    if value is None or value != value:
        return ""
    if isinstance(value, bool):
        return "true" if value else "false"
    return "".join(f"\\u{ord(one):04x}" if one in "\t\n\r" else one for one in str(value))


def markdown(table: Table) -> str:
    """The columns in Markdown; strong cells are bold."""
    columns, cells = table.columns, []
    for one in columns:
        texts = [cell.strip().replace("*", r"\*").replace("|", r"\|") for cell in one.cells]
        strong = one.strong or [False] * len(texts)
        cells.append([f"**{text}**" if bold else text for text, bold in zip(texts, strong, strict=True)])
    rule = ["--:" if column.number else ":--" for column in columns]
    rows = ([column.head for column in columns], rule, *zip(*cells, strict=True))
    return "\n".join(f"| {' | '.join(row)} |".replace("\n", "; ") for row in rows)


def html(table: Table, title: str = "", sentences: Iterable[str] = ()) -> str:
    """The table as a part of a page: title, sentences, lines above, columns and notes."""
    plain = table.plain()
    below = [*filter(None, (table.legend(), *table.notes(()))), *([table.more] if table.more else [])]
    return render(
        Path(__file__).with_name("table.html.jinja"), title=title or table.title, columns=plain.columns,
        above=table.above, rows=list(zip(*(column.cells for column in plain.columns), strict=True)), below=below,
        said=list(sentences),
    )  # fmt: skip


def escaped(text: str) -> str:
    """Text with LaTeX's special characters escaped."""
    return "".join(ESCAPED.get(letter, letter) for letter in " ".join(text.split()))


def latex(table: Table) -> str:
    """The columns in LaTeX, with the package booktabs. Title, and notes as comments, are for the caption."""
    columns = table.columns
    heads = [escaped(column.head) for column in columns]
    heads = [head.replace(r"\%", r"(\%)") if one.number else head for head, one in zip(heads, columns, strict=True)]
    about = filter(None, (table.title, *table.above, table.legend(), *table.notes(())))
    lines = [
        *(f"% {' '.join(line.split())}" for line in about),
        rf"\begin{{tabular}}{{{''.join('lr'[column.number] for column in columns)}}}", r"\toprule",
        " & ".join(heads) + r" \\", r"\midrule",
    ]  # fmt: skip
    cells = [_latex_cells(column) if column.number else list(map(escaped, column.cells)) for column in columns]
    for texts in zip(*cells, strict=True):
        line = " & ".join(texts) + r" \\"
        lines.append("{}" * line.startswith("[") + line)  # or it would say how far below the last one it is
    return "\n".join([*lines, r"\bottomrule", r"\end{tabular}"]) + "\n"


def _latex_cells(column: Column) -> Iterator[str]:
    for row, cell in enumerate(column.cells):
        text = escaped(cell).replace("-", "$-$") if cell != "-" else "--"
        text = rf"\textbf{{{text}}}" if column.strong and column.strong[row] else text
        text += f"$^{{{column.marks[row]}}}$" if column.marks and column.marks[row] else ""
        interval = column.intervals[row] if column.intervals else ""
        if interval not in ("", "-"):
            ends = escaped(interval).replace("-", "$-$").replace(escaped(">="), r"$\geq$")
            text += f" {{\\footnotesize {ends}}}"
        yield text
