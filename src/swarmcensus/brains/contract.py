"""What a brain file must contain. See docs/brain-contract.md."""

import ast
import difflib
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple

from swarmcensus.brains import integer_powers, robot_math, robot_syntax, syntax
from swarmcensus.brains.fields import Value, fields_of, length
from swarmcensus.brains.kinds import REAL, RECORD, VECTOR, Kind, Kinds
from swarmcensus.brains.requirements import Needs, read_needs
from swarmcensus.brains.syntax import BELIEFS
from swarmcensus.support import safe_source

FUNCTIONS = {"observe": 3, "broadcast": 1, "receive": 2, "fuse": 1, "estimate": 1}
CONSTANTS = ("MEMORY", "MESSAGE", "PARAMETERS", "OPTIONS", "ORACLE", "ROLES", "OPINION", "NEEDS", "SUMS")
MAY_HAVE = {"steer": 1, "decide": 1, "done": 1, "interval": 1, "jam": 1}
TRACED = ("estimate", "round", "robot", "blacks", "position", "heading", "looked", "tile", "reading", "neighbours",
          "link", "axis")  # fmt: skip
MOST_OPTIONS = 10_000
ROLES = {  # what a field of a message may mean, and its usual names
    "estimate": ("x", "x_hat", "x_bar", "estimate", "share"),  # a fill ratio, in [0, 1]
    "opinion": ("opinion", "decision"),  # 0 for white, 1 for black
    "option": ("option", "site"),  # a bin of the fill ratio, from 0
    "belief": ("belief", "beliefs"),  # a vector: the probability of each bin, up to a factor
    "confidence": ("alpha", "beta", "confidence", "quality"),  # 0 or more
    "information": (),  # an estimate times the confidence in the same message
    "name": ("name",),  # the sender
}


class Contents(NamedTuple):
    """What a brain file declares, and which optional functions it has."""

    memory: dict[str, Value]  # each field and its initial value
    message: dict[str, int]  # each field and the length of its vector; 0 for a number
    sums: tuple[str, ...]  # fields to which `receive` only adds values that depend on the message alone
    parameters: dict[str, Value]
    options: int  # the number of options of `decide`
    uses: syntax.Uses
    functions: frozenset[str]  # those of MAY_HAVE that the file has
    roles: dict[str, str]  # the meaning of message fields, where known
    opinion: bool  # whether its estimate is an opinion, 0 or 1
    oracle: bool  # whether it hears all robots and knows their true accuracies
    needs: Needs  # of a study


def read_contents(tree: ast.Module, constants: Mapping[str, Any], path: Path) -> Contents:
    """Check a brain's constants and functions against the contract, without running it. Raises InputError."""
    with syntax.naming_lines("brain", path):
        return _contents(tree, constants)


def require(holds: bool, what: str) -> None:
    """Raise ValueError with the message `what` unless `holds`."""
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
    require(_are_names(sums), "SUMS should be a tuple of MEMORY names")
    require(len(set(sums)) == len(sums), "SUMS names a field twice")
    for key in sums:
        require(key in fields, f"SUMS names {key!r}, which is not in MEMORY")
    parameters = constants.get("PARAMETERS", {})
    require(isinstance(parameters, dict), 'PARAMETERS should be a dict such as {"prior": 10.0}')
    given = fields_of(parameters, "PARAMETERS", (*BELIEFS, *syntax.GIVEN_ON_ASKING, "file"))
    for key in given:
        require(key not in fields, f"PARAMETERS[{key!r}] is in MEMORY too: a value that changes is not a parameter")
    options = constants.get("OPTIONS", 2)
    whole = isinstance(options, int) and not isinstance(options, bool)
    right = f"should be a whole number, 2 (white and black) to {MOST_OPTIONS:,} (bins)"
    require(whole and 2 <= options <= MOST_OPTIONS, f"OPTIONS = {options!r}: {right}")
    functions = functions_in(tree, constants, FUNCTIONS, MAY_HAVE)
    require("decide" in functions or "OPTIONS" not in constants, "OPTIONS needs the function decide, which is missing")
    one_by_one = "SUMS cannot be combined with jam: with noise, messages are heard one by one"
    require(not (sums and "jam" in functions), one_by_one)
    robot_math.check(tree)
    robot_syntax.check(tree)
    syntax.check_returns(syntax.functions_of(tree), ("decide", "done", "jam", "interval"))
    lengths_given = {name: length(value) for name, value in given.items()}
    syntax.check(tree, lengths, lengths_given, sums)
    integer_powers.check(tree, lambda: kinds_of(tree, lengths | lengths_given, message))
    uses = syntax.uses(tree, (*fields, *given))
    opinion, oracle = (constants.get(name, False) for name in ("OPINION", "ORACLE"))
    for name, value in (("OPINION", opinion), ("ORACLE", oracle)):
        require(isinstance(value, bool), f"{name} = {value!r}: should be True, or left out")
    require(bool(sums) or not oracle, "an ORACLE hears all robots at once, so it needs SUMS")
    roles = _roles(constants.get("ROLES"), message)
    needs = read_needs(constants.get("NEEDS", {}), given)
    return Contents(fields, message, tuple(sums), given, options, uses, functions, roles, opinion, oracle, needs)


