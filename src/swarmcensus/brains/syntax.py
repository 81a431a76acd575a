"""How a brain's source uses its record, found from the syntax tree without running it."""

import ast
import contextlib
from collections.abc import Collection, Iterator, Sequence
from pathlib import Path
from typing import NamedTuple

from swarmcensus.support.errors import BrainError
from swarmcensus.support.hints import did_you_mean

BELIEFS = ("b", "w")  # the sensor accuracies that a robot assumes
GIVEN_ON_ASKING = ("luck", "name")  # fields of `me` that exist if a brain reads them
RANDOM = ("observe", "receive", "fuse", "steer")  # functions with a new random number at each call
READ_ONLY = ("broadcast", "estimate", "decide", "done", "interval", "jam")  # these only return values
INTERVAL = "two numbers, 0 <= low <= high <= 1, are right, or (0.0, 1.0) if nothing is known"


class Uses(NamedTuple):
    """Which optional parts of the contract a brain uses."""

    random: frozenset[str]  # the functions that read me.luck, directly or in a helper
    name: bool
    silence: bool  # `broadcast` may return None

    @property
    def luck(self) -> bool:
        """Whether any function reads me.luck."""
        return bool(self.random)


class BrokenContract(Exception):
    """A line of a source breaks the contract."""

    def __init__(self, what: str, line: int) -> None:
        """Keep the message and the line number."""
        super().__init__(what)
        self.line = line


@contextlib.contextmanager
def naming_lines(kind: str, path: Path) -> Iterator[None]:
    """In this block, what is wrong with a file of this kind, such as "brain", is a BrainError that names the place."""
    try:
        yield
    except BrokenContract as error:
        raise BrainError.of(path, error, where=f"{kind} file {path}, line {error.line}") from None
    except ValueError as error:
        raise BrainError.within(f"{kind} file {path}", error) from None


def uses(tree: ast.Module, own: Collection[str]) -> Uses:
    """What a brain uses; `own` are the fields that it declares."""
    functions = functions_of(tree)
    broadcasts = [functions[name] for name in called_by("broadcast", functions)]
    random = [name for name in RANDOM if "luck" not in own and _reads("luck", called_by(name, functions), functions)]
    named = "name" not in own and bool(_reads("name", functions, functions))
    return Uses(frozenset(random), named, any(map(may_be_none, broadcasts)))


def check(
    tree: ast.Module,
    memory: dict[str, int],
    parameters: dict[str, int],
    sums: Collection[str],
    first: str = "observe",
    read_only: Collection[str] = READ_ONLY,
    random: Sequence[str] = RANDOM,
    knows: Collection[str] | None = None,
) -> None:
    """Check how a source uses its record; `memory` and `parameters` are fields and lengths. Raises BrokenContract.

    The record is the first argument of the function `first`. The functions `read_only` only return values; those that
    are `random` have a new random number at each call. `knows` are further numbers that an adversary reads; None for a
    brain.
    """
    given = {name for name in GIVEN_ON_ASKING if name not in memory and name not in parameters} | {*(knows or ())}
    known = [*memory, *parameters, *BELIEFS, *given]
    own_vectors = {name for name, items in memory.items() if items}
    vectors = own_vectors | {name for name, items in parameters.items() if items}
    functions = functions_of(tree)
    record = arguments_of(functions[first])[0]  # what the file calls `me`
    for name, node in ((name, node) for name, function in functions.items() for node in ast.walk(function)):
        match node:
            case ast.arg(arg="math") | ast.Name(id="math", ctx=ast.Store()):
                raise BrokenContract(f"{name} uses the name math for something other than the module", node.lineno)
            case ast.Attribute(value=ast.Name(id=owner)) if owner == record and node.attr not in known:
                hint = did_you_mean(node.attr, known)
                own = "MEMORY and PARAMETERS" + ", and of the brain those that KNOWS names" * (knows is not None)
                what = f"{name} uses me.{node.attr}: {hint}a robot has only b, w and the fields of {own}"
                raise BrokenContract(what, node.lineno)
            # before that of slices: an assignment to a slice is refused as an assignment
            case ast.Subscript(ctx=ast.Store() | ast.Del()):
                _check_item(node, name, own_vectors, parameters)
            case ast.Subscript(slice=ast.Slice()) if _is_field(node.value, vectors):
                raise BrokenContract(f"{name} takes a slice of a vector: its items are read one by one", node.lineno)
            case ast.Attribute(ctx=ast.Store() | ast.Del()) if _is_attribute(node):
                _check_set(node, name, own_vectors, parameters, given)
    for name in read_only if "luck" in given else ():
        if readers := _reads("luck", called_by(name, functions), functions):
            through = f" in {readers[0]}" if readers[0] != name else ""
            what = f"{name} reads me.luck{through}, which is new only in {', '.join(random[:-1])} and {random[-1]}"
            raise BrokenContract(what, functions[readers[0]].lineno)
    for name in given if sums else ():
        if readers := _reads(name, called_by("receive", functions), functions):
            what = f"receive reads me.{name}: with SUMS, what it adds may depend only on the message"
            raise BrokenContract(what, functions[readers[0]].lineno)


