"""What a brain needs of a study to be at its best: NEEDS, as numbers or as expressions of its parameters."""

import ast
import contextlib
from collections.abc import Mapping
from typing import Any

from swarmcensus.brains.fields import Value
from swarmcensus.support import safe_source
from swarmcensus.support.hints import did_you_mean

KEYS = {
    "silent": "rounds at the beginning in which it says nothing",
    "robots": "the fewest robots of a swarm",
    "rounds": "the fewest rounds of a trial",
    "length": "the rounds of a trial, neither fewer nor more",
    "neighbours": "the fewest robots that a robot hears",
    "mutual": "true if it diverges where a robot does not hear all that hear it",
    "steps": "the equal steps of [0, 1] of which the middles are the fill ratios that it chooses among",
    "equal_sensors": "true if it takes black to be read right as often as white",
    "perfect_sensors": "true if it takes readings for the truth",
    "even": "true if it takes the ground that its robots see to be like all ground",
    "binary": "true if it answers on which side of one half the fill ratio is, and not how large it is",
}
Needs = dict[str, ast.expr]


def read_needs(given: Any, parameters: Mapping[str, Value]) -> Needs:
    """Check NEEDS, and read its expressions. Raises ValueError, naming the key and the value."""
    if not isinstance(given, dict):
        raise ValueError('NEEDS should be a dict such as {"silent": "3 * phase"}')
    needs = {}
    for key, value in given.items():
        if key not in KEYS:
            raise ValueError(f"NEEDS names {key!r}: {did_you_mean(str(key), KEYS)}known are {', '.join(KEYS)}")
        try:
            needs[key] = ast.parse(str(value), mode="eval").body
            unknown = [name for name in names_in(needs[key]) if name not in _numbers(parameters)]
            if unknown:
                raise ValueError(f"{unknown[0]!r} is not a parameter that is a number")
            float(safe_source.constant(needs[key], _numbers(parameters)))
        except (SyntaxError, ValueError, ArithmeticError, RecursionError, MemoryError) as error:
            should = "should be a number, or plain arithmetic with parameters"
            raise ValueError(f"NEEDS[{key!r}] = {value!r}: {should}: {error}") from None
    return needs


def values_of(needs: Needs, parameters: Mapping[str, Value]) -> dict[str, float]:
    """What is needed with these values of the parameters; what they give no value to is left out."""
    found = {}
    for key, expression in needs.items():
        with contextlib.suppress(ValueError, ArithmeticError):
            found[key] = float(safe_source.constant(expression, _numbers(parameters)))
    return found


def names_in(expression: ast.expr) -> list[str]:
    """The parameters that an expression names."""
    return sorted({node.id for node in ast.walk(expression) if isinstance(node, ast.Name)})


def _numbers(parameters: Mapping[str, Value]) -> dict[str, float]:
    return {name: value for name, value in parameters.items() if isinstance(value, float)}
