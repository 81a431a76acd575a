"""The commands `brains` and `list`: what can be used by name, and whether a brain file keeps the contract."""

import argparse
import ast
import importlib
import re
import sys
from collections.abc import Callable, Collection, Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from swarmcensus.cli.options import Command, Group

from swarmcensus.cli.output import answer, present, say
from swarmcensus.support.errors import InputError
from swarmcensus.support.formatting import counted
from swarmcensus.support.options import misplaced

if TYPE_CHECKING:
    from swarmcensus.checks import Check
    from swarmcensus.robots import Cost

MODULES = {
    "brains": "brains.brain", "adversaries": "brains.adversary", "metrics": "brains.metrics.metric",
    "topologies": "worlds.wiring", "floors": "worlds.patterns", "spreads": "worlds.distributions",
    "figures": "figures.kinds", "targets": "robots.targets",
}  # fmt: skip  # kinds of plugins, and the module that finds each
KINDS = ("studies", *MODULES)
COLUMNS = ("memory", "message", "single")
NAME = 23  # letters of a name and its mark
WIDE = 110  # columns of a terminal in which lists have more than names and what they are
LIVES = {"alone": "alone", "hearing": "next to a neighbour in the same state"}
GROUPS = {"number": "estimates a number", "opinion": "has an opinion, black or white", "": "what is wrong"}
Row = dict[str, Any]


def add_brains_options(sub: argparse.ArgumentParser) -> None:
    """Add the options of `brains`."""
    action = sub.add_mutually_exclusive_group()
    action.add_argument(
        "--check",
        metavar="FILE",
        help="run a brain or an adversary through the conformance suite, which executes it: only a file that you trust",
    )
    action.add_argument("--show", metavar="BRAIN", help="print the source of a brain, or of an adversary and its brain")
    action.add_argument(
        "--cost",
        nargs="*",
        metavar="BRAIN",
        help="measure what brains (default: all shipped) take of an ATmega328P: flash, RAM, stack, time; needs avr-gcc "
        "and simavr",
    )
    sub.add_argument("--single", action="store_true", help="with --check: also live a day at 10 Hz in single precision")
    sub.add_argument(
        "--wrapping", metavar="BRAIN", default="", help="the brain that an adversary wraps (default: minimalistic)"
    )


def brains(options: argparse.Namespace) -> int:
    """List, show, check or measure brains and adversaries."""
    if options.single and options.check is None:
        raise misplaced("single", None, "needs --check with a brain or an adversary")
    if options.check is None and options.show is None:
        if options.wrapping:
            raise misplaced("wrapping", options.wrapping, "needs --check or --show with an adversary")
        if options.cost is not None:
            measure_costs(options)
            return 0
        known, liars = brain_rows(), adversary_rows()
        present(
            options,
            "brains",
            lambda: {"brains": known, "adversaries": liars},
            lambda: [{"kind": kind, **row} for kind, rows in (("brain", known), ("adversary", liars)) for row in rows],
            lambda: show_all(known, liars),
        )
        return 0
    from swarmcensus.brains import find
    from swarmcensus.checks import brain_to_check, check

    if options.wrapping:
        find(options.wrapping)  # so that a misspelt name is not reported as an error of the adversary
    if options.show is not None:
        if options.json:
            raise misplaced("json", None, "does not go with --show, which prints a program")
        sys.stdout.write(brain_to_check(options.show, options.wrapping).source)
        return 0
    say(f"checking {options.check}, which is compiled for it: some seconds")
    found = check(options.check, wrapping=options.wrapping, single=options.single)
    checks, verdict, said, lived = found.checks, found.verdict, [*found.notes], found.single
    if lived is not None:
        said.append(lived if isinstance(lived, str) else single_note(lived))
    if options.json:
        single = {"single": lived} if options.single else {}
        answer("checks", {"file": options.check, "conforms": found.conforms, "checks": checks, "notes": said, **single})
    else:
        show_checks(options.check, checks, verdict, said)
    return {"conforms": 0, "not decided": 1}.get(verdict, 2)


