"""What the loop of rounds passes to functions that are compiled apart (`compiled_apart.py`), as one group."""

from typing import Any, NamedTuple

import numpy as np
from numba import typeof

from swarmcensus.engine.changes import Source
from swarmcensus.engine.layout import (
    ALONE,
    NO_LINKS,
    NOT_RECORDED,
    Chunk,
    Inputs,
    Intervals,
    Measures,
    Reception,
    Segments,
    Sensors,
    States,
    Swarm,
    Tally,
    Work,
)

from .shared_trials import Team


class Graph(NamedTuple):
    """Who hears whom in a trial."""

    mode: Any  # LISTED, FULL or PAIRS
    receivers: Any
    senders: Any
    bounds: Any  # (robot + 1): robot i has the links from bounds[i] to bounds[i + 1]
    reach: Any  # the most blocks from a receiver's to a sender's; the last and the first are next to each other


class TrialArguments(NamedTuple):
    """A trial, or a member's part of one."""

    swarm: Any
    states: Any
    work: Any
    source: Any
    graph: Any
    radio: Any
    tally: Any
    stops: Any
    trial: Any
    team: Any
    stop: Any


def _like(dtype: Any, dimensions: int = 1) -> Any:
    return np.zeros((0,) * dimensions, dtype)


WORDS, REALS, BYTES, FLAGS = (_like(dtype) for dtype in (np.uint64, np.float64, np.uint8, np.bool_))
WHOLES, NUMBERS = _like(np.int64), _like(np.uint32)
WORD_ROWS, REAL_ROWS, BYTE_ROWS, FLAG_ROWS = (_like(dtype, 2) for dtype in (np.uint64, np.float64, np.uint8, np.bool_))
WHOLE_ROWS = _like(np.int64, 2)
REAL_CUBE, BYTE_CUBE, WHOLE_CUBE = (_like(dtype, 3) for dtype in (np.float64, np.uint8, np.int64))

# groups like those that are passed, of which only the types matter
SWARM = Swarm(WORD_ROWS, WHOLES, WHOLES, WHOLES, BYTE_ROWS, WORD_ROWS, WORDS, True, True, True, WORDS, FLAGS, WORDS)
STATES = States(BYTE_ROWS, BYTE_ROWS, BYTES, REAL_ROWS)
TALLY = Tally(WHOLE_ROWS, REAL_ROWS, REALS)
RECEPTION = Reception(WORDS, np.uint64(0), 1, False)
INTERVALS = Intervals(WHOLES, REALS, REAL_ROWS, REALS, REAL_ROWS, REALS)
SENSORS = Sensors(REALS, REALS, REAL_ROWS, REALS, 1, WORDS, WORDS)
READINGS = Source(_like(np.uint64, 3), REAL_ROWS, SENSORS, changes=True)
WORK = Work(
    REALS, WORDS, REALS, WORD_ROWS, BYTE_ROWS, BYTE_ROWS, _like(np.uint32, 2), READINGS.tables, REAL_ROWS, WHOLES,
    REALS, REALS, WHOLE_ROWS,
)  # fmt: skip
GRAPH, TEAM = Graph(1, NUMBERS, NUMBERS, WHOLES, 1), Team(1, 1, 1, 1, 1, 1, 1, REAL_ROWS)
TRIAL = TrialArguments(SWARM, STATES, WORK, READINGS, GRAPH, RECEPTION, TALLY, WHOLE_ROWS, 1, TEAM, BYTES)
INPUTS = Inputs(
    1, Sensors(REAL_ROWS, REAL_ROWS, REAL_CUBE, REALS, 1, WORDS, WORDS), (REAL_ROWS, REAL_ROWS), RECEPTION, NO_LINKS,
    WHOLE_CUBE, WORDS, WORDS, REAL_ROWS, WHOLE_ROWS, FLAG_ROWS,
)  # fmt: skip

SEGMENTS = Segments(BYTE_CUBE, BYTE_CUBE, BYTE_ROWS, REAL_ROWS, REAL_ROWS)
MEASURES = Measures(1.0, REAL_ROWS, WHOLE_ROWS, REAL_ROWS, REAL_ROWS, REAL_ROWS, REAL_ROWS, REALS, REAL_CUBE, REAL_ROWS)
TALLIES = Tally(WHOLE_CUBE, REAL_CUBE, REAL_ROWS)
INTERVALS_OF_TRIALS = Intervals(WHOLES, REALS, REAL_ROWS, REALS, REAL_CUBE, REAL_ROWS)
CHUNK = Chunk(1, FLAG_ROWS, _like(np.int32, 3), WHOLES, NUMBERS, REAL_CUBE, REAL_ROWS)
RECORDED = NOT_RECORDED

SOURCE, ARGUMENTS, INTERVALS_OF_TRIAL = map(typeof, (READINGS, TRIAL, INTERVALS))
ROUNDS = (1, False, 0, 1, BYTES, ALONE, WORK)  # the last arguments of `kernel.simulate`
TO_SIMULATE = SWARM, INPUTS, STATES, SEGMENTS, MEASURES, TALLIES, INTERVALS_OF_TRIALS, *ROUNDS
TO_RIDE = SWARM, INPUTS, STATES, TALLY, INTERVALS, CHUNK, WORK, FLAG_ROWS, RECORDED, BYTES
TO_START = *TO_RIDE[:3], REAL_ROWS, TALLY, WORK
TO_CONCLUDE = SWARM, REAL_ROWS, REAL_ROWS, 1.0, WORK, WHOLES, REALS, REALS, WHOLES, REALS
SIMULATION, RIDE, START, END = map(typeof, (TO_SIMULATE, TO_RIDE, TO_START, TO_CONCLUDE))
