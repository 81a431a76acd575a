"""The commands `brains` and `list`: what can be used by name, and whether a brain file keeps the contract."""

import ast
import importlib
import itertools
import re
from collections.abc import Collection, Iterator, Sequence
from pathlib import Path
from typing import Annotated, Any, Literal, get_args

from cyclopts import Parameter

from swarmcensus.cli.help import UsageError
from swarmcensus.cli.messages import say
from swarmcensus.cli.parameters import BRAIN, exclusive
from swarmcensus.support.answers import Answer
from swarmcensus.support.errors import InputError
from swarmcensus.support.formatting import counted
from swarmcensus.support.options import command as shell_line, option_conflict
from swarmcensus.support.printed_tables import ASKED, KEY, REST, Column, Table

MODULES = {
    "brains": "brains.brain", "adversaries": "brains.adversary", "metrics": "brains.metrics.metric",
    "topologies": "worlds.wiring", "floors": "worlds.patterns", "spreads": "worlds.distributions",
    "figures": "figures.kinds", "targets": "robots.targets",
}  # fmt: skip  # kinds of plugins, and the module that finds each
Kind = Literal["studies", "brains", "adversaries", "metrics", "topologies", "floors", "spreads", "figures", "targets"]
NAME = 23  # letters of a name and its mark
GROUPS = {
    ("brain", "number"): "estimates a number", ("brain", "opinion"): "has an opinion, black or white",
    ("brain", ""): "what is wrong", ("adversary", ""): "what it does",
}  # fmt: skip  # tables by kind and what it estimates, with the head of their last column
SINGLE = "single_precision_readings"
SIZES = {"memory_bytes": "memory", "message_bytes": "message", SINGLE: "single"}  # with their heads
Row = dict[str, Any]
ACTION = exclusive()


def brains(
    name: Annotated[str | None, Parameter(show=False)] = None, /, *,
    check: Annotated[str | None, BRAIN, Parameter(metavar="FILE"), ACTION] = None,
    show: Annotated[str | None, BRAIN, ACTION] = None,
    cost: Annotated[Sequence[str] | None, BRAIN, Parameter(consume_multiple=True), ACTION] = None,
    single: bool = False, wrapping: Annotated[str, BRAIN] = "",
) -> Answer | str:  # fmt: skip
    """List brains and adversaries; print, check or measure one.

    Args:
        check: run a brain or an adversary through the conformance suite, which executes it: only a file that you trust
        show: print the source of a brain, or of an adversary and its brain
        cost: measure flash, RAM, stack and time on an ATmega328P (default: all shipped); needs avr-gcc and simavr
        single: with --check: also live a day at 10 Hz in single precision
        wrapping: the brain that an adversary wraps (default: minimalistic)
    """
    if name is not None:
        meant = shell_line("swarmcensus", "brains", "--check" if name.endswith(".py") else "--show", name)
        raise UsageError(f"{shell_line(name)} is an argument too many: did you mean '{meant}'?")
    if single and check is None:
        raise option_conflict("single", None, "needs --check with a brain or an adversary")
    if wrapping and check is None and show is None:
        raise option_conflict("wrapping", wrapping, "needs --check or --show with an adversary")
    if cost is not None:
        return costs(cost)
    if check is None and show is None:
        return _all()
    from swarmcensus.checks import brain_to_check, check as check_brain

    if show is not None:
        return brain_to_check(show, wrapping).source
    say(f"checking {check}, which is compiled for it: some seconds")
    return check_brain(str(check), wrapping=wrapping, single=single)


def _all() -> Answer:
    """All brains, grouped by what they estimate, and adversaries, a line for each."""
    rows: list[Row] = [*_rows()]
    tables: list[Table] = []
    for (kind, estimates), what in GROUPS.items():
        if found := [row for row in rows if (row["kind"], row.get("estimates", "")) == (kind, estimates)]:
            names = [f"{row['name'] + '*' * (not row.get('anonymous', True)):{NAME}}" for row in found]
            texts = [row["fault"] or _without_name(row) for row in found]
            more = [Column(SIZES[name], [_size(row, name) for row in found], rank=REST, name=name) for name in SIZES]
            if kind == "adversary":
                more = [Column("parameters", [*map(_values, found)], False, REST, name="parameters")]
            columns = Column(kind, names, False, name="name"), *more, Column(what, texts, False, ASKED, name="what")
            tables.append(Table(columns, cuts=True, notes=(lambda _: ()) if tables else _legend))
    return Answer(*tables, rows=rows)


def _rows() -> Iterator[Row]:
    """The brains and adversaries of swarmcensus and of plugins: what each is, and a brain's size on a robot, in bytes.

    `single_precision_readings` are known of shipped brains: the reading at which float32 differs by more than 0.01, or
    None if none does. What cannot be read has only its name and `fault`, which is None otherwise.
    """
    from swarmcensus import brains
    from swarmcensus.brains import adversary
    from swarmcensus.checks import single_lives

    lives = single_lives()
    for kind, module in (("brain", brains), ("adversary", adversary)):
        for name in module.PLUGINS.names:
            row: Row = {"kind": kind, "name": name}
            try:
                one = module.load(name)
            except InputError as error:
                yield row | {"fault": str(error)}
                continue
            row["what"] = (one.functions.__doc__ or "").strip().partition("\n")[0]
            if kind == "brain":
                row |= {"estimates": "opinion" if one.is_opinion else "number", "anonymous": not one.uses.name}
                row |= {"memory_bytes": one.memory_bytes, "message_bytes": one.message_bytes}
                row |= {SINGLE: lives[name]} if name in lives else {}
            yield row | {"parameters": one.parameters, "fault": None}


