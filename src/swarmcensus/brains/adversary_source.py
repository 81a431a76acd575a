"""An adversary wears a brain: of both one brain's source is made, which keeps the contract and can be read.

The robot observes, receives and fuses as its brain does; what it says is altered by what the message's fields mean.
"""

import ast
import functools
import linecache
import math
from collections.abc import Collection, Iterable, Mapping, Sequence
from copy import deepcopy
from pathlib import Path
from typing import NamedTuple

from swarmcensus.basics.errors import InputError
from swarmcensus.basics.safe_source import names_set_by
from swarmcensus.brains.adversary import Adversary
from swarmcensus.brains.brain import Brain, parse, unloaded
from swarmcensus.brains.contract import CONSTANTS, FUNCTIONS, MAY_HAVE, confidence_of
from swarmcensus.brains.syntax import GIVEN_ON_ASKING

ANEW = ("MEMORY", "PARAMETERS", "SUMS")  # constants of a brain that are not as its file says
ALTERED_BY = {"receive": "hear", "fuse": "plot", "jam": "jam"}  # a brain's function, by which of an adversary


VALUES = ("estimate", "opinion", "option", "belief", "information")  # what one may lie about


SPARE = 1e-6  # of a belief's weight, for the bins that are not the lie's: a weight of 0 could never be made good again


class Field(NamedTuple):
    """A part of a message: what it means, if that is known, and how long it is; 0 for a number."""

    name: str
    role: str
    long: int


class Names(NamedTuple):
    """With what functions begin: those of the adversary, those of the brain, and those that are written here."""

    own: str
    honest: str
    worn: str


HELPERS = {
    "share": "def {worn}share(x):\n    return min(max(x, 0.0), 1.0)",
    "told": "def {worn}told(me, x):\n    return {worn}share({own}lie(me, {worn}share(x)))",
    "bin": "def {worn}bin(x, bins):\n    return float(min(int(x * bins), bins - 1))",
    "weight": "def {worn}weight(k, bin, bins):\n"
    f"    return 1.0 - {SPARE} if k == bin else {SPARE} / max(bins - 1.0, 1.0)",
    "mean": """
def {worn}mean(belief, bins):
    total = 0.0
    first = 0.0
    for k in range(bins):
        total += belief[k]
        first += belief[k] * (k + 0.5) / bins
    return first / total if total > 0.0 else 0.5""",
    "ratio": "def {worn}ratio(information, confidence):\n"
    "    return information / confidence if confidence > 0.0 else 0.5",
    "pooled": """
def {worn}pooled(information, confidence, parts):
    total = 0.0
    weight = 0.0
    for k in range(parts):
        total += information[k]
        weight += confidence[k]
    return total / weight if weight > 0.0 else 0.5""",
}


def lying_brain(adversary: Adversary, brain: Brain) -> Brain:
    """The brain of a robot that lies in a swarm of `brain`. Raises ValueError where the two do not go together."""
    return _lying_brain(adversary, brain, adversary.is_loaded and brain.is_loaded)


@functools.lru_cache(maxsize=256)
def _lying_brain(adversary: Adversary, brain: Brain, read: bool) -> Brain:
    """The same; files that were read and files that were not are equal otherwise."""
    own = {_names(adversary, brain).own + name: value for name, value in adversary.overrides}
    return _made(adversary.as_written, brain.as_written, read).with_parameters(dict(brain.overrides) | own)


