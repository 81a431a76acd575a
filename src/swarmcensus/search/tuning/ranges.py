"""Ranges in which parameters are searched; every value of a range has a position in [0, 1]."""

import math
import re
from collections.abc import Iterable
from dataclasses import dataclass, replace
from typing import Literal, TypeVar, get_args

from swarmcensus.brains import Program, length
from swarmcensus.support.hints import did_you_mean
from swarmcensus.support.options import wrong_option

Scale = Literal["linear", "log", "whole"]
One = TypeVar("One", bound=Program)
FORM = "should be such as prior=1:100, prior=1:100:log or prior=1:100:whole"
PLACE = re.compile(r"(\w+)(?:\[(\d{1,6})\])?")
DIGITS = 5  # significant digits of a value, or of a linear range's width: a search is not more precise
LARGEST = 1e100


@dataclass(frozen=True)
class Range:
    """The values that a parameter, or one item of a vector, may take."""

    name: str
    item: int | None  # the index, if the parameter is a vector
    low: float
    high: float
    scale: Scale = "linear"

    @property
    def label(self) -> str:
        """The parameter or item, such as "prior" or "weights[0]"."""
        return self.name if self.item is None else f"{self.name}[{self.item}]"

    def __str__(self) -> str:
        """The range as it is given, such as "prior=1:100:log"."""
        scale = "" if self.scale == "linear" else f":{self.scale}"
        return f"{self.label}={self.low:.15g}:{self.high:.15g}{scale}"

    def value(self, share: float) -> float:
        """The value at a position in [0, 1], rounded to `DIGITS`."""
        if self.scale == "whole":
            count = self.high - self.low + 1
            return self.low + min(math.floor(share * count), count - 1)
        if self.scale == "log":
            value = float(f"{self.low * (self.high / self.low) ** share:.{DIGITS}g}")
        else:
            width = self.high - self.low
            value = round(self.low + share * width, DIGITS - 1 - math.floor(math.log10(width)))
        return min(max(value, self.low), self.high)

    def share(self, value: float) -> float:
        """The position of a value in [0, 1]; a value outside the range has the position of the nearest end."""
        value = min(max(value, self.low), self.high)
        if self.scale == "whole":
            return (round(value) - self.low + 0.5) / (self.high - self.low + 1)
        if self.scale == "log":
            return math.log(value / self.low) / math.log(self.high / self.low)
        return (value - self.low) / (self.high - self.low)

    @property
    def step(self) -> float:
        """The distance between the positions of two whole numbers; 0 for other scales."""
        return 1 / (self.high - self.low + 1) if self.scale == "whole" else 0.0


def ranges_of(texts: Iterable[str], program: Program) -> list[Range]:
    """Read ranges of a program's parameters. Raises InputError, naming the text and what would be right."""
    ranges: list[Range] = []
    for text in [texts] if isinstance(texts, str) else texts:
        try:
            for parameter in _items(_parsed(str(text)), program):
                if parameter.label in [earlier.label for earlier in ranges]:
                    raise ValueError(f"{parameter.label} is given twice")
                ranges.append(parameter)
        except ValueError as error:
            raise wrong_option("parameters", text, f"{error}") from None
    if not ranges:
        raise wrong_option(
            "parameters", None, f"none is given; the {program.kind} {program.name!r} has {_names(program)}"
        )
    return ranges


def start_of(ranges: Iterable[Range], program: Program) -> tuple[float, ...]:
    """The program's present values of these parameters."""
    places = [(program.parameters[parameter.name], parameter.item or 0) for parameter in ranges]
    return tuple(value[item] if isinstance(value, tuple) else value for value, item in places)


def with_values(program: One, ranges: Iterable[Range], values: Iterable[float]) -> One:
    """The program with these values of the parameters; all others stay."""
    changed = dict(program.parameters)
    for parameter, value in zip(ranges, values, strict=True):
        old, k = changed[parameter.name], parameter.item or 0
        changed[parameter.name] = (*old[:k], value, *old[k + 1 :]) if isinstance(old, tuple) else value
    return program.with_parameters(changed)


def _parsed(text: str) -> Range:
    place, equals, rest = text.partition("=")
    parts, named = rest.split(":"), PLACE.fullmatch(place.strip())
    if not (equals and named and len(parts) in (2, 3)):
        raise ValueError(FORM)
    scale = parts[2].strip() if len(parts) == 3 else "linear"
    if scale not in get_args(Scale):
        raise ValueError(f"{did_you_mean(scale, get_args(Scale))}a range is log, whole or, with neither, linear")
    low, high = (_number(part) for part in parts[:2])
    if not low < high:
        raise ValueError("the range is empty: it should be low:high, with low below high")
    if scale == "log" and low <= 0:
        raise ValueError("on a logarithmic scale both ends should be above 0")
    if scale == "whole" and not (low.is_integer() and high.is_integer()):
        raise ValueError("on a scale of whole numbers both ends should be whole")
    return Range(named[1], None if named[2] is None else int(named[2]), low, high, scale)  # type: ignore[arg-type]


def _number(text: str) -> float:
    try:
        number = float(text)
    except ValueError:
        raise ValueError(FORM) from None
    if not abs(number) <= LARGEST:
        raise ValueError(f"{text.strip()} should be at most {LARGEST:g} in size")
    return number


def _names(program: Program) -> str:
    lengths = {name: length(value) for name, value in program.parameters.items()}
    return ", ".join(f"{name}[0] to {name}[{long - 1}]" if long else name for name, long in lengths.items())


def _items(parameter: Range, program: Program) -> list[Range]:
    """The range itself; a range of a whole vector becomes one for each of its items. Raises ValueError."""
    if parameter.name not in program.parameters:
        hint = did_you_mean(parameter.name, program.parameters)
        raise ValueError(
            f"the {program.kind} {program.name!r} has no parameter {parameter.name!r}: {hint}it has {_names(program)}"
        )
    long = length(program.parameters[parameter.name])
    if parameter.item is None:
        return [replace(parameter, item=k) for k in range(long)] or [parameter]
    if not long:
        raise ValueError(f"{parameter.name} is a number, and has no items")
    if parameter.item >= long:
        raise ValueError(
            f"{parameter.name} is a vector of {long}: its items are {parameter.name}[0] to {parameter.name}[{long - 1}]"
        )
    return [parameter]
