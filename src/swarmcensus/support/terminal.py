"""Tables on standard output: as wide as the terminal, and in a file or pipe as wide as their content."""

import io
import os
import shutil
import sys
from collections.abc import Callable, Iterable, Iterator, Sequence
from itertools import pairwise, product
from typing import Any

from rich.console import Console, ConsoleOptions, RenderableType
from rich.segment import Segment
from rich.table import Table as RichTable
from rich.text import Text

from swarmcensus.support.printable import printable
from swarmcensus.support.printed_tables import FEW, FIRST_OUT, INTERVALS, Column, Table
from swarmcensus.support.readers import MOST, asked_columns

UNFOLDED = MOST  # columns: a file or a pipe has no width
WIDTH = 120  # columns of a table as text


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
    if width is None and os.environ.get("COLUMNS") == "0":  # which rich would take for the width
        width = shutil.get_terminal_size().columns
    usual: dict[str, Any] = {"file": getattr(stream, "unescaped", stream), "width": width}
    if not stream.isatty():
        usual["force_terminal"] = False  # whatever FORCE_COLOR and TTY_COMPATIBLE say, as in continuous integration
    if os.environ.get("NO_COLOR"):
        usual["color_system"] = None  # which leaves nothing bold either
    return _Console(**usual | {"highlight": False, "markup": False, "emoji": False} | options)


def show(table: Table, out: Console | None = None, where: str = "--json has all") -> None:
    """Print a table with its title and notes; `where` says where columns are that do not fit."""
    out, table = out or console(), table.plain()
    if table.title:
        out.print(table.title)
    for line in table.above:
        out.print(line, style="dim")
    pages, lacking = _pages(table, out)
    for page in pages:
        out.print(page)
    if lacking:
        out.print(f"left out, as they do not fit into {out.width} columns: {', '.join(lacking)}; {where}", style="dim")
    for line in table.notes(lacking):
        out.print(line, style="dim")
    if table.more:
        out.print(table.more, soft_wrap=True)  # to be copied


def as_text(print_on: Callable[[Console], None], width: int = WIDTH) -> str:
    """What is printed on a console, as text of so many columns, for the `repr` of an object."""
    text = io.StringIO()
    print_on(console(file=text, width=width, force_jupyter=False, force_terminal=False))  # a kernel claims to be both
    return "\n".join(line.rstrip() for line in text.getvalue().splitlines())


def fitted(columns: Sequence[Column], out: Console) -> tuple[RichTable, list[Column]]:
    """A table with a line for each row, and the columns that it has, so that it fits.

    Heads are put into two lines before anything is left out.
    """
    for kept, narrow in product(_choices(columns), (False, True)):
        rows = _grid(kept, [_in_lines(column.head) if narrow else column.head for column in kept])
        if _fits(rows, out):
            break
    return rows, kept


def _lacking(columns: Sequence[Column], kept: Sequence[Column]) -> list[str]:
    """The names of what is left out: intervals, of which columns if others have theirs, and then columns."""
    lost = [column for column in columns if column not in kept]
    heads = [column.head for column in lost if not _of_interval(column.head)]
    of = [column.of for column in lost if _of_interval(column.head)]
    if any(_of_interval(column.head) for column in kept):
        named = [head for head in of if head not in heads]
        return [f"{INTERVALS} of {', '.join(named)}"] * bool(named) + heads
    return [INTERVALS] * bool(of) + heads


def _choices(columns: Sequence[Column]) -> Iterator[list[Column]]:
    """Columns that may be shown: at first all of them, at last only those that are never left out.

    Less important numbers make room for intervals; then intervals, numbers and what tells rows apart are left out.
    """
    spares = sorted({0, *(column.spare for column in columns)} - {FIRST_OUT}, reverse=True)
    yield [*columns]
    for dropped, most in pairwise(spares):
        if dropped > FEW:
            yield _up_to(most, columns, True)
    for most in spares:
        yield _up_to(most, columns, False)


def _up_to(most: int, columns: Sequence[Column], with_intervals: bool) -> list[Column]:
    """Columns that are left out as late as `most` or later, and perhaps their intervals."""
    heads = {column.head for column in columns if column.spare <= most}
    return [
        column for column in columns
        if column.spare <= most or (with_intervals and column.spare == FIRST_OUT and {column.of} <= heads | {""})
    ]  # fmt: skip


def _pages(table: Table, out: Console) -> tuple[list[RichTable], list[str]]:
    """All columns together, or a table for each group if they do not fit; and the names of what is left out."""
    if table.folds:
        return [_grid(table.every, [column.head for column in table.every], table.cuts)], []
    together, kept = fitted(table.every, out)
    lacking = _lacking(table.every, kept)
    if not table.groups or (_fits(together, out) and {*lacking} <= {INTERVALS}):
        return [together], lacking
    pages = [fitted([*table.columns, *group], out) for group in table.groups]
    return [page for page, _ in pages], _lacking(table.every, [column for _, kept in pages for column in kept])


def _grid(columns: Sequence[Column], heads: Sequence[str], cuts: bool = False) -> RichTable:
    """A table without borders, in which long texts are folded; with `cuts`, the last column's are cut."""
    out = RichTable(box=None, pad_edge=False, header_style="bold")
    for column, head in zip(columns, heads, strict=True):
        justify = "right" if column.number else "left"
        whole = column.number or (cuts and column is not columns[-1])
        out.add_column(head, justify=justify, no_wrap=whole, overflow="fold")  # type: ignore[arg-type]
    for row in zip(*(column.cells for column in columns), strict=True):
        out.add_row(
            *(Text(printable(cell), no_wrap=cuts or None, overflow=(cuts and "ellipsis") or None) for cell in row)
        )
    return out


def _fits(rows: RichTable, out: Console) -> bool:
    """Whether no line of a table is folded."""
    return rows.__rich_measure__(out, out.options.update(max_width=UNFOLDED)).maximum <= out.width


def _of_interval(head: str) -> bool:
    return head.startswith("[")


def _in_lines(head: str) -> str:
    """A head in two lines, such as "fill" above "ratio"."""
    return head if _of_interval(head) or "\n" in head else "\n".join(head.replace("_", " ").split(" ", 1))
