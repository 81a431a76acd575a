"""What a plugin's file offers, read without running it: its functions' signatures and its plain constants."""

import ast
import contextlib
import sys
import types
from collections.abc import Callable, Sequence
from inspect import Parameter, Signature
from typing import Annotated, Any, Literal, Optional, Union

TYPES = {one.__name__: one for one in (int, float, bool, str, list, tuple, Sequence)} | {
    "Any": Any, "Annotated": Annotated, "Literal": Literal, "Optional": Optional, "Union": Union
}  # fmt: skip


def outline(source: str, refuse: Callable[[], Exception]) -> types.ModuleType:
    """A module with the constants of a source, and with functions that have its signatures and raise `refuse()`.

    A function `check` is left out. Raises ValueError for a key with a type or default that only running it would give.
    """
    module = types.ModuleType("outline")
    tree = ast.parse(source)
    named: dict[str, Any] = {}  # what annotations and defaults may name: expressions, and what this package has
    for constant in (node for node in tree.body if isinstance(node, ast.Assign)):
        named |= {target.id: constant.value for target in constant.targets if isinstance(target, ast.Name)}
    for name, value in named.items():
        with contextlib.suppress(ValueError):  # what must be computed is no constant
            setattr(module, name, ast.literal_eval(value))
    for node in tree.body:
        if isinstance(node, ast.ImportFrom) and (node.module or "").startswith("swarmcensus."):
            ours = vars(sys.modules.get(node.module or "", module))
            named |= {alias.asname or alias.name: ours.get(alias.name) for alias in node.names}
        elif isinstance(node, ast.FunctionDef) and node.name != "check":
            setattr(module, node.name, _stub(node, named, refuse))
    return module


def _stub(node: ast.FunctionDef, named: dict[str, Any], refuse: Callable[[], Exception]) -> Callable[..., Any]:
    def stub(*_: object, **__: object) -> None:
        raise refuse()

    arguments, empty = node.args, Parameter.empty
    places = [*arguments.posonlyargs, *arguments.args]
    defaults = [empty] * (len(places) - len(arguments.defaults)) + [0] * len(arguments.defaults)  # of any value
    parameters = [Parameter(a.arg, Parameter.POSITIONAL_ONLY, default=d) for a, d in zip(places, defaults, strict=True)]
    parameters += [Parameter(arguments.vararg.arg, Parameter.VAR_POSITIONAL)] if arguments.vararg else []
    try:
        for argument, value in zip(arguments.kwonlyargs, arguments.kw_defaults, strict=True):
            default = empty if value is None else _constant(value, named)
            parameters.append(Parameter(argument.arg, Parameter.KEYWORD_ONLY, default=default))
            if argument.annotation is not None:
                stub.__annotations__[argument.arg] = _type(argument.annotation, named)
    except (ValueError, TypeError, RecursionError, AttributeError):
        raise ValueError(f"only running it would tell the type and default of its key {argument.arg}") from None
    stub.__signature__ = Signature(parameters)  # type: ignore[attr-defined]
    return stub


def _constant(node: ast.expr, named: dict[str, Any]) -> Any:
    return ast.literal_eval(named[node.id] if isinstance(node, ast.Name) and node.id in named else node)


def _type(node: Any, named: dict[str, Any]) -> Any:
    """The type that an annotation gives, without what `Annotated` adds: the values were checked when they were run."""
    match node:
        case ast.Name(name) if isinstance(named.get(name), ast.expr):
            return _type(named[name], named)
        case ast.Name(name) | ast.Attribute(attr=name) if name in TYPES:
            return TYPES[name]
        case ast.Name(name) if named.get(name) is not None:
            return named[name]
        case ast.Constant(str() as text):
            return _type(ast.parse(text, mode="eval").body, named)
        case ast.Constant(None) | ast.Constant(value=types.EllipsisType()):
            return node.value
        case ast.BinOp(left, ast.BitOr(), right):
            return Union[_type(left, named), _type(right, named)]  # noqa: UP007 (of types that are not known here)
        case ast.Subscript(value, inside):
            head, parts = _type(value, named), inside.elts if isinstance(inside, ast.Tuple) else [inside]
            if head is Annotated:
                return _type(parts[0], named)
            found = [_constant(part, named) if head is Literal else _type(part, named) for part in parts]
            return head[tuple(found) if len(found) > 1 else found[0]]
    raise ValueError
