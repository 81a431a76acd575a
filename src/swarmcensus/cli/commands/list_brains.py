"""The commands `list` and `brains`: what can be used by name, and whether a brain file keeps the contract."""

import ast
import importlib
import itertools
import re
from collections.abc import Collection, Iterator
from pathlib import Path
from typing import Annotated, Any, Literal, get_args

from cyclopts import Parameter

from swarmcensus.cli.help import UsageError
from swarmcensus.cli.parameters import BRAIN, exclusive
from swarmcensus.support.answers import Answer
from swarmcensus.support.errors import InputError
from swarmcensus.support.options import option_conflict
from swarmcensus.support.printed_tables import ASKED, KEY, REST, Column, Table

MODULES = {
    "brains": "brains.brain", "adversaries": "brains.adversary", "metrics": "brains.metrics.metric",
    "topologies": "worlds.wiring", "floors": "worlds.patterns", "spreads": "worlds.distributions",
    "figures": "figures.kinds", "targets": "robots.targets",
}  # fmt: skip  # kinds of plugins, and the module that finds each
Kind = Literal["studies", "brains", "adversaries", "metrics", "topologies", "floors", "spreads", "figures", "targets"]
SINGLE = "single_precision_readings"
SIZES = {"memory_bytes": "memory", "message_bytes": "message", SINGLE: "single"}  # of brains, with their heads
HEADS = {"name": "", **SIZES, "estimates": "estimates", "anonymous": "anonymous", "keys": "keys",
         "what": "what it is", "from": "from"}  # fmt: skip
Row = dict[str, Any]
ACTION = exclusive()


def brains(
    *,
    check: Annotated[str | None, BRAIN, Parameter(metavar="FILE"), ACTION] = None,
    show: Annotated[str | None, BRAIN, ACTION] = None,
    wrapping: Annotated[str, BRAIN] = "",
) -> Answer | str:  # fmt: skip
    """Print or check a brain or an adversary.

    Args:
        check: run a brain or an adversary through the conformance suite, which executes it: only a file that you trust
        show: print the source of a brain, or of an adversary and its brain
        wrapping: the brain that an adversary wraps (default: minimalistic)
    """
    if wrapping and check is None and show is None:
        raise option_conflict("wrapping", wrapping, "needs --check or --show with an adversary")
    if check is None and show is None:
        raise UsageError("needs --check or --show; 'swarmcensus list brains' lists all")
    from swarmcensus.checks import brain_to_check, check as check_brain

    if show is not None:
        return brain_to_check(show, wrapping).source
    return check_brain(str(check), wrapping=wrapping)


OF_PYTHON = ("progress",)  # arguments that no text can give
MAKERS = ("edges", "links", "score", "paint", "level", "quantile")  # functions whose arguments are keys in a study


def choices(kind: Annotated[Kind | None, Parameter(metavar="KIND")] = None, /) -> Answer:
    """List what can be used by name: studies, brains, floors ...

    Args:
        kind: what to list (default: all kinds)
    """
    tables, rows = [], []
    for one in [kind] if kind else get_args(Kind):
        found = [*_of_kind(one)]
        cells = {key: [_text(row.get(key, "")) for row in found] for key in HEADS}
        said = [key for key, texts in cells.items() if {*texts} not in ({""}, {"swarmcensus"})]
        ranks = {"name": KEY, "what": ASKED}
        columns = [
            Column(one if key == "name" else HEADS[key], cells[key], key in SIZES, ranks.get(key, REST), name=key)
            for key in said
        ]
        tables.append(Table(columns, folds=True, notes=_legend if one == "brains" else lambda _: ()))
        rows += found
    return Answer(*tables, rows=rows, usual_limit=0)


def _text(value: object) -> str:
    if isinstance(value, bool):
        return "yes" if value else "no"
    if isinstance(value, list):
        return ", ".join(value)
    return "any" if value is None else f"{value:,}" if isinstance(value, int | float) else str(value)


def _legend(left_out: Collection[str]) -> Iterator[str]:
    if "memory" not in left_out:
        yield "memory, message: in bytes, 4 per number; alone never sends its message"
    if "single" not in left_out:
        yield "single: readings after which single precision is more than 0.01 off; any: none"


def _of_kind(kind: Kind) -> Iterator[Row]:
    """Of each plugin of a kind: name, keys or parameters, the first line of its docstring, and its package.

    A brain's row also has what it estimates, its size in bytes on a robot, and the reading at which float32 differs by
    more than 0.01, None if none does, of shipped brains. Files are parsed, and not run.
    """
    if kind == "studies":
        from swarmcensus.support.files import shipped_studies

        for name, path in shipped_studies().items():
            yield {"kind": kind, "name": name, "keys": [], "what": _first_words(path), "from": "swarmcensus"}
        return
    plugins = importlib.import_module(f"swarmcensus.{MODULES[kind]}").PLUGINS
    for name in plugins.names:
        row: Row = {"kind": kind, "name": name, "keys": []}
        try:
            source = plugins.path(name).read_text(encoding="utf-8-sig")
            tree = ast.parse(source)
            row |= {"what": (ast.get_docstring(tree) or "").partition("\n")[0]} | _about(kind, name, source, tree)
        except (InputError, OSError, ValueError, SyntaxError) as error:
            row["what"] = f"cannot be read: {error}"
        yield row | {"from": plugins.provider(name)}


def _about(kind: Kind, name: str, source: str, tree: ast.Module) -> Row:
    """What else is known of a plugin from its source. Raises InputError."""
    from swarmcensus import brains
    from swarmcensus.brains import adversary
    from swarmcensus.checks import single_lives

    if kind == "adversaries":
        return {"keys": [*adversary.unloaded(source, name, adversary.PLUGINS.path(name)).parameters]}
    if kind == "brains":
        brain, lives = brains.unloaded(name, source), single_lives()
        row: Row = {"keys": [*brain.parameters], "estimates": "opinion" if brain.is_opinion else "number"}
        row |= {"anonymous": not brain.uses.name}
        row |= {"memory_bytes": brain.memory_bytes, "message_bytes": brain.message_bytes}
        return row | ({SINGLE: lives[name]} if name in lives else {})
    keys: list[str] = []
    made = [one for one in tree.body if isinstance(one, ast.FunctionDef)]
    for function in (one for one in made if one.name in (*MAKERS, name.replace("-", "_"))):
        given = function.args.kwonlyargs + function.args.args[1:] * (function.name == "quantile")
        keys += [argument.arg for argument in given if argument.arg not in OF_PYTHON]
    return {"keys": [*dict.fromkeys(keys)]}


def _first_words(study: Path) -> str:
    """The first sentence of the comment that a study begins with."""
    lines = study.read_text(encoding="utf-8").splitlines()
    comment = itertools.takewhile(lambda line: line.startswith("#") and not line.startswith("# swarmcensus "), lines)
    words = re.split(r"(?<!Sec)[.?] (?=[A-Z`])|: (?=`)", " ".join(line.lstrip("# ") for line in comment))[0]
    return words.rstrip(".:")
