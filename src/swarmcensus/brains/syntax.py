"""What a brain's source says of how it uses its record, found without running it."""

import ast
from collections.abc import Collection, Sequence
from typing import NamedTuple

from swarmcensus.basics.hints import did_you_mean

BELIEFS = ("b", "w")  # the sensor accuracies that a robot assumes, beside its memory
GIVEN_ON_ASKING = ("luck", "name")  # fields of `me` that are there where a brain asks for them
LUCKY = ("observe", "receive", "fuse", "steer")  # luck is fresh at each call of these
TELL = ("broadcast", "estimate", "decide", "done", "interval", "jam")  # these tell, and change nothing
INTERVAL = "two numbers, 0 <= low <= high <= 1, are right, and (0.0, 1.0) where it cannot tell"


class Uses(NamedTuple):
    """Which parts of the contract's second edition a brain asks for."""

    lucky: frozenset[str]  # the functions that read me.luck, themselves or in a helper
    name: bool
    silence: bool  # `broadcast` may return None

    @property
    def luck(self) -> bool:
        """Whether a robot is given luck."""
        return bool(self.lucky)


class Wrong(Exception):
    """What a brain does to its record that it may not, and in which line."""

    def __init__(self, what: str, line: int) -> None:
        """Say what, and where."""
        super().__init__(what)
        self.line = line


def uses(tree: ast.Module, own: Collection[str]) -> Uses:
    """What a brain asks for; `own` are the fields that it names itself."""
    functions = functions_of(tree)
    said = [functions[name] for name in called_by("broadcast", functions)]
    lucky = [name for name in LUCKY if "luck" not in own and _reads("luck", called_by(name, functions), functions)]
    named = "name" not in own and bool(_reads("name", functions, functions))
    return Uses(frozenset(lucky), named, any(map(may_be_none, said)))


def check(
    tree: ast.Module,
    memory: dict[str, int],
    parameters: dict[str, int],
    sums: Collection[str],
    first: str = "observe",
    tells: Collection[str] = TELL,
    lucky: Sequence[str] = LUCKY,
) -> None:
    """Hold a source against what it may do with its record, fields and their lengths. Raises Wrong.

    The record is the first argument of the function `first`; those of `tells` only tell, in those that are `lucky`
    luck is fresh.
    """
    given = {name for name in GIVEN_ON_ASKING if name not in memory and name not in parameters}
    known = [*memory, *parameters, *BELIEFS, *given]
    vectors = {name for name, long in memory.items() if long}
    wholes = vectors | {name for name, long in parameters.items() if long}
    functions = functions_of(tree)
    given_to = functions[first].args
    record = [*given_to.posonlyargs, *given_to.args][0].arg  # what the file calls `me`
    for function in functions.values():
        for node in ast.walk(function):
            if (isinstance(node, ast.arg) and node.arg == "math") or (
                isinstance(node, ast.Name) and node.id == "math" and isinstance(node.ctx, ast.Store)
            ):
                raise Wrong(f"{function.name} calls something of its own math, which is the module", node.lineno)
            if isinstance(node, ast.Attribute) and _is(node.value, record) and node.attr not in known:
                raise Wrong(_unknown(function.name, node.attr, known), node.lineno)
            if isinstance(node, ast.Subscript) and isinstance(node.ctx, ast.Store | ast.Del):
                _check_item(node, function.name, vectors, parameters)
            elif isinstance(node, ast.Subscript) and isinstance(node.slice, ast.Slice) and _names(node.value, wholes):
                raise Wrong(f"{function.name} takes a part of a vector: its items are read one by one", node.lineno)
            elif _of_record(node) and isinstance(node.ctx, ast.Store | ast.Del):  # type: ignore[attr-defined]
                _check_set(node, function.name, vectors, parameters, given)
    if "luck" in given:
        _check_luck(tree, tells, lucky)
    for name in given if sums else ():
        _check_sums(tree, name)


