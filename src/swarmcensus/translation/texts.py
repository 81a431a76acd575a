"""Pieces of C expressions, with what is needed to put brackets around them, and names in comments."""

import ast
import re
from typing import NamedTuple

from swarmcensus.support.control_characters import printable

CHOICE, OR, AND, EQUAL, LESS, SUM, PRODUCT, UNARY, ATOM = range(9)  # how tightly operators of C bind


class Text(NamedTuple):
    """An expression in C, and how tightly its outermost operator binds."""

    text: str
    level: int = ATOM

    def within(self, level: int) -> str:
        """The expression as an operand of an operator of this level."""
        return self.text if self.level >= level else f"({self.text})"


def literal(node: ast.expr) -> int | float | None:
    """The number that is written here; None if an expression is something else."""
    match node:
        case ast.Constant(value=bool()):
            return None
        case ast.Constant(value=int(value)) | ast.Constant(value=float(value)):
            return value
        case ast.UnaryOp(op=ast.USub(), operand=operand) if (inner := literal(operand)) is not None:
            return -inner
    return None


def signed(text: str) -> Text:
    """A number, which may have a sign."""
    return Text(text, UNARY if text.startswith("-") else ATOM)


def joined(parts: list[Text], sign: str) -> Text:
    """Truths joined by && or ||; the others of the two get brackets, which compilers warn about otherwise."""
    if len(parts) == 1:
        return parts[0]
    level = AND if sign == "&&" else OR
    return Text(f" {sign} ".join(part.text if part.level > AND else f"({part.text})" for part in parts), level)


def quoted(label: str) -> str:
    """A brain's label, which has its file's name, for a comment or docstring: it ends neither, and is one line."""
    line = printable(" ".join(label.split()).replace("\\", "/").replace('"', "'"))
    return re.sub(r"\?(?=\?)", "? ", line)  # ?? may begin a trigraph
