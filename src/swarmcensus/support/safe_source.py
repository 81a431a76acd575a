"""The Python that brain, adversary and metric files may use: constants and small functions that a robot can run."""

import ast
import builtins
import codecs
import graphlib
import io
import keyword
import math
import operator
import tokenize
import types
from collections.abc import Callable, Collection, Iterator, Mapping
from pathlib import Path
from typing import Any

from swarmcensus.support.errors import BrainError, InputError
from swarmcensus.support.hints import did_you_mean
from swarmcensus.support.plugins import MOST_SOURCE, Plugins

CALLS = ("abs", "min", "max", "int", "float", "bool", "round", "range", "pow", "divmod", "len")
DEEP = "its brackets or operators are nested too deep"
LARGEST = 2.0**1023  # the largest constant, so that arithmetic with constants stays quick
LONGEST = 10_000  # items of a repeated tuple
MOST = 1_000_000  # numbers and texts in a constant
ARITHMETIC: dict[type, Callable[[Any, Any], Any]] = {
    ast.Add: operator.add, ast.Sub: operator.sub, ast.Mult: operator.mul, ast.Div: operator.truediv,
    ast.FloorDiv: operator.floordiv, ast.Mod: operator.mod, ast.Pow: operator.pow,
}  # fmt: skip
Error = Callable[[Any, str], InputError]  # makes the error of a syntax node, which names its line
SEVERAL = ast.Tuple | ast.List
SIGNS: dict[type, Callable[[Any], Any]] = {ast.UAdd: operator.pos, ast.USub: operator.neg, ast.Not: operator.not_}
IMPORTS = ast.Import | ast.ImportFrom
TOP_LEVEL = (ast.Import, ast.ImportFrom, ast.FunctionDef, ast.Assign, ast.Expr)
OF_MATH = {**vars(math), "": math}
MATH = frozenset(name for name in dir(math) if name[0] != "_")
IN_FUNCTIONS = (  # all else allocates, defines something, or is not on every robot
    ast.Assign, ast.AugAssign, ast.AnnAssign, ast.Delete, ast.Expr, ast.Return, ast.Raise, ast.Assert, ast.Pass,
    ast.If, ast.For, ast.While, ast.Break, ast.Continue, ast.Match, ast.match_case, ast.pattern,
    ast.BinOp, ast.BoolOp, ast.UnaryOp, ast.Compare, ast.IfExp, ast.NamedExpr, ast.Call, ast.keyword,
    ast.Name, ast.Constant, ast.Attribute, ast.Subscript, ast.Slice, ast.Tuple, ast.Starred,
    ast.operator, ast.boolop, ast.unaryop, ast.cmpop, ast.expr_context,
)  # fmt: skip


def find(plugins: Plugins, name: str, base: Path | None) -> Path:
    """The file of a plugin's name, or of a path relative to `base`. Raises InputError if there is none."""
    path = (base or Path()) / name
    if name in plugins.shipped or (not path.is_file() and name in plugins):
        return plugins.path(name)
    if not path.is_file():
        known = ", ".join(plugins.names)
        file = Path(f"{path}.py")
        hint = f"did you mean {name + '.py'!r}? " if file.is_file() else did_you_mean(name, plugins.names)
        neither = f"neither a shipped {plugins.kind} ({known}) nor a file at {path}"
        neither = "there is no such file" if name.lower().endswith(".py") else neither
        raise BrainError.named(plugins.kind, name, f"{hint}{neither}")
    return path


def parse_checked(source: str, kind: str, path: Path) -> tuple[ast.Module, dict[str, Any]]:
    """Parse and check a source without running it; returns its syntax tree and its constants. Raises InputError."""
    if len(source) > MOST_SOURCE:
        raise BrainError.within(f"{kind} file {path}", f"has over {MOST_SOURCE:,} characters")
    try:
        # Python decodes a file by its first lines: a comment here could be code there
        lines = io.BytesIO(source.replace("\r", "\n").encode())
        encoding, _ = tokenize.detect_encoding(lines.readline)
        if codecs.lookup(encoding).name != "utf-8":
            raise SyntaxError(f"its first lines name the encoding {encoding}: utf-8 is right")
        tree = ast.parse(source, filename=str(path))
    except (RecursionError, MemoryError):
        raise BrainError.within(f"{kind} file {path}", DEEP) from None
    except (SyntaxError, ValueError) as error:
        line = getattr(error, "lineno", None)
        what = getattr(error, "msg", error)
        where = f", line {line}" if line else ""
        raise BrainError.of(path, f"not Python: {what}", where=f"{kind} file {path}{where}") from error
    try:
        return tree, _check_syntax(tree, kind, path)
    except RecursionError:
        raise BrainError.within(f"{kind} file {path}", DEEP) from None