def _unknown(function: str, name: str, known: list[str]) -> str:
    hint = did_you_mean(name, known)
    return f"{function} uses me.{name}: {hint}MEMORY and PARAMETERS name all that a robot has, beside b and w"


def check_decisions(tree: ast.Module, options: int) -> None:
    """Raise Wrong where `decide` returns a number that is no option, or it, `done` or `jam` nothing."""
    functions = functions_of(tree)
    check_returns(functions, ("decide", "done", "jam"))
    for said in _returned("decide", functions):
        number = _literal(said)
        if number and number not in range(-1, options):
            what = f"decide returns {number:g}: -1 (undecided) or an option from 0 to {options - 1} is right"
            raise Wrong(what, said.lineno)


def check_interval(tree: ast.Module) -> None:
    """Raise Wrong where `interval` returns nothing, or what is seen to be no interval without running it."""
    functions = functions_of(tree)
    check_returns(functions, ("interval",))
    for said in _returned("interval", functions):
        if isinstance(said, ast.Constant) or (isinstance(said, ast.Tuple) and not _may_be_interval(said)):
            raise Wrong(f"interval returns {ast.unparse(said)}: {INTERVAL}", said.lineno)


def _may_be_interval(said: ast.Tuple) -> bool:
    if any(isinstance(part, ast.Starred) for part in said.elts):
        return True
    if len(said.elts) != 2:
        return False
    low, high = map(_literal, said.elts)
    return 0.0 <= (0.0 if low is None else low) <= (1.0 if high is None else high) <= 1.0


def check_returns(functions: dict[str, ast.FunctionDef], names: Collection[str]) -> None:
    """Raise Wrong where one of these may return nothing."""
    for name in names:
        if name in functions and _falls_off(functions[name]):
            raise Wrong(f"{name} may end without returning anything", functions[name].lineno)


def _returned(name: str, functions: dict[str, ast.FunctionDef]) -> list[ast.expr]:
    """All that a function may be seen to return."""
    nodes = ast.walk(functions[name]) if name in functions else ()
    values = [node.value for node in nodes if isinstance(node, ast.Return) and node.value is not None]
    return [one for value in values for one in _outcomes(value)]


def _outcomes(node: ast.expr) -> list[ast.expr]:
    """What an expression may come to, as far as it says `if`."""
    return [*_outcomes(node.body), *_outcomes(node.orelse)] if isinstance(node, ast.IfExp) else [node]


def _literal(node: ast.expr) -> float | None:
    """The number that an expression is, if it is nothing but one."""
    try:
        value = ast.literal_eval(node)
    except ValueError:
        return None
    return value if type(value) in (int, float) else None


def never_called(tree: ast.Module) -> list[str]:
    """The functions of a file whose names stand nowhere in it."""
    named = {node.id for node in ast.walk(tree) if isinstance(node, ast.Name)}
    return [name for name in functions_of(tree) if name not in named]


def _check_item(node: ast.Subscript, function: str, vectors: Collection[str], parameters: Collection[str]) -> None:
    if _names(node.value, parameters):
        raise Wrong(f"{function} sets an item of a parameter: parameters are only for reading", node.lineno)
    if not _names(node.value, vectors) or isinstance(node.slice, ast.Slice) or isinstance(node.ctx, ast.Del):
        what = f"{function} sets {ast.unparse(node)}: only single items of MEMORY's vectors are set, as me.belief[0]"
        raise Wrong(what, node.lineno)


def _check_set(
    node: ast.AST, function: str, vectors: Collection[str], parameters: Collection[str], given: Collection[str]
) -> None:
    assert isinstance(node, ast.Attribute)
    if node.attr in given:
        raise Wrong(f"{function} sets me.{node.attr}, which is given: it is only for reading", node.lineno)
    if node.attr in parameters:
        raise Wrong(f"{function} sets me.{node.attr}: parameters are only for reading", node.lineno)
    if node.attr in vectors:
        raise Wrong(f"{function} sets me.{node.attr}, a vector: its items are set one by one", node.lineno)


