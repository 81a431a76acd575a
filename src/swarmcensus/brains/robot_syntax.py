"""What the language of brain files has on robots: what MicroPython lacks of Python is refused."""

import ast

from swarmcensus.brains.syntax import BrokenContract


def check(tree: ast.Module) -> None:
    """Raise BrokenContract if a source has syntax that MicroPython 1.27 lacks."""
    for node in ast.walk(tree):
        if found := _missing(node):
            what, right, place = found
            raise BrokenContract(f"MicroPython on a robot has no {what}: {right}", place.lineno)


def _missing(node: ast.AST) -> tuple[str, str, ast.stmt | ast.expr] | None:
    """What a node needs that MicroPython lacks, what is right instead, and where."""
    match node:
        case ast.Match():
            return "match statement", "if and elif are right", node
        case ast.FunctionDef(args=ast.arguments(posonlyargs=[_, *_])):
            return f"/ among arguments, as {node.name} has", "leave it out", node
        case ast.FunctionDef() if getattr(node, "type_params", ()):  # of Python 3.12
            return f"type parameters, as {node.name} has", "leave them out", node
        case ast.Tuple(elts=items, ctx=ast.Load()) if any(isinstance(item, ast.Starred) for item in items):
            return f"* in a tuple, as in {ast.unparse(node)}", "write its items one by one", node
        case ast.Subscript(slice=ast.Slice(step=step)) if step is not None:
            return f"step in a slice, as in {ast.unparse(node)}", "a loop over range is right", node
    return None
