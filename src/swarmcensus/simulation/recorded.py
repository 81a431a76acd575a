"""Readings of real robots, from a table: a column for each robot, or a row for each reading."""

import re
from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np

from swarmcensus.support.errors import InputError, TableError
from swarmcensus.support.formatting import counted
from swarmcensus.support.options import option, wrong_option
from swarmcensus.support.read_table import MISSING, NUMBER, UNNAMED, Table, in_order, plain
from swarmcensus.worlds import STEPS, TIMES

ROBOTS = ("robot", "robots", "robotid", "robotname")  # names of columns
READINGS = ("observation", "reading", "black", "isblack", "value")
WORDS = {"black": 1.0, "true": 1.0, "white": 0.0, "false": 0.0}
READING = "0 (white), 1 (black) or empty"
FORMS = "a column for each robot, or columns such as step,robot,observation"
NUMBERED = re.compile(r"(.*[^0-9]|)([0-9]{1,9})[\W_]*", re.DOTALL)  # a name: what it begins with, and its number
OWN = ("", "r", "robot", "v", "x")  # what names of numbered robots begin with; R adds V or X to numbers
MOST_READINGS = 2**27
NANO = 1e9


def known(name: str) -> bool:
    """Whether a plain name is a column's."""
    return name in (*TIMES, *ROBOTS, *READINGS) or re.fullmatch("r(obot)?[0-9]+", name) is not None


class Readings(NamedTuple):
    """Readings of robots, and how tables of links call the robots and the steps."""

    values: np.ndarray  # (step, robot): 0 white, 1 black, NaN none
    names: Mapping[str, int] = {}  # the robots by their names in the table
    is_labelled: bool = False  # whether robots have names; else they are numbered
    start: float = 0.0  # the time of step 0, in seconds
    period: float | None = None  # seconds of a step; None: tables number the steps
    notes: Sequence[str] = ()  # what is missing, and what was left out

    @property
    def labels(self) -> list[str]:
        """The names of the robots, in their order; none if they are numbered."""
        return sorted(self.names, key=self.names.__getitem__) if self.is_labelled else []

    def robots(self, table: Table, name: str) -> np.ndarray:
        """The numbers of the robots that a column names. Raises InputError."""
        texts = table.texts(name)
        if not self.is_labelled and not self.names.keys() >= {*texts}:
            return table.whole(name)
        for row, text in enumerate(texts):
            if text not in self.names:
                raise table.wrong(row, name, f"one of the robots {', '.join(self.labels or self.names)}")
        return np.array([self.names[text] for text in texts], np.int64)

    def steps(self, table: Table, name: str) -> np.ndarray:
        """The steps of a column of times. Raises InputError."""
        if self.period is not None:
            return np.asarray(np.floor((times_of(table, name) - self.start) / self.period + 0.5), np.int64)
        if plain(name) not in STEPS:
            raise table.refused(f"column {name!r}: times of messages need readings with times and {option('period')}")
        return table.whole(name)


def times_of(table: Table, name: str) -> np.ndarray:
    """Times in seconds, from numbers or timestamps. Raises InputError."""
    import pandas as pd

    right, texts = "seconds, or a time such as 2026-03-01T14:00:00.5", table.texts(name)
    if "" in texts:
        raise table.wrong(int(np.argmax(texts == "")), name, right)
    if NUMBER.fullmatch(str(texts[0]).replace(",", ".")):
        return table.values(name, right)
    stamps = pd.to_datetime(pd.Series(texts), format="ISO8601", utc=True, errors="coerce")
    if stamps.isna().any():
        raise table.wrong(int(np.argmax(stamps.isna())), name, right)
    return np.asarray(stamps.dt.as_unit("ns").astype(np.int64).to_numpy() / NANO)


def readings_of(
    table: Table, time: str | None = None, robot: str | None = None, reading: str | None = None,
    period: float | None = None,
) -> Readings:  # fmt: skip
    """Readings of a table with a column for each robot, or a row for each reading.

    `time`, `robot` and `reading` name columns, and `period` is the seconds of a step. Without times, each row of a
    table with a column for each robot is a step. Raises InputError.
    """
    if period is not None and not 1e-9 <= period < 1e9:
        raise wrong_option("period", period, "should be the seconds of a step, above 0")
    if not len(table.frame):
        raise TableError.of(table.source, f"no observations: there should be {FORMS}, and rows")
    _check_names(table)
    if table.gap:
        at = f"{table.source}, line {table.gap} is empty"
        raise TableError.of(table.source, "write NA where a robot observed nothing", where=at)
    when, who = table.column("time", time, TIMES), table.column("robot", robot, ROBOTS)
    what = table.column("reading", reading, READINGS)
    others = [name for name in table.names if name not in (when, who, what)]
    if not others and what is None:
        raise table.refused(f"no observations: there should be {FORMS}")
    if when is None and (who is not None or period is not None):
        needed = f" for {option('period', period)}" if period is not None else ""
        raise _unclear(table, "time", f"which column has the times{needed}")
    if who is None and what is not None and others:
        raise _unclear(table, "robot", "which column names the robots")
    if who is not None and what is None:
        raise _unclear(table, "reading", "which column has the readings, 1 for black,", others)
    if who is not None and what is not None:
        values, texts, rows = _values(table, [what]), table.texts(who), np.arange(len(table.frame))
        if "" in texts:
            raise table.wrong(int(np.argmax(texts == "")), who, "the name of a robot")
        found, places = np.unique(texts, return_inverse=True)
        names = list(map(str, found))
        notes = [f"left out: column{'s' * (len(others) > 1)} {', '.join(others)}"] if others else []
    else:
        names, notes = others or [str(what)], []
        _check_robots(table, names)
        values = _values(table, names)
        rows, places = (grid.ravel() for grid in np.indices(values.shape))
    numbers, is_labelled = _numbers(names)
    robots = np.array([numbers[name] for name in names])[places]
    steps, times = (np.arange(len(values)),) * 2 if when is None else _steps(table, when, period)
    shape = (int(steps.max()) + 1, len(names))
    if shape[0] * shape[1] > MOST_READINGS:
        raise table.refused(f"{shape[0]:,} steps of {shape[1]:,} robots: {MOST_READINGS:,} readings at most")
    where = steps[rows] * shape[1] + robots
    if period is None and len(first := np.unique(where, return_index=True)[1]) < len(where):
        again = int(np.setdiff1d(np.arange(len(where)), first)[0])
        where_again = f"robot {names[places[again]]} at step {steps[rows[again]]}"
        raise table.error(int(rows[again]), f"a second observation of {where_again}")
    order = np.argsort(times[rows], kind="stable")
    order = order[~np.isnan(values.ravel()[order])]
    out = np.full(shape, np.nan)
    out.flat[where[order]] = values.ravel()[order]  # of several the last one counts
    if repeated := len(order) - int(np.isfinite(out).sum()):
        notes.append(f"{counted(repeated, 'reading')} left out: the last one of a robot in a step counts")
    empty, missing = int(np.isnan(out).all(axis=1).sum()), int(np.isnan(out).sum())
    if missing and (period is not None or len(np.unique(steps)) < len(out)):
        of = f"{out.size:,} readings are missing: {empty:,} of {counted(len(out), 'step')} have none"
        notes.append(f"{missing:,} of {of}")
    start = 0.0 if period is None else float(times.min())
    return Readings(out, numbers, is_labelled, start, period, notes)


