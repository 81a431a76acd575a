"""The fields of a robot's memory: each is a number, or a vector, which is a fixed number of numbers."""

import math
import unicodedata
from collections.abc import Mapping
from typing import Any, ClassVar, NoReturn

from swarmcensus.support import safe_source

Value = float | tuple[float, ...]
LONGEST = 4096  # items of a vector
LARGEST = 1e300


class _Rigid:
    """A list or tuple of which only single items are used in CPython, as in compiled code."""

    __slots__ = ()
    why: ClassVar[str]

    def _no(self, *_: object) -> NoReturn:
        raise TypeError(self.why)

    __add__ = __mul__ = __rmul__ = _no

    def __getitem__(self, place: Any) -> Any:
        """One item."""
        return self._no() if isinstance(place, slice) else super().__getitem__(place)  # type: ignore[misc]


class Vector(_Rigid, list[float]):  # type: ignore[misc]
    """A vector in CPython: a list of which items can only be read and set one by one, as in compiled code."""

    __slots__ = ()
    why = "a vector has a fixed length: its items are read and set one by one"
    append = extend = insert = pop = remove = clear = sort = reverse = _Rigid._no  # type: ignore[assignment]
    __delitem__ = __iadd__ = __imul__ = _Rigid._no  # type: ignore[assignment]

    def __setitem__(self, place: Any, value: Any) -> None:
        """Set one item."""
        if isinstance(place, slice):
            self._no()
        super().__setitem__(place, value)


class Fixed(_Rigid, tuple[float, ...]):  # type: ignore[misc]
    """A vector parameter in CPython: a tuple whose items can only be read one by one, as in compiled code."""

    __slots__ = ()
    why = "a parameter is read-only, and the items of its vector are read one by one"
    __radd__ = _Rigid._no


def value_of(given: object) -> Value:
    """A number or a vector as floats. Raises ValueError, which says what is wrong."""
    if isinstance(given, list | tuple):
        if not 1 <= len(given) <= LONGEST:
            raise ValueError(f"a vector of {len(given):,}: it should have 1 to {LONGEST:,} numbers")
        return tuple(_number(item, f", as item {k}") for k, item in enumerate(given))
    return _number(given)


def _number(given: object, where: str = "") -> float:
    if not isinstance(given, int | float) or isinstance(given, bool) or math.isnan(given):
        raise ValueError(f"not a number{where}")
    if not abs(given) < LARGEST:
        raise ValueError(f"too large{where}: numbers are below {LARGEST:g}")
    return float(given)


def length(value: Value) -> int:
    """The number of items of a vector; 0 for a number."""
    return len(value) if isinstance(value, tuple) else 0


def slots(fields: Mapping[str, int]) -> list[str]:
    """The names of all numbers of fields of these lengths, such as "t" or "belief[3]"."""
    return [place for name, items in fields.items() for place in places(name, items)]


def places(name: str, items: int) -> list[str]:
    """The names of the numbers of one field; `items` is the length of its vector, 0 for a number."""
    return [f"{name}[{k}]" for k in range(items)] or [name]


def numbers(values: Mapping[str, Value]) -> list[float]:
    """The values of all numbers of fields, in the order of `slots`."""
    return [x for value in values.values() for x in (value if isinstance(value, tuple) else (value,))]


def fields_of(given: Any, what: str, taken: tuple[str, ...]) -> dict[str, Value]:
    """Check the fields of MEMORY, PARAMETERS or MESSAGE; `taken` are reserved names. Raises ValueError."""
    fields = {}
    for key, value in given.items():
        if not safe_source.is_name(key):
            raise ValueError(f"{what} key {key!r} is not a name")
        if key.startswith("__"):
            raise ValueError(f"{what} key {key!r}: names that begin with __ belong to Python")
        if (plain := unicodedata.normalize("NFKC", key)) != key:
            raise ValueError(f"{what} key {key!r} is written {plain!r} in Python's names")
        if key in taken:
            raise ValueError(f"{what} key {key!r} is reserved: choose another name than {', '.join(taken)}")
        try:
            fields[key] = value_of(value)
        except ValueError as error:
            raise ValueError(f"{what}[{key!r}] = {value!r}: {error}") from None
    return fields
