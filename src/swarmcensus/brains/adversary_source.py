"""The source of a lying brain: an adversary and the brain that it wraps, merged into one readable brain file.

The robot observes, receives and fuses as the brain does; the adversary alters its messages according to the meaning of
their fields.
"""

import ast
import functools
import linecache
from collections.abc import Collection, Iterable, Mapping, Sequence
from copy import deepcopy
from pathlib import Path
from typing import NamedTuple

from swarmcensus.brains.adversary import SAYS, Adversary
from swarmcensus.brains.brain import Brain, parse, unloaded
from swarmcensus.brains.contract import CONSTANTS, FUNCTIONS, MAY_HAVE, confidence_of
from swarmcensus.brains.fields import length as length_of
from swarmcensus.brains.syntax import GIVEN_ON_ASKING
from swarmcensus.support.errors import BrainError, InputError
from swarmcensus.support.hints import did_you_mean
from swarmcensus.support.safe_source import names_set_by, of_math

REPLACED = (
    "MEMORY",
    "PARAMETERS",
    "SUMS",
    "KNOWS",
)  # constants of both files that are merged; those of the files get a prefix
ALTERED_BY = {"receive": "hear", "fuse": "plot", "jam": "jam"}  # a brain's function: the adversary's that alters it
VALUES = ("estimate", "opinion", "option", "belief", "information")  # roles that an adversary can lie about
SPARE = 1e-6  # the weight of a belief's other bins; from a weight of 0, a belief could never recover


class Field(NamedTuple):
    """A field of a message: its name, its role if known, and the length of its vector; 0 for a number."""

    name: str
    role: str
    length: int


class Prefixes(NamedTuple):
    """Prefixes of names: those of the adversary, of the brain, and of the helpers that are generated here."""

    own: str
    honest: str
    helper: str


HELPERS = {
    "share": "def {helper}share(x):\n    return min(max(x, 0.0), 1.0)",
    "told": "def {helper}told(me, x):\n    return {helper}share({own}lie(me, {helper}share(x)))",
    "bin": "def {helper}bin(x, bins):\n    return float(min(int(x * bins), bins - 1))",
    "weight": "def {helper}weight(k, bin, bins):\n"
    f"    return 1.0 - {SPARE} if k == bin else {SPARE} / max(bins - 1.0, 1.0)",
    "mean": """
def {helper}mean(belief, bins):
    total = 0.0
    first = 0.0
    for k in range(bins):
        total += belief[k]
        first += belief[k] * (k + 0.5) / bins
    return first / total if total > 0.0 else 0.5""",
    "ratio": "def {helper}ratio(information, confidence):\n"
    "    return information / confidence if confidence > 0.0 else 0.5",
    "pooled": """
def {helper}pooled(information, confidence, parts):
    total = 0.0
    weight = 0.0
    for k in range(parts):
        total += information[k]
        weight += confidence[k]
    return total / weight if weight > 0.0 else 0.5""",
}


def lying_brain(adversary: Adversary, brain: Brain) -> Brain:
    """The brain of a robot that lies in a swarm of `brain`. Raises BrainError if the two cannot be combined."""
    merged = _merge(adversary.as_written, brain.as_written, adversary.is_loaded and brain.is_loaded)
    own = {_prefixes(adversary, brain).own + name: value for name, value in adversary.overrides}
    return merged.with_parameters(dict(brain.overrides) | own)


