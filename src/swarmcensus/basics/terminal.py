"""Tables on standard output: as wide as the terminal, and in a file or pipe as wide as their content."""

import sys
from collections.abc import Iterable, Sequence
from itertools import product
from typing import Any, NamedTuple

from rich.console import Console, ConsoleOptions, RenderableType
from rich.segment import Segment
from rich.table import Table
from rich.text import Text

from swarmcensus.basics.printable import printable
from swarmcensus.basics.readers import MOST, asked_columns

UNFOLDED = MOST  # columns: a file or a pipe has no width
INTERVAL = "[95 %]"  # the head of a column of intervals
INTERVALS = "intervals"  # their name among what is left out
FIRST_OUT, NUMBER = 2000, 1000  # `spare` of intervals, which are left out before anything else, and of numbers


class _Console(Console):
    """A console for printable text. It passes on a broken pipe to the command; rich would exit with code 1."""

    def on_broken_pipe(self) -> None:
        raise BrokenPipeError

    def render(self, renderable: RenderableType, options: ConsoleOptions | None = None) -> Iterable[Segment]:
        for segment in super().render(renderable, options):
            yield segment if segment.control else segment._replace(text=printable(segment.text))


def console(**options: Any) -> Console:
    """A console for standard output, or error. It folds lines only in a terminal, and prints texts without markup."""
    stream = sys.stderr if options.get("stderr") else sys.stdout
    width = asked_columns() or (None if stream.isatty() else UNFOLDED)
    usual: dict[str, Any] = {"file": getattr(stream, "unescaped", stream), "width": width}
    return _Console(**usual | {"highlight": False, "markup": False, "emoji": False} | options)


def table(columns: Iterable[tuple[str, bool]], rows: Iterable[Iterable[str]]) -> Table:
    """A table without borders; `columns` are pairs of a name and whether the column holds numbers."""
    out = Table(box=None, pad_edge=False, header_style="bold")
    for name, number in columns:
        out.add_column(name, justify="right" if number else "left", no_wrap=number, overflow="fold")
    for row in rows:
        out.add_row(*(Text(printable(cell)) for cell in row))
    return out


class Column(NamedTuple):
    """A column of a table: its head, its cells, whether they are numbers, and how soon it is left out.

    On a narrow terminal columns with the largest `spare` are left out first, and those with 0 never: NUMBER and above
    for numbers, below for what says which row it is.
    """

    head: str
    cells: Sequence[str]
    number: bool = True
    spare: int = 0


def fitted(columns: Sequence[Column], out: Console) -> tuple[Table, list[str]]:
    """A table with a line for each row, and the names of what is left out so that it fits.

    Heads are put into two lines before anything is left out.
    """
    for most, narrow in product(sorted({column.spare for column in columns} | {0}, reverse=True), (False, True)):
        kept = [column for column in columns if column.spare <= most]
        heads = [_in_lines(column.head) if narrow else column.head for column in kept]
        rows = table(
            zip(heads, (column.number for column in kept), strict=True),
            zip(*(column.cells for column in kept), strict=True),
        )
        if fits(rows, out):
            break
    heads = [column.head for column in columns if column.spare > most]
    return rows, [INTERVALS] * any(map(_of_interval, heads)) + [head for head in heads if not _of_interval(head)]


def left_out(names: Sequence[str], out: Console, where: str = "--json has all") -> list[str]:
    """A sentence on columns that `fitted` left out, and where they are; none if it left out none."""
    if not names:
        return []
    return [f"left out, as they do not fit into {out.width} columns: {', '.join(names)}; {where}"]


def fits(rows: Table, out: Console) -> bool:
    """Whether no line of a table is folded."""
    return rows.__rich_measure__(out, out.options.update(max_width=UNFOLDED)).maximum <= out.width


def _of_interval(head: str) -> bool:
    return head.startswith("[")


def _in_lines(head: str) -> str:
    """A head in two lines, such as "fill" above "ratio"."""
    return head if _of_interval(head) or "\n" in head else "\n".join(head.replace("_", " ").split(" ", 1))
