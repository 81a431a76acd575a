"""What a value may look like in a file beside what its type says: one value for a list; and JSON schemas of it."""

from collections.abc import Callable
from typing import Annotated, Any, TypeVar

from pydantic import BeforeValidator, Field

Schema = dict[str, Any]
TEXT: Schema = {"type": "string", "minLength": 1}


class Form:
    """A mark in an `Annotated` type: its JSON schema, made of that of the type inside, which is asked for if needed."""

    def __init__(self, made: Callable[[Callable[[], Schema]], Schema]) -> None:
        """Keep what makes the schema; it is called when one is asked for."""
        self.made = made

    def __get_pydantic_json_schema__(self, core: Any, handler: Callable[[Any], Schema]) -> Schema:
        """As pydantic asks for it."""
        return self.made(lambda: handler(core))


def or_else(*others: Schema) -> Form:
    """The type itself, or one of others."""
    return Form(lambda inner: {"anyOf": [inner(), *others]})


def _listed(value: object) -> object:
    return value if isinstance(value, list | tuple) else [value]


def _one_or_several(inner: Callable[[], Schema]) -> Schema:
    several = inner()
    return {"anyOf": [several["items"], several]}


T = TypeVar("T")
LISTED, ONE_OR_SEVERAL = BeforeValidator(_listed), Form(_one_or_several)  # of a list that may be its one value
Several = Annotated[list[T], LISTED, Field(min_length=1), ONE_OR_SEVERAL]
# a number of robots, or a fraction of them
ROBOTS = Form(lambda _: {"anyOf": [{"type": "integer", "minimum": 0}, {"type": "number", "minimum": 0, "maximum": 1}]})
