"""Runs batches of trials of one setting, and single trials again in full."""

import functools
import itertools
import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from swarmcensus.brains.metrics import Metric
from swarmcensus.engine import (
    ALONE,
    Inputs,
    Links,
    Measures,
    Segments,
    States,
    Swarm,
    Tally,
    Work,
    compiler,
    interruptible,
    parts_of,
    run_together,
)
from swarmcensus.engine.constants import BLOCK, BLOCKS, COLUMNS, PAIRS, PART, VERDICTS
from swarmcensus.simulation.blame import blaming, check_answers
from swarmcensus.simulation.connecting import networks_of
from swarmcensus.simulation.file_metrics import Watch, results_of
from swarmcensus.simulation.inputs import inputs_of
from swarmcensus.simulation.intervals import intervals_of, no_intervals
from swarmcensus.simulation.swarming import consensus_of, states_of, swarm_of, tally_of
from swarmcensus.studies import Setting, addresses
from swarmcensus.support.bins import right_bins
from swarmcensus.worlds import Change, along, steady

ROWS_BYTES = 8_000_000  # of estimates kept at a time, at the least
ROWS_OF_A_CROWD = 100  # rounds kept of a swarm too large for that: running rounds again would cost more
CROWD_BYTES = 1_000_000_000  # of these, where no other trial runs at the same time
SHARED_BYTES = 250_000_000  # of each trial, where other trials run at the same time
LARGE = 50_000  # robots from which on threads gain by sharing a trial; each then has a quarter of that or more


@dataclass(frozen=True)
class Metrics:
    """What is measured: see `swarmcensus.simulation.metrics`."""

    delta: float
    bins: int
    checkpoints: tuple[int, ...]
    on_floor: bool = False  # errors and decisions refer to the true fill ratio of the floor
    estimates: bool = False  # each robot's estimate is kept at the checkpoints
    watched: tuple[Metric, ...] = ()  # metrics of files
    stored: frozenset[str] = frozenset()  # see `Study.stored`


@dataclass(frozen=True)
class Batch:
    """The metrics of a batch: convergence index K, error at K and final estimate (trial, robot), and the
    fraction of robots in the right bin (checkpoint, trial); how far estimates are from each other (checkpoint, trial),
    and the round from which on they agree (trial); the fill ratio (trial), and of robots that move that of the floor;
    where they are kept, estimates at the checkpoints (checkpoint, trial, robot); what metrics of files say, by their
    variables, (trial, robot) or (trial); messages sent and heard (trial, what, robot); of brains that decide what
    `engine.constants` names (trial, robot, what), and the first option that all agreed on, when, whether it is right,
    and which is (trial, 4); of brains with intervals their coverage and mean width (what, checkpoint, trial); and of
    networks what `connecting.networks_of` says (2, trial)."""

    convergence: np.ndarray
    error: np.ndarray
    final: np.ndarray
    correct: np.ndarray
    disagreement: np.ndarray
    agreement: np.ndarray
    counts: np.ndarray
    verdicts: np.ndarray
    consensus: np.ndarray
    intervals: np.ndarray
    fill_ratio: float | np.ndarray = np.nan
    true_fill_ratio: np.ndarray | None = None
    kept: np.ndarray | None = None
    watched: dict[str, np.ndarray] = field(default_factory=dict)
    networks: np.ndarray | None = None


def is_crowd(setting: Setting, local: bool = False) -> bool:
    """Whether the estimates of a trial take so much memory that no other such trial should run at the same time."""
    rounds = setting.rounds * (setting.observations_per_round if local else 1)
    return 8 * setting.robots * min(rounds, ROWS_OF_A_CROWD) > SHARED_BYTES


def is_shared(setting: Setting) -> bool:
    """Whether threads may share a trial."""
    return setting.body is None and setting.robots >= LARGE


