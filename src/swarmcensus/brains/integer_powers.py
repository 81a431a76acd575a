"""Powers of whole numbers: where an exponent may be below 0, machine code has 0 and CPython a fraction."""

import ast
from collections.abc import Callable

from swarmcensus.brains.kinds import TRUTH, WHOLE, Kinds
from swarmcensus.brains.syntax import BrokenContract, functions_of


def check(tree: ast.Module, kinds: Callable[[], Kinds]) -> None:
    """Raise BrokenContract if a source raises a whole number to another that may be below 0."""
    for name, function in functions_of(tree).items():
        for node in ast.walk(function):
            match node:
                case (
                    ast.BinOp(left=base, op=ast.Pow(), right=exponent)
                    | ast.AugAssign(target=base, op=ast.Pow(), value=exponent)
                    | ast.Call(func=ast.Name(id="pow"), args=[base, exponent])
                ) if _may_be_below_0(exponent, function):
                    if all(kinds().of(side, name) in (WHOLE, TRUTH) for side in (base, exponent)):
                        whole = f"{ast.unparse(base)} and {ast.unparse(exponent)} are whole numbers"
                        what = f"{whole}, and machine code gives 0 if the second is below 0"
                        right = f"float({ast.unparse(base)}) as the base is right"
                        raise BrokenContract(f"{ast.unparse(node)}: {what}: {right}", node.lineno)


def _may_be_below_0(exponent: ast.expr, function: ast.FunctionDef) -> bool:
    """Whether an exponent is no number from 0, no length, and no counter of loops that begin at 0 or above."""
    match exponent:
        case ast.Constant(value=int() | float() as value):
            return value < 0
        case ast.Call(func=ast.Name(id="len")):
            return False
        case ast.Name(id=name):
            nodes = [*ast.walk(function)]
            stores = sum(isinstance(n, ast.Name) and n.id == name and isinstance(n.ctx, ast.Store) for n in nodes)
            return not stores or stores > sum(_counts_up(n, name) for n in nodes)
    return True


def _counts_up(node: ast.AST, name: str) -> bool:
    match node:
        case ast.For(target=ast.Name(id=target), iter=ast.Call(func=ast.Name(id="range"), args=[*first, _])):
            start = first[0] if first else ast.Constant(0)
            is_from_0 = isinstance(start, ast.Constant) and isinstance(start.value, int) and start.value >= 0
            return target == name and len(first) < 2 and is_from_0
    return False
