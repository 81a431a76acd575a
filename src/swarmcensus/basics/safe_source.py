"""What a plain file may hold: a brain's or a metric's. Constants and small functions, so that a robot can run it."""

import ast
import builtins
import hashlib
import keyword
import math
import operator
import types
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

from swarmcensus.basics.errors import InputError
from swarmcensus.basics.hints import did_you_mean
from swarmcensus.basics.plugins import Plugins

CALLS = ("abs", "min", "max", "int", "float", "bool", "round", "range", "pow", "divmod", "len")
LARGEST = 2.0**1023  # of a constant: what comes out of arithmetic with such numbers is small enough to be looked at
LONGEST = 10_000  # items of a tuple that is repeated
ARITHMETIC: dict[type, Callable[[Any, Any], Any]] = {
    ast.Add: operator.add, ast.Sub: operator.sub, ast.Mult: operator.mul, ast.Div: operator.truediv,
    ast.FloorDiv: operator.floordiv, ast.Mod: operator.mod, ast.Pow: operator.pow,
}  # fmt: skip
SEVERAL = ast.Tuple | ast.List
SIGNS: dict[type, Callable[[Any], Any]] = {ast.UAdd: operator.pos, ast.USub: operator.neg, ast.Not: operator.not_}
TOP_LEVEL = (ast.Import, ast.ImportFrom, ast.FunctionDef, ast.Assign, ast.Expr)
ALLOCATES = (
    ast.List, ast.Dict, ast.Set, ast.ListComp, ast.DictComp, ast.SetComp, ast.GeneratorExp, ast.Lambda,
    ast.ClassDef, ast.FunctionDef, ast.AsyncFunctionDef, ast.Import, ast.ImportFrom, ast.Global, ast.Nonlocal,
    ast.Yield, ast.YieldFrom, ast.Await, ast.Try, ast.With, ast.AsyncWith, ast.AsyncFor, ast.JoinedStr,
)  # fmt: skip


def find(plugins: Plugins, name: str, base: Path | None) -> Path:
    """Where the file of a name lies, or that of a path relative to `base`. Raises InputError where there is none."""
    path = (base or Path()) / name
    if name in plugins.shipped or (not path.is_file() and name in plugins):
        return plugins.path(name)
    if not path.is_file():
        known = ", ".join(plugins.names)
        file = path.with_name(f"{path.name}.py")
        hint = f"did you mean {name + '.py'!r}? " if file.is_file() else did_you_mean(name, plugins.names)
        raise InputError(
            f"{plugins.kind} {name!r}: {hint}neither a shipped {plugins.kind} ({known}) nor a file at {path}"
        )
    return path


def read_source(kind: str, path: Path) -> str:
    """The source of a file of this kind ("brain"), which is not run. Raises InputError."""
    try:
        return path.read_text(encoding="utf-8-sig")
    except (OSError, UnicodeDecodeError) as error:
        raise InputError(f"{kind} file {path}: cannot be read as text: {error}") from error


def digest(source: str) -> str:
    """The hash of a source, as stored with results."""
    return hashlib.sha256(source.encode()).hexdigest()


def checked(source: str, kind: str, path: Path) -> tuple[ast.Module, dict[str, Any]]:
    """A source as a tree that holds what it may, and its constants; nothing of it is run. Raises InputError."""
    try:
        tree = ast.parse(source, filename=str(path))
    except (SyntaxError, ValueError, RecursionError, MemoryError) as error:
        line = getattr(error, "lineno", None)
        what = getattr(error, "msg", error)
        raise InputError(f"{kind} file {path}{f', line {line}' if line else ''}: not Python: {what}") from error
    try:
        return tree, _check_syntax(tree, kind, path)
    except RecursionError:
        raise InputError(f"{kind} file {path}: its brackets or operators are nested too deep") from None


def loaded(tree: ast.Module, kind: str, path: Path) -> types.ModuleType:
    """The file as a module, run by CPython. Raises InputError."""
    module = types.ModuleType(kind)
    module.__file__ = str(path)
    try:
        exec(compile(tree, str(path), "exec"), vars(module))
    except Exception as error:
        raise InputError(f"{kind} file {path}: fails when it is loaded: {error!r}") from error
    return module


