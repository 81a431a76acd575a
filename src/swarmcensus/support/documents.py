"""Values as JSON can hold them."""

import dataclasses
import math
from collections.abc import Mapping
from typing import Any

import numpy as np

INFINITY = "infinity"  # JSON has no such number


def json_value(value: Any) -> Any:
    """A value that JSON can hold: NaN becomes None, and an infinite number "infinity" or "-infinity".

    Dataclasses, named tuples and mappings become objects; arrays, tuples and sets become lists; other values become
    text.
    """
    if isinstance(value, np.ndarray | np.generic):
        value = value.tolist()
    if isinstance(value, float):
        return f"{'-' * (value < 0)}{INFINITY}" if math.isinf(value) else None if math.isnan(value) else value
    if value is None or isinstance(value, bool | int | str):
        return value
    if dataclasses.is_dataclass(value) and not isinstance(value, type):
        return {field.name: json_value(getattr(value, field.name)) for field in dataclasses.fields(value)}
    if isinstance(value, tuple) and hasattr(value, "_asdict"):
        return json_value(value._asdict())
    if isinstance(value, Mapping):
        return {str(key): json_value(item) for key, item in value.items()}
    if isinstance(value, list | tuple | set | frozenset):
        return [json_value(item) for item in value]
    return str(value)
