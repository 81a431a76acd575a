"""Where tables are printed: as wide as a terminal is, and elsewhere as wide as they are."""

import sys
from collections.abc import Iterable
from typing import Any

from rich.console import Console
from rich.table import Table
from rich.text import Text

UNFOLDED = 1_000_000  # columns: a file or a pipe has no edge


class _Console(Console):
    """One that leaves it to the command what is to be done where nobody reads any more: rich would exit with 1."""

    def on_broken_pipe(self) -> None:
        raise BrokenPipeError


def console(**options: Any) -> Console:
    """Of standard output. It folds lines at the edge of a terminal, and nowhere else; texts are taken as they are."""
    width = None if sys.stdout.isatty() else UNFOLDED
    return _Console(width=width, highlight=False, markup=False, emoji=False, **options)


def table(columns: Iterable[tuple[str, bool]], rows: Iterable[Iterable[str]]) -> Table:
    """A table without lines around it; `columns` are names, and whether they are numbers."""
    out = Table(box=None, pad_edge=False, header_style="bold")
    for name, number in columns:
        out.add_column(name, justify="right" if number else "left", no_wrap=number, overflow="fold")
    for row in rows:
        out.add_row(*map(Text, row))
    return out
