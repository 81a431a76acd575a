"""JSON documents for programs: all that commands print with --json has this one shape."""

import dataclasses
import json
import math
from collections.abc import Mapping
from typing import Any

import numpy as np

NEVER = "infinity"  # in JSON, which has no such number


def document(kind: str, about: Mapping[str, Any]) -> str:
    """One document: its `format`, as "swarmcensus summary 1", and then what it is about, as `plain` has it."""
    whole = {"format": f"swarmcensus {kind} 1", **json_value(about)}
    return json.dumps(whole, indent=1, allow_nan=False, ensure_ascii=False)


def json_value(value: Any) -> Any:
    """A value as JSON takes it: None for a missing number, "infinity" or "-infinity" in words, records as objects.

    Records are dataclasses, named tuples and mappings; arrays, tuples and sets are lists; whatever else is text.
    """
    if isinstance(value, np.ndarray | np.generic):
        value = value.tolist()
    if isinstance(value, float):
        return f"{'-' * (value < 0)}{NEVER}" if math.isinf(value) else None if math.isnan(value) else value
    if value is None or isinstance(value, bool | int | str):
        return value
    if dataclasses.is_dataclass(value) and not isinstance(value, type):
        return {one.name: json_value(getattr(value, one.name)) for one in dataclasses.fields(value)}
    if isinstance(value, tuple) and hasattr(value, "_asdict"):
        return json_value(value._asdict())
    if isinstance(value, Mapping):
        return {str(key): json_value(one) for key, one in value.items()}
    if isinstance(value, list | tuple | set | frozenset):
        return [json_value(one) for one in value]
    return str(value)
