"""A fill ratio that changes during a trial: `{from = 0.9, to = 0.1, at = 5000, until = 6000}`."""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Annotated, Any, Self

import numpy as np
from numpy.typing import ArrayLike, NDArray
from pydantic import BeforeValidator, Field

from swarmcensus.support.times import MOST, OR_TIME, Time, in_ticks
from swarmcensus.support.toml_types import OrElse, Share, ValueTable, read, says

KEYS = ("from", "to", "at", "until")
LEAST = 2  # in round 1 nothing can change
FORM = "{from = 0.9, to = 0.1, at = 500}, or with until = 600 where it drifts"


@dataclass(frozen=True)
class Change:
    """A fill ratio: `first` before round (or tick) `at`, `last` from round `until` on, linear in between.

    `until` is None for a switch at `at`. `given` is the change as written, before times became ticks, for messages.
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
        """The change with its times in ticks of `tick` seconds, None on fixed networks. Raises ValueError."""
        at = in_ticks(self.at, tick, f"{key}.at", LEAST)
        until = None if self.until is None else in_ticks(self.until, tick, f"{key}.until", LEAST)
        change = replace(self, at=at, until=until, given=self)
        if until is not None and until < at:
            what = f"{key}.until = {change.label('until')} comes before at = {change.label('at')}"
            raise ValueError(f"{what}: should be that or later")
        return change

    def label(self, key: str) -> str:
        """The time `at` or `until` for messages: as the file gives it, with its ticks."""
        ticks, given = getattr(self, key), getattr(self.given or self, key)
        return f'"{given}" ({ticks:,} ticks)' if isinstance(given, Time) else str(ticks)

    @property
    def end(self) -> int:
        """The first round with `last`."""
        end = self.at if self.until is None else self.until
        assert isinstance(end, int)
        return end

    def ends_in(self, rounds: int) -> float:
        """The fill ratio in the last round of a trial of `rounds` rounds."""
        return float(along(self.course, rounds))

    @property
    def course(self) -> NDArray[np.float64]:
        """The change in the engine's form: see `engine.changes`."""
        return np.array([self.first, self.last, self.at, self.end], np.float64)


def read_change(text: str) -> Change | None:
    """Read a change from its text in a dataset; None if the text is empty: a constant fill ratio."""
    if not text:
        return None
    words = text.split()
    numbers = dict(zip(("from", *words[1::2]), map(float, words[::2]), strict=True))
    until = int(numbers["until"]) if "until" in numbers else None
    return Change(numbers["from"], numbers["to"], int(numbers["at"]), until)


def steady(fill_ratio: float) -> NDArray[np.float64]:
    """The course of a constant fill ratio."""
    return np.array([fill_ratio, fill_ratio, 1.0, 1.0])


def along(course: NDArray[np.float64], rounds: ArrayLike) -> NDArray[np.float64]:
    """The fill ratio at each of these rounds, computed as in the engine, bit for bit."""
    first, last, at, until = course
    k = np.asarray(rounds, np.float64)
    between = first + (last - first) * ((k - at + 1.0) / (until - at + 1.0))
    return np.asarray(np.where(k < at, first, np.where(k >= until, last, between)))


ROUND = f"a whole number from {LEAST} to {MOST:,}, as nothing has changed yet in round 1"
TIME = says(f'should be {ROUND}, or a time such as "5 min" for robots that move')
When = Annotated[int, Field(strict=True, ge=LEAST, le=MOST), TIME, OR_TIME]
End = Annotated[Share, says("should be a number in [0, 1]")]


class ChangeTable(ValueTable):
    """A fill ratio that changes."""

    first: Annotated[End, Field(alias="from")]
    last: Annotated[End, Field(alias="to")]
    at: When
    until: When | None = None


def parse_change(value: Any) -> Change:
    """Read a change from a table. Raises ValueError with what would be right."""
    if isinstance(value, Change):
        return value
    table = read(ChangeTable, value, lambda: f"a fill ratio that changes is {FORM}")
    if table.first == table.last:
        raise ValueError(f"from and to are both {table.first}: should differ, or be a plain number")
    return Change(table.first, table.last, table.at, table.until)


# for a fill ratio that may change
OR_CHANGE = OrElse(Annotated[Change, BeforeValidator(parse_change)], Mapping, Change)
