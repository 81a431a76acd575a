"""Times with a unit, such as "17 min", and their conversion to ticks, the time steps of moving robots."""

import math
import re
from dataclasses import dataclass
from typing import Annotated, Any

from pydantic import BeforeValidator

from swarmcensus.support.toml_types import OrElse

UNITS = {"s": 1.0, "min": 60.0, "h": 3600.0}
WRITTEN = r"\s*(\d+(?:\.\d*)?(?:[eE][+-]?\d+)?)\s*(s|min|h)\s*"
NEAR = 1e-9  # relative: a number of ticks this near to a whole one is whole
MOST = 2**31 - 1


@dataclass(frozen=True)
class Time:
    """A time in a study: a number of seconds, minutes or hours."""

    number: float
    unit: str

    def __str__(self) -> str:
        """As in a study file."""
        return f"{self.number:.12g} {self.unit}"

    def ticks(self, tick: float, least: int = 1) -> int:
        """The number of ticks of `tick` seconds. Raises ValueError, naming the nearest, unless it is whole."""
        count = self.number * UNITS[self.unit] / tick
        if not count <= MOST:
            raise ValueError(f"that is {count:.3g} ticks: {MOST:,} at the most")
        whole = round(count)
        if whole >= least and abs(count - whole) <= min(NEAR * count, 1e-3):
            return whole
        around = sorted({max(least, math.floor(count)), max(least, math.ceil(count))})
        near = " or ".join(f'"{Time(n * tick / UNITS[self.unit], self.unit)}" ({n})' for n in around)
        kind = "whole number" if least <= 1 else f"whole number from {least}"
        raise ValueError(f"that is {count:.6g} ticks of {tick:g} s: should be a {kind}, such as {near}")


def parse_time(text: "str | Time") -> Time:
    """Read a time such as "90 s", "17 min" or "1.5 h". Raises ValueError."""
    if isinstance(text, Time):
        return text
    match = re.fullmatch(WRITTEN, text)
    if match is None:
        raise ValueError('should be a whole number, or a time such as "17 min" (s, min or h)')
    return Time(float(match[1]), match[2])


WrittenTime = Annotated[Time, BeforeValidator(parse_time)]
OR_TIME = OrElse(WrittenTime, str, Time)  # a whole number, or a time until its ticks are known


def in_ticks(value: Any, tick: float | None, key: str, least: int = 1) -> int:
    """A time in ticks; a whole number is returned as it is. `tick` is None for studies that count rounds.

    Raises ValueError unless a time is a whole number of ticks, at least `least`.
    """
    if not isinstance(value, Time):
        return int(value)
    if tick is None:
        raise ValueError(f'{key} = "{value}": the rounds of fixed networks have no clock: should be a whole number')
    try:
        return value.ticks(tick, least)
    except ValueError as error:
        raise ValueError(f'{key} = "{value}": {error}') from None
