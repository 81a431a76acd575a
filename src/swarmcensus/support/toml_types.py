"""Types of values in files: pydantic checks a value by its type."""

import functools
import re
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Annotated, Any, Generic, Protocol, TypeAlias, TypeVar, get_args

import numpy as np
from numpy.typing import NDArray
from pydantic import BaseModel, BeforeValidator, ConfigDict, Field, TypeAdapter, ValidationError, WrapValidator
from pydantic_core import ErrorDetails

from swarmcensus.support.errors import StudyError, pydantic_message
from swarmcensus.support.formatting import counted
from swarmcensus.support.hints import did_you_mean
from swarmcensus.support.toml_text import plain, to_toml_value

T = TypeVar("T")


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
    """A table of a file: it has these keys and no others, each with a docstring that says what it means.

    In Python it is made from keywords, with values as in a file, or of NumPy and pandas. Raises InputError.
    """

    model_config = ConfigDict(extra="forbid", frozen=True, arbitrary_types_allowed=True, use_attribute_docstrings=True)

    if not TYPE_CHECKING:  # type checkers make the signature from the fields

        def __init__(self, **values: Any) -> None:
            """Check the values."""
            given = plain(values)
            try:
                super().__init__(**given)
            except ValidationError as error:
                raise table_error(error, type(self).__name__, type(self), given) from None

        def __repr__(self) -> str:
            """The keys that were given, with their values."""
            given = [name for name in type(self).model_fields if name in self.model_fields_set]
            texts = (f"{name}={to_toml_value(getattr(self, name))}" for name in given)
            return f"{type(self).__name__}({', '.join(texts)})"

        __str__ = __repr__

        __init__.__pydantic_base_init__ = True  # within other tables pydantic does not call it


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
        message = pydantic_message(first)
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


class LabelledTable(ValueTable):
    """A value that tables and figures may call by another name."""

    label: Text | None = None


def label_of(table: Mapping[str, Any]) -> str:
    """The label that a table in place of a value gives it, or nothing. Raises ValueError."""
    return read(LabelledTable, {key: table[key] for key in table if key == "label"}, str).label or ""


if TYPE_CHECKING:
    Given = TypeVar("Given", contravariant=True)
    Kept = TypeVar("Kept", covariant=True)

    class Column(Protocol):
        """Values of pandas or xarray."""

        def to_numpy(self) -> Any:
            """The values as an array."""

    class Checked(Generic[Given, Kept]):
        """A key that may be given in several ways, and is kept in one."""

        def __get__(self, table: object, owner: type) -> Kept:
            """What is kept."""

        def __set__(self, table: object, value: Given) -> None:
            """What may be given."""

    Int: TypeAlias = int | np.integer[Any]
    Real: TypeAlias = float | np.integer[Any] | np.floating[Any]
    Many: TypeAlias = T | Sequence[T] | NDArray[Any] | Column


def usual(value: Any) -> Any:
    """A key's default, which has the type that is kept, while type checkers expect the one that is given."""
    return Field(default=value)


# a list, or its only value
LISTED = BeforeValidator(lambda value: value if isinstance(value, list | tuple) else [value])
Several = Annotated[list[T], LISTED, Field(min_length=1)]


def table_error(error: ValidationError, where: str, model: type[BaseModel], given: Any = None) -> StudyError:
    """The first error, with a sentence that names file, key and value, and says what would be right.

    `given` is what was checked: if it has one value in place of a list, the key gets no index.
    """
    first = min(error.errors(), key=lambda e: e["type"] != "extra_forbidden")
    place, key = first["loc"], _key(first["loc"], given)
    more = _others(error.errors(), first, given)
    if first["type"] == "extra_forbidden":
        known = _known_keys(model, place[:-1])
        hint = did_you_mean(str(first["loc"][-1]), known)
        return StudyError.within(where, f"unknown key {key}: {hint}known here: {', '.join(known)}{more}", key)
    if first["type"] == "missing":
        keys = [_key(one["loc"], given) for one in error.errors() if one["type"] == "missing"]
        more = _others([one for one in error.errors() if one["type"] != "missing"], first, given)
        what = f"{key} is" if len(keys) == 1 else f"{', '.join(keys[:-1])} and {keys[-1]} are"
        return StudyError.within(where, f"{what} missing{more}", key)
    message = pydantic_message(first)
    value = first["input"]
    right = r"should be a \1, or a dictionary" if isinstance(value, BaseModel) else "should be a table"
    message = re.sub(r"should be a valid dictionary or instance of (\w+)", right, message)
    message = message.replace("should be a valid dictionary", "should be a table")
    if not key:  # of a check of several values, which names one
        cause = first.get("ctx", {}).get("error")
        named = (cause.key, cause.value) if isinstance(cause, StudyError) else ()
        return StudyError.within(where, message + more, *named)
    if isinstance(value, str):  # a brain's error names it too
        message = re.sub(rf"^\w+ {re.escape(repr(value))}: ", "", message)
    shown = to_toml_value(value) if isinstance(value, str | int | float | list | dict) else repr(value)
    if hasattr(value, "nodes"):  # of networkx
        shown = f"graph {value.name!r}" if getattr(value, "name", "") else "a graph"
    return StudyError.within(where, f"{key} = {shown[:200]}: {message}{more}", key, value)


def _others(errors: Iterable[ErrorDetails], first: ErrorDetails, given: Any) -> str:
    """How many errors there are besides the first one, and of which keys; empty if there are none."""
    kinds = {"missing": "is missing", "extra_forbidden": "is unknown"}
    other = [f"{_key(one['loc'], given)} {kinds.get(one['type'], 'is wrong')}" for one in errors if one != first]
    listed = ", ".join(other[:3]) + ", ..." * (len(other) > 3)
    return f"; {counted(len(other), 'more error')}: {listed}" if other else ""


def _key(place: tuple[int | str, ...], given: Any) -> str:
    """The key at a place of a study: world.topology[1].k."""
    return "".join(f"[{p}]" if isinstance(p, int) else f".{p}" for p in _as_given(place, given)).lstrip(".")


def _as_given(place: tuple[int | str, ...], given: Any) -> Iterator[int | str]:
    for part in place:
        if isinstance(part, int) and given is not None and not isinstance(given, list | tuple):
            continue
        yield part
        try:
            given = given[part]
        except (TypeError, KeyError, IndexError):
            given = None


def _known_keys(model: type[BaseModel], path: tuple[int | str, ...]) -> list[str]:
    for part in (part for part in path if isinstance(part, str)):
        field = model.model_fields[part]
        others = [mark.other for mark in field.metadata if isinstance(mark, OrElse)]
        kinds = (field.annotation, *get_args(field.annotation), *others)
        model = next(k for k in kinds if isinstance(k, type) and issubclass(k, BaseModel))
    return list(model.model_fields)
