"""Readings of robots on a black and a white strip, from tables and logs, and whether they depend on the one before.

Readings in a row may depend on each other, as where a robot stands still. Then there are fewer changes from black to
white than in a random order (Wald and Wolfowitz, 1940), and a chain with this share of changes says how many
independent readings count as much.
"""

import math
from collections.abc import Sequence
from functools import reduce
from pathlib import Path
from statistics import NormalDist
from typing import NamedTuple

import numpy as np

from swarmcensus.robots.logs.folders import logs_in, without_logs
from swarmcensus.robots.logs.logs import read_log
from swarmcensus.support.read_table import Table, read_table

LEVEL = 0.01  # of tests
MOST_NUMBER = 0xFFFF  # of a robot
MANY = 100.0  # changes that chance is expected to take away, from which on their number is normal enough
SIDES = {"black": "b", "white": "w"}
NAMES = {  # of columns, as they may be written
    "robot": ("robot", "number"), "strip": ("strip", "floor", "side"), "readings": ("readings", "looks"),
    "black": ("black", "blacks"), "changes": ("changes",), "reading": ("reading", "observation", "value"),
}  # fmt: skip
FORM = "columns robot,strip,readings,black,changes with counts, or robot,strip,reading with single readings in order"
COLOURS = {"black": 1.0, "white": 0.0, "true": 1.0, "false": 0.0}


class Part(NamedTuple):
    """Readings of a robot on one strip, in one row."""

    robot: int
    strip: str
    readings: int
    black: int
    changes: int | None = None  # from black to white or back; None if their order is not known


def _fewer_p(black: int, readings: int) -> np.ndarray:
    """The probabilities of 0, 1, 2 ... changes in a random order of so many black and white readings."""
    logs = np.array(
        [0.0, *np.cumsum(np.log(np.arange(1.0, readings + 1.0))), np.inf]
    )  # the last is of a factorial of -1

    def ways(n: int, k: np.ndarray) -> np.ndarray:
        """The logarithm of n over k, for k from -1 to n + 1."""
        return np.asarray(logs[n] - logs[k] - logs[n - k])

    few = min(black, readings - black)
    many, changes = readings - few, np.arange(2 * few + 1)
    low, high = (changes - 1) // 2, changes // 2  # the runs of one colour are as many as of the other, or one more
    both = [ways(few - 1, a) + ways(many - 1, b) for a, b in ((low, high), (high, low))]
    return np.asarray(np.exp(np.logaddexp(*both) - ways(readings, np.array(few))))


def dependence(parts: Sequence[Part]) -> tuple[float, float]:
    """The p-value of readings in a row that are more often equal than by chance, and the correlation of neighbours.

    The p-value is exact unless there are many changes. Both are NaN if no part tells its changes, or all of its
    readings are equal.
    """
    known = [part for part in parts if part.changes is not None and 0 < part.black < part.readings]
    black, n, changes = (np.array([getattr(part, name) for part in known], np.float64) for name in
                         ("black", "readings", "changes"))  # fmt: skip
    if not known:
        return math.nan, math.nan
    expected = 2.0 * black * (n - black) / n
    lost = float((2.0 * np.minimum(black, n - black) - expected).sum())
    if lost < MANY:
        chances = reduce(np.convolve, (_fewer_p(part.black, part.readings) for part in known))
        p = float(chances[: int(changes.sum()) + 1].sum())
    else:
        variance = expected * (expected - 1.0) / (n - 1.0)
        p = NormalDist().cdf(float(changes.sum() - expected.sum()) / math.sqrt(float(variance.sum())))
    return min(1.0, p), max(0.0, 1.0 - float(changes.sum() / expected.sum()))


class Dependence(NamedTuple):
    """How readings depend on the one before: of robots that stand out alone, of the others together."""

    p: float  # of the others; NaN if it is not known
    share: float  # of their readings that are independent
    alone: dict[int, float]  # the same of robots that stand out


