"""What changes during a trial: fill ratio and accuracies by round, and the tables that readings are drawn from.

The `course` of a fill ratio is four numbers: the ratio at first, the ratio in the end, and the two rounds (or ticks)
between which it changes linearly. A constant ratio has round 1 for both.
A `drift` (3, robot or 1) is what accuracies gain per round, their minimum and their maximum; no robots where accuracies
stay.
"""

from typing import Any, NamedTuple

import numpy as np

from swarmcensus.engine.compiling import inside, loop
from swarmcensus.engine.constants import COLUMNS, PART
from swarmcensus.engine.draws import binomial_row

FROM, TO, AT, UNTIL = range(4)  # of a course
SLOPE, LEAST, MOST = range(3)  # of a drift


@loop()
def fill_ratio_in(course, k):
    """The fill ratio of round k."""
    if k < course[AT]:
        return course[FROM]
    if k >= course[UNTIL]:
        return course[TO]
    return course[FROM] + (course[TO] - course[FROM]) * ((k - course[AT] + 1.0) / (course[UNTIL] - course[AT] + 1.0))


@loop()
def accuracy_in(side, drift, i, k):
    """The true accuracy of robot i in round k: `side` (robot or 1) is that of round 1."""
    own, j = i if side.size > 1 else 0, i if drift.shape[1] > 1 else 0
    return min(max(side[own] + drift[SLOPE, j] * (k - 1.0), drift[LEAST, j]), drift[MOST, j])


class Source(NamedTuple):
    """Where a trial's readings come from."""

    tables: Any  # (kind, robot or 1, column): alias rows, of `draws.binomial_row`
    stand: Any  # (3, robot or 1): the accuracies b and w and the fill ratio that each table was made for
    sensors: Any  # `Sensors` of the trial
    changes: bool  # whether tables may differ from those of the round before


@loop(inline="always")
def source_with(tables, stand, sensors):
    """A source of a trial's readings with such tables."""
    return Source(tables, stand, sensors, sensors.drift.shape[1] > 0 or sensors.course[UNTIL] > 1.0)


@inside()
def source_of(sensors):
    """A source of a trial's readings, whose tables are not made yet."""
    looks, robots = sensors.looks, sensors.b.size
    kinds = (1 if looks >= PART else 0) + (1 if looks % PART > 0 else 0)
    return source_with(np.empty((kinds, robots, COLUMNS), np.uint64), np.full((3, robots), np.nan), sensors)


@loop()
def renew(source, k, first, last):
    """Make the tables of round k for robots first ... last - 1: kind 0 for PART observations, the last for the rest.

    A reading is black with probability b f + (1 - w)(1 - f) (paper, Sec. III-C). Tables that were made for the same
    numbers stay.
    """
    sensors, looks = source.sensors, source.sensors.looks
    f = fill_ratio_in(sensors.course, k)
    for i in range(first if sensors.b.size > 1 else 0, last if sensors.b.size > 1 else 1):
        b, w = sensors.b[i], sensors.w[i]
        if sensors.drift.shape[1] > 0:
            b, w = accuracy_in(sensors.b, sensors.drift, i, k), accuracy_in(sensors.w, sensors.drift, i, k)
        if source.stand[0, i] == b and source.stand[1, i] == w and source.stand[2, i] == f:
            continue
        source.stand[0, i], source.stand[1, i], source.stand[2, i] = b, w, f
        p = min(max(b * f + (1.0 - w) * (1.0 - f), 0.0), 1.0)
        if looks >= PART:
            binomial_row(np.int64(PART), p, source.tables[0, i])  # a type of its own would be compiled apart
        if looks % PART > 0:
            binomial_row(looks % PART, p, source.tables[source.tables.shape[0] - 1, i])
