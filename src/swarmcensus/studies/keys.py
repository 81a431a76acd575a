"""Declarations of keys of a study file: all that the program knows of a key besides its name and values.

Declarations are in the tables of `studies/settings.py`, next to a key's type and default and above its meaning.
"""

import dataclasses
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, Literal

from pydantic import BaseModel

World = Literal["any", "networks", "moving"]
Draws = Literal["readings", "losses", "luck", "luck alone", "floor", "walk"]  # purposes: see `addresses`


@dataclass(frozen=True)
class Coordinate:
    """A coordinate of the dataset along `setting`, with its names in tables, captions and axes."""

    type: Literal["text", "number", "whole number"]
    caption: str = ""  # formats a value in a caption; by default as "name = value"
    title: str = ""  # of an axis or a key of a figure
    plural: str = ""  # several values
    idle: str = ""  # the caption's text for an idle value (an empty text, NaN), if it should have one
    counts: bool = False  # whether its values often span decades
    blank: int | str | None = None  # of a setting without a value, if other settings of the study have one
    unsaid: float | None = None  # the value that lines and tables leave out
    always: bool = False  # whether every file has it; others have it if any setting is not at the default
    world: World | None = None  # where it means something, elsewhere it is NaN or empty; None: the world of its key
    of: Callable[[Any], object] | None = None  # takes it from a setting; by default the field of its name, or its text
    meaning: str = ""  # in files, of a coordinate that follows from another one
    name: str = ""


@dataclass(frozen=True, kw_only=True)
class Key:
    """A key of a study file. The last five fields are filled in by `keys_of`."""

    coordinate: Coordinate | None = None
    world: World = "any"  # where it has an effect
    instead: str = ""  # advice in a message about a key without effect
    spans: bool = True  # takes several values, which span the grid
    field: str = ""  # of a setting, if that has another name
    messages: bool = False  # concerns only messages, so that local estimates do not depend on it
    draws: tuple[Draws, ...] = ()  # the random numbers that depend on it
    name: str = ""
    table: str = ""
    default: Any = None
    meaning: str = ""
    is_required: bool = False

    @property
    def is_new(self) -> bool:
        """Whether it is newer than the first studies, so that addresses contain only values other than the default."""
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
                key, name=name, table=table, field=key.field or name, meaning=field.description or "",
                default=default[0] if isinstance(default, list) else default, is_required=field.is_required(),
            )  # fmt: skip
    return {name: found[name] for name in dict.fromkeys([*first, *found])}
