"""How long a search goes on: for so many evaluations, or for a time."""

from dataclasses import dataclass

from swarmcensus.basics.counting import counted
from swarmcensus.basics.errors import InputError
from swarmcensus.basics.options import option
from swarmcensus.basics.times import UNITS, parse_time

MOST = 10_000_000


@dataclass(frozen=True)
class Budget:
    """So many evaluations, or so many seconds; the other is None."""

    evaluations: int | None
    seconds: float | None
    text: str

    def allows(self, done: int, more: int, seconds: float) -> bool:
        """Whether a search that has done so much in so many seconds may do so many more evaluations."""
        if self.evaluations is not None:
            return done + more <= self.evaluations
        assert self.seconds is not None
        return seconds < self.seconds


def budget_of(given: int | str) -> Budget:
    """Read 200, "200" or "10 min". Raises InputError."""
    text = str(given).strip()
    if text.isascii() and text.isdigit() and len(text) < 10 and 1 <= int(text) <= MOST:
        return Budget(int(text), None, f"{counted(int(text), 'evaluation')}")
    try:
        time = parse_time(text)
        if not 0 < time.number < MOST:
            raise ValueError
    except ValueError:
        raise InputError(
            f"{option('budget', given)}: should be a number of evaluations, as 200, or a time, as "
            '"10 min" (s, min or h)'
        ) from None
    return Budget(None, time.number * UNITS[time.unit], str(time))
