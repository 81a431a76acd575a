"""The kind of every expression of a brain's source: a real or whole number, a truth, a vector, the record.

CPython and Numba find out while they run. A translation to another language, and arithmetic in single precision, need
to know it from the source.
"""

import ast
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field

from swarmcensus.brains.syntax import arguments_of, functions_of

REAL, WHOLE, TRUTH, VECTOR, RECORD, NOTHING = "real", "whole", "truth", "vector", "record", "nothing"
TO_WHOLE = ("int", "len", "round", "floor", "ceil", "trunc")
TO_TRUTH = ("bool", "isnan", "isinf", "isfinite")
SAME = ("abs", "min", "max", "pow")  # whole if all arguments are

Kind = str | tuple["Kind", ...]  # a tuple has the kinds of its items


@dataclass
class Kinds:
    """The kinds in a source: of its functions' arguments, local names and results, and of its constants."""

    tree: ast.Module
    record: Mapping[str, int]  # the fields of the record and their lengths, 0 for a number
    first: Mapping[str, tuple[Kind, ...]]  # the kinds of the arguments of functions that others call
    names: dict[str, dict[str, Kind]] = field(default_factory=dict)  # by function, then by name
    results: dict[str, Kind] = field(default_factory=dict)
    constants: dict[str, Kind] = field(default_factory=dict)
    unknown: dict[str, set[str]] = field(default_factory=dict)  # names of unknown kind, while they are found

    def __post_init__(self) -> None:
        """Go through all functions until nothing new is found."""
        functions = functions_of(self.tree)
        for statement in self.tree.body:
            if isinstance(statement, ast.Assign) and isinstance(statement.targets[0], ast.Name):
                self.constants[statement.targets[0].id] = self.of(statement.value, "")
        for name, function in functions.items():
            given = self.first.get(name, ())
            self.names[name] = dict(zip(arguments_of(function), given, strict=False))
        self.unknown = {name: {*arguments_of(function), *_set_in(function)} for name, function in functions.items()}
        self._go_through(functions)
        self.unknown = {}  # what nothing has been found about, since nobody calls the function, is a real number
        self._go_through(functions)

    def _go_through(self, functions: Mapping[str, ast.FunctionDef]) -> None:
        before = None
        while before != (now := repr((self.names, self.results))):
            before = now
            for name, function in functions.items():
                for node in ast.walk(function):
                    self._note(node, name, functions)

    def of(self, node: ast.expr, function: str) -> Kind:
        """The kind of an expression in a function; `function` is empty for a constant."""
        match node:
            case ast.Constant(value=bool()) | ast.Compare() | ast.UnaryOp(op=ast.Not()):
                return TRUTH
            case ast.Constant(value=int()):
                return WHOLE
            case ast.Constant(value=None):
                return NOTHING
            case ast.Tuple(elts=items) | ast.List(elts=items):
                return tuple(self.of(item, function) for item in items)
            case ast.Name(id=name):
                own = self.names.get(function, {}).get(name)
                return own or (NOTHING if name in self.unknown.get(function, ()) else self.constants.get(name) or REAL)
            case ast.Attribute(value=ast.Name() as value, attr=attribute):
                whole = self.of(value, function)
                is_vector = whole == RECORD and self.record.get(attribute)
                return NOTHING if whole == NOTHING else VECTOR if is_vector else REAL
            case ast.Subscript(value=value, slice=index):
                whole = self.of(value, function)
                if isinstance(whole, str):
                    return REAL
                if isinstance(index, ast.Constant) and isinstance(index.value, int) and index.value < len(whole):
                    return whole[index.value]
                return joined(*whole)
            case ast.UnaryOp(operand=operand):
                return _number(self.of(operand, function))
            case ast.IfExp(body=body, orelse=otherwise):
                return joined(self.of(body, function), self.of(otherwise, function))
            case ast.BoolOp(values=values):
                return joined(*(self.of(value, function) for value in values))
            case ast.BinOp(left=left, op=operation, right=right):
                if isinstance(several := self.of(left, function), tuple):  # a constant tuple, repeated
                    return VECTOR if joined(*several) == REAL else several
                sides = _number(several), _number(self.of(right, function))
                is_any_power = isinstance(operation, ast.Pow) and not isinstance(right, ast.Constant)
                exact = not isinstance(operation, ast.Div) and not is_any_power
                if exact and NOTHING in sides:
                    return NOTHING
                return WHOLE if exact and sides == (WHOLE, WHOLE) else REAL
            case ast.Call(func=called, args=arguments):
                return self._of_call(called, arguments, function)
        return REAL

    def _of_call(self, called: ast.expr, arguments: list[ast.expr], function: str) -> Kind:
        name = called.attr if isinstance(called, ast.Attribute) else called.id if isinstance(called, ast.Name) else ""
        if isinstance(called, ast.Name) and name in self.names:
            return self.results.get(name, NOTHING if self.unknown else REAL)
        if name in TO_WHOLE and not (name == "round" and len(arguments) > 1):
            return WHOLE
        if name in TO_TRUTH:
            return TRUTH
        if name in SAME and isinstance(called, ast.Name):
            return joined(*(_number(self.of(argument, function)) for argument in arguments))
        if name == "divmod":
            both = joined(*(_number(self.of(argument, function)) for argument in arguments))
            return (WHOLE, WHOLE) if both == WHOLE else (REAL, REAL)
        return (REAL, WHOLE) if name == "frexp" else REAL

    def _note(self, node: ast.AST, function: str, functions: Mapping[str, ast.FunctionDef]) -> None:
        match node:
            case ast.Assign(targets=targets, value=value):
                for target in targets:
                    self._set(target, self.of(value, function), function)
            case ast.AnnAssign(target=target, value=ast.expr() as value) | ast.NamedExpr(target=target, value=value):
                self._set(target, self.of(value, function), function)
            case ast.AugAssign(target=ast.Name() as target, op=operation, value=value):
                both = ast.BinOp(ast.Name(target.id, ast.Load()), operation, value)
                self._set(target, self.of(both, function), function)
            case ast.For(target=target, iter=over):
                counts = isinstance(over, ast.Call) and isinstance(over.func, ast.Name) and over.func.id == "range"
                items = self.constants.get(over.id) if isinstance(over, ast.Name) else None
                of_wholes = isinstance(items, tuple) and joined(*items) == WHOLE
                self._set(target, WHOLE if counts or of_wholes else REAL, function)
            case ast.Return(value=value):
                kind = NOTHING if value is None else self.of(value, function)
                self.results[function] = joined(*filter(None, (self.results.get(function), kind)))
            case ast.Call(func=ast.Name(id=called), args=arguments) if called in functions:
                own = self.names[called]
                for name, argument in zip(arguments_of(functions[called]), arguments, strict=False):
                    own[name] = joined(*filter(None, (own.get(name), self.of(argument, function))))

    def _set(self, target: ast.expr, kind: Kind, function: str) -> None:
        own = self.names[function]
        if isinstance(target, ast.Name):
            own[target.id] = joined(*filter(None, (own.get(target.id), kind)))
        elif isinstance(target, ast.Tuple | ast.List):
            kinds = kind if isinstance(kind, tuple) else (NOTHING if kind == NOTHING else REAL,) * len(target.elts)
            for item, each in zip(target.elts, kinds, strict=False):
                self._set(item, each, function)


def joined(*kinds: Kind) -> Kind:
    """The kind of a value that has one of these kinds."""
    distinct = list(dict.fromkeys(kind for kind in kinds if kind != NOTHING))
    if len(distinct) < 2:
        return distinct[0] if distinct else NOTHING
    if all(isinstance(kind, tuple) for kind in distinct) and len({len(kind) for kind in distinct}) == 1:
        return tuple(joined(*items) for items in zip(*distinct, strict=True))
    if set(distinct) <= {TRUTH, WHOLE}:
        return WHOLE
    return REAL


def _number(kind: Kind) -> Kind:
    """The kind of a value in arithmetic, where a truth is 0 or 1; nothing as long as nothing is known about it."""
    return NOTHING if kind == NOTHING else WHOLE if kind in (WHOLE, TRUTH) else REAL


def _set_in(function: ast.FunctionDef) -> Iterator[str]:
    return (n.id for n in ast.walk(function) if isinstance(n, ast.Name) and isinstance(n.ctx, ast.Store))