def run(tree: ast.Module, kind: str, path: Path) -> types.ModuleType:
    """Run a file in CPython; returns its module. Raises InputError."""
    module = types.ModuleType(kind)
    module.__file__ = str(path)
    try:
        exec(compile(tree, str(path), "exec"), vars(module))
    except Exception as error:
        raise BrainError.within(f"{kind} file {path}", f"fails when it is loaded: {error!r}") from error
    return module


def _check_syntax(tree: ast.Module, kind: str, path: Path) -> dict[str, Any]:
    """Check what a file holds; returns its constants. Raises InputError."""

    def error(node: ast.stmt | ast.expr, what: str) -> InputError:
        return BrainError.of(path, what, where=f"{kind} file {path}, line {node.lineno}")

    a_kind = f"{'an' if kind[0] in 'aeiou' else 'a'} {kind}"
    functions = {node.name: node for node in tree.body if isinstance(node, ast.FunctionDef)}
    assigned = [target for node in tree.body if isinstance(node, ast.Assign) for target in node.targets]
    imported = [alias for node in tree.body if isinstance(node, IMPORTS) for alias in node.names]
    known = {*functions, *CALLS, *(target.id for target in assigned if isinstance(target, ast.Name))}
    known |= {alias.asname or alias.name for alias in imported}
    constants: dict[str, Any] = {}
    defined: set[str] = set()
    for node in tree.body:
        if not isinstance(node, TOP_LEVEL) or (isinstance(node, ast.Expr) and not isinstance(node.value, ast.Constant)):
            raise error(node, f"{a_kind} file holds only constants and small functions")
        if isinstance(node, IMPORTS):
            modules = [node.module] if isinstance(node, ast.ImportFrom) else [alias.name for alias in node.names]
            if any(module != "math" for module in modules) or (isinstance(node, ast.ImportFrom) and node.level):
                raise error(node, f"imports {', '.join(map(str, modules))}: {a_kind} may import only math")
            if private := [alias.name for alias in node.names if alias.name[0] == "_"]:
                raise error(node, f"imports {private[0]}, which belongs to Python: {a_kind} may import only math")
            if any(alias.name == "*" for alias in node.names):
                raise error(node, "imports all of math: name what is used, as in from math import sqrt")
            constants |= {name: OF_MATH[origin] for name, origin in of_math(node).items() if origin in OF_MATH}
        for name in _defined_by(node):
            if name in defined:
                raise error(node, f"{name} is defined twice, and only the last would count: it needs another name")
            if name.startswith("__"):
                raise error(node, f"defines {name}: names that begin with __ belong to Python")
            defined.add(name)
        if isinstance(node, ast.Assign):
            if not all(isinstance(target, ast.Name) for target in node.targets):
                raise error(node, "a constant needs one plain name")
            try:
                value = constant(node.value, constants)
            except ArithmeticError as fault:
                raise error(node, f"a constant has no value: {fault}") from None
            except ValueError as fault:
                raise error(node, str(fault)) from None
            constants |= {target.id: value for target in node.targets if isinstance(target, ast.Name)}
        if isinstance(node, ast.FunctionDef):
            _check_function(node, functions, known, a_kind, error)
    _check_cycles(functions, a_kind, error)
    return constants


def _defined_by(node: ast.stmt) -> list[str]:
    """The names that a statement of a file defines; one that it defines twice is there twice."""
    if isinstance(node, ast.FunctionDef):
        return [node.name]
    if isinstance(node, IMPORTS):
        return [alias.asname or alias.name for alias in node.names]
    return [target.id for target in getattr(node, "targets", ()) if isinstance(target, ast.Name)]