def single_note(lived: dict[str, int | None]) -> str:
    """A sentence on a day of readings in single precision."""
    apart = {how: at for how, at in lived.items() if at is not None}
    if not apart:
        return "single precision stays within 0.01 of double precision for a day at 10 Hz, which is 864,000 readings"
    where = " and ".join(f"at reading {at:,} {LIVES[how]}" for how, at in apart.items())
    return f"single precision differs from double precision by more than 0.01 {where}"


def brain_rows() -> list[Row]:
    """The brains of swarmcensus and of plugins: what each is, and its size on a robot, in bytes.

    `single_precision_readings` are known of shipped brains: the reading at which float32 differs by more than 0.01, or
    None if none does. A brain that cannot be read has only its name and `fault`, which is None otherwise.
    """
    from swarmcensus import brains
    from swarmcensus.checks import single_lives

    lives = single_lives()

    def details(name: str) -> Row:
        brain = brains.load(name)
        return {
            "what": (brain.functions.__doc__ or "").strip().partition("\n")[0],
            "estimates": "opinion" if brain.is_opinion else "number",
            "anonymous": not brain.uses.name,
            "memory_bytes": brain.memory_bytes,
            "message_bytes": brain.message_bytes,
            **({"single_precision_readings": lives[name]} if name in lives else {}),
            "parameters": brain.parameters,
        }

    return [_row(name, details) for name in brains.PLUGINS.names]


def adversary_rows() -> list[Row]:
    """The adversaries of swarmcensus and of plugins: what each does, and its parameters; `fault` as of brains."""
    from swarmcensus.brains import adversary

    def details(name: str) -> Row:
        liar = adversary.load(name)
        return {"what": (liar.functions.__doc__ or "").strip().partition("\n")[0], "parameters": liar.parameters}

    return [_row(name, details) for name in adversary.PLUGINS.names]


def _row(name: str, details: Callable[[str], Row]) -> Row:
    try:
        return {"name": name, **details(name), "fault": None}
    except InputError as error:
        return {"name": name, "fault": str(error)}


def show_all(brains: list[Row], adversaries: list[Row]) -> None:
    """Print brains, grouped by what they estimate, then adversaries; a line for each, in narrow terminals its name."""
    from swarmcensus.support.terminal import console

    out = console()
    narrow = out.width < WIDE
    for estimates, group in GROUPS.items():
        rows = [row for row in brains if row.get("estimates", "") == estimates]
        _show_lines("brain", rows, dict.fromkeys(() if narrow else COLUMNS, True), _sizes, group)
    _show_lines("adversary", adversaries, {} if narrow else {"parameters": False}, _values, "what it does")
    print("*: not anonymous, since it uses the name of its robot")
    if narrow:
        out.print(f"sizes and parameters: in a terminal of {WIDE} columns, or with --json")
    else:
        print("memory, message: in bytes, 4 per number; alone never sends its message")
        print("single: readings after which single precision is more than 0.01 off; any: none")
    print("brains --show NAME prints the whole file")


def _show_lines(
    kind: str, rows: list[Row], more: dict[str, bool], cells: Callable[[Row], Sequence[str]], what: str
) -> None:
    """Print a line for each row: its name, `cells` under the heads `more`, and what it is."""
    from swarmcensus.support.printed_tables import Table
    from swarmcensus.support.terminal import show

    if rows:
        names = [row["name"] + "*" * (not row.get("anonymous", True)) for row in rows]
        texts = [
            (name.ljust(NAME), *cells(row)[: len(more)], row["fault"] or _without_name(row))
            for name, row in zip(names, rows, strict=True)
        ]
        show(Table.of_rows({kind: False} | more | {what: False}, texts, cuts=True))
        print()


