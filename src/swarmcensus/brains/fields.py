"""What a robot keeps under a name: a number, or a vector, which is a fixed number of them."""

import math
from collections.abc import Mapping
from typing import Any, NoReturn

from swarmcensus.basics import safe_source

Value = float | tuple[float, ...]
LONGEST = 4096  # numbers of a vector
LARGEST = 1e300


class Vector(list[float]):
    """A vector in CPython: a list of which only single items are read and set, as a compiled one's are."""

    __slots__ = ()

    def _no(self, *_: object) -> NoReturn:
        raise TypeError("a vector is as long as it is: its items are read and set one by one")

    append = extend = insert = pop = remove = clear = sort = reverse = _no  # type: ignore[assignment]
    __delitem__ = __add__ = __iadd__ = __mul__ = __imul__ = __rmul__ = _no  # type: ignore[assignment]

    def __getitem__(self, place: Any) -> Any:
        """One item."""
        return self._no() if isinstance(place, slice) else super().__getitem__(place)

    def __setitem__(self, place: Any, value: Any) -> None:
        """Set one item."""
        if isinstance(place, slice):
            self._no()
        super().__setitem__(place, value)


class Fixed(tuple[float, ...]):
    """A parameter's vector in CPython: of a compiled one, too, only single items are read."""

    __slots__ = ()

    def _no(self, *_: object) -> NoReturn:
        raise TypeError("a parameter is only for reading: the items of its vector are read one by one")

    __add__ = __radd__ = __mul__ = __rmul__ = _no  # type: ignore[assignment]

    def __getitem__(self, place: Any) -> Any:
        """One item."""
        return self._no() if isinstance(place, slice) else super().__getitem__(place)


def value_of(given: object) -> Value:
    """A number, or a vector, as floats. Raises ValueError, which says what it is not."""
    if isinstance(given, list | tuple):
        if not 1 <= len(given) <= LONGEST:
            raise ValueError(f"a vector of {len(given):,}: it should have 1 to {LONGEST:,} numbers")
        return tuple(_number(one, f", as item {k}") for k, one in enumerate(given))
    return _number(given)


def _number(given: object, where: str = "") -> float:
    if not isinstance(given, int | float) or isinstance(given, bool) or math.isnan(given):
        raise ValueError(f"not a number{where}")
    if not abs(given) < LARGEST:
        raise ValueError(f"too large{where}: numbers are below {LARGEST:g}")
    return float(given)


def length(value: Value) -> int:
    """How many numbers a vector has; 0 for what is no vector."""
    return len(value) if isinstance(value, tuple) else 0


def slots(fields: Mapping[str, int]) -> list[str]:
    """The numbers that fields of these lengths are made of, as "t" or "belief[3]"."""
    return [place for name, long in fields.items() for place in places(name, long)]


def places(name: str, long: int) -> list[str]:
    """The same of one field."""
    return [f"{name}[{k}]" for k in range(long)] or [name]


def numbers(values: Mapping[str, Value]) -> list[float]:
    """The numbers themselves, in that order."""
    return [x for value in values.values() for x in (value if isinstance(value, tuple) else (value,))]


def fields_of(given: Any, what: str, taken: tuple[str, ...]) -> dict[str, Value]:
    """What a brain file says under MEMORY or PARAMETERS. Raises ValueError."""
    fields = {}
    for key, value in given.items():
        if not safe_source.is_name(key):
            raise ValueError(f"{what} key {key!r} is not a name")
        if key in taken:
            raise ValueError(f"{what} key {key!r} is taken by the engine")
        try:
            fields[key] = value_of(value)
        except ValueError as error:
            raise ValueError(f"{what}[{key!r}] = {value!r}: {error}") from None
    return fields