def segment_length(robots: int, rounds: int, record_bytes: int, multiple: int) -> int:
    """How many rounds of estimates to keep at a time.

    All rounds if they fit; else the number for which estimates and snapshots together take the least memory, which
    grows with the square root of the rounds; but a hundred where memory allows.
    """
    fits = ROWS_BYTES // (8 * robots)
    crowd = min(ROWS_OF_A_CROWD, CROWD_BYTES // (8 * robots))
    balanced = math.isqrt(rounds * record_bytes // 8)
    length = max(fits, crowd, balanced, 1)
    return min(rounds, -(-length // multiple) * multiple)


def run_batch(
    setting: Setting,
    seed: int,
    first: int,
    trials: int,
    metrics: Metrics,
    stop: np.ndarray,
    local: bool = False,
    spare: dict[tuple[int, ...], np.ndarray] | None = None,
    idle: Callable[[], int] = lambda: 1,
) -> Batch | None:
    """Run trials first ... first + trials - 1; None if `stop` (uint8, shape (1,)) was set meanwhile.

    With `local`, the metrics are of the local estimate by single observation. A trial of a large swarm is shared by as
    many threads as are `idle`, to the same bits. Estimates lie where those of trials before lay, in an array of `spare`
    (by shape), because the system takes up to as long to clear new pages as robots take for their rounds.
    """
    if not (setting.members or setting.spread) and (local or not metrics.watched):
        given = inputs_of(setting, seed, first, trials, order=local)
        return _live(setting, given, trials, metrics, stop, local, spare, idle)
    batches = []
    for k in range(first, first + trials):  # metrics of files see one trial at a time, and trials differ in the others
        own = addresses.in_trial(setting, seed, k)
        batch = _live(own, inputs_of(own, seed, k, order=local), 1, metrics, stop, local, spare, idle)
        if batch is None:
            return None
        batches.append(batch)
    return _joined(batches)


def _live(
    setting: Setting, given: Inputs, trials: int, metrics: Metrics, stop: np.ndarray, local: bool,
    spare: dict[tuple[int, ...], np.ndarray] | None, idle: Callable[[], int],
) -> Batch | None:  # fmt: skip
    first = given.first
    looks = setting.observations_per_round
    rounds = setting.rounds * (looks if local else 1)
    if local:  # nobody hears anything
        given = given._replace(radio=given.radio._replace(delay=0))
    delay = given.radio.delay
    honest = given.honest[0] if given.honest.size else slice(None)
    with blaming(setting, first, trials):
        swarm = swarm_of(setting, given, "alone" if local else setting.use)
    # NumPy asks for huge pages where a large array wants them, Numba does not
    states = states_of(setting, swarm, delay + 2, np.empty((0, setting.robots)))
    memory, outbox, signals, _ = states
    kept = memory.nbytes + (outbox.nbytes + signals.nbytes if delay else 0)  # where a segment may be run again
    length = segment_length(setting.robots, rounds, kept // setting.robots, looks if local else 1)
    segments = -(-rounds // length)
    spare = {} if spare is None else spare
    rows = spare.pop((length, setting.robots), None)  # of several threads one gets them, and others make their own
    spare.clear()
    states = states._replace(rows=np.empty((length, setting.robots)) if rows is None else rows)
    team = min(idle(), 4 * setting.robots // LARGE, swarm.of_block.size - 1) if is_shared(setting) else 1
    room = room_of(states, max(segments - 2, 0), max(segments - 2, 0) if delay else 0, team)
    measures = measures_of(setting, trials, replace(metrics, checkpoints=()) if local else metrics)
    tally = tally_of(setting, trials, local)
    checkpoints = np.array(metrics.checkpoints, np.int64)
    intervals = no_intervals(trials) if local else intervals_of(setting, checkpoints, setting.fill_ratios, trials)
    watched = () if local else metrics.watched
    watches = [Watch(m, setting, first, setting.fill_ratios, metrics.delta, metrics.bins) for m in watched]
    last = 2 * segments - 1
    for begin, end in itertools.pairwise(sorted({*range(segments + 1), last})) if watches else ((0, last),):
        with blaming(setting, first, trials):
            groups = given, states, room, measures, tally, intervals, rounds, local, begin, end
            finished = _simulate(swarm, groups, stop, team)
        if not finished:
            return None
        # before a metric fails because of them
        check_answers(setting, given, measures.wrong, tally.verdicts, intervals, local)
        for watch in watches if begin < segments else ():
            watch.see(np.ascontiguousarray(states.rows[: rounds - begin * length, honest]), begin * length + 1)
    spare[states.rows.shape] = states.rows
    del swarm, states, rows, room, groups  # before there is more: for a large swarm they take much memory
    batch = batch_of(setting, given, metrics, measures, tally, intervals.sure.transpose(1, 2, 0))
    networks = None if local else networks_of(setting, given.links, trials)
    return replace(batch, watched=results_of(watches), networks=networks)


def batch_of(
    setting: Setting, given: Inputs, metrics: Metrics, measures: Measures, tally: Tally, intervals: np.ndarray,
    truth: float | None = None,
) -> Batch:  # fmt: skip
    """What was measured of honest robots; `truth` is the fill ratio that errors refer to, by default the setting's."""
    trials, robots = measures.where.shape
    honest = given.honest if given.honest.size else np.ones((trials, robots), np.bool_)
    truth = setting.fill_ratio if truth is None else truth

    def counted(array: np.ndarray) -> np.ndarray:
        """The honest robots of (trial, robot, ...)."""
        return array if honest.all() else array[honest].reshape(trials, honest[0].sum(), *array.shape[2:])

    return Batch(
        convergence=counted(measures.where),
        error=counted(np.abs(measures.value - truth)),
        final=counted(measures.final),
        correct=measures.correct,
        disagreement=measures.disagreement,
        agreement=measures.agreement,
        counts=counted(tally.counts.transpose(0, 2, 1)).transpose(0, 2, 1),
        verdicts=counted(tally.verdicts) if tally.verdicts.size else tally.verdicts,
        consensus=consensus_of(setting, tally.agreed, truth),
        intervals=intervals,
        fill_ratio=np.full(trials, setting.fill_ratio),
        kept=counted(measures.kept.transpose(1, 2, 0)).transpose(2, 0, 1) if metrics.estimates else None,
    )


def _simulate(swarm: Swarm, groups: tuple[Any, ...], stop: np.ndarray, team: int) -> bool:
    """Whether `kernel.simulate` came to the end, in one thread or in several that share each trial."""
    simulate = compiler.compile_world("kernel").simulate
    if team == 1:
        return bool(simulate(swarm, *groups, stop, ALONE, work_of(swarm, groups[0], groups[1], groups[-3])))
    parts, sums = parts_of(swarm, team), sums_of(groups[1])

    groups[2].votes[:] = 0.0

    def run_part(number: int, gate: int, here: int, halt: np.ndarray) -> bool:
        own, begin = parts[number]
        work = work_of(own, groups[0], groups[1], groups[-3], begin * BLOCK, sums)
        return bool(simulate(own, *groups, halt, np.array([begin, number, team, gate, here]), work))

    return all(run_together(run_part, team, stop))


def room_of(states: States, snapshots: int, outboxes: int, threads: int = 1) -> Segments:
    """Room for so many copies of states, and of their messages, and for what threads that share a trial tell others."""
    return Segments(
        np.empty((snapshots, *states.memory.shape), np.uint8),
        np.empty((outboxes, *states.outbox.shape), np.uint8),
        np.empty((outboxes, *states.signals.shape), np.uint8),
        np.empty((3, states.memory.shape[0])),
        np.zeros((4, threads)),
    )


def sums_of(states: States) -> np.ndarray:
    """Room for sums of the messages of blocks of robots."""
    return np.empty((-(-states.memory.shape[0] // BLOCK), states.outbox.shape[1]), np.uint8)


def work_of(
    swarm: Swarm, given: Inputs, states: States, local: bool = False, begin: int = 0, sums: np.ndarray | None = None,
    most: int = 0,
) -> Work:  # fmt: skip
    """Room to work in, for the robots of a swarm, from `begin` on; those that move hear at most `most` at once."""
    robots, looks, accuracies = len(states.memory), given.sensors.looks, given.sensors.b.shape[1]
    own = min((swarm.of_block.size - 1) * BLOCK, robots - begin)
    at_once, luck = own if local else min(own, BLOCK), swarm.draws.size > 0
    sums = sums_of(states) if sums is None else sums
    if luck or swarm.is_signalled or given.radio.threshold or given.stops.size:
        most = max(most, _most_arrivals(given.links, robots))
    return Work(
        np.zeros(at_once), np.zeros(at_once, np.uint64), np.zeros(own if local else 0),
        np.zeros((3, max(at_once, min(own, BLOCKS * BLOCK), most) if luck else 0), np.uint64),
        sums, np.zeros((2 * len(sums), sums.shape[1]), np.uint8),
        np.zeros((2, most if given.links.mode != PAIRS else robots), np.uint32),
        np.empty(((looks >= PART) + (looks % PART > 0), accuracies, COLUMNS), np.uint64),
        np.full((3, accuracies), np.nan), np.empty(robots + 1, np.int64), np.empty(robots), np.empty(1),
        np.empty((3, 0), np.int64),
    )  # fmt: skip


def _most_arrivals(links: Links, robots: int) -> int:
    """How many messages may arrive at a block of robots in a round, or among pairs at one robot."""
    if links.mode == PAIRS:
        return robots
    if robots <= BLOCK:
        return int(np.diff(links.starts).max())
    graphs = itertools.pairwise(links.starts.tolist())
    return max(int(np.bincount(links.receivers[a:z] // BLOCK, minlength=1).max()) for a, z in graphs)


def measures_of(setting: Setting, trials: int, metrics: Metrics) -> Measures:
    """Room for the metrics of a batch."""
    shape, count = (trials, setting.robots), len(metrics.checkpoints)
    return Measures(
        metrics.delta,
        bins_at(setting.fill_ratio, setting.change, metrics.checkpoints, metrics.bins),
        np.zeros(shape, np.int64),
        np.zeros(shape),
        np.zeros(shape),
        np.full((count, trials), np.nan),
        np.full((count, trials), np.nan),
        np.zeros(trials),
        np.full((count if metrics.estimates else 0, *shape), np.nan),
        np.full((trials, 3), -1.0),
    )


def _joined(batches: Sequence[Batch]) -> Batch:
    """Several trials' batches as one."""
    axes = {"correct": 1, "disagreement": 1, "intervals": 2, "kept": 1, "networks": 1}  # of trials; of others it is 0
    columns = {name: [getattr(b, name) for b in batches] for name in vars(batches[0]) if name != "watched"}
    arrays = {n: np.concatenate(c, axes.get(n, 0)) for n, c in columns.items() if c[0] is not None}
    watched = {name: np.concatenate([b.watched[name] for b in batches]) for name in batches[0].watched}
    return Batch(**arrays, watched=watched)


@functools.lru_cache(maxsize=256)
def bins_at(fill_ratio: float, change: Change | None, checkpoints: tuple[int, ...], bins: int) -> np.ndarray:
    """The ends of the right bins at checkpoints, (checkpoint, 2); they are only read."""
    return right_bins(along(change.course if change else steady(fill_ratio), checkpoints), bins)


@interruptible
def record_estimates(setting: Setting, seed: int, trial: int) -> np.ndarray:
    """The estimates (round, robot) of one trial, index 0 before any observation, as `Stepped` gives them.

    They are the rows that a run measures, so nothing is compiled for them after a run of the setting.
    """
    given, estimates = inputs_of(setting, seed, trial), np.empty((setting.rounds + 1, setting.robots))
    with blaming(setting, trial):
        swarm = swarm_of(setting, given, setting.use)
        states = states_of(setting, swarm, setting.message_delay + 2, estimates[1:])
        room, stop = room_of(states, 0, 0), np.zeros(1, np.uint8)
        measures = measures_of(setting, 1, Metrics(delta=1.0, bins=1, checkpoints=()))
        tally = Tally(np.zeros((1, 2, 0), np.int64), np.empty((1, 0, VERDICTS)), np.empty((1, 2)))
        groups = swarm, given, states, room, measures, tally, no_intervals()
        work = work_of(swarm, given, states)
        compiler.compile_world("kernel").simulate(*groups, setting.rounds, False, 0, 1, stop, ALONE, work)
    estimates[0] = room.extremes[2]
    return estimates


def record_readings(setting: Setting, seed: int, trial: int) -> np.ndarray:
    """The single readings (observation, robot), 1 black, that the rounds of a trial are made of."""
    out = np.zeros((setting.rounds * setting.observations_per_round, setting.robots))
    given = inputs_of(setting, seed, trial, order=True)
    compiler.compile_world().single_readings(given.sensors.of_trial(0), trial, out)
    return out


def seconds(setting: Setting, local: bool = False) -> float:
    """A rough prediction of a trial's cost on one core, for batches of a fair size and the time left."""
    looks = setting.observations_per_round
    if setting.body is not None:
        return setting.rounds * setting.robots * 40e-9
    if local:
        return setting.rounds * looks * setting.robots * 15e-9
    messages = 2.0 if setting.topology.edges is None else 2.0 * len(setting.topology.edges) / setting.robots
    if setting.topology.name == "full" and not (setting.additive and setting.hears_all):
        messages = float(setting.robots)
    return setting.rounds * setting.robots * (13e-9 + 3e-9 * messages + 2e-9 * (looks // PART)) + 20e-6


def walk_seconds(setting: Setting) -> float:
    """A rough prediction of the cost of a trial's walk."""
    return setting.rounds * setting.robots * (100e-9 + 30e-9 * (setting.density or 0.0))
