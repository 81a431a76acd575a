"""Pieces of C expressions, with what is needed to put brackets around them."""

import ast
from typing import NamedTuple

CHOICE, OR, AND, BITS, EQUAL, LESS, SHIFT, SUM, PRODUCT, UNARY, ATOM = range(11)  # how tightly operators of C bind


class Text(NamedTuple):
    """An expression in C, and how tightly its outermost operator binds."""

    text: str
    level: int = ATOM

    def within(self, level: int) -> str:
        """The expression as an operand of an operator of this level."""
        return self.text if self.level >= level else f"({self.text})"


def literal(node: ast.expr) -> int | float | None:
    """The number that an expression of literals has; None if it has none."""
    match node:
        case ast.Constant(value=bool()):
            return None
        case ast.Constant(value=int(value)) | ast.Constant(value=float(value)):
            return value
        case ast.UnaryOp(op=ast.USub(), operand=operand) if (inner := literal(operand)) is not None:
            return -inner
        case ast.BinOp(left=left, op=ast.Add() | ast.Sub() | ast.Mult(), right=right):
            sides = literal(left), literal(right)
            if isinstance(sides[0], int) and isinstance(sides[1], int):
                return _whole(node.op, *sides)  # type: ignore[attr-defined, arg-type]
    return None


def _whole(operator: ast.operator, left: int, right: int) -> int:
    return (
        left + right
        if isinstance(operator, ast.Add)
        else left - right
        if isinstance(operator, ast.Sub)
        else left * right
    )


def signed(text: str) -> Text:
    """A number, which may have a sign."""
    return Text(text, UNARY if text.startswith("-") else ATOM)


def joined(parts: list[Text], operator: str) -> Text:
    """Truths joined by && or ||; the others of the two get brackets, which compilers warn about otherwise."""
    if len(parts) == 1:
        return parts[0]
    level = AND if operator == "&&" else OR
    return Text(f" {operator} ".join(part.text if part.level > AND else f"({part.text})" for part in parts), level)