def _sizes(row: Row) -> list[str]:
    lived = row.get("single_precision_readings", 0)
    single = "any" if lived is None else f"{lived / 1e6:.1f} M" if lived else "-"
    return [*(f"{row[name]:,}" if name in row else "-" for name in ("memory_bytes", "message_bytes")), single]


def _values(row: Row) -> list[str]:
    values = row.get("parameters", {}).items()
    return [", ".join(f"{name} {value:,.10g}" if isinstance(value, float) else name for name, value in values)]


def _without_name(row: Row) -> str:
    """What a brain is, without its name in front: "Bayes Bots: each robot ..." is "Each robot ..."."""
    what = str(row["what"])
    title, colon, text = what.partition(": ")
    named = re.sub(r"[^a-z0-9]+", "-", title.lower()).startswith(row["name"])
    return text[:1].upper() + text[1:] if colon and named else what


def show_checks(path: Any, checks: "list[Check]", verdict: str, notes: Collection[str] = ()) -> None:
    """Print the results of the conformance suite, and notes."""
    from rich.text import Text

    from swarmcensus.support.terminal import console

    out = console()
    for result in checks:
        if not result.used:
            out.print(f"-     {result.name}: not used", style="dim")
            continue
        failed = Text("FAIL", "red bold") if result.decided else Text("?   ", "yellow bold")
        out.print(Text("pass", "green") if result.fault is None else failed, f" {result.name}")
        if result.fault is not None:
            out.print(f"      {result.fault}", soft_wrap=True)
    for note in notes:
        out.print(f"note  {note}", soft_wrap=True)
    out.print(f"{path}: {verdict}", soft_wrap=True)


def measure_costs(options: argparse.Namespace) -> None:
    """Measure the brains of --cost, all shipped ones if none is named, and print what they take."""
    from swarmcensus.brains import load, shipped
    from swarmcensus.robots import check_tools, cost

    brains = [load(name) for name in options.cost or shipped()]
    check_tools()
    say(f"measuring {counted(len(brains), 'brain')}, each for some seconds")
    costs = [cost(brain) for brain in brains]
    rows = [_cost_as_dict(one) for one in costs]
    present(options, "costs", lambda: {"costs": rows}, lambda: rows, lambda: _show_costs(costs))


def _cost_as_dict(one: "Cost") -> dict[str, Any]:
    more = {"milliseconds": one.milliseconds, "fits_kilobot": not one.too_large, "too_large": one.too_large}
    return one._asdict() | more


def _show_costs(costs: "Sequence[Cost]") -> None:
    from swarmcensus.robots import CLOCK, COLUMNS, KILOBOT
    from swarmcensus.support.printed_tables import Table
    from swarmcensus.support.terminal import show

    columns = [column for column in COLUMNS if column.short]
    heads = {column.short: column not in (columns[0], columns[-1]) for column in columns}
    rows = [[column.text(one) for column in columns] for one in costs]
    for row, one in zip(rows, costs, strict=True):
        row[0] += "*" * (one.chip != KILOBOT)
    show(Table.of_rows(heads, rows))
    print()
    print("flash, RAM, stack and message: bytes of an ATmega328P, in single precision, with messages in ratio16")
    print(f"cycles: of a tick with 2 messages, on average; ms: at {CLOCK / 1e6:g} MHz; longest: also with 20 messages")
    print("Kilobot: whether a Kilobot has room, and if not, what is too large")
    if any(one.chip != KILOBOT for one in costs):
        print("*: its memory has no room on an ATmega328P beside another robot's; its cycles are an ATmega1284P's")


OF_PYTHON = ("ax", "progress")  # arguments that no text can give
MAKERS = ("edges", "links", "score", "paint", "quantile")  # functions whose arguments are keys in a study


def add_list_options(sub: argparse.ArgumentParser) -> None:
    """Add the options of `list`."""
    sub.add_argument("kind", nargs="?", metavar="KIND", choices=KINDS, help=f"one of {', '.join(KINDS)}")


