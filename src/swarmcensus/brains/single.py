"""A brain's source in single precision: every number that it works out is rounded to the nearest float32.

Rounding after each operation in double precision gives the bits of arithmetic in float32, because double has more than
twice the digits (Figueroa, "When is double rounding innocuous?", SIGNUM Newsletter 30, 1995). So the same source runs
in CPython, and Numba's optimiser makes float32 instructions of it. Functions of `math` are rounded once, from double.
"""

import ast
import ctypes

from swarmcensus.brains.kinds import REAL, Kinds

CONSTANTS = ("pi", "e", "tau", "inf")  # of math
ROUND = "rounded_to_single"  # what the function is called that rounds, in the source that is made here


def rounded_to_single(x: float) -> float:
    """The nearest float32; infinite beyond its largest."""
    return ctypes.c_float(x).value


def in_single(tree: ast.Module, kinds: Kinds) -> ast.Module:
    """The source in single precision, with calls of `rounded_to_single`; `kinds` are those of `tree`."""
    made: ast.Module = _Rounding(kinds).visit(ast.parse(ast.unparse(tree)))
    made.body.insert(0, ast.ImportFrom(__name__, [ast.alias(ROUND)], 0))
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
        return self._rounded(node)

    def visit_Call(self, node: ast.Call) -> ast.expr:
        name = node.func.id if isinstance(node.func, ast.Name) else ""
        if isinstance(node.func, ast.Attribute):  # a call of math.pi would be wrapped, and not math itself
            node.args = [self.visit(argument) for argument in node.args]
            return _call(node) if self.kinds.of(node, self.function) == REAL else node
        if name in self.kinds.names or name in ("min", "max", "abs", "range"):
            return self._parts(node)
        return self._rounded(node)

    def visit_AugAssign(self, node: ast.AugAssign) -> ast.Assign:
        read = ast.parse(ast.unparse(node.target), mode="eval").body
        value = self.visit(ast.BinOp(read, node.op, node.value))
        return ast.Assign([self.visit(node.target)], value, lineno=node.lineno)

    def visit_Attribute(self, node: ast.Attribute) -> ast.expr:
        is_constant = isinstance(node.value, ast.Name) and node.value.id == "math" and node.attr in CONSTANTS
        return _call(node) if is_constant else self._parts(node)

    def _parts(self, node: ast.expr) -> ast.expr:
        """The expression with its parts rounded."""
        self.generic_visit(node)
        return node

    def _rounded(self, node: ast.expr) -> ast.expr:
        kind = self.kinds.of(node, self.function)
        made = self._parts(node)
        return _call(made) if kind == REAL else made


def _call(value: ast.expr) -> ast.Call:
    return ast.Call(ast.Name(ROUND, ast.Load()), [value], [])
