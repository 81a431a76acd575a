"""Values in place of those of a study's keys: `--set density=2`, or `set={"world.density": 2}` in Python."""

from collections.abc import Iterator, Mapping
from typing import Any

from pydantic import BaseModel

from swarmcensus.studies.grids import SIZES
from swarmcensus.studies.tables import Tables
from swarmcensus.support.errors import StudyError
from swarmcensus.support.hints import did_you_mean
from swarmcensus.support.toml_text import read_toml

Path = tuple[str, ...]


def read_value(text: str) -> Any:
    """A value as a study file has it; what is no TOML is a text, so that a single word needs no quotation marks.

    Raises InputError for a list, a table or a text in quotation marks that is not closed.
    """
    try:
        return read_toml(f"value = {text}", "")["value"]
    except StudyError as error:
        if text[:1] in "[{\"'":
            raise StudyError(f'{text[:200]}: not a value of TOML, such as 2, "a text", [1, 2] or {{p = 1}}') from error
        return text


def with_values(tables: Mapping[str, Any], values: Mapping[str, Any]) -> dict[str, Any]:
    """A study's tables with other values of some keys. Raises InputError.

    A key stands in full ("world.density") or, if only one key ends so, by its last part ("density"). A side replaces a
    density, and the other way round. Lists of tables are replaced as a whole ("members").
    """
    changed = dict(tables)
    for key, value in values.items():
        *tables_above, name = _path(key)
        table = changed
        for part in tables_above:
            below = table.get(part)
            table[part] = table = dict(below) if isinstance(below, Mapping) else {}
        if name in SIZES:
            for other in SIZES - values.keys():
                table.pop(other, None)
        table[name] = value
    return changed


def _path(key: str) -> Path:
    parts = tuple(key.split("."))
    if parts[0] in Tables.model_fields:
        return parts
    ends = [path for path in _paths(Tables) if path[-len(parts) :] == parts]
    if len(ends) == 1:
        return ends[0]
    if ends:
        raise StudyError(f"{key} may be {' or '.join(map('.'.join, ends))}: say which", key=key)
    known = list(dict.fromkeys(path[-1] for path in _paths(Tables)))
    raise StudyError(f"unknown key {key}: {did_you_mean(key, known)}known here: {', '.join(known)}", key=key)


def _paths(model: type[BaseModel], above: Path = ()) -> Iterator[Path]:
    """The places of all keys that are not in lists of tables."""
    for name, field in model.model_fields.items():
        yield (*above, name)
        if isinstance(field.annotation, type) and issubclass(field.annotation, BaseModel):
            yield from _paths(field.annotation, (*above, name))
