"""Selecting settings by an expression such as 'topology == "ring" and accuracy == 0.675'."""

import ast
import contextlib
import operator
from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from swarmcensus.studies import idle_caption
from swarmcensus.summaries.labels import groups_in
from swarmcensus.support.errors import InputError
from swarmcensus.support.hints import did_you_mean
from swarmcensus.support.options import wrong_option
from swarmcensus.support.quantities import QUANTITIES

COMPARE: dict[type, Callable[[Any, Any], Any]] = {
    ast.Eq: operator.eq,
    ast.NotEq: operator.ne,
    ast.Lt: operator.lt,
    ast.LtE: operator.le,
    ast.Gt: operator.gt,
    ast.GtE: operator.ge,
}


MOST_VALUES = 12  # of a coordinate in a message


def require(data: xr.Dataset, *names: str, dimensions: tuple[str, ...] = ("setting",)) -> None:
    """Raise InputError unless `data` has the variables `names`, and the dimensions are not empty."""
    for dimension in dimensions:
        if not data.sizes.get(dimension):
            why = "select with a list or a mask that is not empty"
            raise InputError(f"this dataset has no {dimension}: {why}", key=dimension)
    for name in names:
        if name not in data.variables:
            hint = ": set local = true under [measure] and run again" if name.startswith("local_") else ""
            raise InputError(f"this dataset has no variable {name!r}{hint}", key=name)


def places_with(data: xr.Dataset, values: Mapping[str, object]) -> NDArray[np.intp]:
    """The places of the settings with these values of coordinates."""
    return np.flatnonzero(np.logical_and.reduce([data[name].values == value for name, value in values.items()]))


def where(data: xr.Dataset, expression: str | None) -> xr.Dataset:
    """Select the settings for which an expression over their coordinates is true; None selects all.

    The name of a group of the study stands for its expression. The expression may use ==, !=, <, <=, >, >=, in, and,
    or, not and brackets; no code is executed. Raises InputError.
    """
    if expression is None:
        return data
    expression = groups_in(data).get(expression, expression)
    known = {str(k): c.values for k, c in data.coords.items() if c.dims == ("setting",)}
    if "members" in known:  # as it is shown
        known["members"] = np.where(known["members"] == "", idle_caption("members"), known["members"])
    try:
        tree = ast.parse(expression.strip(), mode="eval").body
        holds = _evaluate(tree, known)
    except (SyntaxError, ValueError, TypeError, ArithmeticError, RecursionError, MemoryError) as error:
        what = error.msg if isinstance(error, SyntaxError) else error
        example = 'write for example: topology == "ring" and accuracy == 0.675'
        raise wrong_option("where", expression, f"{what}; {example}") from None
    chosen = data.isel(setting=np.flatnonzero(np.broadcast_to(holds, data.sizes["setting"])))
    if not chosen.sizes["setting"]:
        raise wrong_option("where", expression, f"no setting is so{_known_values(tree, known)}")
    return chosen


def _known_values(tree: ast.expr, known: dict[str, np.ndarray]) -> str:
    """A phrase with the values of the first coordinate that is compared with a value that no setting has."""
    for node in ast.walk(tree):
        if not isinstance(node, ast.Compare) or len(node.ops) != 1 or not isinstance(node.ops[0], ast.Eq):
            continue
        sides = node.left, node.comparators[0]
        name = next((side.id for side in sides if isinstance(side, ast.Name)), None)
        if name is None or np.any(_evaluate(node, known)):
            continue
        values = dict.fromkeys(map(str, known[name].tolist()))
        meant = next((str(side.value) for side in sides if isinstance(side, ast.Constant)), "")
        more = ", ..." if len(values) > MOST_VALUES else ""
        return f": {did_you_mean(meant, values)}{name} is {', '.join([*values][:MOST_VALUES])}{more}"
    return ""


def _evaluate(node: ast.expr, known: dict[str, np.ndarray]) -> Any:
    if isinstance(node, ast.BoolOp):
        combine = np.logical_and if isinstance(node.op, ast.And) else np.logical_or
        return combine.reduce([_evaluate(v, known) for v in node.values])
    if isinstance(node, ast.UnaryOp) and isinstance(node.op, ast.Not):
        return np.logical_not(_evaluate(node.operand, known))
    if isinstance(node, ast.Compare):
        operands = [node.left, *node.comparators]
        if len(node.ops) > 1 and not any(isinstance(one, ast.Name) for one in operands[1:-1]):
            raise ValueError("a chain has a coordinate between, as 0.5 < accuracy < 0.9")
        pairs = zip(node.ops, operands, operands[1:], strict=False)
        return np.logical_and.reduce([_compare(op, left, right, known) for op, left, right in pairs])
    raise ValueError("should compare settings' coordinates with values")


def _compare(op: ast.cmpop, left: ast.expr, right: ast.expr, known: dict[str, np.ndarray]) -> Any:
    if isinstance(op, ast.In | ast.NotIn):
        if not isinstance(right, ast.List | ast.Tuple):
            raise ValueError("after 'in' comes a list")
        found = np.logical_or.reduce([_compare(ast.Eq(), left, item, known) for item in right.elts])
        return np.logical_not(found) if isinstance(op, ast.NotIn) else found
    if type(op) not in COMPARE:
        raise ValueError("should compare with ==, !=, <, <=, >, >= or in")
    sides = [_value(left, known), _value(right, known)]
    if any(isinstance(side, int | float) for side in sides):  # an accuracy is text, since it may be a spread
        sides = [numbers(s) if isinstance(s, np.ndarray) and s.dtype.kind in "UO" else s for s in sides]
    return COMPARE[type(op)](*sides)


def numbers(texts: np.ndarray) -> np.ndarray:
    """Texts as numbers; NaN for a text that is not a number."""

    values = np.full(len(texts), np.nan)
    for k, text in enumerate(texts):
        with contextlib.suppress(ValueError):
            values[k] = float(str(text))
    return values


def _value(node: ast.expr, known: dict[str, np.ndarray]) -> Any:
    if isinstance(node, ast.Name):
        if node.id not in known:
            if any(node.id in values for values in known.values()):
                raise ValueError(f'no coordinate {node.id!r}: a text is quoted, as "{node.id}"')
            there = ", ".join(sorted(known))
            if any(node.id in (name, quantity.title) for name, quantity in QUANTITIES.items()):
                raise ValueError(f"{node.id} is measured, and settings are selected by what a study sets: {there}")
            raise ValueError(f"no coordinate {node.id!r}: {did_you_mean(node.id, known)}known are {there}")
        return known[node.id]
    try:
        value = ast.literal_eval(node)
    except ValueError:
        raise ValueError(f"{ast.unparse(node)!r} is neither a coordinate nor a value") from None
    if not isinstance(value, str | int | float):
        raise ValueError(f"{value!r} is no number and no text")
    return value