def check_returns(functions: dict[str, ast.FunctionDef], names: Collection[str]) -> None:
    """Raise BrokenContract if one of these functions may return nothing."""
    for name in names:
        if name in functions and _falls_off(functions[name]):
            raise BrokenContract(f"{name} may end without returning anything", functions[name].lineno)


def _returned(name: str, functions: dict[str, ast.FunctionDef]) -> list[ast.expr]:
    """The expressions that a function returns."""
    nodes = ast.walk(functions[name]) if name in functions else ()
    values = [node.value for node in nodes if isinstance(node, ast.Return) and node.value is not None]
    return [outcome for value in values for outcome in _outcomes(value)]


def _outcomes(node: ast.expr) -> list[ast.expr]:
    """The alternatives of a conditional expression."""
    return [*_outcomes(node.body), *_outcomes(node.orelse)] if isinstance(node, ast.IfExp) else [node]


def _check_item(node: ast.Subscript, function: str, vectors: Collection[str], parameters: Collection[str]) -> None:
    if _is_field(node.value, parameters):
        raise BrokenContract(f"{function} sets an item of a parameter: parameters are read-only", node.lineno)
    if not _is_field(node.value, vectors) or isinstance(node.slice, ast.Slice) or isinstance(node.ctx, ast.Del):
        what = f"{function} sets {ast.unparse(node)}: only items of MEMORY's vectors can be set, such as me.belief[0]"
        raise BrokenContract(what, node.lineno)


def _check_set(
    node: ast.Attribute, function: str, vectors: Collection[str], parameters: Collection[str], given: Collection[str]
) -> None:
    if node.attr in given:
        raise BrokenContract(f"{function} sets me.{node.attr}, which is read-only", node.lineno)
    if node.attr in parameters:
        raise BrokenContract(f"{function} sets me.{node.attr}: parameters are read-only", node.lineno)
    if node.attr in vectors:
        raise BrokenContract(f"{function} sets me.{node.attr}, a vector: its items are set one by one", node.lineno)


def _reads(field: str, names: Collection[str], functions: dict[str, ast.FunctionDef]) -> list[str]:
    """The functions of `names` that read a field of the record."""
    return [name for name in names if any(_is_field(node, (field,)) for node in ast.walk(functions[name]))]


def called_by(name: str, functions: dict[str, ast.FunctionDef]) -> list[str]:
    """A function of the file, and those of its functions that it calls, directly or indirectly."""
    reached = [name] if name in functions else []
    for caller in reached:
        called = {node.id for node in ast.walk(functions[caller]) if isinstance(node, ast.Name)}
        reached += [function for function in functions if function in called and function not in reached]
    return reached


def functions_of(tree: ast.Module) -> dict[str, ast.FunctionDef]:
    """The functions of a file by name."""
    return {node.name: node for node in tree.body if isinstance(node, ast.FunctionDef)}


def arguments_of(function: ast.FunctionDef) -> list[str]:
    """The names of a function's arguments."""
    return [argument.arg for argument in (*function.args.posonlyargs, *function.args.args)]


def _is_attribute(node: ast.AST) -> bool:
    """Whether this is an attribute, but not of `math`."""
    return isinstance(node, ast.Attribute) and not is_name(node.value, "math")


def is_name(node: ast.AST, name: str) -> bool:
    """Whether this is a use of a name."""
    return isinstance(node, ast.Name) and node.id == name


def _is_field(node: ast.AST, fields: Collection[str]) -> bool:
    return _is_attribute(node) and node.attr in fields  # type: ignore[attr-defined]


def never_speaks(tree: ast.Module) -> bool:
    """Whether `broadcast` plainly returns None alone."""
    said = _returned("broadcast", functions_of(tree))
    return all(isinstance(value, ast.Constant) and value.value is None for value in said)


def may_be_none(function: ast.FunctionDef) -> bool:
    """Whether a function may return None, as far as its source shows."""
    nodes = [node for statement in function.body for node in ast.walk(statement)]
    nones = [node for node in nodes if isinstance(node, ast.Constant) and node.value is None]
    bare = [node for node in nodes if isinstance(node, ast.Return) and node.value is None]
    return bool(nones or bare) or not _returns(function.body)


def _falls_off(function: ast.FunctionDef) -> bool:
    """Whether a function may return nothing; a loop at its end is assumed to return."""
    bare = [node for node in ast.walk(function) if isinstance(node, ast.Return) and node.value is None]
    return bool(bare) or not _returns(function.body, trusting=True)


def _returns(body: list[ast.stmt], trusting: bool = False) -> bool:
    """Whether these statements always return or raise, `trusting` a block at their end to do so."""
    return any(_leaves(statement, trusting and statement is body[-1]) for statement in body)


def _leaves(statement: ast.stmt, trusting: bool) -> bool:
    if isinstance(statement, ast.If):
        return _returns(statement.body, trusting) and _returns(statement.orelse, trusting)
    if isinstance(statement, ast.While) and not trusting:
        breaks = any(isinstance(node, ast.Break) for node in ast.walk(statement))
        return isinstance(statement.test, ast.Constant) and bool(statement.test.value) and not breaks
    blocks = (ast.For, ast.While, ast.Match, ast.Try, ast.With) if trusting else ()
    return isinstance(statement, (ast.Return, ast.Raise, *blocks))
