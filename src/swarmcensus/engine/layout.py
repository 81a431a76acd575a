"""What the engine's loops take: arrays and numbers in groups, each declared once.

CPython makes the groups and passes them as they are: Numba takes a NamedTuple apart. In groups of a batch, arrays whose
first dimension is the trial have one row a trial; `of_trial` gives those of one trial, in CPython and in machine code.
"""

import itertools
from typing import Any, NamedTuple

import numpy as np

from swarmcensus.engine.constants import BLOCK, LISTED


class Swarm(NamedTuple):
    """Which robot has which brain. Robots with the same brain are a group.

    In `memory` (robot, byte) each group has room for all robots, from its base on, and uses that of its own robots: a
    record for each, as its brain needs it. So little is wasted that packing would gain nothing.
    """

    functions: Any  # (group, function): addresses of the brains' functions, see `constants.py`
    bases: np.ndarray  # (group): where its records begin, in bytes
    sizes: np.ndarray  # (group): bytes of a record
    clipped: np.ndarray  # (group): which byte of it begins the count of messages that no format could hold, or -1
    blanks: np.ndarray  # (group, byte): a state before its first observation
    runs: np.ndarray  # (run, 3): group, first robot, last robot + 1; none crosses the end of a block
    of_block: np.ndarray  # (block + 1): where the runs of a block of BLOCK robots begin
    additive: bool  # whether all brains only add up what they hear
    is_signalled: bool  # whether robots may be silent or jam, and say so in `States.signals`
    jams: bool  # whether any brain may drown what others say
    draws: np.ndarray  # two keys of two words each; empty where no brain uses luck
    honest: np.ndarray  # (robot): whom decisions and metrics count; empty where they count all
    helpers: Any  # (function): addresses of what of the engine is compiled apart, see `constants.py`


class States(NamedTuple):
    """The states of one trial: what they hold, say and estimate."""

    memory: np.ndarray  # (robot, byte), see `Swarm`
    outbox: np.ndarray  # (round x robot, byte): the messages of the last rounds, which take turns
    signals: np.ndarray  # (round x robot): whether each was SAID, or its robot SILENT, or NOISE; empty if all are said
    rows: np.ndarray  # (round, robot): estimates


class Sensors(NamedTuple):
    """What readings are drawn from."""

    b: np.ndarray  # (trial, robot or 1): true accuracies in the first round
    w: np.ndarray
    drift: np.ndarray  # (trial, 3, robot or 1): see `changes.py`; no robots where accuracies stay
    course: np.ndarray  # of the fill ratio, see `changes.py`
    looks: int  # observations per round
    key: np.ndarray  # of readings
    order: np.ndarray  # key of the order of single readings within a round

    def of_trial(self, k: int) -> "Sensors":
        """The sensors of the k-th trial."""
        return Sensors(self.b[k], self.w[k], self.drift[k], self.course, self.looks, self.key, self.order)


class Reception(NamedTuple):
    """How messages travel."""

    key: np.ndarray  # of losses
    threshold: np.uint64  # a message gets through where a uniform uint64 is below it; 0 if none is ever lost
    delay: int  # rounds or ticks from a message to its hearing
    everyone: bool  # whether robots that move hear all others, near or far


class Links(NamedTuple):
    """Directed links of the graphs of a batch: graph g has links starts[g] to starts[g + 1], sorted by receiver."""

    mode: int  # LISTED, FULL or PAIRS
    starts: np.ndarray  # one graph for all trials, or one for each
    receivers: np.ndarray
    senders: np.ndarray


NO_LINKS = Links(LISTED, np.zeros(2, np.int64), np.zeros(0, np.uint32), np.zeros(0, np.uint32))


class Inputs(NamedTuple):
    """All that chance decides for trials first to first + trials - 1 before they run."""

    first: int
    sensors: Sensors
    beliefs: tuple[np.ndarray, np.ndarray]  # assumed b and w, (trial, robot or 1)
    radio: Reception
    links: Links  # who hears whom; NO_LINKS where robots move
    stops: np.ndarray  # (trial, part, robot): when parts of robots fail, see `failures.py`
    draws: np.ndarray  # two keys; empty where no brain uses luck
    walk: np.ndarray  # key of the random walk
    speeds: np.ndarray  # (trial, robot): metres that a robot goes in a tick; no rows on fixed networks
    group: np.ndarray  # (trial, robot): which of the setting's brains; no rows where there is only one
    honest: np.ndarray  # (trial, robot): whom metrics count; no rows where they count all