def _size(row: Row, name: str) -> str:
    if name not in row:
        return "-"
    return "any" if row[name] is None else f"{row[name] / 1e6:.1f} M" if name == SINGLE else f"{row[name]:,}"


def _values(row: Row) -> str:
    values = row.get("parameters", {}).items()
    return ", ".join(f"{name} {value:,.10g}" if isinstance(value, float) else name for name, value in values)


def _without_name(row: Row) -> str:
    """What a brain is, without its name in front: "Bayes Bots: each robot ..." is "Each robot ..."."""
    title, _, text = row["what"].partition(": ")
    named = re.sub(r"[^a-z0-9]+", "-", title.lower()).startswith(row["name"])
    return text[:1].upper() + text[1:] if text and named else str(row["what"])


def _legend(left_out: Collection[str]) -> Iterator[str]:
    yield "*: not anonymous, since it uses the name of its robot; brains --show NAME prints the whole file"
    if "memory" not in left_out:
        yield "memory, message: in bytes, 4 per number; alone never sends its message"
    if "single" not in left_out:
        yield "single: readings after which single precision is more than 0.01 off; any: none"


def costs(names: Sequence[str]) -> Answer:
    """What brains take of an ATmega328P, all shipped ones if none is named."""
    from swarmcensus.brains import load, shipped
    from swarmcensus.robots import CLOCK, COLUMNS, KILOBOT, check_tools, cost

    measured = [load(name) for name in names or shipped()]
    check_tools()
    say(f"measuring {counted(len(measured), 'brain')}, each for some seconds")
    found = [cost(brain) for brain in measured]
    shown = [one for one in COLUMNS if one.short]
    columns = [Column(one.short, [*map(one.text, found)], one not in (shown[0], shown[-1])) for one in shown]
    notes = [
        "flash, RAM, stack and message: bytes of an ATmega328P, in single precision, with messages in ratio16",
        f"cycles: of a tick with 2 messages, on average; ms: at {CLOCK / 1e6:g} MHz; longest: also with 20 messages",
        "Kilobot: whether a Kilobot has room, and if not, what is too large",
    ]
    if larger := [one.name for one in found if one.chip != KILOBOT]:
        which = ", ".join(larger)
        notes.append(f"{which}: too large for an ATmega328P with another robot's memory; cycles of an ATmega1284P")
    rows = [one._asdict() | {"milliseconds": one.milliseconds, "too_large": one.too_large} for one in found]
    rows = [row | {"fits_kilobot": not row["too_large"]} for row in rows]
    return Answer(Table(columns, notes=lambda _: notes), rows=rows)


OF_PYTHON = ("ax", "progress")  # arguments that no text can give
MAKERS = ("edges", "links", "score", "paint", "quantile")  # functions whose arguments are keys in a study


def choices(kind: Annotated[Kind | None, Parameter(metavar="KIND")] = None, /) -> Answer:
    """List what can be used by name: studies, floors, figures ...

    Args:
        kind: what to list (default: all kinds)
    """
    tables, rows = [], []
    for one in [kind] if kind else get_args(Kind):
        found = [*_of_kind(one)]
        cells = {key: [row[key] for row in found] for key in ("name", "what", "from")}
        cells["keys"] = [", ".join(row["keys"]) for row in found]
        heads = {"name": (one, KEY), "keys": ("keys", REST), "what": ("what it is", ASKED), "from": ("from", REST)}
        said = [key for key in heads if {*cells[key]} not in ({""}, {"swarmcensus"})]
        columns = [Column(heads[key][0], cells[key], False, heads[key][1], name=key) for key in said]
        tables.append(Table(columns, folds=one != "studies", cuts=one == "studies"))
        rows += found
    return Answer(*tables, rows=rows, usual_limit=0)


def _of_kind(kind: Kind) -> Iterator[Row]:
    """Of each plugin of a kind: name, keys or parameters, the first line of its docstring, and its package.

    Files are parsed, and not run.
    """
    if kind == "studies":
        from swarmcensus.support.files import shipped_studies

        for name, path in shipped_studies().items():
            yield {"kind": kind, "name": name, "keys": [], "what": _first_words(path), "from": "swarmcensus"}
        return
    from swarmcensus import brains
    from swarmcensus.brains import adversary

    plugins = importlib.import_module(f"swarmcensus.{MODULES[kind]}").PLUGINS
    for name in plugins.names:
        keys: list[str] = []
        try:
            source = plugins.path(name).read_text(encoding="utf-8-sig")
            tree = ast.parse(source)
            text = (ast.get_docstring(tree) or "").partition("\n")[0]
            made = [one for one in tree.body if isinstance(one, ast.FunctionDef)]
            for function in (one for one in made if one.name in (*MAKERS, name.replace("-", "_"))):
                given = function.args.kwonlyargs + function.args.args[1:] * (function.name == "quantile")
                keys += [argument.arg for argument in given if argument.arg not in OF_PYTHON]
            if kind == "brains":
                brain = brains.unloaded(name, source)
                keys, text = [*brain.parameters], text + " Not anonymous." * brain.uses.name
            if kind == "adversaries":
                keys = [*adversary.unloaded(source, name, plugins.path(name)).parameters]
        except (InputError, OSError, ValueError, SyntaxError) as error:
            text = f"cannot be read: {error}"
        yield {"kind": kind, "name": name, "keys": keys, "what": text, "from": plugins.provider(name)}


def _first_words(study: Path) -> str:
    """The first sentence of the comment that a study begins with."""
    lines = study.read_text(encoding="utf-8").splitlines()
    comment = itertools.takewhile(lambda line: line.startswith("#") and not line.startswith("# swarmcensus "), lines)
    words = re.split(r"(?<!Sec)[.?] (?=[A-Z`])|: (?=`)", " ".join(line.lstrip("# ") for line in comment))[0]
    return words.rstrip(".:")
