"""What brains call of `math` and of Python, so that machine code raises where CPython does.

Numba's functions go on with NaN, infinity or any whole number there. The same functions work out the results here.
"""

import math
import types
from collections.abc import Callable
from typing import Any

import numpy as np

from swarmcensus.engine.code_cache import not_compiled
from swarmcensus.engine.compiling import compiled
from swarmcensus.engine.constants import POWER, RAISED

DOMAIN, RANGE = "math domain error", "math range error"
LARGEST = 2.0**63
GROWING = ("cosh", "exp", "expm1", "gamma", "lgamma", "sinh")


def _of_one(usual: Any) -> Any:
    """A function that is infinite at poles, or that grows: then its results may be too large."""

    def strict(x):
        result = usual(x)
        if not math.isfinite(result) and not math.isnan(x) and (math.isnan(result) or math.isfinite(x)):
            if grows and math.isinf(result) and (x > 0.0 or x != math.floor(x) or no_poles):
                raise OverflowError(RANGE)
            raise ValueError(DOMAIN)
        return result

    grows, no_poles = usual.__name__ in GROWING, usual.__name__ not in ("gamma", "lgamma")
    return strict


def _of_two(usual: Any) -> Any:
    def strict(x, y):
        result = usual(x, y)
        if not math.isfinite(result) and not math.isnan(x) and not math.isnan(y):
            if math.isnan(result) or (math.isfinite(x) and math.isfinite(y) and x == 0.0):
                raise ValueError(DOMAIN)
            if math.isfinite(x) and math.isfinite(y):
                raise OverflowError(RANGE)
        return result

    return strict


def _to_whole(usual: Any) -> Any:
    def strict(x):
        if not math.isfinite(x):
            if math.isnan(x):
                raise ValueError("cannot convert float NaN to integer")
            raise OverflowError("cannot convert float infinity to integer")
        if abs(x) >= LARGEST:  # CPython goes on, and robots do not
            raise OverflowError("a whole number has more than 64 bits")
        return usual(x)

    return strict


def _round(x, digits=None):
    if digits is None:
        return nearest(x)
    return round(x, digits)


def _power(result, base, exponent):
    """The result of base ** exponent, if CPython has one."""
    if not math.isfinite(result) and math.isfinite(base) and math.isfinite(exponent):
        if base == 0.0:
            raise ZeroDivisionError("0.0 cannot be raised to a negative power")
        if math.isinf(result):
            raise OverflowError("(34, 'Numerical result out of range')")
        raise ValueError("a negative number has no real power with this exponent")
    return result


def _raised(base, exponent):
    return power(base**exponent, base, exponent)


nearest, power = compiled(_to_whole(round)), compiled(_power)
raised = compiled(_raised)
KINDS: tuple[tuple[Callable[[Any], Any], tuple[str, ...]], ...] = (
    (_of_one, ("acos", "acosh", "asin", "atanh", "cos", "log", "log10", "log2", "sin", "sqrt", "tan", *GROWING)),
    (_of_two, ("ldexp", "pow")),
    (_to_whole, ("ceil", "floor", "trunc")),
)
OF_MATH = {name: compiled(made(getattr(math, name))) for made, names in KINDS for name in names}
OF_MATH["fmod"] = compiled(_of_two(np.fmod))  # Numba has no math.fmod
OF_PYTHON = {"int": compiled(_to_whole(int)), "round": compiled(_round), "pow": raised, RAISED: raised, POWER: power}
MATH = types.ModuleType("math")
vars(MATH).update(vars(math) | OF_MATH)


def make_strict(brain: types.ModuleType) -> None:
    """Give the functions of a brain's file, which are not compiled yet, what is in here; CPython needs none of it."""
    if not_compiled():
        return
    for name, value in list(vars(brain).items()):
        if value is math:
            setattr(brain, name, MATH)
        elif callable(value) and vars(math).get(value.__name__) is value and value.__name__ in OF_MATH:
            setattr(brain, name, OF_MATH[value.__name__])
    for name, value in OF_PYTHON.items():
        vars(brain).setdefault(name, value)
