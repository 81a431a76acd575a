"""Values in place of those of a study's keys: `--set density=2`, or {"world.density": 2} in Python."""

import contextlib
from collections.abc import Collection, Iterator, Mapping
from itertools import combinations
from typing import Any

from pydantic import BaseModel

from swarmcensus.studies.tables import Tables
from swarmcensus.support.errors import StudyError
from swarmcensus.support.formatting import shortened
from swarmcensus.support.hints import did_you_mean
from swarmcensus.support.options import in_shell, option
from swarmcensus.support.toml_text import read_toml, to_toml_value

Path = tuple[str, ...]
REPLACED = {  # keys of which only one may be given
    "density": {"side"}, "side": {"density"}, "error": {"right", "margin"}, "right": {"error"},
}  # fmt: skip
BRAIN: Path = ("swarm", "brain")


def read_value(text: str) -> Any:
    """A value as a study file has it; what is no TOML is a text, so that a single word needs no quotation marks.

    An empty text is None, which takes the key out of the study.

    Raises InputError for a list, a table or a text in quotation marks that is not closed, and for more than a value.
    """
    if not text:
        return None
    what = 'not a value of TOML, such as 2, "a text", [1, 2] or {p = 1}'
    try:
        tables = read_toml(f"value = {text}", "")
    except StudyError as error:
        if text[:1] in "[{\"'" or "\n" in text:
            raise StudyError(f"{text[:200]}: {what}") from error
        return text
    if tables.keys() != {"value"}:
        raise StudyError(f"{text[:200]}: {what}")
    return tables["value"]


def to_text(value: Any) -> str:
    """The text that `read_value` reads as this value: words without quotation marks, and TOML for all else."""
    with contextlib.suppress(StudyError):
        if isinstance(value, str) and value.strip() == value and read_value(value) == value:
            return value
    return to_toml_value(value)


def with_assignments(where: str, values: Any) -> str:
    """What a study is called in messages, with values in place of its own: "study file s.toml with --set robots=3"."""
    items = values.items() if isinstance(values, Mapping) else ()
    given = [shortened(f"{key}={'' if value is None else to_toml_value(value)}") for key, value in items]
    asked = ", ".join(option("set", one) if in_shell() else one for one in given)
    return f"{where} with {asked}" if asked else where


def with_values(tables: Mapping[str, Any], values: Mapping[str, Any]) -> dict[str, Any]:
    """A study's tables with other values of some keys. Raises InputError.

    A key stands in full ("world.density") or, if only one key ends so, by its last part ("density"). A side replaces a
    density, and the other way round; so do an error that is wanted and a right answer. Lists of tables are replaced as
    a whole ("members"). "brain.prior" is a parameter of the study's brain. None takes a key out of the study.
    """
    if not isinstance(values, Mapping) or not all(isinstance(key, str) for key in values):
        raise StudyError(f'{values!r:.200}: should be values by key, such as {{"density": 2}}')
    paths = dict(sorted(((key, _path(key)) for key in values), key=lambda pair: len(pair[1])))
    for (one, path), (other, longer) in combinations(paths.items(), 2):
        if longer[: len(path)] == path and (path != BRAIN or longer == path):
            raise StudyError(f"{one} and {other} are one key: give it once", key=other)
    changed, given = dict(tables), {path[-1] for path in paths.values()}
    for key, (*above, name) in paths.items():
        table = changed
        for part in above:
            below = table.get(part)
            below = {"file": below} if part == "brain" and isinstance(below, str) else below
            table[part] = table = dict(below) if isinstance(below, Mapping) else {}
        if values[key] is None:
            table.pop(name, None)
            continue
        for other in REPLACED.get(name, set()) - given:
            table.pop(other, None)
        table[name] = values[key]
    return changed


def short_key(key: str, taken: Collection[str]) -> str:
    """The shortest name of a key that means no other one and is not `taken`. Raises InputError for an unknown key."""
    path = _path(key)
    for count in range(1, len(path)):
        short = ".".join(path[-count:])
        with contextlib.suppress(StudyError):
            if short not in taken and _path(short) == path:
                return short
    return ".".join(path)


def _path(key: str) -> Path:
    parts = tuple(key.split("."))
    if parts[0] in Tables.model_fields:
        return parts
    known = list(_paths(Tables))
    ends = [path for path in known if path[-len(parts) :] == parts]
    if len(ends) == 1:
        return ends[0]
    if ends:
        raise StudyError(f"{key} may be {' or '.join(map('.'.join, ends))}: say which", key=key)
    if parts[:-1] == BRAIN[1:]:
        return (*BRAIN, parts[-1])
    if parts[1:] and any(path[-len(parts) + 1 :] == parts[:-1] for path in known):
        whole = f"{'.'.join(parts[:-1])} = {{{parts[-1]} = ...}}"
        raise StudyError(f"unknown key {key}: a table in place of a value is given whole, as {whole}", key=key)
    names = list(dict.fromkeys(path[-1] for path in known))
    hint = did_you_mean(key, names) or f"known here: {', '.join(names)}"
    raise StudyError(f"unknown key {key}: {hint.strip()}", key=key)


def _paths(model: type[BaseModel], above: Path = ()) -> Iterator[Path]:
    """The places of all keys that are not in lists of tables."""
    for name, field in model.model_fields.items():
        yield (*above, name)
        if isinstance(field.annotation, type) and issubclass(field.annotation, BaseModel):
            yield from _paths(field.annotation, (*above, name))