def _check_function(
    function: ast.FunctionDef, functions: Collection[str], known: set[str], a_kind: str, error: Error
) -> None:
    """Check one function; `functions` are those of its file, and `known` are the names that the file defines."""
    name, arguments = function.name, function.args
    if function.decorator_list:
        raise error(function, f"{name} has a decorator: functions of {a_kind} are plain")
    optional = arguments.defaults or arguments.kw_defaults or arguments.vararg or arguments.kwarg
    if optional or getattr(function, "type_params", None):
        raise error(function, f"{name} has optional arguments: functions of {a_kind} are plain")
    positional = [*arguments.posonlyargs, *arguments.args]
    if any(not isinstance(a, ast.Name | None) for a in (*(a.annotation for a in positional), function.returns)):
        raise error(function, f"{name} has an annotation that is not a plain name")
    nodes = [node for statement in function.body for node in ast.walk(statement)]
    annotations = [node.annotation for node in nodes if isinstance(node, ast.AnnAssign)]
    unread: list[ast.AST | None] = [part for annotation in annotations for part in ast.walk(annotation)]
    unread += [node.exc for node in nodes if isinstance(node, ast.Raise) and _is_error(node.exc)]
    local = _local_names(function)
    may = f"{a_kind} may call its own functions, math's, and {', '.join(CALLS)}"
    for node in nodes:
        if not isinstance(node, IN_FUNCTIONS):
            where = node if isinstance(node, ast.stmt | ast.expr) else function
            raise error(where, f"{type(node).__name__} in {name}: {a_kind} may not allocate or define anything")
    for node in nodes:
        if isinstance(node, ast.Call) and not _may_call(node.func, functions, local):
            called = ast.unparse(node.func)
            raise error(node, f"{name} calls {called}{', a local name' if called in local else ''}: {may}")
        if isinstance(node, ast.Call) and node.keywords and ast.unparse(node.func) in {"min", "max"} - {*functions}:
            raise error(node, f"{name} gives {ast.unparse(node.func)} a keyword: only values are right")
        if isinstance(node, ast.Attribute) and (wrong := _wrong_attribute(node, local, known - {*functions, *CALLS})):
            raise error(node, f"{name} uses {ast.unparse(node)}: {wrong}")
        if isinstance(node, ast.Name) and node.id not in known | local and node not in unread:
            why = f", which is not defined: {did_you_mean(node.id, known | local)}".rstrip(": ")
            raise error(node, f"{name} uses {node.id}{f': {may}' if hasattr(builtins, node.id) else why}")


def _local_names(function: ast.FunctionDef) -> set[str]:
    """The arguments of a function, and the names that it sets."""
    arguments = {part.arg for part in ast.walk(function.args) if isinstance(part, ast.arg)}
    return arguments.union(*(names_set_by(node) for node in ast.walk(function)))


def _wrong_attribute(node: ast.Attribute, local: set[str], others: set[str]) -> str:
    """What is wrong with an attribute; empty if it is of a local name, or of `others` such as `math` and only read."""
    of = node.value.id if isinstance(node.value, ast.Name) else ""
    if node.attr.startswith("__"):
        return "names that begin with __ belong to Python"
    if of in local or (of in others and isinstance(node.ctx, ast.Load)):
        return ""
    if of == "math" and isinstance(node.ctx, ast.Load):
        return "write import math at the top of the file"
    return "only the record's fields may be set, and only these and what math has may be read"


def _is_error(raised: ast.expr | None) -> bool:
    """Whether this names one of Python's errors, but none that would end the program."""
    error = getattr(builtins, raised.id, None) if isinstance(raised, ast.Name) else None
    return isinstance(error, type) and issubclass(error, Exception)


def _check_cycles(functions: Mapping[str, ast.FunctionDef], a_kind: str, error: Error) -> None:
    """Refuse functions that call themselves, directly or through others: Python and robots have room for few calls."""
    names: dict[str, dict[str, ast.Name]] = {}
    for caller, function in functions.items():
        others = functions.keys() - _local_names(function)
        used = (node for node in ast.walk(function) if isinstance(node, ast.Name) and node.id in others)
        names[caller] = {node.id: node for node in used}
    try:
        graphlib.TopologicalSorter(names).prepare()
    except graphlib.CycleError as found:
        first, *others = found.args[1][::-1]
        which = "itself" if len(others) == 1 else ", which calls ".join(others)
        what = f"{first} calls {which}: functions of {a_kind} may not call themselves, directly or through others"
        raise error(names[first][others[0]], what) from None