def dependences(parts: Sequence[Part]) -> Dependence:
    """Robots stand out that fail the test at the level divided by their number."""
    tests = {
        number: dependence([part for part in parts if part.robot == number])
        for number in sorted({part.robot for part in parts})
    }
    alone = {number: _share(r) for number, (p, r) in tests.items() if p < LEVEL / len(tests)}
    p, correlation = dependence([part for part in parts if part.robot not in alone])
    return Dependence(p, _share(correlation) if p < LEVEL else 1.0, alone)


def _share(correlation: float) -> float:
    return (1.0 - correlation) / (1.0 + correlation)


def parts_of_table(path: Path) -> list[Part]:
    """The parts of a table: a row of counts for each, or a row for each reading, in order. Raises InputError."""
    names = {name for spelled in NAMES.values() for name in spelled}
    table = read_table(path, lambda name: name in names)
    found = {key: table.column(key, None, spelled) for key, spelled in NAMES.items()}
    if not (found["robot"] and found["strip"] and (found["reading"] or (found["readings"] and found["black"]))):
        raise table.refused(f"should have {FORM}")
    if found["reading"] and found["black"]:
        raise table.refused("has counts and single readings: leave one of them out")
    robots = table.whole(str(found["robot"]))
    if robots.max(initial=0) > MOST_NUMBER:
        raise table.wrong(int(robots.argmax()), str(found["robot"]), f"a robot's number, from 0 to {MOST_NUMBER}")
    strips = _colours(table, str(found["strip"]), "black or white")
    sides = ["black" if strip == 1.0 else "white" for strip in strips]
    if found["reading"]:
        read = _colours(table, str(found["reading"]), "0 (white), 1 (black) or empty", may_lack=True)
        places: dict[tuple[int, str], list[float]] = {}
        for robot, side, reading in zip(robots.tolist(), sides, read.tolist(), strict=True):
            places.setdefault((robot, side), []).append(reading)
        return [_part(robot, side, np.array(values)) for (robot, side), values in places.items()]
    n, black = (table.whole(str(found[key])).tolist() for key in ("readings", "black"))
    changes = table.whole(found["changes"]).tolist() if found["changes"] else [None] * len(n)
    parts = [*map(Part, robots.tolist(), sides, n, black, changes)]
    for row, part in enumerate(parts):
        few = min(part.black, part.readings - part.black)  # of two colours there is a change at least
        if few < 0 or (part.changes is not None and not (few > 0) <= part.changes <= 2 * few):
            counts = f"{part.readings} readings, {part.black} black, {part.changes} changes"
            raise table.error(row, f"{counts}: {'that cannot be' if few >= 0 else 'more black than readings'}")
    return parts


def _colours(table: Table, name: str, right: str, may_lack: bool = False) -> np.ndarray:
    """A column of black, 1, and white, 0; NaN where it may lack one. Raises InputError."""
    values = table.values(name, right, COLOURS)
    wrong = ~(np.isin(values, (0.0, 1.0)) | (may_lack & np.isnan(values)))
    if wrong.any():
        raise table.wrong(int(wrong.argmax()), name, right)
    return values


def _part(robot: int, strip: str, readings: np.ndarray) -> Part:
    """Single readings, NaN where there is none, counted."""
    known = readings[np.isfinite(readings)]
    return Part(robot, strip, known.size, int(known.sum()), int(np.count_nonzero(np.diff(known))))


def parts_of_logs(folder: Path, strip: str) -> list[Part]:
    """The readings in robots' logs, all on one strip. Raises InputError."""
    parts = []
    for path in logs_in(folder):
        log = read_log(path)
        looks, blacks = (np.array([getattr(tick, name) for tick in log.ticks]) for name in ("looks", "blacks"))
        if looks.max(initial=0) <= 1:
            parts.append(_part(log.number, strip, blacks[looks > 0].astype(np.float64)))
        else:  # of several in a tick the order is not known
            parts.append(Part(log.number, strip, int(looks.sum()), int(blacks.sum())))
    if not parts:
        raise without_logs(folder)
    return parts
