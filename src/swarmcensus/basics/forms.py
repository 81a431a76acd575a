"""Alternative forms of values in study files, such as one value in place of a list, and their JSON schemas."""

from collections.abc import Callable
from typing import Annotated, Any, TypeVar

from pydantic import BeforeValidator, Field

Schema = dict[str, Any]
TEXT: Schema = {"type": "string", "minLength": 1}


class Form:
    """A mark in an `Annotated` type that replaces its JSON schema."""

    def __init__(self, schema: Callable[[Callable[[], Schema]], Schema]) -> None:
        """Keep `schema`, which makes the new schema from a function that returns the schema of the inner type."""
        self.schema = schema

    def __get_pydantic_json_schema__(self, core: Any, handler: Callable[[Any], Schema]) -> Schema:
        """The schema, as pydantic calls for it."""
        return self.schema(lambda: handler(core))


def or_else(*others: Schema) -> Form:
    """A mark for a schema that is the type itself, or one of `others`."""
    return Form(lambda inner: {"anyOf": [inner(), *others]})


def _listed(value: object) -> object:
    return value if isinstance(value, list | tuple) else [value]


def _one_or_several(inner: Callable[[], Schema]) -> Schema:
    several = inner()
    return {"anyOf": [several["items"], several]}


T = TypeVar("T")
LISTED, ONE_OR_SEVERAL = BeforeValidator(_listed), Form(_one_or_several)  # a list, or its only value
Several = Annotated[list[T], LISTED, Field(min_length=1), ONE_OR_SEVERAL]
# a number of robots, or a fraction of them
ROBOTS = Form(lambda _: {"anyOf": [{"type": "integer", "minimum": 0}, {"type": "number", "minimum": 0, "maximum": 1}]})