def choices(options: argparse.Namespace) -> int:
    """List what can be used by name, kind by kind."""
    kinds = [options.kind] if options.kind else KINDS
    present(
        options,
        "choices",
        lambda: {kind: [_as_dict(row) for row in _rows(kind)] for kind in kinds},
        lambda: ({"kind": kind, **_as_dict(row)} for kind in kinds for row in _rows(kind)),
        lambda: _show_choices(kinds),
    )
    return 0


def _show_choices(kinds: Collection[str]) -> None:
    """Print a table for each kind."""
    from swarmcensus.support.printed_tables import Table
    from swarmcensus.support.terminal import show

    for k, kind in enumerate(kinds):
        rows = list(_rows(kind))
        plugins = {row[-1] for row in rows} != {
            "swarmcensus"
        }  # otherwise the last column would be the same in every row
        heads = dict.fromkeys((kind, "keys", "what it is", *["from"] * plugins), False)
        cells = [row[: len(heads)] for row in rows]
        if not any(keys for _, keys, *_ in rows):
            del heads["keys"]
            cells = [(name, *more) for name, _, *more in cells]
        if k:
            print()
        show(Table.of_rows(heads, cells, cuts=kind == "studies"))


def _as_dict(row: tuple[str, str, str, str]) -> dict[str, object]:
    name, keys, what, package = row
    return {"name": name, "keys": keys.split(", ") if keys else [], "what": what, "from": package}


def _rows(kind: str) -> Iterator[tuple[str, str, str, str]]:
    """Of each plugin of a kind: name, keys or parameters, the first line of its docstring, and its package.

    Files are parsed, and not run.
    """
    if kind == "studies":
        from swarmcensus.support.files import shipped_studies

        yield from ((name, "", _first_words(path), "swarmcensus") for name, path in shipped_studies().items())
        return
    from swarmcensus import brains
    from swarmcensus.brains import adversary

    plugins = importlib.import_module(f"swarmcensus.{MODULES[kind]}").PLUGINS
    for name in plugins.names:
        keys = ""
        try:
            source = plugins.path(name).read_text(encoding="utf-8-sig")
            tree = ast.parse(source)
            text = (ast.get_docstring(tree) or "").partition("\n")[0]
            keys = ", ".join(_keys(tree, (*MAKERS, name.replace("-", "_"))))
            if kind == "brains":
                brain = brains.unloaded(name, source)
                keys, text = ", ".join(brain.parameters), text + " Not anonymous." * brain.uses.name
            if kind == "adversaries":
                keys = ", ".join(adversary.unloaded(source, name, plugins.path(name)).parameters)
        except (InputError, OSError, ValueError, SyntaxError) as error:
            text = f"cannot be read: {error}"
        yield name, keys, text, plugins.provider(name)


def _keys(tree: ast.Module, makers: Collection[str]) -> Iterator[str]:
    """The keys that a study may give to a plugin, from the arguments of its functions."""
    for node in tree.body:
        if isinstance(node, ast.FunctionDef) and node.name in makers:
            yield from (argument.arg for argument in node.args.kwonlyargs if argument.arg not in OF_PYTHON)
            if node.name == "quantile":
                yield from (argument.arg for argument in node.args.args[1:])


def _first_words(study: Path) -> str:
    """The first sentence of the comment that a study begins with."""
    lines = []
    for line in study.read_text(encoding="utf-8").splitlines():
        if not line.startswith("#") or line.startswith("# swarmcensus "):  # the words of a command
            break
        lines.append(line.lstrip("# "))
    words = re.split(r"(?<!Sec)[.?] (?=[A-Z`])|: (?=`)", " ".join(lines))[0]
    return words.rstrip(".:")


COMMANDS = (
    Command(
        "brains", "List brains and adversaries; print, check or measure one.",
        Group.BRAINS, 1, brains, add_brains_options, table=True,
    ),
    Command(
        "list", "List what can be used by name: studies, floors, figures ...",
        Group.SETUP, 1, choices, add_list_options, table=True,
    ),
)  # fmt: skip
