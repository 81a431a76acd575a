"""What a brain file has to hold: see docs/brain-contract.md."""

import ast
import difflib
from collections.abc import Mapping
from pathlib import Path
from typing import Any, NamedTuple

from swarmcensus.basics import plain
from swarmcensus.basics.errors import InputError
from swarmcensus.brains import syntax
from swarmcensus.brains.fields import Value, fields_of, length
from swarmcensus.brains.syntax import BELIEFS

FUNCTIONS = {"observe": 3, "broadcast": 1, "receive": 2, "fuse": 1, "estimate": 1}
MAY_HAVE = {"steer": 1, "decide": 1, "done": 1}
TRACED = ("estimate", "round", "robot", "blacks", "position", "heading", "looked", "tile", "reading", "neighbours",
          "link", "axis")  # fmt: skip
MOST_OPTIONS = 10_000


class Contents(NamedTuple):
    """What a brain file says beside its functions."""

    memory: dict[str, Value]  # every field, its value before the first observation
    message: dict[str, int]  # what is said, and how long each vector of it is; 0 for a number
    sums: tuple[str, ...]  # the fields to which `receive` only adds what depends on the message alone
    parameters: dict[str, Value]
    options: int  # among how many `decide` decides
    uses: syntax.Uses
    functions: frozenset[str]  # which of MAY_HAVE there are


def contents(tree: ast.Module, constants: Mapping[str, Any], path: Path) -> Contents:
    """Hold a brain's constants and functions against the contract; nothing of it is run. Raises InputError."""
    try:
        return _contents(tree, constants)
    except syntax.Wrong as wrong:
        raise InputError(f"brain file {path}, line {wrong.line}: {wrong}") from None
    except ValueError as wrong:
        raise InputError(f"brain file {path}: {wrong}") from None


def need(holds: bool, what: str) -> None:
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
    need(_are_names(sums), "SUMS is a tuple of MEMORY names")
    need(len(set(sums)) == len(sums), "SUMS names a field twice")
    for key in sums:
        need(key in fields, f"SUMS names {key!r}, which is not in MEMORY")
    parameters = constants.get("PARAMETERS", {})
    need(isinstance(parameters, dict), 'PARAMETERS should be a dict such as {"prior": 10.0}')
    given = fields_of(parameters, "PARAMETERS", (*BELIEFS, *syntax.GIVEN_ON_ASKING, "file"))
    for key in given:
        need(key not in fields, f"PARAMETERS[{key!r}] is in MEMORY too: what changes is no parameter")
    options = constants.get("OPTIONS", 2)
    whole = isinstance(options, int) and not isinstance(options, bool)
    need(
        whole and 2 <= options <= MOST_OPTIONS,
        f"OPTIONS = {options!r}: should be a whole number, 2 (white and black) to {MOST_OPTIONS} (bins)",
    )
    functions = _functions(tree, constants)
    need("decide" in functions or "OPTIONS" not in constants, "OPTIONS is of the function decide, which is missing")
    syntax.check_decisions(tree, options)
    syntax.check(tree, lengths, {name: length(value) for name, value in given.items()}, sums)
    return Contents(fields, message, tuple(sums), given, options, syntax.uses(tree, (*fields, *given)), functions)


def _message(given: Any, memory: dict[str, int]) -> dict[str, int]:
    """What a message holds: names, of which those of vectors in MEMORY are as long as there, or a dict as MEMORY is."""
    if isinstance(given, dict):
        need(bool(given), "MESSAGE is empty")
        return {name: length(value) for name, value in fields_of(given, "MESSAGE", ()).items()}
    if isinstance(given, str):
        raise ValueError(f"MESSAGE is {given!r}, a text: a tuple of one name is ({given!r},)")
    example = 'MESSAGE is missing: a tuple of names such as ("x_hat", "alpha")'
    need(_are_names(given) and bool(given), example)
    twice = [name for name in given if list(given).count(name) > 1 and memory.get(name)]
    need(not twice, f"MESSAGE names {', '.join(twice[:1])!r} twice")
    return {_unlike(name, given[:k]): memory.get(name, 0) for k, name in enumerate(given)}


def _unlike(name: str, before: tuple[str, ...]) -> str:
    """A name that stands twice, as it may for numbers, told apart."""
    return f"{name}_{before.count(name) + 1}" if name in before else name


def _are_names(value: object) -> bool:
    return isinstance(value, tuple) and all(plain.is_name(v) for v in value)


def _functions(tree: ast.Module, constants: Mapping[str, Any]) -> frozenset[str]:
    functions = {node.name: node.args for node in tree.body if isinstance(node, ast.FunctionDef)}
    for name, arity in (FUNCTIONS | MAY_HAVE).items():
        need(name not in constants, f"{name} is {constants.get(name)!r}, not a function")
        if name not in functions:
            need(name in MAY_HAVE, f"the function {name} is missing")
            continue
        found = len(functions[name].posonlyargs) + len(functions[name].args)
        need(found == arity and not functions[name].kwonlyargs, f"{name} takes {found} arguments: {arity} are right")
    for name in syntax.never_called(tree):
        if name not in (*FUNCTIONS, *MAY_HAVE) and (meant := _meant(name)):
            raise ValueError(f"the function {name} is called by nobody: did you mean {meant!r}?")
    return frozenset(name for name in MAY_HAVE if name in functions)


def _meant(name: str) -> str:
    """Which function that a brain may have is written almost like this; nothing where none is."""
    return next(iter(difflib.get_close_matches(name.lower(), MAY_HAVE, n=1, cutoff=0.9)), "")