class Segments(NamedTuple):
    """Room to run rounds of a trial again from a copy of its states, see `kernel.simulate`."""

    snapshots: np.ndarray  # (segment, robot, byte): memory before the segment
    outboxes: np.ndarray  # (segment, round x robot, byte): the outbox; no segments if messages are not late
    signals: np.ndarray  # (segment, round x robot): as the outbox
    extremes: np.ndarray  # (3, robot): least and greatest estimate of all later rounds, and the estimate of round 0
    votes: np.ndarray  # (4, thread): see `shared_trials.py`


class Work(NamedTuple):
    """Room to work in, for a block of robots, or for all that go alone or move; each thread has its own."""

    blacks: np.ndarray  # (robot): how many readings of a round are black
    bits: np.ndarray  # (robot): random words
    single: np.ndarray  # (robot): single readings; no robots if they do neither
    draws: np.ndarray  # (3, robot or message): words to observe, fuse and hear with; empty where no brain uses luck
    sums: np.ndarray  # (block, byte): sums of messages of blocks of a full network, see `brain_calls.hear_all`
    partial: np.ndarray  # (2 x block, byte): sums of the blocks before and after each
    arrivals: np.ndarray  # (2, message): receivers and senders of what gets through
    tables: np.ndarray  # (kind, robot or 1, column): see `changes.Source`
    stand: np.ndarray  # (3, robot or 1)
    bounds: np.ndarray  # (robot + 1): see `trial_arguments.Graph`
    order: np.ndarray  # (robot): estimates that are put in order
    answer: np.ndarray  # (1): what a function that is compiled apart returns
    uncounted: np.ndarray  # (3, 0): counts of no robots


class Measures(NamedTuple):
    """The metrics of a batch on a fixed network, and what defines them."""

    delta: float  # of the convergence rule
    bins: np.ndarray  # (checkpoint, 2): the ends of the right bin
    where: np.ndarray  # (trial, robot): the convergence index
    value: np.ndarray  # (trial, robot): the estimate there
    final: np.ndarray  # (trial, robot): the last estimate
    correct: np.ndarray  # (checkpoint, trial): the share of honest robots in the right bin
    disagreement: np.ndarray  # (checkpoint, trial): of honest robots, see `agreement.py`
    agreement: np.ndarray  # (trial): from which round on it stays within delta; infinite for never
    kept: np.ndarray  # (checkpoint, trial, robot): estimates; no checkpoints if they are not kept
    wrong: np.ndarray  # (trial, 3): the first estimate outside [0, 1]: robot (-1 if there is none), round, estimate


class Tally(NamedTuple):
    """What is counted of messages, and what is known of decisions."""

    counts: np.ndarray  # (trial, what, robot): messages SENT, HEARD and CLIPPED
    verdicts: np.ndarray  # (trial, robot, what): see `constants.py`; no robots where no brain decides or ends
    agreed: np.ndarray  # (trial, 2): the first option that all honest robots agreed on, and after which round

    def of_trial(self, k: int) -> "Tally":
        """The tally of the k-th trial."""
        return Tally(self.counts[k], self.verdicts[k], self.agreed[k])


class Intervals(NamedTuple):
    """Checkpoints, and how robots' intervals do there."""

    checkpoints: np.ndarray  # rounds, in order
    truths: np.ndarray  # (checkpoint): the fill ratios that intervals should hold
    bounds: np.ndarray  # (end, robot): room for the intervals of a checkpoint; no robots where no brain has one
    sums: np.ndarray  # (3): room, for how many intervals hold the truth, their widths, and how many there are
    sure: np.ndarray  # (trial, what, checkpoint): COVERAGE and WIDTH; NaN where no honest robot has an interval
    wrong: np.ndarray  # (trial, 4): the first invalid interval: robot (-1 if there is none), round, both ends

    def of_trial(self, k: int) -> "Intervals":
        """The intervals of the k-th trial."""
        return Intervals(self.checkpoints, self.truths, self.bounds, self.sums, self.sure[k], self.wrong[k])


