"""Powers of whole numbers: where an exponent may be below 0, machine code has 0 and CPython a fraction."""

import ast
from collections.abc import Callable

from swarmcensus.brains.kinds import TRUTH, WHOLE, Kinds
from swarmcensus.brains.syntax import BrokenContract, functions_of


def check(tree: ast.Module, kinds: Callable[[], Kinds]) -> None:
    """Raise BrokenContract if a source raises a whole number to another, but for a number from 0 in its place."""
    for name, function in functions_of(tree).items():
        for node in ast.walk(function):
            match node:
                case (
                    ast.BinOp(left=base, op=ast.Pow(), right=exponent)
                    | ast.AugAssign(target=base, op=ast.Pow(), value=exponent)
                    | ast.Call(func=ast.Name(id="pow"), args=[base, exponent])
                ) if not isinstance(exponent, ast.Constant):  # which is not below 0
                    if all(kinds().of(side, name) in (WHOLE, TRUTH) for side in (base, exponent)):
                        whole = f"{ast.unparse(base)} and {ast.unparse(exponent)} are whole numbers"
                        what = f"{whole}, and machine code gives 0 if the second is below 0"
                        right = f"float({ast.unparse(base)}) as the base is right"
                        raise BrokenContract(f"{ast.unparse(node)}: {what}: {right}", node.lineno)
