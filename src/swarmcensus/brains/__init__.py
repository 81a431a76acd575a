"""The brains that are shipped, a file each, and the contract that any brain file keeps: loaded, checked, hashed.

In: a brain file, or a shipped brain's name.
Out: a Brain: its functions, memory, message and source.
Must not know: how brains are compiled, worlds, studies.
"""

import ast
import functools
import hashlib
import keyword
import math
import operator
import types
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from swarmcensus.basics.errors import InputError
from swarmcensus.basics.hints import did_you_mean

HERE = Path(__file__).parent
FUNCTIONS = {"observe": 3, "broadcast": 1, "receive": 2, "fuse": 1, "estimate": 1}
MAY_HAVE = {"steer": 1}
TRACED = ("estimate", "round", "robot", "blacks", "position", "heading", "looked", "tile", "reading", "neighbours",
          "link", "axis")  # fmt: skip
CALLS = ("abs", "min", "max", "int", "float", "bool", "round", "range", "pow", "divmod")
BELIEFS = ("b", "w")  # the sensor accuracies that a robot assumes, beside its memory
BYTES_A_NUMBER = 4  # on the robot
LARGEST = 2.0**1023  # of a constant: what comes out of arithmetic with such numbers is small enough to be looked at
ARITHMETIC: dict[type, Callable[[Any, Any], Any]] = {
    ast.Add: operator.add, ast.Sub: operator.sub, ast.Mult: operator.mul, ast.Div: operator.truediv,
    ast.FloorDiv: operator.floordiv, ast.Mod: operator.mod, ast.Pow: operator.pow,
}  # fmt: skip
SIGNS: dict[type, Callable[[Any], Any]] = {ast.UAdd: operator.pos, ast.USub: operator.neg, ast.Not: operator.not_}
TOP_LEVEL = (ast.Import, ast.ImportFrom, ast.FunctionDef, ast.Assign, ast.Expr)
ALLOCATES = (
    ast.List, ast.Dict, ast.Set, ast.ListComp, ast.DictComp, ast.SetComp, ast.GeneratorExp, ast.Lambda,
    ast.ClassDef, ast.FunctionDef, ast.AsyncFunctionDef, ast.Import, ast.ImportFrom, ast.Global, ast.Nonlocal,
    ast.Yield, ast.YieldFrom, ast.Await, ast.Try, ast.With, ast.AsyncWith, ast.AsyncFor, ast.JoinedStr,
)  # fmt: skip


@dataclass(frozen=True)
class Brain:
    """One brain file, read and found to keep the contract."""

    name: str  # a shipped brain's name, or the file's path as the user gave it
    path: Path
    source: str
    memory: dict[str, float] = field(compare=False)  # every field, its value before the first observation
    message: tuple[str, ...] = field(compare=False)
    sums: tuple[str, ...] = field(
        compare=False
    )  # the fields to which `receive` only adds what depends on the message alone
    functions: types.ModuleType = field(compare=False)  # the file itself, run by CPython

    @functools.cached_property
    def sha256(self) -> str:
        """The hash of the source, as stored with results."""
        return digest(self.source)

    @property
    def steers(self) -> bool:
        """Whether it says where its robot goes: such a walk depends on the brain."""
        return hasattr(self.functions, "steer")

    @property
    def memory_bytes(self) -> int:
        """What a robot remembers, beliefs about its sensor included."""
        return BYTES_A_NUMBER * (len(self.memory) + len(BELIEFS))

    @property
    def message_bytes(self) -> int:
        """What a robot broadcasts in one message."""
        return BYTES_A_NUMBER * len(self.message)

    @functools.cached_property
    def _robot(self) -> type:
        return type("Robot", (), {"__slots__": (*self.memory, *BELIEFS)})

    def robot(self, b: float, w: float) -> Any:
        """A blank mind for CPython: it can hold the fields of MEMORY and nothing else."""
        mind = self._robot()
        for name, value in self.memory.items():
            setattr(mind, name, value)
        mind.b, mind.w = b, w
        return mind


def shipped() -> list[str]:
    """The names of the brains that come with swarmcensus."""
    return sorted(p.stem for p in HERE.glob("*.py") if not p.stem.startswith("_"))


def load(name: str | Path, base: Path | None = None) -> Brain:
    """Read a shipped brain by its name or a brain file by its path, relative to `base`.

    Raises InputError where the file is not there or breaks the contract.
    """
    path = find(name, base)
    return parse(read(path), str(name), path)