def _check_names(table: Table) -> None:
    """Raise InputError for names that may be the first readings, or readings that may be names."""
    if table.named:
        names = {*map(str.lower, table.names)} - {UNNAMED.lower()}
        colours = {text.lower() for name in table.names[:1] for text in table.texts(name)} & {"black", "white"}
        if table.unit == "line" and names <= {*WORDS, *MISSING, "0", "1"} and (colours or names != {"black"}):
            raise table.ambiguous(",".join(f"robot {k}" for k in range(len(table.names))), "readings")
        return
    cells = table.frame.iloc[0].tolist()
    if cells in (["0"], ["0", "1"]) or [*filter(None, cells)] == ["1", "0"]:
        raise table.ambiguous(",".join(f"robot {cell}" for cell in cells if cell), "readings")
    if len(cells) > 1 and not any(table.texts(table.names[-1])):
        raise table.refused("the last column is empty: name the columns robot 0,robot 1,...")


def _unclear(table: Table, asked: str, what: str, others: Sequence[str] = ()) -> TableError:
    return table.refused(f"{what} is not clear: name it with {option(asked, others[0] if len(others) == 1 else None)}")


def _values(table: Table, names: Sequence[str]) -> np.ndarray:
    try:
        columns = [table.values(name, READING, WORDS) for name in names]
        for name, values in zip(names, columns, strict=True):
            if (wrong := ~(np.isnan(values) | (values == 0.0) | (values == 1.0))).any():
                raise table.wrong(int(np.argmax(wrong)), name, READING)
    except TableError as error:
        first = f"{table.where(0)}: "
        if not str(error).startswith(first):
            raise
        ways = ", ".join(map(option, ("time", "robot", "reading")))
        raise table.refused(f"{str(error).removeprefix(first)}; {ways} name the columns of other tables") from None
    return np.stack(columns, axis=1)


def _check_robots(table: Table, names: Sequence[str]) -> None:
    """Raise InputError for names of columns that may be no robots: without a name, or among numbered ones."""
    if UNNAMED in names:
        raise table.refused(f"the first column or index is unnamed: drop it, or name it with {option('time', UNNAMED)}")
    strange = [name for name in names if not NUMBERED.fullmatch(name)]
    if 0 < len(strange) < len(names):
        columns = f"column{'s' * (len(strange) > 1)} {', '.join(map(repr, strange))}"
        right = "the others are numbered, as robots are: leave out what is no robot, or name the columns with"
        raise table.refused(f"{columns}: {right} {option('time')}, {option('robot')} and {option('reading')}")


def _numbers(names: Sequence[str]) -> tuple[dict[str, int], bool]:
    """The robots by their names, and whether these are labels: not numbers from 0."""
    found = [NUMBERED.fullmatch(name) for name in names]
    numbers = [int(match[2]) for match in found if match and plain(match[1]) in OWN]
    if sorted(numbers) == list(range(len(names))):
        return dict(zip(names, numbers, strict=True)), False
    order = sorted(names, key=in_order)
    return {name: k for k, name in enumerate(order)}, len(names) > 1 or plain(names[0]) not in READINGS


def _steps(table: Table, when: str, period: float | None) -> tuple[np.ndarray, np.ndarray]:
    """The step of each row, and its time in seconds, or steps."""
    if period is not None:
        times = times_of(table, when)
        steps = np.floor((times - times.min()) / period + 0.5)
        if not steps.max() < MOST_READINGS:
            raise table.refused(f"{option('period', period)} makes over {MOST_READINGS:,} steps of these times")
        return steps.astype(np.int64), times
    needed = table.refused(f"column {when!r}: times need {option('period')}, the seconds of a step")
    try:
        steps = table.whole(when)
    except InputError as error:
        raise (error if plain(when) in STEPS else needed) from None
    if plain(when) not in STEPS and len(np.unique(steps)) <= steps.max():
        raise needed
    if steps.min() > 0:
        first = f"steps are numbered from 0, and the first is {steps.min()} here"
        raise table.refused(f"column {when!r}: {first}: {option('period', 1)} counts them from it")
    return steps, steps