def _check_luck(tree: ast.Module, tells: Collection[str], lucky: Sequence[str]) -> None:
    functions = functions_of(tree)
    for name in tells:
        found = _reads("luck", called_by(name, functions), functions)
        if found:
            through = f" in {found[0]}" if found[0] != name else ""
            raise Wrong(
                f"{name} reads me.luck{through}, which is fresh in {', '.join(lucky[:-1])} and {lucky[-1]} alone",
                functions[found[0]].lineno,
            )


def _check_sums(tree: ast.Module, name: str) -> None:
    functions = functions_of(tree)
    found = _reads(name, called_by("receive", functions), functions)
    if found:
        what = f"receive reads me.{name}: by SUMS what it adds depends on the message alone"
        raise Wrong(what, functions[found[0]].lineno)


def _reads(field: str, names: Collection[str], functions: dict[str, ast.FunctionDef]) -> list[str]:
    """Which of some functions read a field of the record."""
    return [name for name in names if any(_names(node, (field,)) for node in ast.walk(functions[name]))]


def called_by(name: str, functions: dict[str, ast.FunctionDef]) -> list[str]:
    """A function of the file, and those of its own that it calls, and so on."""
    found = [name] if name in functions else []
    for one in found:
        called = {node.id for node in ast.walk(functions[one]) if isinstance(node, ast.Name)}
        found += [other for other in functions if other in called and other not in found]
    return found


def functions_of(tree: ast.Module) -> dict[str, ast.FunctionDef]:
    """The functions of a file by name."""
    return {node.name: node for node in tree.body if isinstance(node, ast.FunctionDef)}


def _of_record(node: ast.AST) -> bool:
    """Whether this is a field of a record, and nothing of `math`."""
    return isinstance(node, ast.Attribute) and not _is(node.value, "math")


def _is(node: ast.AST, name: str) -> bool:
    return isinstance(node, ast.Name) and node.id == name


def _names(node: ast.AST, fields: Collection[str]) -> bool:
    return _of_record(node) and node.attr in fields  # type: ignore[attr-defined]


def may_be_none(function: ast.FunctionDef) -> bool:
    """Whether a function may return None, as far as one sees without running it."""
    nodes = [node for one in function.body for node in ast.walk(one)]
    said = [node for node in nodes if isinstance(node, ast.Constant) and node.value is None]
    bare = [node for node in nodes if isinstance(node, ast.Return) and node.value is None]
    return bool(said or bare) or not _returns(function.body)


def _falls_off(function: ast.FunctionDef) -> bool:
    """Whether a function may return nothing: a loop at its end is trusted to return before."""
    bare = [node for node in ast.walk(function) if isinstance(node, ast.Return) and node.value is None]
    return bool(bare) or _may_end(function.body)


def _may_end(body: list[ast.stmt]) -> bool:
    last = body[-1]
    if isinstance(last, ast.If):
        return not last.orelse or _may_end(last.body) or _may_end(last.orelse)
    trusted = isinstance(last, ast.Return | ast.Raise | ast.For | ast.While | ast.Match | ast.Try | ast.With)
    return not trusted and not _returns(body)


def _returns(body: list[ast.stmt]) -> bool:
    """Whether these statements never come to their end."""
    return any(_leaves(one) for one in body)


def _leaves(one: ast.stmt) -> bool:
    if isinstance(one, ast.If):
        return _returns(one.body) and _returns(one.orelse)
    if isinstance(one, ast.While):
        return isinstance(one.test, ast.Constant) and bool(one.test.value) and not _breaks(one)
    return isinstance(one, ast.Return | ast.Raise)


def _breaks(loop: ast.While) -> bool:
    return any(isinstance(node, ast.Break) for node in ast.walk(loop))