class Bodies(NamedTuple):
    """The robots of a trial in which they move."""

    state: np.ndarray  # (what, robot): see `constants.py`
    body: np.ndarray  # (1): `Body.numbers` (worlds/bodies.py)
    half: float  # half the arena's side, in metres
    key: np.ndarray  # of the random walk
    commands: np.ndarray  # (3, robot): of brains that steer: whether there is one, metres and radians a tick


class Neighbours(NamedTuple):
    """Who is near whom, kept from tick to tick by `neighbours.py`."""

    anchors: np.ndarray  # (2, robot): where robots were when the lists were made; infinity before the first
    first: np.ndarray  # (robot + 1): others[first[i]: first[i + 1]] are the robots j > i on i's list
    others: np.ndarray
    room: np.ndarray  # (robot + 1): from room[i] on is i's place in near, ears and gaps
    around: np.ndarray  # (robot): how many are within reach
    lower: np.ndarray  # (robot): how many of those have a lower number
    hears: np.ndarray  # (robot): how many it hears
    near: np.ndarray  # who is within reach
    ears: np.ndarray  # who is heard
    gaps: np.ndarray  # (2, place): dx and dy to who is within reach
    close: np.ndarray  # (pair, 2): robots that may touch by the end of the next tick
    pairs: np.ndarray  # (1): how many rows of `close` are in use
    pushed: np.ndarray  # (robot): how far contact has pushed it in this tick
    heads: np.ndarray  # (cell, cell): the first robot in a cell of the grid, -1 if there is none
    following: np.ndarray  # (robot): the next robot in the same cell


class Chunk(NamedTuple):
    """Some ticks of a walk of n robots.

    In the k-th of these ticks robot i hears senders[heard[k n + i]: heard[k n + i + 1]], in order.
    """

    tick: int  # the first one
    looked: np.ndarray  # (tick, robot), bool: whether an observation is made
    tiles: np.ndarray  # (tick, robot, 2): the tile under the ground sensor
    heard: np.ndarray  # (tick * robot + 1)
    senders: np.ndarray
    poses: np.ndarray  # (tick, robot, 3): x and y in metres, heading in radians; no rows if they are not recorded
    begin: np.ndarray  # (robot, 3): the poses before the first of these ticks


class Recorded(NamedTuple):
    """Room for what is recorded of a chunk; no rows if nothing is."""

    history: np.ndarray  # (tick, robot, byte): states after the tick
    readings: np.ndarray  # (tick, robot): 1 for black; set where a robot made one
    said: np.ndarray  # (tick, robot, byte): the message of each that was heard in the tick
    signals: np.ndarray  # (tick, robot): whether each was said; no robots if all are
    messages: np.ndarray  # (tick, what): how many all robots have sent and heard so far


NOT_RECORDED = Recorded(
    np.zeros((0, 0, 0), np.uint8), np.zeros((0, 0)), np.zeros((0, 0, 0), np.uint8), np.zeros((0, 0), np.uint8),
    np.zeros((0, 2), np.int64),
)  # fmt: skip


def runs_of(group: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The `runs` and `of_block` of robots' groups (robot)."""
    robots = group.size
    cuts = np.flatnonzero(np.diff(group)) + 1
    first = np.unique(np.concatenate([np.arange(0, robots, BLOCK), cuts]))
    runs = np.stack([group[first], first, np.append(first[1:], robots)], axis=1).astype(np.uint64)
    of_block = np.searchsorted(first, np.arange(0, robots + BLOCK, BLOCK))
    return runs, of_block[: -(-robots // BLOCK) + 1].astype(np.uint64)


ALONE = np.array([0, 0, 1, 0, 0])  # the member of a team of one, see `shared_trials.py`


def parts_of(swarm: Swarm, count: int) -> list[tuple[Swarm, int]]:
    """A swarm cut into so many parts, each with the runs of its own blocks, and the number of its first block."""
    of_block = swarm.of_block
    cuts = [(of_block.size - 1) * k // count for k in range(count + 1)]
    parts = []
    for begin, end in itertools.pairwise(cuts):
        own = of_block[begin : end + 1]
        parts.append((swarm._replace(runs=swarm.runs[own[0] : own[-1]], of_block=own - own[0]), begin))
    return parts