@functools.lru_cache(maxsize=256)
def _made(adversary: Adversary, brain: Brain, read: bool) -> Brain:
    if brain.is_oracle:
        raise ValueError(f"brain {brain.name!r}: an oracle hears no liar: no adversary can wear it")
    fields = [Field(name, brain.roles.get(name, ""), long) for name, long in brain.message.items()]
    if not any(field.role in VALUES for field in fields):
        raise ValueError(
            f"the adversary {adversary.name!r} cannot lie: of the MESSAGE of {brain.name!r}, "
            f"({', '.join(brain.message)}), nothing is known to be one of {', '.join(VALUES)}: say what its MESSAGE "
            "means with ROLES"
        )
    # as the command line names it, which messages do too
    path = Path(f"{adversary.path} --wearing {brain.path}")
    try:
        source = source_of(adversary, brain, fields)
        if not read:
            return unloaded(adversary.name, source)
        linecache.cache[str(path)] = (len(source), None, source.splitlines(keepends=True), str(path))
        return parse(source, adversary.name, path)
    except InputError as error:
        told = str(error)
    except RecursionError:
        told = "its brackets or operators are nested too deep"
    raise ValueError(f"the adversary {adversary.name!r} cannot wear the brain {brain.name!r}: {told}")


def _names(adversary: Adversary, brain: Brain) -> Names:
    sources = adversary.source, brain.source
    return Names(*(free_prefix(prefix, sources) for prefix in ("liar_", "honest_", "worn_")))


def source_of(adversary: Adversary, brain: Brain, fields: list[Field]) -> str:
    """Both as one source. Raises InputError."""
    names, has = _names(adversary, brain), adversary.contents.functions
    tree, lies = ast.parse(brain.source), ast.parse(adversary.source)
    for given in GIVEN_ON_ASKING:
        if given in {*brain.memory, *brain.contents.parameters} and speaks_of(lies, given):
            raise InputError(f"it asks for me.{given}, and the brain has a field of its own of this name")
    own = (
        {names.own + k: v for k, v in table.items()}
        for table in (adversary.contents.memory, adversary.contents.parameters)
    )
    memory, parameters = (a | b for a, b in zip((brain.memory, brain.contents.parameters), own, strict=True))
    altered = {"broadcast", *(made for made, by in ALTERED_BY.items() if by in has)}
    kept = {*FUNCTIONS, *MAY_HAVE, *CONSTANTS} - altered - {*ANEW}
    constants = [f"MEMORY = {memory!r}", *([f"PARAMETERS = {parameters!r}"] if parameters else [])]
    parts = [
        f'"""{_first_line(lies)}\n\nWearing: {_first_line(tree)}\n"""',
        *(["import math"] if imports(tree) or imports(lies) else []),
        "\n".join(constants),
        renamed(tree, names.honest, kept, anew=ANEW),
        renamed(
            lies,
            names.own,
            (),
            fields_of_liar(names.own, {*adversary.contents.memory, *adversary.contents.parameters}),
            ANEW,
        ),
        functions_source(fields, has, names, brain.options, brain.uses.silence),
    ]
    return "\n\n\n".join(parts) + "\n"


def _first_line(tree: ast.Module) -> str:
    return (ast.get_docstring(tree) or "no description").partition("\n")[0].replace("\\", "/").replace('"', "'")


def functions_source(fields: Sequence[Field], has: Collection[str], names: Names, options: int, silent: bool) -> str:
    """The functions that alter what an honest brain says and hears; `has` are those that the adversary may have."""
    own, honest, worn = names
    before, parts = _saying(fields, has, names, options)
    # of a tuple or None, Numba indexes nothing, but takes it apart
    apart = ", ".join(f"said_{k}" for k, _ in enumerate(fields)) + ", = said"
    lines = [*(["if said is None:", "    return None"] if silent else []), apart, *before]
    functions = [
        "\n    ".join([f"def {worn}tell(me, said):", *lines, f"return ({', '.join(parts)},)"]),
        f"def broadcast(me):\n    return {worn}tell(me, {honest}broadcast(me))",
    ]
    if "hear" in has:
        k = next(k for k, field in enumerate(fields) if field.role in VALUES)
        heard = f"{own}hear(me, {worn}share({_read(fields, k, 'message[{}]', worn, options)}))"
        functions.append(f"def receive(me, message):\n    {honest}receive(me, message)\n    {heard}")
    if "plot" in has:
        functions.append(f"def fuse(me):\n    {honest}fuse(me)\n    {own}plot(me)")
    if "jam" in has:
        functions.append(f"def jam(me):\n    return {own}jam(me)")
    found = list(functions)
    for name, source in reversed(HELPERS.items()):
        if any(f"{worn}{name}(" in one for one in found):
            found.insert(0, source.format(own=own, worn=worn).strip("\n"))
    return "\n\n\n".join(found)


