"""Where the local names of a function are declared in C: as near to their use as their lives allow."""

import ast
from collections.abc import Iterator
from typing import NamedTuple

Path = tuple[tuple[str, int], ...]  # from the outermost block inwards: which block of a statement, and the place in it
LOOPS = (ast.For, ast.While)


class Occurrence(NamedTuple):
    """A place where a name occurs."""

    path: Path
    statement: ast.stmt
    loops: tuple[bool, ...]  # of each block of the path: whether it is the body of a loop
    is_load: bool
    is_store: bool


class Scopes:
    """Where the names of one function are declared."""

    def __init__(self, function: ast.FunctionDef, parameters: frozenset[str] = frozenset()) -> None:
        """Find all names, and where each occurs; a robot that is asked for a parameter, a constant in C, does not."""
        self.constants = {
            id(node.value) for node in ast.walk(function) if isinstance(node, ast.Attribute) and node.attr in parameters
        }
        self.given = {argument.arg for argument in (*function.args.posonlyargs, *function.args.args)}
        self.found: dict[str, list[Occurrence]] = {}
        self.statements: dict[Path, ast.stmt] = {}
        self.private: set[int] = set()  # loops, by id, whose counter is theirs alone
        self._walk(function.body, (), (False,), "body")
        loops = [node for node in ast.walk(function) if isinstance(node, ast.For)]
        counters = [(loop.target.id, loop) for loop in loops if isinstance(loop.target, ast.Name)]
        for name in dict(counters):
            self._claim(name, [loop for counter, loop in counters if counter == name])
        self.before: dict[int, list[str]] = {}  # by id of a statement: names declared before it
        self.at: dict[int, set[str]] = {}  # names declared by it
        for name, occurrences in self.found.items():
            if name not in self.given:
                self._place(name, occurrences)

    def is_read(self, name: str) -> bool:
        """Whether a local name is read anywhere."""
        return any(each.is_load for each in self.found.get(name, ()))

    def begins(self, node: ast.stmt, name: str) -> bool:
        """Whether a name is to be declared where this statement sets it; asked again, it is not."""
        names = self.at.get(id(node), set())
        is_new = name in names
        names.discard(name)
        return is_new

    def _walk(self, body: list[ast.stmt], path: Path, loops: tuple[bool, ...], block: str) -> None:
        for k, statement in enumerate(body):
            here = (*path, (block, k))
            self.statements[here] = statement
            for node in _header(statement):
                if isinstance(node, ast.Name) and id(node) not in self.constants:
                    both = isinstance(statement, ast.AugAssign) and node is statement.target
                    is_load = isinstance(node.ctx, ast.Load)
                    each = Occurrence(here, statement, loops, is_load or both, not is_load or both)
                    self.found.setdefault(node.id, []).append(each)
            for field in ("body", "orelse"):
                inner = getattr(statement, field, None)
                if isinstance(inner, list):
                    self._walk(inner, here, (*loops, isinstance(statement, LOOPS)), field)

    def _claim(self, name: str, counted: list[ast.For]) -> None:
        """Give a counter to its loops, if it is used in them only and set by them only."""
        parts = [part for loop in counted for part in ast.walk(loop)]
        inside = {id(part) for part in parts if isinstance(part, ast.Name) and part.id == name}
        everywhere, stores = self.found[name], sum(each.is_store for each in self.found[name])
        nested = any(parts.count(loop) > 1 for loop in counted)
        in_iter = any(mentions(loop.iter, name) for loop in counted)
        in_loops_only = len(inside) == len(everywhere) and stores == len(counted)
        if in_loops_only and not nested and not in_iter and name not in self.given:
            self.private |= {id(loop) for loop in counted}
            del self.found[name]

    def _place(self, name: str, occurrences: list[Occurrence]) -> None:
        if not any(each.is_store for each in occurrences):  # a constant or a function
            return
        paths = [each.path for each in occurrences]
        depth = 0
        while (
            all(len(path) > depth + 1 for path in paths)
            and len({(*path[: depth + 1], path[depth + 1][0]) for path in paths}) == 1
        ):
            depth += 1
        while True:  # outwards, as long as the value may have to live from one turn of a loop to the next
            place = min(path[depth][1] for path in paths)
            first = [each for each in occurrences if each.path[depth][1] == place]
            begins = all(len(each.path) == depth + 1 for each in first) and _sets(first[0].statement, name)
            if begins or not any(first[0].loops[1 : depth + 1]):
                break
            depth -= 1
        if begins:
            self.at.setdefault(id(first[0].statement), set()).add(name)
            return
        self.before.setdefault(id(self.statements[first[0].path[: depth + 1]]), []).append(name)


def _header(statement: ast.stmt) -> Iterator[ast.AST]:
    """The nodes of a statement without those of the statements inside."""
    for field, value in ast.iter_fields(statement):
        if field in ("body", "orelse"):
            continue
        for part in value if isinstance(value, list) else [value]:
            if isinstance(part, ast.AST):
                yield from ast.walk(part)


def _sets(statement: ast.stmt, name: str) -> bool:
    """Whether a statement gives a name its first value."""
    if not isinstance(statement, ast.Assign) or mentions(statement.value, name):
        return False
    names = [t for target in statement.targets for t in (target.elts if isinstance(target, ast.Tuple) else [target])]
    return any(isinstance(target, ast.Name) and target.id == name for target in names)


def mentions(node: ast.AST, name: str) -> bool:
    """Whether a name occurs in a piece of source."""
    return any(isinstance(part, ast.Name) and part.id == name for part in ast.walk(node))
