"""How wrong shipped brains are after a day in each message format: `python benchmarks/pages.py formats` finds it."""

import csv
import functools
import math
from collections.abc import Collection
from pathlib import Path
from typing import NamedTuple

from swarmcensus.brains import Brain, load, shipped

TABLE = Path(__file__).with_name("formats.csv")
NAMES = {"float32": "single"}  # of formats in the table, where they have another one there
PREFERRED = ("float32", "ratio16", "ratio8", "float16")  # of formats that err the same; counts outgrow float16
DAY = 864_000  # readings, at 10 Hz
TIMES = 2.0  # an error of more than so many times that of double precision, and of so much more, is worth a warning
MORE = 0.005


class Measured(NamedTuple):
    """The error of a brain's estimates in a format; of opinions the share that is wrong."""

    format: str
    readings: int
    error: float  # NaN: estimates are no numbers
    low: float  # ends of its 95 % interval over trials
    high: float
    double: float  # the error in double precision

    @property
    def fails(self) -> bool:
        """Whether estimates are no numbers."""
        return math.isnan(self.error)

    @property
    def is_wrong(self) -> bool:
        """Whether the format is wrong for the brain."""
        return self.fails or self.error > max(TIMES * self.double, self.double + MORE)


def measured(brain: Brain, message: str) -> Measured | None:
    """What was found for a shipped brain with its default parameters; None for other brains, and for those left out."""
    if brain.name not in shipped():
        return None
    found = _rows().get((brain.name, NAMES.get(message, message)))
    return found and Measured(message, DAY, *found, _rows()[brain.name, "double"][0])


def least_wrong(brain: Brain, formats: Collection[str]) -> str:
    """Of these formats the preferred one of those in which a brain errs least, within that one's interval."""
    fit = [one for one in PREFERRED if one in formats] or [*PREFERRED]
    known = [found for one in fit if (found := measured(brain, one)) and not found.fails]
    best = min(known, key=lambda found: found.error, default=None)
    return next((found.format for found in known if best and found.error <= best.high), fit[0])


def caution(brain: Brain, formats: Collection[str]) -> str:
    """A sentence if a brain's message format is wrong for it, with what is right of these; empty otherwise."""
    message = brain.numbers.message
    found = measured(brain, message)
    if found is None or not found.is_wrong:
        return ""
    right = [one for one in formats if (other := measured(brain, one)) and not other.is_wrong]
    names = " or ".join(filter(None, (", ".join(right[:-1]), right[-1]))) if right else "no format that fits this radio"
    advice = f"{names} is right"
    if found.fails:
        return f"{brain.name} fails in {message}: {advice}"
    errs = f"{brain.name} errs by {found.error:.4f} after {DAY:,} readings in {message}"
    return f"{errs}, and by {found.double:.4f} in double precision: {advice}"


def sentence(brain: Brain) -> str:
    """How wrong a robot will be, or how to find out."""
    message = brain.numbers.message
    found = measured(brain, message)
    if found is None:
        study = "a study of robots that move" if brain.steers else "studies/formats.toml"
        return f"not measured in {message}: add this brain to {study}, and run that"
    of = " of opinions wrong" if brain.is_opinion else ""
    error = "no number" if found.fails else f"{found.error:.4f}{of}"
    given = "" if brain.parameters == load(brain.name).parameters else " with default parameters"
    return (
        f"{error} after {DAY:,} readings in {message} ({found.double:.4f} in double precision){given}, docs/machines.md"
    )


@functools.cache
def _rows() -> dict[tuple[str, str], tuple[float, float, float]]:
    """By brain and format as the table calls it: the error after a day, and the ends of its interval."""
    with TABLE.open(encoding="utf-8", newline="") as file:
        rows = [row for row in csv.DictReader(file) if row["readings"] == str(DAY)]
    return {(row["brain"], row["format"]): (float(row["error"]), float(row["low"]), float(row["high"])) for row in rows}