def _read(fields: Sequence[Field], k: int, part: str, worn: str, options: int) -> str:
    """The fill ratio that stands in a field of a message, whose parts are called so."""
    this = part.format(k)
    match fields[k].role:
        case "option":
            return f"({this} + 0.5) / {float(options)}"
        case "belief":
            return f"{worn}mean({this}, {fields[k].long})"
        case "information":
            other, long = part.format(_confidence(fields, k)), fields[k].long
            return f"{worn}pooled({this}, {other}, {long})" if long else f"{worn}ratio({this}, {other})"
    return this


def _confidence(fields: Sequence[Field], k: int) -> int:
    """The place of the confidence that the k-th field, an information, goes with."""
    names = [field.name for field in fields]
    return names.index(confidence_of(fields[k].name, names, {field.name: field.role for field in fields}))


def _each(parts: Sequence[str]) -> str:
    """The source of a vector of these."""
    return f"({', '.join(parts)},)"


def _saying(fields: Sequence[Field], has: Collection[str], names: Names, options: int) -> tuple[list[str], list[str]]:
    """What is said in place of the honest message `said`, field by field; and the lines that go before."""
    own, _, worn = names
    before, parts = [], []
    for k, (_, role, long) in enumerate(fields):
        told = f"{worn}told(me, {_read(fields, k, 'said_{}', worn, options)})"
        sure = f"max({own}boast(me, said_{{}}), 0.0)" if "boast" in has else "said_{}"
        match role:
            case "estimate":
                parts.append(told)
            case "opinion":
                parts.append(f"1.0 if {told} >= 0.5 else 0.0")
            case "option":
                parts.append(f"{worn}bin({told}, {options})")
            case "belief":
                before.append(f"bin_{k} = {worn}bin({told}, {long})")
                parts.append(f"({''.join(f'{worn}weight({j}, bin_{k}, {long}), ' for j in range(long))})")
            case "confidence" if long:
                parts.append(_each([sure.format(f"{k}[{j}]") for j in range(long)]))
            case "confidence":
                parts.append(sure.format(k))
            case "information" if long:
                before.append(f"told_{k} = {told}")
                other = _confidence(fields, k)
                parts.append(_each([f"told_{k} * {sure.format(f'{other}[{j}]')}" for j in range(long)]))
            case "information":
                parts.append(f"{told} * {sure.format(_confidence(fields, k))}")
            case "name" if "forge" in has:
                parts.append(f"1.0 * {own}forge(me, said_{k})")
            case _:
                parts.append(f"said_{k}")
    return before, parts


# the low bits of luck: independent of what a brain makes of the high ones
OWN_LUCK = "me.luck * 1048576.0 % 1.0"


def free_prefix(prefix: str, sources: Iterable[str]) -> str:
    """A prefix that stands in none of these sources."""
    while any(prefix in source for source in sources):
        prefix += "_"
    return prefix


class Renamed(ast.NodeTransformer):
    """Names of the top level, but where a function has a local of that name, and fields of the record."""

    def __init__(self, names: Mapping[str, ast.expr], fields: Mapping[str, ast.expr]) -> None:
        """What they become: `fields` are those of a record called `me`."""
        self.names, self.fields = names, fields
        self.local: set[str] = set()

    def visit_FunctionDef(self, node: ast.FunctionDef) -> ast.AST:
        """Rename what a function names."""
        self.local = {one.arg for one in ast.walk(node) if isinstance(one, ast.arg)}
        self.local |= {name for one in ast.walk(node) for name in names_set_by(one)}
        self.generic_visit(node)
        self.local = set()
        return node

    def visit_Name(self, node: ast.Name) -> ast.expr:
        """Rename what is of the top level."""
        new = None if node.id in self.local else self.names.get(node.id)
        return deepcopy(new) if new is not None else node

    def visit_Attribute(self, node: ast.Attribute) -> ast.expr:
        """Rename a field, but nothing of `math`."""
        node.value = self.visit(node.value)
        new = None if isinstance(node.value, ast.Name) and node.value.id == "math" else self.fields.get(node.attr)
        if isinstance(new, ast.Attribute):
            return ast.Attribute(node.value, new.attr, node.ctx)
        if new is None:
            return node
        found = deepcopy(new)
        for one in ast.walk(found):
            if isinstance(one, ast.Attribute):
                one.value = node.value  # whatever the function calls its record
        return found