def kinds_of(tree: ast.Module, lengths: Mapping[str, int], message: Mapping[str, int]) -> Kinds:
    """The kinds of a source's expressions; `lengths` are those of its fields and parameters."""
    record = {**lengths, **dict.fromkeys(("luck", "name", *BELIEFS), 0)}
    first: dict[str, tuple[Kind, ...]] = dict.fromkeys((*FUNCTIONS, *MAY_HAVE), (RECORD,))
    heard = tuple(VECTOR if items else REAL for items in message.values())
    return Kinds(tree, record, first | {"observe": (RECORD, REAL, REAL), "receive": (RECORD, heard)})


def _roles(given: Any, message: dict[str, int]) -> dict[str, str]:
    """The meaning of message fields: from ROLES, or else from their usual names."""
    if given is None:
        usual = {name: role for role, names in ROLES.items() for name in names}
        return {name: usual[name] for name in message if name in usual}
    require(isinstance(given, dict), 'ROLES should be a dict such as {"x_hat": "estimate"}')
    for name, role in given.items():
        require(name in message, f"ROLES names {name!r}, which is not in MESSAGE")
        require(role in ROLES, f"ROLES[{name!r}] = {role!r}: should be one of {', '.join(ROLES)}")
    for name, role in given.items():
        fits = role in ("information", "confidence") or (role == "belief") == bool(message[name])
        require(fits, f"ROLES[{name!r}] = {role!r}: a belief is a vector, and other roles are numbers")
    needs = "information" in given.values() and "confidence" not in given.values()
    require(not needs, "ROLES names an information but no confidence: an information is a confidence times an estimate")
    for name in (name for name, role in given.items() if role == "information"):
        confidence = confidence_of(name, list(message), given)
        equal = message[name] == message[confidence]
        require(equal, f"ROLES: the information {name!r} and its confidence {confidence!r} should have the same length")
    return dict(given)


def confidence_of(name: str, message: Sequence[str], roles: Mapping[str, str]) -> str:
    """The confidence that belongs to an information field: the next one in the message, or else the first."""
    candidates = [*message[message.index(name) :], *message]
    return next(field for field in candidates if roles.get(field) == "confidence")


def _message(given: Any, memory: dict[str, int]) -> dict[str, int]:
    """The fields of MESSAGE and their vector lengths; it is a tuple of names, or a dict like MEMORY.

    In a tuple, the name of a vector in MEMORY stands for a vector of that length.
    """
    if isinstance(given, dict):
        require(bool(given), "MESSAGE is empty")
        return {name: length(value) for name, value in fields_of(given, "MESSAGE", ()).items()}
    if isinstance(given, str):
        raise ValueError(f"MESSAGE is {given!r}, a text: a tuple of one name is ({given!r},)")
    example = 'MESSAGE is missing: a tuple of names such as ("x_hat", "alpha")'
    require(_are_names(given) and bool(given), example)
    twice = [name for name in given if given.count(name) > 1]
    require(not twice, f"MESSAGE names {', '.join(twice[:1])!r} twice")
    return {name: memory.get(name, 0) for name in given}


def _are_names(value: object) -> bool:
    return isinstance(value, tuple) and all(safe_source.is_name(v) for v in value)


def functions_in(
    tree: ast.Module, constants: Mapping[str, Any], must: Mapping[str, int], may: Mapping[str, int]
) -> frozenset[str]:
    """The functions of `may` that a file has. Raises ValueError if one of `must` is missing, or has other arguments."""
    functions = syntax.functions_of(tree)
    for name, arity in {**must, **may}.items():
        require(name not in constants, f"{name} is {constants.get(name)!r}, not a function")
        if name not in functions:
            require(name in may, f"the function {name} is missing")
            continue
        arguments = len(syntax.arguments_of(functions[name]))
        is_right = arguments == arity and not functions[name].args.kwonlyargs
        require(is_right, f"{name}: the number of its arguments should be {arity}, not {arguments}")
    named = {node.id for node in ast.walk(tree) if isinstance(node, ast.Name)}
    for name in (name for name in functions if name not in {*must, *may, *named}):
        for meant in difflib.get_close_matches(name.lower(), may, n=1, cutoff=0.9):
            raise ValueError(f"the function {name} is never called: did you mean {meant!r}?")
    return frozenset(name for name in may if name in functions)
