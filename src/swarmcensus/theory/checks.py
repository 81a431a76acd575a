"""Arguments of theory, made sure of: one sentence for each that cannot be."""

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from swarmcensus.basics.errors import InputError
from swarmcensus.worlds.graphs import whole

Floats = NDArray[np.float64]
MOST_READINGS = 10_000_000  # whose law is listed count by count
BLIND = 1e-12  # |b + w - 1| below which readings say nothing


def shares(name: str, value: ArrayLike) -> Floats:
    """Numbers from 0 to 1, of any shape. Raises InputError."""
    found = numbers(name, value)
    if not ((found >= 0.0) & (found <= 1.0)).all():
        raise InputError(f"{name} = {_shown(value)}: should be from 0 to 1")
    return found


def positive(name: str, value: ArrayLike) -> Floats:
    """Numbers above 0, of any shape. Raises InputError."""
    found = numbers(name, value)
    if not ((found > 0.0) & np.isfinite(found)).all():
        raise InputError(f"{name} = {_shown(value)}: should be above 0")
    return found


def numbers(name: str, value: ArrayLike) -> Floats:
    """Numbers of any shape. Raises InputError."""
    try:
        found = np.asarray(value, np.float64)
    except (TypeError, ValueError):
        raise InputError(f"{name} = {_shown(value)}: should be a number, or an array of numbers") from None
    if np.isnan(found).any():
        raise InputError(f"{name} = {_shown(value)}: should have no NaN in it")
    return found


def count(name: str, value: Any, least: int = 1, most: int | None = None) -> int:
    """A whole number in a range. Raises InputError."""
    try:
        found = whole(name, value)
    except ValueError as error:
        raise InputError(str(error)) from None
    if found < least or (most is not None and found > most):
        reach = f"from {least}" if most is None else f"from {least} to {most:,}"
        raise InputError(f"{name} = {found}: should be {reach}")
    return found


def times(name: str, value: int | Sequence[int] | NDArray[Any]) -> tuple[list[int], bool]:
    """Whole numbers from 1 on, one or several, and whether it was one. Raises InputError."""
    single = np.ndim(value) == 0
    given: list[Any] = [value] if single else list(value)  # type: ignore[arg-type]
    if not given:
        raise InputError(f"{name} = []: should hold a number")
    return [count(name, one) for one in given], single


def sensors(b: ArrayLike, w: ArrayLike | None) -> tuple[Floats, Floats]:
    """Accuracies b and w, of one shape; w is b where it is not given. Raises InputError."""
    black = shares("b", b)
    white = black if w is None else shares("w", w)
    try:
        black, white = np.broadcast_arrays(black, white)
    except ValueError:
        raise InputError(f"b has the shape {black.shape}, w {white.shape}: should be one shape, or a number") from None
    return black, white


def _shown(value: Any) -> str:
    text = " ".join(repr(value).split())
    return text if len(text) <= 60 else f"{text[:57]}..."