def find(name: str | Path, base: Path | None = None) -> Path:
    """Where a brain's file is. Raises InputError where there is none."""
    path = HERE / f"{name}.py" if str(name) in shipped() else (base or Path()) / name
    if not path.is_file():
        raise InputError(
            f"brain {str(name)!r}: {did_you_mean(str(name), shipped())}neither a shipped brain "
            f"({', '.join(shipped())}) nor a file at {path}"
        )
    return path


def read(path: Path) -> str:
    """A brain file's source, which is not run. Raises InputError."""
    try:
        return path.read_text(encoding="utf-8-sig")
    except (OSError, UnicodeDecodeError) as error:
        raise InputError(f"brain file {path}: cannot be read as text: {error}") from error


def digest(source: str) -> str:
    """The hash of a source, as stored with results."""
    return hashlib.sha256(source.encode()).hexdigest()


def parse(source: str, name: str, path: Path) -> Brain:
    """Check a brain's source against the contract and run it once. Raises InputError."""
    try:
        tree = ast.parse(source, filename=str(path))
    except (SyntaxError, ValueError, RecursionError, MemoryError) as error:
        line = getattr(error, "lineno", None)
        what = getattr(error, "msg", error)
        raise InputError(f"brain file {path}{f', line {line}' if line else ''}: not Python: {what}") from error
    try:
        _check_syntax(tree, path)
    except RecursionError:
        raise InputError(f"brain file {path}: its brackets or operators are nested too deep") from None
    module = types.ModuleType("brain")
    module.__file__ = str(path)
    try:
        exec(compile(tree, str(path), "exec"), vars(module))
    except Exception as error:
        raise InputError(f"brain file {path}: fails when it is loaded: {error!r}") from error
    return Brain(name, path, source, *_check_contents(module, path), functions=module)


def _check_syntax(tree: ast.Module, path: Path) -> None:
    def bad(node: ast.stmt | ast.expr, what: str) -> InputError:
        return InputError(f"brain file {path}, line {node.lineno}: {what}")

    own = {node.name for node in tree.body if isinstance(node, ast.FunctionDef)}
    constants: dict[str, Any] = {}
    for node in tree.body:
        if not isinstance(node, TOP_LEVEL) or (isinstance(node, ast.Expr) and not isinstance(node.value, ast.Constant)):
            raise bad(node, "a brain file holds constants and small functions, nothing else")
        modules = (
            [a.name for a in node.names]
            if isinstance(node, ast.Import)
            else [node.module]
            if isinstance(node, ast.ImportFrom)
            else []
        )
        if any(m != "math" for m in modules):
            raise bad(node, f"imports {', '.join(map(str, modules))}: a brain may import math alone")
        if isinstance(node, ast.Import | ast.ImportFrom):
            constants |= _imported(node)
        if isinstance(node, ast.Assign):
            if not all(isinstance(target, ast.Name) for target in node.targets):
                raise bad(node, "a constant has one plain name")
            try:
                value = _constant(node.value, constants)
            except ArithmeticError as error:
                raise bad(node, f"a constant has no value: {error}") from None
            except ValueError as error:
                raise bad(node, str(error)) from None
            constants |= {target.id: value for target in node.targets if isinstance(target, ast.Name)}
        if isinstance(node, ast.FunctionDef):
            if node.decorator_list:
                raise bad(node, f"{node.name} has a decorator: a brain's functions are plain")
            given = node.args
            if given.defaults or given.kw_defaults or given.vararg or given.kwarg or getattr(node, "type_params", None):
                raise bad(node, f"{node.name} has arguments that may be left out: a brain's functions are plain")
            every = [*given.posonlyargs, *given.args]
            if any(not isinstance(a, ast.Name | None) for a in (*(a.annotation for a in every), node.returns)):
                raise bad(node, f"{node.name} has an annotation that is no plain name")
            for inner in (n for statement in node.body for n in ast.walk(statement)):
                if isinstance(inner, ALLOCATES):
                    kind = type(inner).__name__
                    raise bad(inner, f"{kind} in {node.name}: a brain allocates and defines nothing")  # type: ignore[arg-type]
                if isinstance(inner, ast.Call) and not _may_call(inner.func, own):
                    raise bad(
                        inner,
                        f"{node.name} calls {ast.unparse(inner.func)}: a brain may call its own functions, math's, "
                        f"and {', '.join(CALLS)}",
                    )


def _imported(node: ast.Import | ast.ImportFrom) -> dict[str, Any]:
    """The names that an import of math gives."""
    if isinstance(node, ast.Import):
        return {alias.asname or alias.name: math for alias in node.names}
    names = {alias.asname or alias.name: alias.name for alias in node.names}
    if "*" in names:
        names = {name: name for name in dir(math) if not name.startswith("_")}
    return {name: getattr(math, origin) for name, origin in names.items() if hasattr(math, origin)}


