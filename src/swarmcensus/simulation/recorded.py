"""Observations of real robots, from a table: a column for each robot, or a row for each observation."""

import re
from collections import Counter
from collections.abc import Sequence

import numpy as np

from swarmcensus.support.errors import TableError
from swarmcensus.support.tables import ReadTable, plain
from swarmcensus.worlds import from_one

LONG = ("step", "robot")
READINGS = ("observation", "reading", "black", "value")  # names of the readings' column
RIGHT = "robot 0,robot 1,... or step,robot,observation"
READING = "0 (white), 1 (black) or empty"
ROBOT = re.compile(r"(.*[^0-9]|)([0-9]{1,9})[\W_]*", re.DOTALL)  # a name: what it begins with, and the robot's number
MOST_READINGS = 2**27


def known(name: str) -> bool:
    """Whether a plain name is a column's."""
    return name in (*LONG, *READINGS, "time") or re.fullmatch("r(obot)?[0-9]+", name) is not None


def readings_of(table: ReadTable) -> np.ndarray:
    """Observations (step, robot): 0 white, 1 black, NaN none. Raises InputError."""
    if table.names is None and table.rows:
        table = _unnamed(table)
    if not table.rows or not table.width:
        raise TableError.of(table.source, f"no observations: there should be {RIGHT}, and rows")
    if table.gap:
        empty = f"{table.source}, line {table.gap} is empty"
        raise TableError.of(table.source, "write NA where a robot observed nothing", where=empty)
    if table.names is None:
        return _values(table, range(table.width))
    names = [plain(name) for name in table.names]
    if "robot" in names:
        return _long(table, names)
    if "step" in names:
        if not table.counts(names.index("step")):
            raise TableError.of(table.source, f"column 'step': should be 0, 1, 2, ...; or name the columns {RIGHT}")
        return readings_of(table.without(names.index("step")))
    found = [ROBOT.fullmatch(name) for name in table.names]
    stems = [plain(match[1]) if match else None for match in found]
    usual = Counter(stem for stem in stems if stem is not None).most_common(1)
    strange = [k for k, stem in enumerate(stems) if stem is None or stem != usual[0][0]]
    if strange:
        table.refuse(strange, RIGHT)
    numbers = np.array([int(match[2]) for match in found if match])
    _check_numbered(table, numbers)
    return _values(table, np.argsort(numbers).tolist())


def _unnamed(table: ReadTable) -> ReadTable:
    """A table whose first row has numbers alone: those of the columns, if they cannot be readings."""
    cells = table.heading()
    if max(cells) > 1.0 and cells in (list(range(len(cells))), list(range(1, len(cells) + 1))):
        return table.named_by_first_row()
    table.check_heading(",".join(f"robot {k}" for k in range(len(cells))), "readings")
    if table.width > 1 and table.is_empty(table.width - 1):
        raise TableError.of(table.source, "the last column is empty: name the columns robot 0,robot 1,...")
    return table


def _values(table: ReadTable, columns: Sequence[int]) -> np.ndarray:
    readings = np.stack([table.column(k, READING) for k in columns], axis=1)
    wrong = ~(np.isnan(readings) | (readings == 0.0) | (readings == 1.0))
    if wrong.any():
        row, k = np.argwhere(wrong)[0].tolist()
        raise table.wrong(row, columns[k], READING)
    return readings


def _long(table: ReadTable, names: list[str]) -> np.ndarray:
    """Readings of a table with a row for each."""
    chosen = [name for name in READINGS if name in names]
    strange = [k for k, name in enumerate(names) if name not in (*LONG, *chosen[:1])]
    if strange or not chosen or "step" not in names:
        table.refuse(strange or range(len(names)), RIGHT)
    step, robot = (table.whole(names.index(name)) for name in LONG)
    values = _values(table, [names.index(chosen[0])])[:, 0]
    _check_numbered(table, np.unique(robot))
    if step.min() > 0:
        raise TableError.of(table.source, f"steps are numbered from 0: the first is {step.min()} here")
    shape = (int(step.max()) + 1, int(robot.max()) + 1)
    if shape[0] * shape[1] > MOST_READINGS:
        raise TableError.of(
            table.source, f"{shape[0]:,} steps of {shape[1]:,} robots: {MOST_READINGS:,} readings at most"
        )
    places, first = np.unique(step * shape[1] + robot, return_index=True)
    if len(places) < len(step):
        again = int(np.setdiff1d(np.arange(len(step)), first)[0])
        raise table.error(again, f"a second observation of robot {robot[again]} at step {step[again]}")
    readings = np.full(shape, np.nan)
    readings[step, robot] = values
    return readings


def _check_numbered(table: ReadTable, numbers: np.ndarray) -> None:
    """Raise InputError for robots that are not numbered 0, 1, 2, ... without a gap."""
    lacking = np.setdiff1d(np.arange(len(numbers)), numbers)
    if lacking.size:
        raise TableError.of(
            table.source, f"there is no robot {lacking[0]}: number the robots 0, 1, 2, ...{from_one(numbers)}"
        )