def of_math(node: ast.Import | ast.ImportFrom) -> dict[str, str]:
    """The names that an import of math defines, each with its name there; empty for `math` itself."""
    if isinstance(node, ast.Import):
        return {alias.asname or alias.name: "" for alias in node.names}
    return {alias.asname or alias.name: alias.name for alias in node.names}


def constant(node: ast.expr | None, known: Mapping[str, Any]) -> Any:
    """The value of a constant, evaluated here so that no file takes long to load. Raises ValueError."""
    value: Any = None
    if isinstance(node, ast.Constant):
        value = node.value
    elif isinstance(node, ast.Name) and isinstance(known.get(node.id), int | float | str | tuple):
        value = known[node.id]
    elif isinstance(node, ast.Attribute) and isinstance(node.value, ast.Name) and known.get(node.value.id) is math:
        value = getattr(math, node.attr, None)
    elif isinstance(node, SEVERAL):
        return _sized_tuple([constant(item, known) for item in node.elts])
    elif isinstance(node, ast.Dict) and None not in node.keys:
        keys = [constant(key, known) for key in node.keys]
        if not all(isinstance(key, int | float | str) for key in keys):
            raise ValueError("keys of a dict should be numbers or texts")
        if twice := [key for k, key in enumerate(keys) if key in keys[:k]]:
            raise ValueError(f"the key {twice[0]!r} is there twice, and only the last would count")
        return dict(zip(keys, _sized_tuple([constant(item, known) for item in node.values]), strict=True))
    elif isinstance(node, ast.UnaryOp) and type(node.op) in SIGNS:
        value = SIGNS[type(node.op)](_number(node.operand, known))
    elif isinstance(node, ast.BinOp) and isinstance(node.op, ast.Mult) and isinstance(node.left, SEVERAL):
        times = _number(node.right, known)
        if not isinstance(times, int) or not 0 <= times * len(node.left.elts) <= LONGEST:
            raise ValueError(f"a tuple may be repeated a whole number of times, to {LONGEST:,} items at most")
        return _sized_tuple([constant(item, known) for item in node.left.elts], times) * times
    elif isinstance(node, ast.BinOp) and type(node.op) in ARITHMETIC:
        left, right = _number(node.left, known), _number(node.right, known)
        if isinstance(node.op, ast.Pow) and float(abs(left)) > 1.0 and right * math.log2(abs(left)) > 1023.0:
            raise ValueError("a constant is too large")
        value = ARITHMETIC[type(node.op)](left, right)
    if not isinstance(value, int | float | str):
        right = "a number, a text, a tuple or dict of them, or plain arithmetic with numbers"
        raise ValueError(f"a constant should be {right}")
    if isinstance(value, int) and abs(value) > LARGEST:
        raise ValueError("a constant is too large")
    return value


def _sized_tuple(items: list[Any], times: int = 1) -> tuple[Any, ...]:
    """The items as a tuple, to be repeated. Raises ValueError if they hold too much: printing it would not end."""
    size = 0
    for item in items:
        size += _size(item)
        if size * times > MOST:
            raise ValueError(f"a constant holds more than {MOST:,} numbers and texts")
    return tuple(items)


def _size(value: Any) -> int:
    """How many numbers and texts a constant holds; one that is repeated counts each time."""
    parts = value.values() if isinstance(value, dict) else value if isinstance(value, tuple) else ()
    return max(sum(map(_size, parts)), 1)


def _number(node: ast.expr, known: Mapping[str, Any]) -> Any:
    value = constant(node, known)
    if not isinstance(value, int | float):
        raise ValueError("arithmetic of constants needs numbers")
    return value


def _may_call(function: ast.expr, functions: Collection[str], local: set[str]) -> bool:
    if isinstance(function, ast.Attribute):
        return isinstance(function.value, ast.Name) and function.value.id == "math" and "math" not in local
    return isinstance(function, ast.Name) and function.id in {*functions, *CALLS, *MATH} - local


def names_set_by(node: ast.AST) -> Iterator[str]:
    """The names that a syntax node assigns to."""
    if isinstance(node, ast.Name) and not isinstance(node.ctx, ast.Load):
        yield node.id
    elif isinstance(node, ast.MatchAs | ast.MatchStar) and node.name:
        yield node.name
    elif isinstance(node, ast.MatchMapping) and node.rest:
        yield node.rest


def is_name(value: object) -> bool:
    """Whether a value can be the name of a field."""
    return isinstance(value, str) and value.isidentifier() and not keyword.iskeyword(value)