@functools.lru_cache(maxsize=256)
def _merge(adversary: Adversary, brain: Brain, loaded: bool) -> Brain:
    """The brain with the parameters of both files; files that are `loaded` and not are otherwise equal."""
    if brain.is_oracle:
        raise BrainError.named("brain", brain.name, "an oracle hears no liars, so no adversary can wrap it")
    fields = [Field(name, brain.roles.get(name, ""), items) for name, items in brain.message.items()]
    if not any(field.role in VALUES for field in fields):
        raise BrainError(
            f"the adversary {adversary.name!r} cannot lie: the MESSAGE of {brain.name!r} is "
            f"({', '.join(brain.message)}), and none is known to be one of {', '.join(VALUES)}: name a role in ROLES",
            key="adversary",
            value=adversary.name,
        )
    # as in the command line and in messages
    path = Path(f"{adversary.path} --wrapping {brain.path}")
    try:
        _check_fit(adversary, brain)
        source = source_of(adversary, brain, fields)
        if not loaded:
            return unloaded(adversary.name, source)
        linecache.cache[str(path)] = (len(source), None, source.splitlines(keepends=True), str(path))
        return parse(source, adversary.name, path)
    except InputError as error:
        reason = str(error)
    except RecursionError:
        reason = "its brackets or operators are nested too deep"
    what = f"the adversary {adversary.name!r} cannot wrap the brain {brain.name!r}: {reason}"
    raise BrainError(what, key="adversary", value=adversary.name)


def _check_fit(adversary: Adversary, brain: Brain) -> None:
    """Raise InputError if the brain lacks fields that the adversary knows, or has a vector where it says a number."""
    fields = {**brain.lengths, **{name: length_of(value) for name, value in brain.contents.parameters.items()}}
    lacking = _unknown_fields(adversary, brain) if not brain.never_speaks else []
    for name in adversary.contents.knows:
        what = f"KNOWS of {adversary.path} names {name!r}"
        if name in lacking:
            hint = did_you_mean(name, fields).rstrip()
            raise InputError(f"{what}, and the brain has no such field{': ' * bool(hint)}{hint}")
        if fields.get(name):
            raise InputError(f"{what}, which is a vector of the brain: it may know numbers")
    for name, items in brain.message.items():
        if items and SAYS + name in adversary.contents.functions:
            raise InputError(f"{SAYS}{name} of {adversary.path} returns a number, and {name} is a vector of {items}")


def _unknown_fields(adversary: Adversary, brain: Brain) -> list[str]:
    """The fields that the adversary knows and the brain does not have."""
    return [name for name in adversary.contents.knows if name not in {*brain.memory, *brain.contents.parameters}]


def _prefixes(adversary: Adversary, brain: Brain) -> Prefixes:
    sources = adversary.source, brain.source
    return Prefixes(*(free_prefix(prefix, sources) for prefix in ("liar_", "honest_", "worn_")))


def source_of(adversary: Adversary, brain: Brain, fields: list[Field]) -> str:
    """The merged source. Raises InputError."""
    prefixes, optional = _prefixes(adversary, brain), adversary.contents.functions
    tree, lies = ast.parse(brain.source), ast.parse(adversary.source)
    for given in GIVEN_ON_ASKING:
        if given in {*brain.memory, *brain.contents.parameters} and uses_field(lies, given):
            raise InputError(f"it reads me.{given}, and the brain has a field of this name")
    own_memory = adversary.contents.memory | dict.fromkeys(_unknown_fields(adversary, brain), 0.0)
    own = ({prefixes.own + k: v for k, v in table.items()} for table in (own_memory, adversary.contents.parameters))
    memory, parameters = (a | b for a, b in zip((brain.memory, brain.contents.parameters), own, strict=True))
    altered = {"broadcast", *(function for function, by in ALTERED_BY.items() if by in optional)}
    kept = {*FUNCTIONS, *MAY_HAVE, *CONSTANTS} - altered - {*REPLACED}
    fields_of_liar = {name: f"{{}}.{prefixes.own}{name}" for name in (*own_memory, *adversary.contents.parameters)}
    constants = [f"MEMORY = {memory!r}", *([f"PARAMETERS = {parameters!r}"] if parameters else [])]
    parts = [
        f'"""{_first_line(lies)}\n\nWearing: {_first_line(tree)}\n"""',
        *(["import math"] if imports(tree) or imports(lies) else []),
        "\n".join(constants),
        renamed(tree, prefixes.honest, kept),
        renamed(lies, prefixes.own, (), fields_of_liar | {"luck": OWN_DRAW}),
        functions_source(fields, optional, prefixes, brain.options, brain.uses.silence, brain.never_speaks),
    ]
    return "\n\n\n".join(parts) + "\n"


