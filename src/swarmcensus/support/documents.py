"""The JSON documents that commands print with --json."""

import dataclasses
import json
import math
from collections.abc import Mapping
from typing import Any

import numpy as np

INFINITY = "infinity"  # JSON has no such number


def document(kind: str, content: Mapping[str, Any], ascii_only: bool = False) -> str:
    """One JSON document: its `format`, such as "swarmcensus summary 1", and then the entries of `content`.

    JSON is UTF-8, whatever the encoding of a stream: with `ascii_only`, other letters are escaped, so that both agree.
    """
    entries = {"format": f"swarmcensus {kind} 1", **json_value(content)}
    return json.dumps(entries, indent=1, allow_nan=False, ensure_ascii=ascii_only)


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
