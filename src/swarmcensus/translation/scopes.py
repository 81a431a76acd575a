"""The local names of a function: which are read, and which loops have a counter of their own."""

import ast


class Scopes:
    """The names of one function."""

    def __init__(self, function: ast.FunctionDef, parameters: frozenset[str] = frozenset()) -> None:
        """Find all names, and where each occurs; a robot that is asked for a parameter, a constant in C, does not."""
        nodes = list(ast.walk(function))
        constants = {id(node.value) for node in nodes if isinstance(node, ast.Attribute) and node.attr in parameters}
        changed = {id(node.target) for node in nodes if isinstance(node, ast.AugAssign)}
        self.names = [node for node in nodes if isinstance(node, ast.Name) and id(node) not in constants]
        self.read = {name.id for name in self.names if isinstance(name.ctx, ast.Load) or id(name) in changed}
        given = {argument.arg for argument in (*function.args.posonlyargs, *function.args.args)}
        loops = [node for node in nodes if isinstance(node, ast.For)]
        counted = {loop.target.id for loop in loops if isinstance(loop.target, ast.Name)} - given
        owned = {name for name in counted if self._is_of(name, [loop for loop in loops if _counts(loop, name)])}
        self.private = {id(loop) for loop in loops for name in owned if _counts(loop, name)}  # counters are theirs
        stored = {node.id for node in self.names if isinstance(node.ctx, ast.Store)}
        self.local = sorted(stored - given - owned)

    def _is_of(self, name: str, loops: list[ast.For]) -> bool:
        """Whether a counter is used only in these loops, which do not contain each other, and set by them only."""
        parts = [part for loop in loops for part in ast.walk(loop)]
        inside = {id(part) for part in parts if isinstance(part, ast.Name) and part.id == name}
        everywhere = [node for node in self.names if node.id == name]
        stores = sum(isinstance(node.ctx, ast.Store) for node in everywhere)
        is_nested = any(parts.count(loop) > 1 for loop in loops)
        in_iter = any(mentions(loop.iter, name) for loop in loops)
        return len(inside) == len(everywhere) and stores == len(loops) and not is_nested and not in_iter


def _counts(loop: ast.For, name: str) -> bool:
    return isinstance(loop.target, ast.Name) and loop.target.id == name


def mentions(node: ast.AST, name: str) -> bool:
    """Whether a name occurs in a piece of source."""
    return any(isinstance(part, ast.Name) and part.id == name for part in ast.walk(node))
