"""What a brain file has to hold: see docs/brain-contract.md."""

import ast
import difflib
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple

from swarmcensus.basics import safe_source
from swarmcensus.basics.errors import InputError
from swarmcensus.brains import syntax
from swarmcensus.brains.fields import Value, fields_of, length
from swarmcensus.brains.syntax import BELIEFS

FUNCTIONS = {"observe": 3, "broadcast": 1, "receive": 2, "fuse": 1, "estimate": 1}
CONSTANTS = ("MEMORY", "MESSAGE", "PARAMETERS", "OPTIONS", "ORACLE", "ROLES", "OPINION", "SUMS")
MAY_HAVE = {"steer": 1, "decide": 1, "done": 1, "interval": 1, "jam": 1}
TRACED = ("estimate", "round", "robot", "blacks", "position", "heading", "looked", "tile", "reading", "neighbours",
          "link", "axis")  # fmt: skip
MOST_OPTIONS = 10_000
ROLES = {  # what a number of a message may mean, and how it is mostly called
    "estimate": ("x", "x_hat", "x_bar", "estimate", "share"),  # a fill ratio, in [0, 1]
    "opinion": ("opinion", "decision"),  # 0 for white, 1 for black
    "option": ("option", "site"),  # one of several bins of the fill ratio, from 0 on
    "belief": ("belief", "beliefs"),  # a vector: how likely each bin is, up to a factor
    "confidence": ("alpha", "beta", "confidence", "quality"),  # from 0 on
    "information": (),  # an estimate times the confidence that stands in the same message
    "name": ("name",),  # who speaks
}


class Contents(NamedTuple):
    """What a brain file says beside its functions."""

    memory: dict[str, Value]  # every field, its value before the first observation
    message: dict[str, int]  # what is said, and how long each vector of it is; 0 for a number
    sums: tuple[str, ...]  # the fields to which `receive` only adds what depends on the message alone
    parameters: dict[str, Value]
    options: int  # among how many `decide` decides
    uses: syntax.Uses
    functions: frozenset[str]  # which of MAY_HAVE there are
    roles: dict[str, str]  # what fields of the message mean, as far as it is known
    opinion: bool  # whether its estimate is a mere opinion, 0 or 1
    oracle: bool  # whether it hears all robots, and knows all sensors


def contents(tree: ast.Module, constants: Mapping[str, Any], path: Path) -> Contents:
    """Hold a brain's constants and functions against the contract; nothing of it is run. Raises InputError."""
    try:
        return _contents(tree, constants)
    except syntax.Wrong as wrong:
        raise InputError(f"brain file {path}, line {wrong.line}: {wrong}") from None
    except ValueError as wrong:
        raise InputError(f"brain file {path}: {wrong}") from None


def require(holds: bool, what: str) -> None:
    """Raise ValueError where something does not hold."""
    if not holds:
        raise ValueError(what)


def _contents(tree: ast.Module, constants: Mapping[str, Any]) -> Contents:
    memory = constants.get("MEMORY")
    if not isinstance(memory, dict) or not memory:
        raise ValueError('MEMORY is missing: a dict such as {"t": 0.0, "x": 0.5}')
    fields = fields_of(memory, "MEMORY", (*BELIEFS, *TRACED))
    lengths = {name: length(value) for name, value in fields.items()}
    message = _message(constants.get("MESSAGE"), lengths)
    sums = constants.get("SUMS", ())
    require(_are_names(sums), "SUMS is a tuple of MEMORY names")
    require(len(set(sums)) == len(sums), "SUMS names a field twice")
    for key in sums:
        require(key in fields, f"SUMS names {key!r}, which is not in MEMORY")
    parameters = constants.get("PARAMETERS", {})
    require(isinstance(parameters, dict), 'PARAMETERS should be a dict such as {"prior": 10.0}')
    given = fields_of(parameters, "PARAMETERS", (*BELIEFS, *syntax.GIVEN_ON_ASKING, "file"))
    for key in given:
        require(key not in fields, f"PARAMETERS[{key!r}] is in MEMORY too: what changes is no parameter")
    options = constants.get("OPTIONS", 2)
    whole = isinstance(options, int) and not isinstance(options, bool)
    require(
        whole and 2 <= options <= MOST_OPTIONS,
        f"OPTIONS = {options!r}: should be a whole number, 2 (white and black) to {MOST_OPTIONS:,} (bins)",
    )
    functions = functions_in(tree, constants, FUNCTIONS, MAY_HAVE)
    require("decide" in functions or "OPTIONS" not in constants, "OPTIONS is of the function decide, which is missing")
    require(not (sums and "jam" in functions), "SUMS goes without jam: where noise is, messages are heard one by one")
    syntax.check_decisions(tree, options)
    syntax.check_interval(tree)
    syntax.check(tree, lengths, {name: length(value) for name, value in given.items()}, sums)
    uses = syntax.uses(tree, (*fields, *given))
    opinion = constants.get("OPINION", False)
    require(isinstance(opinion, bool), f"OPINION = {opinion!r}: should be True, or left out")
    oracle = constants.get("ORACLE", False)
    require(isinstance(oracle, bool), f"ORACLE = {oracle!r}: should be True, or left out")
    require(bool(sums) or not oracle, "an ORACLE hears all robots at once, and so has SUMS")
    roles = _roles(constants.get("ROLES"), message)
    return Contents(fields, message, tuple(sums), given, options, uses, functions, roles, opinion, oracle)


