"""What the loop of rounds passes to functions that are compiled apart (`helpers.py`), as one group."""

from typing import Any, NamedTuple

import numpy as np
from numba import typeof

from swarmcensus.engine.changes import Source
from swarmcensus.engine.layout import Intervals, Reception, Sensors, States, Swarm, Tally

from .teams import Team


class Graph(NamedTuple):
    """Who hears whom in a trial."""

    mode: Any  # LISTED, FULL or PAIRS
    receivers: Any
    senders: Any
    bounds: Any  # (robot + 1): robot i has the links from bounds[i] to bounds[i + 1]


class Work(NamedTuple):
    """Room to work in, for a block of robots, or for all that go alone."""

    blacks: Any  # (robot): how many readings of a round are black
    bits: Any  # (robot): random words
    single: Any  # (robot): single readings; no robots if they do not go alone
    draws: Any  # (3, robot or message): words to observe, fuse and hear with; empty where no brain uses luck
    sums: Any  # (block, byte): sums of messages of blocks of a full network, see `phases.hear_all`
    partial: Any  # (2 x block, byte): sums of the blocks before and after each
    arrivals: Any  # (2, message): receivers and senders of what gets through


class Scene(NamedTuple):
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


def _arrays(dtype: Any) -> list[Any]:
    """Arrays by their dimensions, from 0 on."""
    return [np.zeros((0,) * dimensions, dtype) for dimensions in range(4)]


_, BYTES, TABLES, _ = _arrays(np.uint8)
_, WORDS, ROWS_OF_WORDS, CUBE = _arrays(np.uint64)
_, WHOLES, ROWS_OF_WHOLES, _ = _arrays(np.int64)
_, REALS, ROWS_OF_REALS, _ = _arrays(np.float64)
_, NUMBERS, ROWS_OF_NUMBERS, _ = _arrays(np.uint32)
FLAGS = np.zeros(0, np.bool_)

# the Numba types of groups that are passed by their addresses
SOURCE_LIKE = Source(
    CUBE, ROWS_OF_REALS, Sensors(REALS, REALS, ROWS_OF_REALS, REALS, 1, WORDS, WORDS), changes=True
)  # fmt: skip
SOURCE = typeof(SOURCE_LIKE)
SCENE = typeof(
    Scene(
        Swarm(
            ROWS_OF_WORDS, WHOLES, WHOLES, WHOLES, TABLES, ROWS_OF_WORDS, WORDS, True, True, True, WORDS, FLAGS, WORDS
        ),
        States(TABLES, TABLES, BYTES, ROWS_OF_REALS),
        Work(REALS, WORDS, REALS, ROWS_OF_WORDS, TABLES, TABLES, ROWS_OF_NUMBERS),
        SOURCE_LIKE,
        Graph(1, NUMBERS, NUMBERS, WHOLES),
        Reception(WORDS, np.uint64(0), 1, False),
        Tally(ROWS_OF_WHOLES, ROWS_OF_REALS, REALS),
        ROWS_OF_WHOLES,
        1,
        Team(1, 1, 1, 1, 1, 1, ROWS_OF_REALS),
        BYTES,
    )
)
INTERVALS_OF_TRIAL = typeof(Intervals(WHOLES, REALS, ROWS_OF_REALS, REALS, ROWS_OF_REALS, REALS))
