"""Tables on standard output: as wide as the terminal, and in a file or pipe as wide as their content."""

import sys
from collections.abc import Iterable
from typing import Any

from rich.console import Console
from rich.table import Table
from rich.text import Text

UNFOLDED = 1_000_000  # columns: a file or a pipe has no width


class _Console(Console):
    """A console that passes on a broken pipe to the command; rich would exit with code 1."""

    def on_broken_pipe(self) -> None:
        raise BrokenPipeError


def console(**options: Any) -> Console:
    """A console for standard output, or error. It folds lines only in a terminal, and prints texts without markup."""
    stream = sys.stderr if options.get("stderr") else sys.stdout
    width = None if stream.isatty() else UNFOLDED
    return _Console(width=width, highlight=False, markup=False, emoji=False, **options)


def table(columns: Iterable[tuple[str, bool]], rows: Iterable[Iterable[str]]) -> Table:
    """A table without borders; `columns` are pairs of a name and whether the column holds numbers."""
    out = Table(box=None, pad_edge=False, header_style="bold")
    for name, number in columns:
        out.add_column(name, justify="right" if number else "left", no_wrap=number, overflow="fold")
    for row in rows:
        out.add_row(*map(Text, row))
    return out
