"""The commands `brains` and `list`: what there is to choose from, and whether a brain file conforms."""

import argparse
import ast
import importlib
import sys
from collections.abc import Callable, Collection, Iterator
from typing import TYPE_CHECKING, Any

from swarmcensus.basics.errors import InputError
from swarmcensus.cli.output import answer, say

if TYPE_CHECKING:
    from swarmcensus.conformance.suite import Check

PLUGINS = {
    "brains": "brains.brain", "adversaries": "brains.adversary", "metrics": "metrics.metric",
    "topologies": "worlds.wiring", "floors": "worlds.patterns", "spreads": "worlds.spreading",
    "figures": "figures.kinds",
}  # fmt: skip  # what is added by files, and the module that finds it
GROUPS = {"number": "estimates a number", "opinion": "has an opinion, black or white", "": "what is wrong"}
Row = dict[str, Any]


def add_brains_options(sub: argparse.ArgumentParser) -> None:
    """Of `brains`."""
    one = sub.add_mutually_exclusive_group()
    one.add_argument("--check", metavar="FILE", help="run a brain or an adversary through the conformance suite")
    one.add_argument("--show", metavar="FILE", help="print the source of a brain, or of an adversary and its brain")
    sub.add_argument("--wearing", metavar="BRAIN", default="", help="what an adversary wears (default: minimalistic)")


def brains(options: argparse.Namespace) -> int:
    """List, show or check brains and adversaries."""
    if options.check is None and options.show is None:
        if options.wearing:
            raise InputError(f"--wearing {options.wearing}: it goes with --check or --show, and an adversary")
        known, liars = brain_rows(), adversary_rows()
        if options.json:
            answer("brains", {"brains": known, "adversaries": liars})
        else:
            show_brains(known)
            show_adversaries(liars)
        return 0
    from swarmcensus.brains import find
    from swarmcensus.conformance.suite import check, subject

    if options.wearing:
        find(options.wearing)  # what is misspelt there is no fault of the adversary's
    if options.show is not None:
        if options.json:
            raise InputError("--json is of the list and of --check: --show prints a program")
        sys.stdout.write(subject(options.show, options.wearing).source)
        return 0
    say(f"checking {options.check}: compiled too, which takes up to a minute")
    found = check(options.check, wearing=options.wearing)
    if not options.json:
        return 0 if checks(options.check, found) else 2
    conforms = all(one.fault is None for one in found)
    answer("checks", {"file": options.check, "conforms": conforms, "checks": found})
    return 0 if conforms else 2


def brain_rows() -> list[Row]:
    """The brains that come with swarmcensus and other packages: what each is, and its size on a robot, in bytes.

    Of one that cannot be read there is `fault`, which is None of the others.
    """
    from swarmcensus import brains

    def told(name: str) -> Row:
        brain = brains.load(name)
        return {
            "what": (brain.functions.__doc__ or "").strip().partition("\n")[0],
            "estimates": "opinion" if brain.is_opinion else "number",
            "anonymous": not brain.uses.name,
            "memory_bytes": brain.memory_bytes,
            "message_bytes": brain.message_bytes,
            "parameters": brain.parameters,
        }

    return [_row(name, told) for name in brains.DOOR.names]


def adversary_rows() -> list[Row]:
    """The adversaries that come with swarmcensus and other packages, likewise."""
    from swarmcensus.brains import adversary

    def told(name: str) -> Row:
        one = adversary.load(name)
        return {"what": (one.functions.__doc__ or "").strip().partition("\n")[0], "parameters": one.parameters}

    return [_row(name, told) for name in adversary.DOOR.names]


def _row(name: str, told: Callable[[str], Row]) -> Row:
    try:
        return {"name": name, **told(name), "fault": None}
    except InputError as error:
        return {"name": name, "fault": str(error)}


def show_brains(rows: list[Row]) -> None:
    """Print them by what they estimate."""
    from swarmcensus.basics.terminal import console, table

    groups: dict[str, list[tuple[str, ...]]] = {group: [] for group in GROUPS.values()}
    for row in rows:
        sizes = [f"{row[name]:,}" if name in row else "-" for name in ("memory_bytes", "message_bytes")]
        what = row["fault"] or row["what"] + " Not anonymous." * (not row["anonymous"])
        groups[GROUPS[row.get("estimates", "")]].append((row["name"], *sizes, what))
    widest = max(len(row["name"]) for row in rows)
    for group, some in groups.items():
        if some:
            heads = [("brain".ljust(widest), False), ("memory", True), ("message", True), (group, False)]
            console().print(table(heads, some))
            print()
    print("memory and message: bytes, 4 a number; not anonymous: uses its robot's name\n")


def show_adversaries(rows: list[Row]) -> None:
    """Print them with their parameters."""
    from swarmcensus.basics.terminal import console, table

    cells = []
    for row in rows:
        told = [f"{k} {v:,.10g}" if isinstance(v, float) else k for k, v in row.get("parameters", {}).items()]
        cells.append((row["name"], "-" if row["fault"] else ", ".join(told), row["fault"] or row["what"]))
    console().print(table([("adversary", False), ("parameters", False), ("what it does", False)], cells))


def checks(path: Any, found: "list[Check]") -> bool:
    """What the conformance suite found; whether the brain passed."""
    from rich.text import Text

    from swarmcensus.basics.terminal import console

    out = console()
    for one in found:
        if not one.used:
            out.print(f"-     {one.name}: not used", style="dim")
            continue
        out.print(Text("pass", "green") if one.fault is None else Text("FAIL", "red bold"), f" {one.name}")
        if one.fault is not None:
            out.print(f"      {one.fault}", soft_wrap=True)
    good = all(one.fault is None for one in found)
    out.print(f"{path}: {'conforms' if good else 'does not conform'}", soft_wrap=True)
    return good


MAKERS = ("edges", "links", "score", "paint", "quantile")  # functions whose arguments a study gives


def add_list_options(sub: argparse.ArgumentParser) -> None:
    """Of `list`."""
    sub.add_argument("kind", nargs="?", metavar="KIND", choices=[*PLUGINS], help=f"one of {', '.join(PLUGINS)}")


def choices(options: argparse.Namespace) -> int:
    """List what there is, kind by kind."""

    from swarmcensus.basics.terminal import console, table

    kinds = [options.kind] if options.kind else list(PLUGINS)
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

    door = importlib.import_module(f"swarmcensus.{PLUGINS[kind]}").DOOR
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
