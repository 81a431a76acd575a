"""Tables on standard output: as wide as the terminal, and in a file or pipe as wide as their content."""

import io
import os
import re
import shutil
import sys
from collections.abc import Callable, Iterable, Iterator, Sequence
from typing import Any

from rich.cells import cell_len
from rich.console import Console, ConsoleOptions, RenderableType
from rich.segment import Segment
from rich.table import Table as RichTable
from rich.text import Text

from swarmcensus.support.control_characters import printable
from swarmcensus.support.printed_tables import ASKED, INTERVALS, KEY, REST, Column, Table
from swarmcensus.support.readers import MOST, terminal_columns

UNFOLDED = MOST  # columns: a file or a pipe has no width
WIDTH = 120  # columns of a table as text
GAP = 2  # blanks between columns
FOLDED = 30  # columns of a folded text at the least
MEASURED = re.compile(r"M\(([^()]{40,})\)")  # accuracies and errors of robots one after another, as worlds write them


class _Console(Console):
    """A console for printable text. It passes on a broken pipe to the command; rich would exit with code 1."""

    def print(self, *objects: Any, **options: Any) -> None:
        super().print(*(_brief(one) if isinstance(one, str) else one for one in objects), **options)

    def on_broken_pipe(self) -> None:
        raise BrokenPipeError

    def render(self, renderable: RenderableType, options: ConsoleOptions | None = None) -> Iterable[Segment]:
        for segment in super().render(renderable, options):
            yield segment if segment.control else segment._replace(text=printable(segment.text))


def console(**options: Any) -> Console:
    """A console for standard output, or error. It folds lines only in a terminal, and prints texts without markup."""
    stream = sys.stderr if options.get("stderr") else sys.stdout
    width = terminal_columns() or (None if stream.isatty() else UNFOLDED)
    if width is None and os.environ.get("COLUMNS") == "0":  # which rich would take for the width
        width = shutil.get_terminal_size().columns
    usual: dict[str, Any] = {"file": getattr(stream, "unescaped", stream), "width": width}
    if not stream.isatty():
        usual["force_terminal"] = False  # whatever FORCE_COLOR and TTY_COMPATIBLE say, as in continuous integration
    if os.environ.get("NO_COLOR"):
        usual["color_system"] = None  # which leaves nothing bold either
    return _Console(**usual | {"highlight": False, "markup": False, "emoji": False} | options)


def _brief(text: str) -> str:
    """A text with the number of measured robots in place of the accuracy of each, which programs and files get."""
    return MEASURED.sub(lambda found: f"measured ({found[1].count(',') // 2 + 1} robots)", text)


def show(table: Table, out: Console | None = None, longer: str = "") -> tuple[int, list[str]]:
    """Print a table with its title and notes, and return how many rows, and the names of columns that do not fit.

    `longer` says where rows are that were left out.
    """
    out, legend, table = out or console(), table.legend, table.plain()
    if table.title:
        out.print(table.title)
    for line in table.above:
        out.print(line, style="dim")
    kept, heads = _fitting(table.columns, out.width, table.folds)
    lacking = _lacking(table.columns, kept)
    out.print(_grid(kept, heads))
    unsaid = lacking + [INTERVALS] * (not any(column.of for column in kept))
    for line in filter(None, (legend(unsaid), *table.notes(unsaid))):
        out.print(line, style="dim")
    if table.more:
        out.print("; ".join(filter(None, (table.more, longer))), soft_wrap=True)  # to be copied
    return max((len(column.cells) for column in table.columns), default=0), lacking


def as_text(print_on: Callable[[Console], None], width: int = WIDTH) -> str:
    """What is printed on a console, as text of so many columns, for the `repr` of an object."""
    text = io.StringIO()
    print_on(console(file=text, width=width, force_jupyter=False, force_terminal=False))  # a kernel claims to be both
    return "\n".join(line.rstrip() for line in text.getvalue().splitlines())


def _fitting(columns: Sequence[Column], width: int, folds: bool) -> tuple[list[Column], list[str]]:
    """The columns that fit, and their heads, in two lines before anything is left out; a number is never folded."""
    for kept in _choices(columns):
        whole = [column.head for column in kept]
        for heads in (whole, [_in_lines(head) for head in whole]):
            widths = [*map(_width, kept, heads)]
            least = [
                min(FOLDED, one) if folds and not column.number else one
                for column, one in zip(kept, widths, strict=True)
            ]
            if sum(least) + GAP * (len(kept) - 1) <= width:
                return kept, heads
    return kept, heads


def _width(column: Column, head: str) -> int:
    return max(map(cell_len, (*head.split("\n"), *map(printable, map(_brief, column.cells)))))


def _choices(columns: Sequence[Column]) -> Iterator[list[Column]]:
    """Columns that may be shown: at first all of them, then fewer and fewer.

    Of each rank intervals are left out first, then columns, those on the right before others. The first column that was
    asked for stays, and the first that tells rows apart.
    """
    kept = [*columns]
    yield kept
    for rank in (REST, ASKED, KEY):
        ranked = [column for column in columns if column.rank == rank]
        ordered = [*filter(lambda one: one.of, reversed(ranked)), *filter(lambda one: not one.of, reversed(ranked))]
        for column in ordered if rank == REST else ordered[:-1]:
            kept = [one for one in kept if one is not column]
            yield kept


def _lacking(columns: Sequence[Column], kept: Sequence[Column]) -> list[str]:
    """The names of what is left out: columns, and intervals of others."""
    lost = [column for column in columns if not any(column is one for one in kept)]
    heads = [column.head for column in lost if not column.of]
    return heads + [f"{column.of} {column.head}" for column in lost if column.of and column.of not in heads]


def _grid(columns: Sequence[Column], heads: Sequence[str]) -> RichTable:
    """A table without borders, in which long texts are folded."""
    out = RichTable(box=None, pad_edge=False, header_style="bold")
    for column, head in zip(columns, heads, strict=True):
        out.add_column(head, justify="right" if column.number else "left", no_wrap=column.number, overflow="fold")
    for row in zip(*(column.cells for column in columns), strict=True):
        out.add_row(*(Text(printable(_brief(cell))) for cell in row))
    return out


def _in_lines(head: str) -> str:
    """A head in two lines, such as "fill" above "ratio"."""
    return head if head.startswith("[") or "\n" in head else "\n".join(head.replace("_", " ").split(" ", 1))