def fields_of_liar(own: str, fields: Collection[str]) -> dict[str, ast.expr]:
    """What the fields of an adversary's record become."""
    found: dict[str, ast.expr] = {name: ast.Attribute(_name("me"), own + name, ast.Load()) for name in fields}
    return found | {"luck": ast.parse(OWN_LUCK, mode="eval").body}


def renamed(
    tree: ast.Module,
    prefix: str,
    kept: Collection[str] = (),
    fields: Mapping[str, ast.expr] | None = None,
    anew: Collection[str] = (),
) -> str:
    """A file with a prefix before all names of its top level but those `kept`, and `math` for what it imports.

    What is given a value `anew` elsewhere stays under the prefix only where it is read.
    """
    names: dict[str, ast.expr] = {}
    body: list[ast.stmt] = []
    for node in deepcopy(tree.body):  # in turn: a name may be bound twice, and constants are made of the ones before
        if isinstance(node, ast.Import | ast.ImportFrom):
            names |= _imported(node)
        elif isinstance(node, ast.Assign):
            node.value = Renamed(names, {}).visit(node.value)
            mine = {one.id: _new(one.id, prefix, kept) for one in node.targets if isinstance(one, ast.Name)}
            names |= {name: _name(new) for name, new in mine.items()}
            node.targets = [ast.Name(new, ast.Store()) for new in mine.values()]
            body.append(node)
        elif isinstance(node, ast.FunctionDef):
            new = _new(node.name, prefix, kept)
            names[node.name] = _name(new)
            node.name = new
            body.append(node)
    body = [Renamed(names, fields or {}).visit(n) if isinstance(n, ast.FunctionDef) else n for n in body]
    unread = {prefix + name for name in anew} - _names_read(body)
    for node in body:
        if isinstance(node, ast.Assign):
            node.targets = [one for one in node.targets if not (isinstance(one, ast.Name) and one.id in unread)]
    body = [node for node in body if not isinstance(node, ast.Assign) or node.targets]
    return ast.unparse(ast.fix_missing_locations(ast.Module(body, [])))


def _name(name: str) -> ast.Name:
    return ast.Name(name, ast.Load())


def _new(name: str, prefix: str, kept: Collection[str]) -> str:
    return name if name in kept else prefix + name


def _imported(node: ast.Import | ast.ImportFrom) -> dict[str, ast.expr]:
    """The names that an import of math gives, as what they are of `math`."""
    if isinstance(node, ast.Import):
        return {alias.asname or alias.name: _name("math") for alias in node.names}
    names = {alias.asname or alias.name: alias.name for alias in node.names}
    if "*" in names:
        names = {name: name for name in dir(math) if name[0] != "_"}
    return {name: ast.Attribute(_name("math"), origin, ast.Load()) for name, origin in names.items()}


def _names_read(body: list[ast.stmt]) -> set[str]:
    nodes = [one for node in body for one in ast.walk(node)]
    return {one.id for one in nodes if isinstance(one, ast.Name) and isinstance(one.ctx, ast.Load)}


def imports(tree: ast.Module) -> bool:
    """Whether a file imports anything, which can be `math` alone."""
    return any(isinstance(node, ast.Import | ast.ImportFrom) for node in tree.body)


def speaks_of(tree: ast.Module, field: str) -> bool:
    """Whether a source names a field of its record."""
    return any(isinstance(node, ast.Attribute) and node.attr == field for node in ast.walk(tree))
