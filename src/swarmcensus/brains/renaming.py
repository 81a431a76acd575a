"""Two files become one: all names of their top levels are given prefixes, and nothing else of what they do changes."""

import ast
import math
from collections.abc import Collection, Iterable, Mapping
from copy import deepcopy

from swarmcensus.basics.safe_source import set_by

# the low bits of luck: independent of what a brain makes of the high ones
OWN_LUCK = "me.luck * 1048576.0 % 1.0"


def free_prefix(prefix: str, sources: Iterable[str]) -> str:
    """A prefix that stands in none of these sources."""
    while any(prefix in source for source in sources):
        prefix += "_"
    return prefix


class Renamed(ast.NodeTransformer):
    """Names of the top level, but where a function has a local of that name, and fields of the record."""

    def __init__(self, names: Mapping[str, ast.expr], fields: Mapping[str, ast.expr]) -> None:
        """What they become: `fields` are those of a record called `me`."""
        self.names, self.fields = names, fields
        self.local: set[str] = set()

    def visit_FunctionDef(self, node: ast.FunctionDef) -> ast.AST:
        """Rename what a function names."""
        self.local = {one.arg for one in ast.walk(node) if isinstance(one, ast.arg)}
        self.local |= {name for one in ast.walk(node) for name in set_by(one)}
        self.generic_visit(node)
        self.local = set()
        return node

    def visit_Name(self, node: ast.Name) -> ast.expr:
        """Rename what is of the top level."""
        new = None if node.id in self.local else self.names.get(node.id)
        return deepcopy(new) if new is not None else node

    def visit_Attribute(self, node: ast.Attribute) -> ast.expr:
        """Rename a field, but nothing of `math`."""
        node.value = self.visit(node.value)
        new = None if isinstance(node.value, ast.Name) and node.value.id == "math" else self.fields.get(node.attr)
        if isinstance(new, ast.Attribute):
            return ast.Attribute(node.value, new.attr, node.ctx)
        if new is None:
            return node
        found = deepcopy(new)
        for one in ast.walk(found):
            if isinstance(one, ast.Attribute):
                one.value = node.value  # whatever the function calls its record
        return found


def fields_of_liar(own: str, fields: Collection[str]) -> dict[str, ast.expr]:
    """What the fields of an adversary's record become."""
    found: dict[str, ast.expr] = {name: ast.Attribute(_name("me"), own + name, ast.Load()) for name in fields}
    return found | {"luck": ast.parse(OWN_LUCK, mode="eval").body}


def renamed(
    tree: ast.Module,
    prefix: str,
    kept: Collection[str] = (),
    fields: Mapping[str, ast.expr] | None = None,
    anew: Collection[str] = (),
) -> str:
    """A file with a prefix before all names of its top level but those `kept`, and `math` for what it imports.

    What is given a value `anew` elsewhere stays under the prefix only where it is read.
    """
    names: dict[str, ast.expr] = {}
    body: list[ast.stmt] = []
    for node in deepcopy(tree.body):  # in turn: a name may be bound twice, and constants are made of the ones before
        if isinstance(node, ast.Import | ast.ImportFrom):
            names |= _imported(node)
        elif isinstance(node, ast.Assign):
            node.value = Renamed(names, {}).visit(node.value)
            mine = {one.id: _new(one.id, prefix, kept) for one in node.targets if isinstance(one, ast.Name)}
            names |= {name: _name(new) for name, new in mine.items()}
            node.targets = [ast.Name(new, ast.Store()) for new in mine.values()]
            body.append(node)
        elif isinstance(node, ast.FunctionDef):
            new = _new(node.name, prefix, kept)
            names[node.name] = _name(new)
            node.name = new
            body.append(node)
    body = [Renamed(names, fields or {}).visit(n) if isinstance(n, ast.FunctionDef) else n for n in body]
    unread = {prefix + name for name in anew} - _read(body)
    for node in body:
        if isinstance(node, ast.Assign):
            node.targets = [one for one in node.targets if not (isinstance(one, ast.Name) and one.id in unread)]
    body = [node for node in body if not isinstance(node, ast.Assign) or node.targets]
    return ast.unparse(ast.fix_missing_locations(ast.Module(body, [])))


def _name(name: str) -> ast.Name:
    return ast.Name(name, ast.Load())


def _new(name: str, prefix: str, kept: Collection[str]) -> str:
    return name if name in kept else prefix + name


def _imported(node: ast.Import | ast.ImportFrom) -> dict[str, ast.expr]:
    """The names that an import of math gives, as what they are of `math`."""
    if isinstance(node, ast.Import):
        return {alias.asname or alias.name: _name("math") for alias in node.names}
    names = {alias.asname or alias.name: alias.name for alias in node.names}
    if "*" in names:
        names = {name: name for name in dir(math) if name[0] != "_"}
    return {name: ast.Attribute(_name("math"), origin, ast.Load()) for name, origin in names.items()}


def _read(body: list[ast.stmt]) -> set[str]:
    nodes = [one for node in body for one in ast.walk(node)]
    return {one.id for one in nodes if isinstance(one, ast.Name) and isinstance(one.ctx, ast.Load)}


def imports(tree: ast.Module) -> bool:
    """Whether a file imports anything, which can be `math` alone."""
    return any(isinstance(node, ast.Import | ast.ImportFrom) for node in tree.body)


def speaks_of(tree: ast.Module, field: str) -> bool:
    """Whether a source names a field of its record."""
    return any(isinstance(node, ast.Attribute) and node.attr == field for node in ast.walk(tree))
