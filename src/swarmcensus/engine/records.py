"""Records whose fields are attributes in CPython too, whatever their names."""

import functools
from typing import Any

import numpy as np


def record_type(fields: list[tuple[Any, ...]]) -> np.dtype:
    """The type of a record with these fields, as `np.dtype` takes them: `me.size` is the field, if there is one.

    An `np.record` looks for NumPy's own attributes first (`size`, `mean`). Here a number is CPython's `float`: a
    division by zero is an error, as on a robot, and not NumPy's warning.
    """
    return _cached_type(tuple(fields))


@functools.lru_cache(maxsize=256)
def _cached_type(fields: tuple[tuple[Any, ...], ...]) -> np.dtype:
    attributes = {name: _field(name, vector=bool(shape)) for name, _, *shape in fields}
    kind = type("Record", (np.void,), {"__slots__": (), **attributes})
    return np.dtype((kind, list(fields)))


def _field(name: str, vector: bool) -> property:
    def assign(me: Any, value: Any) -> None:
        me[name] = value

    if vector:
        return property(lambda me: me[name], assign)
    return property(lambda me: float(me[name]), assign)
