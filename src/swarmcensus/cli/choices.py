"""The command `list`: what there is to choose from, ours and what other installed packages add."""

import argparse
import ast
import importlib
from collections.abc import Collection, Iterator

from swarmcensus.basics.errors import InputError
from swarmcensus.cli.options import DOORS
from swarmcensus.cli.output import answer

MAKERS = ("edges", "links", "score", "paint", "quantile")  # functions whose arguments a study gives


def choices(options: argparse.Namespace) -> int:
    """List what there is, kind by kind."""
    from swarmcensus.basics.terminal import console, table

    kinds = [options.kind] if options.kind else list(DOORS)
    if options.json:
        answer("choices", {kind: [_told(row) for row in _rows(kind)] for kind in kinds})
        return 0
    for k, kind in enumerate(kinds):
        rows = list(_rows(kind))
        ours = {row[-1] for row in rows} == {"swarmcensus"}  # then every line would end in the same word
        heads = [(kind, False), ("keys", False), ("what it is", False), *[("from", False)] * (not ours)]
        if k:
            print()
        console().print(table(heads, [row[: len(heads)] for row in rows]))
    return 0


def _told(row: tuple[str, str, str, str]) -> dict[str, object]:
    name, keys, what, giver = row
    return {"name": name, "keys": keys.split(", ") if keys else [], "what": what, "from": giver}


def _rows(kind: str) -> Iterator[tuple[str, str, str, str]]:
    """Each one's name, its keys or parameters, the first line of its file, which is not run, and whose it is."""
    from swarmcensus import brains
    from swarmcensus.brains import adversary

    door = importlib.import_module(f"swarmcensus.{DOORS[kind]}").DOOR
    for name in door.names:
        keys = ""
        try:
            source = door.path(name).read_text(encoding="utf-8-sig")
            tree = ast.parse(source)
            text = (ast.get_docstring(tree) or "").partition("\n")[0]
            keys = ", ".join(_keys(tree, (*MAKERS, name.replace("-", "_"))))
            if kind == "brains":
                brain = brains.unread(name, source)
                keys, text = ", ".join(brain.parameters), text + " Not anonymous." * brain.uses.name
            if kind == "adversaries":
                keys = ", ".join(adversary.unread(source, name, door.path(name)).parameters)
        except (InputError, OSError, ValueError, SyntaxError) as error:
            text = f"cannot be read: {error}"
        yield name, keys, text, door.giver(name)


def _keys(tree: ast.Module, makers: Collection[str]) -> Iterator[str]:
    """What may be given to what a file makes."""
    for node in tree.body:
        if isinstance(node, ast.FunctionDef) and node.name in makers:
            yield from (one.arg for one in node.args.kwonlyargs)
            if node.name == "quantile":
                yield from (one.arg for one in node.args.args[1:])
