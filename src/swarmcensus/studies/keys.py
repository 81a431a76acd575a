"""How a key of a study file is declared: what the program and its pages know of it besides its name and its values.

A declaration stands in the tables of `studies/settings.py`, next to the key's type and default, with its meaning below.
"""

import dataclasses
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, Literal

from pydantic import BaseModel

World = Literal["any", "networks", "moving"]


@dataclass(frozen=True)
class Coordinate:
    """A coordinate of the dataset along `setting`, with how tables, captions and axes call it.

    `caption` formats a value in a caption, by default as "name = value". `idle` is what a caption says of a value that
    says nothing (an empty text, NaN), where that would be missed. `title` names an axis or a key, `plural` several
    values. `counts` is whether its values often span decades. `blank` stands for a setting that has no value, where
    other settings of the study have one. `always` is whether every file has it; others have it where any setting is
    not at the default. `world` is where it means something: elsewhere it is NaN, an empty text or left out. `of` takes
    its value from a setting, None for none; by default the setting's field of that name.
    """

    type: Literal["text", "number", "whole number"]
    page: str  # what docs/data-format.md says
    caption: str = ""
    title: str = ""
    plural: str = ""
    idle: str = ""
    counts: bool = False
    blank: int | str | None = None
    always: bool = False
    world: World | None = None  # None: that of its key
    of: Callable[[Any], object] | None = None
    name: str = ""


@dataclass(frozen=True, kw_only=True)
class Key:
    """A key of a study file. The last five fields are filled in by `keys_of`."""

    coordinate: Coordinate | None = None
    world: World = "any"  # where it has an effect
    instead: str = ""  # what a message adds where it has none
    spans: bool = True  # takes several values, which span the grid
    field: str = ""  # of a setting, if that has another name
    messages: bool = False  # concerns messages alone, so that local estimates do not depend on it
    draws: tuple[str, ...] = ()  # the purposes of random numbers that depend on it
    values: str = ""  # its values and its meaning as docs/study-file.md says them, where that differs from the schema
    page: str = ""
    without: str = ""  # what holds without it, if it has no default
    name: str = ""
    table: str = ""
    default: Any = None
    meaning: str = ""
    is_required: bool = False

    @property
    def is_new(self) -> bool:
        """Whether it is newer than the first studies, so that only other values than the default leave any trace."""
        return self.coordinate is not None and not self.coordinate.always

    def has_effect(self, moves: bool) -> bool:
        """Whether it has an effect on robots that move, or on fixed networks."""
        return self.world in ("any", "moving" if moves else "networks")


def keys_of(tables: Mapping[str, type[BaseModel]], first: tuple[str, ...]) -> dict[str, Key]:
    """The keys that these tables declare, those of `first` in this order, and then the others."""
    found = {}
    for table, model in tables.items():
        for name, field in model.model_fields.items():
            key = next(one for one in field.metadata if isinstance(one, Key))
            default = None if field.is_required() else field.get_default()
            found[name] = dataclasses.replace(
                key,
                name=name,
                table=table,
                field=key.field or name,
                default=default[0] if isinstance(default, list) else default,
                meaning=field.description or "",
                is_required=field.is_required(),
            )
    return {name: found[name] for name in dict.fromkeys([*first, *found])}
