"""A brain's source in single precision: every number that it works out is rounded to the nearest float32.

Rounding after each operation in double precision gives the bits of arithmetic in float32, because double has more than
twice the digits (Figueroa, "When is double rounding innocuous?", SIGNUM Newsletter 30, 1995). So the same source runs
in CPython, and in machine code with float32 instructions. Functions of `math` are rounded once, from double.
"""

import ast
import copy
import ctypes
import functools
from pathlib import Path
from typing import Any

from swarmcensus import runtime as robot
from swarmcensus.brains.kinds import REAL, WHOLE, Kind, Kinds
from swarmcensus.brains.syntax import arguments_of, functions_of

CONSTANTS = ("pi", "e", "tau", "inf")  # of math
EXACT = 2**24  # up to here single precision has all whole numbers
MODULE = __name__  # from which a source in single precision imports it
ROUND = "rounded_to_single"  # what the function is called that rounds, in the source that is made here


def rounded_to_single(x: float) -> float:
    """The nearest float32; infinite beyond its largest."""
    return ctypes.c_float(x).value


@functools.cache
def codec_source(precision: str) -> str:
    """The source of `runtime/codec.py` in this precision, "double" or "single"."""
    text = (Path(robot.__file__).parent / "codec.py").read_text(encoding="utf-8")
    tree = ast.parse(text)
    return text if precision == "double" else ast.unparse(in_single(tree, Kinds(tree, {}, {})))


def in_single(tree: ast.Module, kinds: Kinds) -> ast.Module:
    """The source in single precision, with calls of `rounded_to_single`; `kinds` are those of `tree`."""
    made: ast.Module = _Rounding(kinds).visit(copy.deepcopy(tree))  # with the lines of the file
    made.body.insert(0, ast.ImportFrom(MODULE, [ast.alias(ROUND)], 0))
    return ast.fix_missing_locations(made)


class _Rounding(ast.NodeTransformer):
    """Rounds each result, and each constant at once."""

    def __init__(self, kinds: Kinds) -> None:
        self.kinds = kinds
        self.function = ""

    def visit_FunctionDef(self, node: ast.FunctionDef) -> ast.FunctionDef:
        self.function = node.name
        self.generic_visit(node)
        self.function = ""
        return node

    def visit_Constant(self, node: ast.Constant) -> ast.expr:
        return ast.Constant(rounded_to_single(node.value)) if isinstance(node.value, float) else node

    def visit_BinOp(self, node: ast.BinOp) -> ast.expr:
        if self.kinds.of(node, self.function) != REAL:
            return self._parts(node)
        if isinstance(node.op, ast.Pow | ast.FloorDiv):
            node.left, node.right = _in_double(self.visit(node.left)), _in_double(self.visit(node.right))
        else:
            node.left, node.right = self._as_kind(node.left, REAL), self._as_kind(node.right, REAL)
        return _call(node)

    def visit_Assign(self, node: ast.Assign) -> ast.Assign:
        """A number that a name begins with is rounded too: the name is then a float32 in machine code all along."""
        value, target = node.value, node.targets[0]
        kind = self.kinds.of(value, self.function)
        own = self.kinds.names.get(self.function, {})
        wanted = own.get(target.id, REAL) if isinstance(target, ast.Name) else REAL
        begins = isinstance(value, ast.Constant | ast.UnaryOp) and isinstance(target, ast.Name)
        self.generic_visit(node)
        if self.function and kind == REAL and begins:
            node.value = _call(node.value)
        elif self.function:
            node.value = _as_real(value, kind, node.value, wanted)
        return node

    def visit_Return(self, node: ast.Return) -> ast.Return:
        if node.value is not None:
            node.value = self._as_kind(node.value, self.kinds.results.get(self.function, REAL))
        return node

    def visit_Call(self, node: ast.Call) -> ast.expr:
        name = node.func.id if isinstance(node.func, ast.Name) else ""
        if isinstance(node.func, ast.Attribute):  # a call of math.pi would be wrapped, and not math itself
            kind, kinds = self.kinds.of(node, self.function), [self.kinds.of(a, self.function) for a in node.args]
            arguments = [self.visit(argument) for argument in node.args]
            node.args = [_in_double(a) if k == REAL else a for a, k in zip(arguments, kinds, strict=True)]
            return _call(node) if kind == REAL else node
        if name in ("min", "max") and self.kinds.of(node, self.function) == REAL:
            are_literal = [isinstance(argument, ast.Constant) for argument in node.args]
            made = [self._as_kind(argument, REAL) for argument in node.args]
            node.args = [_call(a) if is_literal else a for a, is_literal in zip(made, are_literal, strict=True)]
            return node
        if name in self.kinds.names:
            places = arguments_of(functions_of(self.kinds.tree)[name])
            kinds = [self.kinds.names[name].get(place, REAL) for place in places]
            node.args = [self._as_kind(*each) for each in zip(node.args, kinds, strict=False)]
            node.keywords = [self.visit(keyword) for keyword in node.keywords]
            return node
        if name in ("min", "max", "abs", "range"):
            return self._parts(node)
        return self._rounded(node)

    def visit_Compare(self, node: ast.Compare) -> ast.Compare:
        terms = [node.left, *node.comparators]
        is_real = any(self.kinds.of(term, self.function) == REAL for term in terms)
        node.left, *node.comparators = [self._as_kind(term, REAL if is_real else WHOLE) for term in terms]
        return node

    def visit_AugAssign(self, node: ast.AugAssign) -> ast.Assign:
        read: Any = copy.deepcopy(node.target)
        read.ctx = ast.Load()
        value = self.visit(ast.BinOp(read, node.op, node.value))
        return ast.Assign([self.visit(node.target)], value, lineno=node.lineno)

    def visit_Attribute(self, node: ast.Attribute) -> ast.expr:
        is_constant = isinstance(node.value, ast.Name) and node.value.id == "math" and node.attr in CONSTANTS
        return _call(node) if is_constant else self._parts(node)

    def _parts(self, node: ast.expr) -> ast.expr:
        """The expression with its parts rounded."""
        self.generic_visit(node)
        return node

    def _as_kind(self, node: ast.expr, wanted: Kind) -> ast.expr:
        """The expression with its parts rounded, where a value of this kind is wanted."""
        kind = self.kinds.of(node, self.function)  # of the source as it was written
        return _as_real(node, kind, self.visit(node), wanted)

    def _rounded(self, node: ast.expr) -> ast.expr:
        kind = self.kinds.of(node, self.function)
        made = self._parts(node)
        return _call(made) if kind == REAL else made


def _call(value: ast.expr) -> ast.Call:
    return ast.Call(ast.Name(ROUND, ast.Load()), [value], [])


def _in_double(value: ast.expr) -> ast.Call:
    """The value for a function of `math`, which works in double precision and not in that of its argument."""
    return ast.Call(ast.Name("float", ast.Load()), [value], [])


def _as_real(before: ast.expr, kind: Kind, now: ast.expr, wanted: Kind) -> ast.expr:
    """A whole number where a real one is wanted, rounded as C rounds it; a literal is exact or rounded by itself."""
    is_exact = isinstance(before, ast.Constant) and isinstance(before.value, int) and abs(before.value) <= EXACT
    is_whole = kind == WHOLE and wanted == REAL and not is_exact
    return _call(now) if is_whole else now
