"""Checks of the arguments of theory, each with an error message of one sentence."""

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from swarmcensus.support.errors import InputError
from swarmcensus.support.formatting import short_repr
from swarmcensus.support.intervals import Floats
from swarmcensus.worlds import whole

MOST_READINGS = 10_000_000  # of a local law, which lists every count
BLIND = 1e-12  # |b + w - 1| below which readings carry no information


def shares(name: str, value: ArrayLike) -> Floats:
    """Numbers from 0 to 1, of any shape. Raises InputError."""
    return _numbers_so(name, value, lambda found: (found >= 0.0) & (found <= 1.0), "from 0 to 1")


def one_share(name: str, value: ArrayLike) -> float:
    """One number from 0 to 1. Raises InputError."""
    if numbers(name, value).ndim:
        raise InputError.at(name, short_repr(value), "should be one number")
    return float(shares(name, value))


def positive(name: str, value: ArrayLike) -> Floats:
    """Numbers above 0, of any shape. Raises InputError."""
    return _numbers_so(name, value, lambda found: (found > 0.0) & np.isfinite(found), "above 0")


def from_zero(name: str, value: ArrayLike) -> Floats:
    """Numbers of 0 or above, of any shape, which may be infinite. Raises InputError."""
    return _numbers_so(name, value, lambda found: found >= 0.0, "0 or above")


def _numbers_so(name: str, value: ArrayLike, holds: Callable[[Floats], NDArray[np.bool_]], should: str) -> Floats:
    found = numbers(name, value)
    if not holds(found).all():
        raise InputError.at(name, short_repr(value), f"should be {should}")
    return found


def numbers(name: str, value: ArrayLike) -> Floats:
    """Numbers of any shape. Raises InputError."""
    try:
        found = np.asarray(value, np.float64)
    except (TypeError, ValueError, OverflowError):
        raise InputError.at(name, short_repr(value), "should be a number, or an array of numbers") from None
    if np.isnan(found).any():
        raise InputError.at(name, short_repr(value), "should have no NaN in it")
    return found


def count(name: str, value: Any, least: int = 1, most: int | None = None) -> int:
    """A whole number in a range. Raises InputError."""
    try:
        found = whole(name, value)
    except ValueError as error:
        raise InputError(str(error), key=name, value=value) from None
    if found < least or (most is not None and found > most):
        reach = f"from {least}" if most is None else f"from {least} to {most:,}"
        raise InputError.at(name, found, f"should be {reach}")
    return found


def times(name: str, value: int | Sequence[int] | NDArray[Any]) -> tuple[list[int], bool]:
    """A list of one or several whole numbers from 1 on, and whether a single one was given. Raises InputError."""
    single = np.ndim(value) == 0
    given: list[Any] = [value] if single else list(value)  # type: ignore[arg-type]
    if not given:
        raise InputError(f"{name} = []: should hold a number", key=name)
    return [count(name, one) for one in given], single


def sensors(b: ArrayLike, w: ArrayLike | None) -> tuple[Floats, Floats]:
    """Accuracies b and w, broadcast to one shape; w is b by default. Raises InputError."""
    black = shares("b", b)
    black, white = fitting(b=black, w=black if w is None else shares("w", w))
    return black, white


def fitting(**given: Floats) -> tuple[Floats, ...]:
    """These arrays, broadcast to one shape. Raises InputError, naming them."""
    try:
        return tuple(np.broadcast_arrays(*given.values()))
    except ValueError:
        shapes = ", ".join(f"{name} {one.shape}" for name, one in given.items()).replace(" ", " has the shape ", 1)
        raise InputError(f"{shapes}: should be one shape, or a number", key=next(iter(given))) from None


def misshapen(name: str, value: Floats, should: str) -> InputError:
    """The error of an array of a wrong shape."""
    return InputError(f"{name} has the shape {value.shape}: should be {should}", key=name)
