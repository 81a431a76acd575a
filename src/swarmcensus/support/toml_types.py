"""Types of values in files: pydantic checks a value by its type, and makes the JSON schema from the same type."""

import functools
from collections.abc import Callable, Mapping
from typing import Annotated, Any, TypeVar

from pydantic import BaseModel, BeforeValidator, ConfigDict, Field, TypeAdapter, ValidationError, WrapValidator

from swarmcensus.support.errors import pydantic_message
from swarmcensus.support.hints import did_you_mean
from swarmcensus.support.plugins import Plugins

Schema = dict[str, Any]
T = TypeVar("T")


class Form:
    """A mark in an `Annotated` type that replaces its JSON schema."""

    def __init__(self, schema: Callable[[Callable[[], Schema]], Schema]) -> None:
        """Keep `schema`, which makes the new schema from a function that returns the schema of the inner type."""
        self.schema = schema

    def __get_pydantic_json_schema__(self, core: Any, handler: Callable[[Any], Schema]) -> Schema:
        """The schema, as pydantic calls for it."""
        return self.schema(lambda: handler(core))


def any_of(*types: Any) -> Form:
    """A mark for a value that a parser reads from one of these types: the schema is theirs."""
    return Form(lambda _: {"anyOf": [TypeAdapter(one).json_schema() for one in types]})


def name_in(*kinds: Plugins) -> Form:
    """A mark for the name of a plugin, or the path of a file. A misspelt name is neither: it has no dot or slash."""
    path = {"type": "string", "pattern": r"[./\\]"}
    return Form(lambda _: {"anyOf": [{"enum": [name for plugins in kinds for name in plugins.names]}, path]})


class OrElse:
    """A mark in an `Annotated` type: values of the classes `when` are checked as another type instead."""

    def __init__(self, other: Any, *when: type) -> None:
        """Keep the other type, and the classes of values that are checked as it."""
        self.other, self.when = other, when

    @functools.cached_property
    def adapter(self) -> TypeAdapter[Any]:
        """The validator of the other type, built on first use."""
        return TypeAdapter(self.other)

    def __get_pydantic_core_schema__(self, source: Any, handler: Callable[[Any], Any]) -> Any:
        """The validator, as pydantic calls for it."""
        from pydantic_core import core_schema

        def check(value: object, itself: Callable[[Any], Any]) -> Any:
            return self.adapter.validate_python(value) if isinstance(value, self.when) else itself(value)

        return core_schema.no_info_wrap_validator_function(check, handler(source))

    def __get_pydantic_json_schema__(self, core: Any, handler: Callable[[Any], Schema]) -> Schema:
        """The schema, as pydantic calls for it."""
        return {"anyOf": [handler(core), self.adapter.json_schema()]}


def says(message: str, *words: str) -> WrapValidator:
    """A mark in an `Annotated` type: its error message, with a hint if a text is like one of `words`."""

    def check(value: object, itself: Callable[[Any], Any]) -> Any:
        try:
            return itself(value)
        except ValidationError:
            hint = did_you_mean(value, words) if isinstance(value, str) else ""
            raise ValueError(f"{hint}{message}") from None

    return WrapValidator(check)


class TomlTable(BaseModel):
    """A table of a file: it has these keys and no others, each with a docstring that the schema shows."""

    model_config = ConfigDict(extra="forbid", frozen=True, arbitrary_types_allowed=True, use_attribute_docstrings=True)


class ValueTable(TomlTable):
    """A table in place of one value, as {from = 0.9, to = 0.1, at = 500}. Its validator is built on first use."""

    model_config = ConfigDict(use_attribute_docstrings=False, defer_build=True)


M = TypeVar("M", bound=ValueTable)


def read(
    model: type[M],
    given: Mapping[str, Any],
    right: Callable[[], str],
    known: tuple[str, ...] = (),
    context: Mapping[str, Any] = {},
) -> M:
    """Check a table in place of a value. Raises ValueError; for an unknown or missing key it says what is `right`.

    `known` are the keys for hints, if the value may also be a table of another form; `context` is for validators.
    """
    try:
        return model.model_validate(dict(given), context=dict(context))
    except ValidationError as error:
        first = min(error.errors(), key=lambda e: e["type"] != "extra_forbidden")
        key = str(first["loc"][0])
        if first["type"] == "extra_forbidden":
            names = known or [field.alias or name for name, field in model.model_fields.items()]
            raise ValueError(f"unknown key {key}: {did_you_mean(key, names)}{right()}") from None
        if first["type"] == "missing":
            raise ValueError(f"{key} is missing: {right()}") from None
        message = pydantic_message(first["msg"])
        raise ValueError(f"{key}{'' if message.startswith('should') else ':'} {message}") from None


def _plain_number(value: object) -> object:
    if isinstance(value, bool):
        raise ValueError("a number is wanted, not a truth value")
    if isinstance(value, str):  # pydantic would read a number from it
        raise ValueError("a number is wanted, not a text")
    return value


Number = Annotated[float, BeforeValidator(_plain_number)]
Share = Annotated[Number, Field(ge=0.0, le=1.0)]
Text = Annotated[str, Field(min_length=1), says("should be a text, and not empty")]
Robots = Annotated[
    Annotated[int, Field(strict=True, ge=0)] | Annotated[float, Field(strict=True, ge=0.0, le=1.0)],
    says("should be a whole number of robots, or a fraction of the swarm in [0, 1]"),
]


def _as_list(value: object) -> object:
    return value if isinstance(value, list | tuple) else [value]


LISTED = BeforeValidator(_as_list)  # a list, or its only value
ONE_OR_SEVERAL = Form(lambda inner: {"anyOf": [inner()["items"], inner()]})
Several = Annotated[list[T], LISTED, Field(min_length=1), ONE_OR_SEVERAL]