def _constant(node: ast.expr | None, known: dict[str, Any]) -> Any:
    """The value of a constant, found without running it, so that no file takes long to load. Raises ValueError."""
    value: Any = None
    if isinstance(node, ast.Constant):
        value = node.value
    elif isinstance(node, ast.Name) and isinstance(known.get(node.id), int | float | str | tuple):
        value = known[node.id]
    elif isinstance(node, ast.Attribute) and isinstance(node.value, ast.Name) and known.get(node.value.id) is math:
        value = getattr(math, node.attr, None)
    elif isinstance(node, ast.Tuple | ast.List):
        return tuple(_constant(item, known) for item in node.elts)
    elif isinstance(node, ast.Dict) and None not in node.keys:
        return {_constant(k, known): _constant(v, known) for k, v in zip(node.keys, node.values, strict=True)}
    elif isinstance(node, ast.UnaryOp) and type(node.op) in SIGNS:
        value = SIGNS[type(node.op)](_number(node.operand, known))
    elif isinstance(node, ast.BinOp) and type(node.op) in ARITHMETIC:
        left, right = _number(node.left, known), _number(node.right, known)
        if isinstance(node.op, ast.Pow) and float(abs(left)) > 1.0 and right * math.log2(abs(left)) > 1023.0:
            raise ValueError("a constant is too large")
        value = ARITHMETIC[type(node.op)](left, right)
    if not isinstance(value, int | float | str):
        raise ValueError("a constant is a number, a text, a tuple or dict of such, or plain arithmetic with numbers")
    if isinstance(value, int) and abs(value) > LARGEST:
        raise ValueError("a constant is too large")
    return value


def _number(node: ast.expr, known: dict[str, Any]) -> Any:
    value = _constant(node, known)
    if not isinstance(value, int | float):
        raise ValueError("plain arithmetic is with numbers")
    return value


def _may_call(function: ast.expr, own: set[str]) -> bool:
    if isinstance(function, ast.Attribute):
        return isinstance(function.value, ast.Name) and function.value.id == "math"
    if isinstance(function, ast.Lambda):
        return True  # refused as such
    return isinstance(function, ast.Name) and (function.id in own or function.id in CALLS or hasattr(math, function.id))


def _is_name(value: object) -> bool:
    return isinstance(value, str) and value.isidentifier() and not keyword.iskeyword(value)


def _check_contents(module: types.ModuleType, path: Path) -> tuple[dict[str, float], tuple[str, ...], tuple[str, ...]]:
    def need(holds: bool, what: str) -> None:
        if not holds:
            raise InputError(f"brain file {path}: {what}")

    def names(value: object) -> bool:
        return isinstance(value, tuple) and all(_is_name(v) for v in value)

    memory = getattr(module, "MEMORY", None)
    need(isinstance(memory, dict) and bool(memory), 'MEMORY is missing: a dict such as {"t": 0.0, "x": 0.5}')
    assert isinstance(memory, dict)
    for key, value in memory.items():
        need(_is_name(key), f"MEMORY key {key!r} is not a name")
        need(key not in (*BELIEFS, *TRACED), f"MEMORY key {key!r} is taken by the engine")
        need(
            isinstance(value, int | float) and not isinstance(value, bool) and abs(value) < 1e300,
            f"MEMORY[{key!r}] = {value!r}: not a number",
        )
    message = getattr(module, "MESSAGE", None)
    need(names(message) and bool(message), 'MESSAGE is missing: a tuple of names such as ("x_hat", "alpha")')
    sums = getattr(module, "SUMS", ())
    need(names(sums), "SUMS is a tuple of MEMORY names")
    need(len(set(sums)) == len(sums), "SUMS names a field twice")
    for key in sums:
        need(key in memory, f"SUMS names {key!r}, which is not in MEMORY")
    for name, arity in (FUNCTIONS | MAY_HAVE).items():
        if name in MAY_HAVE and not hasattr(module, name):
            continue
        need(hasattr(module, name), f"the function {name} is missing")
        function = getattr(module, name)
        need(isinstance(function, types.FunctionType), f"{name} is {function!r}, not a function")
        found = function.__code__.co_argcount
        need(found == arity, f"{name} takes {found} arguments: {arity} are right")
    assert isinstance(message, tuple)
    return {k: float(v) for k, v in memory.items()}, message, tuple(sums)