def _roles(given: Any, message: dict[str, int]) -> dict[str, str]:
    """What the fields of a message mean: as the file says, else as their names do."""
    if given is None:
        usual = {name: role for role, names in ROLES.items() for name in names}
        return {name: usual[name] for name in message if name in usual}
    require(isinstance(given, dict), 'ROLES should be a dict such as {"x_hat": "estimate"}')
    for name, role in given.items():
        require(name in message, f"ROLES names {name!r}, which is not in MESSAGE")
        require(role in ROLES, f"ROLES[{name!r}] = {role!r}: should be one of {', '.join(ROLES)}")
    for name, role in given.items():
        fits = role in ("information", "confidence") or (role == "belief") == bool(message[name])
        require(fits, f"ROLES[{name!r}] = {role!r}: only a vector is a belief")
    needs = "information" in given.values() and "confidence" not in given.values()
    require(not needs, "ROLES names an information, which is a confidence times an estimate, and no confidence")
    for name in (name for name, role in given.items() if role == "information"):
        other = confidence_of(name, list(message), given)
        alike = message[name] == message[other]
        require(alike, f"ROLES: the information {name!r} and its confidence {other!r} should be of one length")
    return dict(given)


def confidence_of(name: str, message: Sequence[str], roles: Mapping[str, str]) -> str:
    """The confidence that an information of a message goes with: the next one after it, or else the first."""
    after = [*message[message.index(name) :], *message]
    return next(other for other in after if roles.get(other) == "confidence")


def _message(given: Any, memory: dict[str, int]) -> dict[str, int]:
    """What a message holds: names, of which those of vectors in MEMORY are as long as there, or a dict as MEMORY is."""
    if isinstance(given, dict):
        require(bool(given), "MESSAGE is empty")
        return {name: length(value) for name, value in fields_of(given, "MESSAGE", ()).items()}
    if isinstance(given, str):
        raise ValueError(f"MESSAGE is {given!r}, a text: a tuple of one name is ({given!r},)")
    example = 'MESSAGE is missing: a tuple of names such as ("x_hat", "alpha")'
    require(_are_names(given) and bool(given), example)
    twice = [name for name in given if list(given).count(name) > 1 and memory.get(name)]
    require(not twice, f"MESSAGE names {', '.join(twice[:1])!r} twice")
    return {_unlike(name, given[:k]): memory.get(name, 0) for k, name in enumerate(given)}


def _unlike(name: str, before: tuple[str, ...]) -> str:
    """A name that stands twice, as it may for numbers, told apart."""
    return f"{name}_{before.count(name) + 1}" if name in before else name


def _are_names(value: object) -> bool:
    return isinstance(value, tuple) and all(safe_source.is_name(v) for v in value)


def functions_in(
    tree: ast.Module, constants: Mapping[str, Any], must: Mapping[str, int], may: Mapping[str, int]
) -> frozenset[str]:
    """Which functions of `may` a file has; it has those of `must`, with so many arguments. Raises ValueError."""
    functions = {node.name: node.args for node in tree.body if isinstance(node, ast.FunctionDef)}
    for name, arity in {**must, **may}.items():
        require(name not in constants, f"{name} is {constants.get(name)!r}, not a function")
        if name not in functions:
            require(name in may, f"the function {name} is missing")
            continue
        found = len(functions[name].posonlyargs) + len(functions[name].args)
        require(found == arity and not functions[name].kwonlyargs, f"{name} takes {found} arguments: {arity} are right")
    for name in syntax.never_called(tree):
        if name not in (*must, *may) and (meant := _meant(name, may)):
            raise ValueError(f"the function {name} is called by nobody: did you mean {meant!r}?")
    return frozenset(name for name in may if name in functions)


def _meant(name: str, may: Mapping[str, int]) -> str:
    """Which function that a file may have is written almost like this; nothing where none is."""
    return next(iter(difflib.get_close_matches(name.lower(), may, n=1, cutoff=0.9)), "")
