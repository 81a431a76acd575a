"""TOML text: read, and written from tables with all values that a study may have."""

import json
import re
import tomllib
from collections.abc import Iterable, Mapping
from typing import Any

import numpy as np
from pydantic import BaseModel

from swarmcensus.support.errors import StudyError

PART = r"""(?:[\w-]+|"(?:[^"\\\n]|\\.){0,100}"|'[^'\n]{0,100}')"""  # of a key; longer ones cannot be so many
DOTTED = re.compile(rf"(?<![\w-])(?:{PART}[ \t]*\.[ \t]*){{32}}")  # TOML's parser takes memory by its length squared
DEEPEST = 32  # tables and lists within each other
MOST_BITS = 10_000  # of a number that is printed in decimal digits


def read_toml(text: str, where: str) -> dict[str, Any]:
    """Parse TOML. Raises InputError."""
    try:
        if DOTTED.search(text):
            raise RecursionError
        tables = tomllib.loads(text)
        level: list[Any] = [tables]
        for _ in range(DEEPEST):
            level = [value for one in level for value in (one.values() if isinstance(one, dict) else one)]
            level = [value for value in level if isinstance(value, dict | list)]
        if level:
            raise RecursionError
        return tables
    except tomllib.TOMLDecodeError as error:
        why = str(error).replace("Cannot overwrite a value", "a key is given twice")  # Python's words name no key
        raise StudyError.within(where, f"not TOML: {why}") from None
    except RecursionError:
        raise StudyError.within(where, f"its keys, tables or lists are nested over {DEEPEST} deep") from None
    except ValueError:  # Python's limit
        raise StudyError.within(where, "a whole number has too many digits") from None


def to_toml(data: Mapping[str, Any]) -> str:
    """A study's tables as TOML text."""
    tables = {k: v for k, v in data.items() if isinstance(v, Mapping | BaseModel)}
    lines = [f"{_key(k)} = {to_toml_value(v)}" for k, v in data.items() if k not in tables]
    for key, table in tables.items():
        lines += ["", f"[{_key(key)}]", *(f"{_key(k)} = {to_toml_value(v)}" for k, v in _fields(table).items())]
    return "\n".join(lines) + "\n"


def plain(value: Any) -> Any:
    """A study's tables with lists for ranges, tuples and arrays, and Python's own numbers for those of NumPy."""
    value = value.to_numpy() if hasattr(value, "to_numpy") else value  # of pandas and xarray
    if isinstance(value, np.ndarray | np.generic):
        return value.tolist()
    if isinstance(value, Mapping):
        edges = value.get("edges")  # any iterable; `edges_of` checks them
        if isinstance(edges, Iterable) and not isinstance(edges, str | np.ndarray):
            edges = list(edges)
        return {k: edges if k == "edges" else plain(v) for k, v in value.items()}
    return [plain(v) for v in value] if isinstance(value, list | tuple | range) else value


def _fields(table: Mapping[str, Any] | BaseModel) -> dict[str, Any]:
    """The keys of a table that were given, with their values."""
    pairs = ((k, v) for k, v in table if k in table.model_fields_set) if isinstance(table, BaseModel) else table.items()
    return {k: v for k, v in pairs if v is not None}


def _key(key: str) -> str:
    return key if re.fullmatch(r"[A-Za-z0-9_-]+", key) else to_toml_value(key)


def to_toml_value(value: Any) -> str:
    """One value in TOML."""
    if isinstance(value, np.generic):
        value = value.item()
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, int | float):
        return hex(value) if isinstance(value, int) and value.bit_length() >= MOST_BITS else repr(value)
    if isinstance(value, Mapping | BaseModel):
        return "{" + ", ".join(f"{_key(k)} = {to_toml_value(v)}" for k, v in _fields(value).items()) + "}"
    if isinstance(value, list | tuple | np.ndarray):
        return "[" + ", ".join(map(to_toml_value, value)) + "]"
    if hasattr(value, "form"):  # of a brain, an accuracy, a floor ...: what a file has in its place
        return to_toml_value(value.form)
    # TOML escapes what JSON does, and one control character more
    return json.dumps(str(value), ensure_ascii=False).replace("\x7f", "\\u007f")