def _check_syntax(tree: ast.Module, kind: str, path: Path) -> dict[str, Any]:
    def bad(node: ast.stmt | ast.expr, what: str) -> InputError:
        return InputError(f"{kind} file {path}, line {node.lineno}: {what}")

    one = f"{'an' if kind[0] in 'aeiou' else 'a'} {kind}"
    own = {node.name for node in tree.body if isinstance(node, ast.FunctionDef)}
    known = {*own, *CALLS, *(t.id for n in tree.body if isinstance(n, ast.Assign) for t in n.targets
                             if isinstance(t, ast.Name))}  # fmt: skip
    known |= {a.asname or a.name for n in tree.body if isinstance(n, ast.Import | ast.ImportFrom) for a in n.names}
    known |= set(dir(math)) if "*" in known else set()
    constants: dict[str, Any] = {}
    for node in tree.body:
        if not isinstance(node, TOP_LEVEL) or (isinstance(node, ast.Expr) and not isinstance(node.value, ast.Constant)):
            raise bad(node, f"{one} file holds constants and small functions, nothing else")
        modules = (
            [a.name for a in node.names]
            if isinstance(node, ast.Import)
            else [node.module]
            if isinstance(node, ast.ImportFrom)
            else []
        )
        if any(m != "math" for m in modules):
            raise bad(node, f"imports {', '.join(map(str, modules))}: {one} may import math alone")
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
                raise bad(node, f"{node.name} has a decorator: {one}'s functions are plain")
            given = node.args
            if given.defaults or given.kw_defaults or given.vararg or given.kwarg or getattr(node, "type_params", None):
                raise bad(node, f"{node.name} has arguments that may be left out: {one}'s functions are plain")
            every = [*given.posonlyargs, *given.args]
            if any(not isinstance(a, ast.Name | None) for a in (*(a.annotation for a in every), node.returns)):
                raise bad(node, f"{node.name} has an annotation that is no plain name")
            notes = [n for a in ast.walk(node) if isinstance(a, ast.AnnAssign) for n in ast.walk(a.annotation)]
            here = {a.arg for a in (*every, *given.kwonlyargs)} | {name for n in ast.walk(node) for name in set_by(n)}
            for inner in (n for statement in node.body for n in ast.walk(statement)):
                if isinstance(inner, ast.Name) and isinstance(inner.ctx, ast.Load) and inner.id not in known | here:
                    if hasattr(builtins, inner.id) or inner in notes:
                        continue  # told below, if it is called; annotations are not looked at
                    hint = did_you_mean(inner.id, known | here)
                    raise bad(inner, f"{node.name} uses {inner.id}, which is nowhere set: {hint}".rstrip(": "))
                if isinstance(inner, ALLOCATES):
                    name = type(inner).__name__
                    raise bad(inner, f"{name} in {node.name}: {one} allocates and defines nothing")  # type: ignore[arg-type]
                if isinstance(inner, ast.Call) and not _may_call(inner.func, own):
                    raise bad(
                        inner,
                        f"{node.name} calls {ast.unparse(inner.func)}: {one} may call its own functions, math's, "
                        f"and {', '.join(CALLS)}",
                    )
    return constants


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
    elif isinstance(node, SEVERAL):
        return tuple(_constant(item, known) for item in node.elts)
    elif isinstance(node, ast.Dict) and None not in node.keys:
        keys = [_constant(key, known) for key in node.keys]
        if not all(isinstance(key, int | float | str) for key in keys):
            raise ValueError("a key of a dict is a number or a text")
        return dict(zip(keys, (_constant(one, known) for one in node.values), strict=True))
    elif isinstance(node, ast.UnaryOp) and type(node.op) in SIGNS:
        value = SIGNS[type(node.op)](_number(node.operand, known))
    elif isinstance(node, ast.BinOp) and isinstance(node.op, ast.Mult) and isinstance(node.left, SEVERAL):
        times = _number(node.right, known)
        if not isinstance(times, int) or not 0 <= times * len(node.left.elts) <= LONGEST:
            raise ValueError(f"a tuple is repeated a whole number of times, to {LONGEST} items at the most")
        return tuple(_constant(item, known) for item in node.left.elts) * times
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


def set_by(node: ast.AST) -> Iterator[str]:
    """The names that a piece of a function gives values to."""
    if isinstance(node, ast.Name) and isinstance(node.ctx, ast.Store):
        yield node.id
    elif isinstance(node, ast.MatchAs | ast.MatchStar) and node.name:
        yield node.name
    elif isinstance(node, ast.MatchMapping) and node.rest:
        yield node.rest


def is_name(value: object) -> bool:
    """Whether a value can name a field."""
    return isinstance(value, str) and value.isidentifier() and not keyword.iskeyword(value)
