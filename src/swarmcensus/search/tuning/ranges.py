"""Ranges in which parameters are searched; every value of a range has a position in [0, 1]."""

import math
import re
from collections.abc import Iterable
from dataclasses import dataclass, replace
from typing import Literal, TypeVar

from swarmcensus.brains import Program, length
from swarmcensus.support.hints import did_you_mean
from swarmcensus.support.options import wrong_option

Scale = Literal["linear", "log", "whole"]
One = TypeVar("One", bound=Program)
FORM = re.compile(r"\s*(\w+)(?:\[(\d{1,6})\])?\s*=([^:]+):([^:]+)(?::(linear|log|whole))?\s*")
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
    """Read ranges of a program's parameters; that of a whole vector becomes one for each of its items.

    Raises InputError, naming the text and what would be right.
    """
    items = {name: [*range(length(value))] or [None] for name, value in program.parameters.items()}
    labels = [Range(name, k, 0, 1).label for name, each in items.items() for k in each]
    has = f"the {program.kind} {program.name!r} has {', '.join(labels)}"
    ranges: dict[str, Range] = {}
    for text in [texts] if isinstance(texts, str) else texts:
        try:
            given = _parsed(str(text))
            if given.label not in (*items, *labels):
                raise ValueError(f"there is no {given.label!r}: {did_you_mean(given.label, labels)}{has}")
            for k in items[given.name] if given.item is None else [given.item]:
                one = replace(given, item=k)
                if one.label in ranges:
                    raise ValueError(f"{one.label} is given twice")
                ranges[one.label] = one
        except ValueError as error:
            raise wrong_option("parameters", text, f"{error}") from None
    if not ranges:
        raise wrong_option("parameters", None, f"none is given; {has}")
    return [*ranges.values()]


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
    if not (found := FORM.fullmatch(text)):
        raise ValueError("should be such as prior=1:100, prior=1:100:log, k=1:9:whole or weights[0]=0:1")
    low, high, scale = float(found[3]), float(found[4]), found[5] or "linear"
    if not -LARGEST <= low < high <= LARGEST:
        raise ValueError(f"should be low:high, with low below high, and both at most {LARGEST:g} in size")
    if scale == "log" and low <= 0:
        raise ValueError("on a logarithmic scale both ends should be above 0")
    if scale == "whole" and not (low.is_integer() and high.is_integer()):
        raise ValueError("on a scale of whole numbers both ends should be whole")
    return Range(found[1], None if found[2] is None else int(found[2]), low, high, scale)  # type: ignore[arg-type]