def _first_line(tree: ast.Module) -> str:
    return (ast.get_docstring(tree) or "no description").partition("\n")[0].replace("\\", "/").replace('"', "'")


def functions_source(
    fields: Sequence[Field], optional: Collection[str], prefixes: Prefixes, options: int, silent: bool, mute: bool
) -> str:
    """The functions that alter what the honest brain says and hears; `optional` are those of the adversary.

    An honest brain may be `silent` now and then, or `mute`: it never says anything.
    """
    own, honest, helper = prefixes
    before, parts = _altered_message(fields, optional, prefixes, options)
    # Numba cannot index a tuple that may be None, but can unpack it
    unpacked = ", ".join(f"said_{k}" for k, _ in enumerate(fields)) + ", = said"
    says = [f"said = {honest}broadcast(me)", *(["if said is None:", "    return None"] if silent else [])]
    says = [f"return {honest}broadcast(me)"] if mute else [*says, f"return {helper}tell(me, said)"]
    functions = [
        "\n    ".join([f"def {helper}tell(me, said):", unpacked, *before, f"return ({', '.join(parts)},)"]),
        "\n    ".join(["def broadcast(me):", *says]),
    ]
    if "hear" in optional:
        k = next(k for k, field in enumerate(fields) if field.role in VALUES)
        heard = f"{own}hear(me, {helper}share({_fill_ratio(fields, k, 'message[{}]', helper, options)}))"
        functions.append(f"def receive(me, message):\n    {honest}receive(me, message)\n    {heard}")
    if "plot" in optional:
        functions.append(f"def fuse(me):\n    {honest}fuse(me)\n    {own}plot(me)")
    if "jam" in optional:
        functions.append(f"def jam(me):\n    return {own}jam(me)")
    sources = list(functions)
    for name, source in reversed(HELPERS.items()):
        if any(f"{helper}{name}(" in user for user in sources):
            sources.insert(0, source.format(own=own, helper=helper).strip("\n"))
    return "\n\n\n".join(sources)


def _fill_ratio(fields: Sequence[Field], k: int, part: str, helper: str, options: int) -> str:
    """The source of the fill ratio in the k-th field of a message; `part` is the format of the fields' names."""
    this = part.format(k)
    match fields[k].role:
        case "option":
            return f"({this} + 0.5) / {float(options)}"
        case "belief":
            return f"{helper}mean({this}, {fields[k].length})"
        case "information":
            confidence, length = part.format(_confidence(fields, k)), fields[k].length
            return (
                f"{helper}pooled({this}, {confidence}, {length})" if length else f"{helper}ratio({this}, {confidence})"
            )
    return this


def _confidence(fields: Sequence[Field], k: int) -> int:
    """The place of the confidence that belongs to the k-th field, an information."""
    names = [field.name for field in fields]
    return names.index(confidence_of(fields[k].name, names, {field.name: field.role for field in fields}))


def _tuple(parts: Sequence[str]) -> str:
    """The source of a tuple of parts."""
    return f"({', '.join(parts)},)"


def _altered_message(
    fields: Sequence[Field], optional: Collection[str], prefixes: Prefixes, options: int
) -> tuple[list[str], list[str]]:
    """The source lines that precede the altered message, and the source of each of its fields."""
    own, _, helper = prefixes
    before, parts = [], []
    for k, (name, role, length) in enumerate(fields):
        if SAYS + name in optional:
            parts.append(f"1.0 * {own}{SAYS}{name}(me, said_{k})")
            continue
        lie = f"{helper}told(me, {_fill_ratio(fields, k, 'said_{}', helper, options)})"
        sure = f"max({own}boast(me, said_{{}}), 0.0)" if "boast" in optional else "said_{}"
        match role:
            case "estimate":
                parts.append(lie)
            case "opinion":
                parts.append(f"1.0 if {lie} >= 0.5 else 0.0")
            case "option":
                parts.append(f"{helper}bin({lie}, {options})")
            case "belief":
                before.append(f"bin_{k} = {helper}bin({lie}, {length})")
                parts.append(f"({''.join(f'{helper}weight({j}, bin_{k}, {length}), ' for j in range(length))})")
            case "confidence" if length:
                parts.append(_tuple([sure.format(f"{k}[{j}]") for j in range(length)]))
            case "confidence":
                parts.append(sure.format(k))
            case "information" if length:
                before.append(f"told_{k} = {lie}")
                confidence = _confidence(fields, k)
                parts.append(_tuple([f"told_{k} * {sure.format(f'{confidence}[{j}]')}" for j in range(length)]))
            case "information":
                parts.append(f"{lie} * {sure.format(_confidence(fields, k))}")
            case "name" if "forge" in optional:
                parts.append(f"1.0 * {own}forge(me, said_{k})")
            case _:
                parts.append(f"said_{k}")
    return before, parts


