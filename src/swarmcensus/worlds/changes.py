"""A fill ratio that changes in the midst of a trial: `{from = 0.9, to = 0.1, at = 5000, until = 6000}`."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from typing import Any, Self

import numpy as np
from numpy.typing import ArrayLike, NDArray
from pydantic import WrapValidator

from swarmcensus.basics.hints import did_you_mean
from swarmcensus.basics.times import MOST, Time, in_ticks, parse_time

KEYS = ("from", "to", "at", "until")
LEAST = 2  # in round 1 there is the fill ratio that changes
FORM = "{from = 0.9, to = 0.1, at = 500}, or with until = 600 where it drifts"


@dataclass(frozen=True)
class Change:
    """A fill ratio, `first` before round (or tick) `at` and `last` from round `until` on, that drifts evenly between.

    Of a switch `until` is None. `given` is what it was before times were counted in ticks, for messages.
    """

    first: float
    last: float
    at: int | Time
    until: int | Time | None = None
    given: "Change | None" = field(default=None, compare=False, repr=False)

    def __str__(self) -> str:
        """As in the dataset: "0.9 to 0.1 at 5000"."""
        drifts = "" if self.until is None else f" until {self.until}"
        return f"{self.first} to {self.last} at {self.at}{drifts}"

    @property
    def form(self) -> dict[str, object]:
        """As in a study file."""
        shown = (str(v) if isinstance(v, Time) else v for v in (self.first, self.last, self.at, self.until))
        return {key: value for key, value in zip(KEYS, shown, strict=True) if value is not None}

    def in_ticks(self, tick: float | None, key: str) -> Self:
        """The same with times as ticks of so many seconds, None of fixed networks. Raises ValueError."""
        at = in_ticks(self.at, tick, f"{key}.at", LEAST)
        until = None if self.until is None else in_ticks(self.until, tick, f"{key}.until", LEAST)
        found = replace(self, at=at, until=until, given=self)
        if until is not None and until < at:
            raise ValueError(
                f"{key}.until = {found.told('until')} comes before at = {found.told('at')}: should be that or later"
            )
        return found

    def told(self, key: str) -> str:
        """When it is `at` or `until`, as the file says it: a time beside its ticks."""
        ticks, given = getattr(self, key), getattr(self.given or self, key)
        return f'"{given}" ({ticks:,} ticks)' if isinstance(given, Time) else str(ticks)

    @property
    def end(self) -> int:
        """The first round with `last`."""
        end = self.at if self.until is None else self.until
        assert isinstance(end, int)
        return end

    def ends_in(self, rounds: int) -> float:
        """The fill ratio of the last of so many rounds."""
        return float(along(self.course, rounds))

    @property
    def course(self) -> NDArray[np.float64]:
        """What the engine takes: see `engine.changes`."""
        return np.array([self.first, self.last, self.at, self.end], np.float64)


def read_change(text: str) -> Change | None:
    """A change from the text of a dataset; None of a fill ratio that stays."""
    if not text:
        return None
    words = text.split()
    numbers = dict(zip(("from", *words[1::2]), map(float, words[::2]), strict=True))
    until = int(numbers["until"]) if "until" in numbers else None
    return Change(numbers["from"], numbers["to"], int(numbers["at"]), until)


def steady(fill_ratio: float) -> NDArray[np.float64]:
    """The course of a fill ratio that stays."""
    return np.array([fill_ratio, fill_ratio, 1.0, 1.0])


def along(course: NDArray[np.float64], rounds: ArrayLike) -> NDArray[np.float64]:
    """The fill ratios of rounds, to the bit as the engine has them."""
    first, last, at, until = course
    k = np.asarray(rounds, np.float64)
    between = first + (last - first) * ((k - at + 1.0) / (until - at + 1.0))
    return np.asarray(np.where(k < at, first, np.where(k >= until, last, between)))


def parse_change(value: Mapping[str, object]) -> Change:
    """Read a change. Raises ValueError with what would be right."""
    for key in value:
        if key not in KEYS:
            hint = did_you_mean(str(key), KEYS)
            raise ValueError(f"unknown key {key}: {hint}a fill ratio that changes is {FORM}")
    for key in KEYS[:3]:
        if key not in value:
            raise ValueError(f"{key} is missing: a fill ratio that changes is {FORM}")
    first, last = (_share(key, value[key]) for key in KEYS[:2])
    if first == last:
        raise ValueError(f"from and to are both {first}: should differ, or be a plain number")
    return Change(
        first, last, _round("at", value["at"]), None if "until" not in value else _round("until", value["until"])
    )


def _change_or(value: object, number: Callable[[Any], Any]) -> Any:
    if isinstance(value, Change):
        return value
    return parse_change(value) if isinstance(value, Mapping) else number(value)


OR_CHANGE = WrapValidator(_change_or)  # of a fill ratio that may change


def _share(key: str, value: object) -> float:
    if isinstance(value, bool) or not isinstance(value, int | float) or not 0.0 <= value <= 1.0:
        raise ValueError(f"{key} should be a number in [0, 1]")
    return float(value)


def _round(key: str, value: object) -> int | Time:
    if isinstance(value, str):
        try:
            return parse_time(value)
        except ValueError as error:
            raise ValueError(f"{key}: {error}") from None
    if isinstance(value, bool) or not isinstance(value, int) or not LEAST <= value <= MOST:
        raise ValueError(
            f"{key} should be a whole number from {LEAST} to {MOST:,}, for in round 1 the fill ratio is as before, or "
            'of robots that move a time such as "5 min"'
        )
    return value
