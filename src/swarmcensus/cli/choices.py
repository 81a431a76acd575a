"""The command `list`: what there is to choose from, ours and what other installed packages add."""

import argparse
import ast
import importlib
from collections.abc import Iterator

from swarmcensus.basics.errors import InputError
from swarmcensus.cli.options import DOORS


def choices(options: argparse.Namespace) -> int:
    """List what there is, kind by kind."""
    from swarmcensus.basics.terminal import console, table

    for kind in [options.kind] if options.kind else DOORS:
        heads = [(kind, False), ("what it is", False), ("from", False)]
        console().print(table(heads, list(_rows(kind))))
    return 0


def _rows(kind: str) -> Iterator[tuple[str, str, str]]:
    """Each one's name, the first line of its file, which is not run, and the package that gives it."""
    door = importlib.import_module(f"swarmcensus.{DOORS[kind]}").DOOR
    for name in door.names:
        try:
            text = ast.get_docstring(ast.parse(door.path(name).read_text(encoding="utf-8-sig"))) or ""
        except (InputError, OSError, ValueError, SyntaxError) as error:
            text = f"cannot be read: {error}"
        yield name, text.partition("\n")[0], door.giver(name)