# the low bits of me.luck, which are independent of the high bits that the brain uses
OWN_DRAW = "({}.luck * 1048576.0 % 1.0)"


def free_prefix(prefix: str, sources: Iterable[str]) -> str:
    """A prefix that occurs in none of these sources."""
    while any(prefix in source for source in sources):
        prefix += "_"
    return prefix


class Renamer(ast.NodeTransformer):
    """Renames top-level names, except where a function has a local of that name, and fields of the record.

    What it makes is for `ast.unparse`: a new name may be any expression as text.
    """

    def __init__(self, names: Mapping[str, str], fields: Mapping[str, str]) -> None:
        """Keep the new names; those of fields are formats of the record's name, which differs between functions."""
        self.names, self.fields = names, fields
        self.local: set[str] = set()

    def visit_FunctionDef(self, node: ast.FunctionDef) -> ast.AST:
        """Rename a function, and within it."""
        node.name = self.names[node.name]
        self.local = {part.arg for part in ast.walk(node) if isinstance(part, ast.arg)}
        self.local |= {name for part in ast.walk(node) for name in names_set_by(part)}
        return self.generic_visit(node)

    def visit_Name(self, node: ast.Name) -> ast.expr:
        """Rename a top-level name."""
        return node if node.id in self.local else ast.Name(self.names.get(node.id, node.id), node.ctx)

    def visit_Attribute(self, node: ast.Attribute) -> ast.expr:
        """Rename a field, but no attribute of `math`."""
        self.generic_visit(node)
        record = ast.unparse(node.value)
        new = self.fields.get(node.attr, f"{{}}.{node.attr}").format(record)
        return node if record == "math" else ast.Name(new, node.ctx)


def renamed(tree: ast.Module, prefix: str, kept: Collection[str] = (), fields: Mapping[str, str] | None = None) -> str:
    """The source of a file with a prefix before all top-level names but those `kept`; `math` is not imported."""
    names: dict[str, str] = {}
    constants, functions = Renamer(names, {}), Renamer(names, fields or {})
    body = [node for node in deepcopy(tree.body) if not isinstance(node, ast.Expr)]
    for node in body:  # in order: names may be bound twice, and constants use earlier ones
        if isinstance(node, ast.Import | ast.ImportFrom):
            names |= {name: f"math.{own}" if own else "math" for name, own in of_math(node).items()}
        elif isinstance(node, ast.Assign):
            node.value = constants.visit(node.value)
            names |= {
                name: name if name in kept else prefix + name for one in node.targets for name in names_set_by(one)
            }
            node.targets = [constants.visit(target) for target in node.targets]
        elif isinstance(node, ast.FunctionDef):
            names[node.name] = node.name if node.name in kept else prefix + node.name
    body = [functions.visit(node) if isinstance(node, ast.FunctionDef) else node for node in body]
    made: list[ast.stmt] = [node for node in body if isinstance(node, ast.FunctionDef | ast.Assign)]
    return ast.unparse(ast.parse(ast.unparse(ast.fix_missing_locations(ast.Module(made, [])))))


def imports(tree: ast.Module) -> bool:
    """Whether a file imports `math`, the only module that it may import."""
    return any(isinstance(node, ast.Import | ast.ImportFrom) for node in tree.body)


def uses_field(tree: ast.Module, field: str) -> bool:
    """Whether a source uses a field of its record."""
    return any(isinstance(node, ast.Attribute) and node.attr == field for node in ast.walk(tree))
