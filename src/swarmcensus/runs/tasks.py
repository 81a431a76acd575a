"""What a study's work is cut into: tasks, bundled so that none is too short to be worth handing out."""

import math
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from swarmcensus.basics.errors import InputError
from swarmcensus.engine.constants import (
    CHANGED,
    COVERAGE,
    DECIDED_IN,
    DECISION,
    DONE_ESTIMATE,
    DONE_IN,
    HEARD,
    SENT,
    VERDICTS,
    WIDTH,
)
from swarmcensus.results.values import Columns, Piece
from swarmcensus.simulation.blaming import line_of_failure
from swarmcensus.simulation.rides import run_ride
from swarmcensus.simulation.trials import NOT_FINITE, Batch, Metrics, blame, run_batch, seconds, walk_seconds
from swarmcensus.simulation.watches import MetricFails
from swarmcensus.studies.settings import Setting
from swarmcensus.studies.study import Study

RIDERS_BYTES = 256_000_000  # of curves that the minds on one walk may fill
EARLY = 10  # of so many trials of a setting, one is run before those of others go on: for an early picture
WORTH = 5e-3  # seconds of a setting from which that is worth its cost, of a tenth of a millisecond


@dataclass(frozen=True)
class Task:
    """Some trials of one setting, or of several at once.

    A local task serves every setting whose robots see the same; a ride is one trial of settings that share
    its walk.
    """

    kind: Literal["batch", "local", "ride"]
    settings: tuple[int, ...]
    first: int
    trials: int
    cost: float  # predicted seconds on one core


@dataclass(frozen=True)
class Failure:
    """A trial that could not be run, and why."""

    setting: int
    trial: int
    why: str


Bundle = tuple[Task, ...]
Outcome = list[Piece | Failure]
Wanted = NDArray[np.bool_]  # (setting, trial)


def metrics_of(study: Study) -> Metrics:
    """What a study measures."""
    measure = study.measure
    return Metrics(
        measure.delta,
        measure.bins,
        tuple(study.checkpoints),
        measure.truth == "floor",
        measure.estimates,
        tuple(measure.metrics),
        any(brain.decides for brain in study.brains),
        any(brain.ends for brain in study.brains),
        any(brain.has_interval for brain in study.brains),
    )


def plan(settings: Sequence[Setting], wanted: Wanted, local: Wanted | None, seconds: float) -> list[Task]:
    """The tasks for all trials that are `wanted`, each of about so many seconds at the most.

    Some trials of every setting come before more of any: a run that is cut off has a picture of the whole study.
    `local` is what is wanted of local estimates.
    """
    return sorted(_tasks(settings, wanted, local, seconds), key=lambda task: task.first)


def _tasks(settings: Sequence[Setting], wanted: Wanted, local: Wanted | None, seconds: float) -> Iterator[Task]:
    # nearly always all of them: to look at each setting costs as much as a tiny trial
    every = [bool(row) for row in np.atleast_1d(wanted.all(axis=1))]
    for number, setting in enumerate(settings):
        if setting.body is None:
            stretches = [(0, wanted.shape[1])] if every[number] else _stretches(wanted[number])
            yield from _split("batch", (number,), setting, stretches, seconds)
    if local is not None:
        for numbers in _alike(settings, lambda s: replace(s, topology=settings[0].topology, link_success=1.0, delay=0)):
            lacking = np.asarray(local[list(numbers)].any(axis=0))
            yield from _split("local", numbers, settings[numbers[0]], _stretches(lacking), seconds)
    for numbers in _alike(settings, lambda s: s.walk_group if s.body else None):
        if settings[numbers[0]].body is not None:
            yield from _rides(numbers, settings, wanted)


def bundled(tasks: Iterable[Task], seconds: float) -> Iterator[Bundle]:
    """The same tasks, in order, as bundles of about so many seconds."""
    bundle: list[Task] = []
    cost = 0.0
    for task in tasks:
        bundle.append(task)
        cost += task.cost
        if cost >= seconds:
            yield tuple(bundle)
            bundle, cost = [], 0.0
    if bundle:
        yield tuple(bundle)


def _rides(numbers: tuple[int, ...], settings: Sequence[Setting], wanted: Wanted) -> Iterator[Task]:
    first = settings[numbers[0]]
    some = max(1, RIDERS_BYTES // (8 * first.robots * first.rounds))
    for trial in range(wanted.shape[1]):
        riding = [n for n in numbers if wanted[n, trial]]
        for k in range(0, len(riding), some):
            riders = tuple(riding[k : k + some])
            yield Task("ride", riders, trial, 1, walk_seconds(first) + len(riders) * seconds(first))


def _alike(settings: Sequence[Setting], content: Callable[[Setting], object]) -> list[tuple[int, ...]]:
    groups: dict[object, list[int]] = {}
    for number, setting in enumerate(settings):
        groups.setdefault(content(setting), []).append(number)
    return [tuple(numbers) for numbers in groups.values()]


def _stretches(wanted: NDArray[np.bool_]) -> list[tuple[int, int]]:
    """The runs of trials that are wanted, each from its first to after its last."""
    edges = np.flatnonzero(np.diff(wanted, prepend=False, append=False)).tolist()
    return list(zip(edges[::2], edges[1::2], strict=True))


def _split(
    kind: Literal["batch", "local"],
    numbers: tuple[int, ...],
    setting: Setting,
    stretches: Sequence[tuple[int, int]],
    long: float,
) -> Iterator[Task]:
    cost = seconds(setting, kind == "local")
    size = max(1, int(long / cost))
    for begin, end in stretches:
        early = -(-(end - begin) // EARLY) if cost * (end - begin) >= WORTH else 0
        first = begin
        while first < end:
            count = min(size, end - first, early or size)
            yield Task(kind, numbers, first, count, cost * count)
            first, early = first + count, 0


def run_bundle(
    settings: Sequence[Setting],
    seed: int,
    bundle: Bundle,
    metrics: Metrics,
    stop: NDArray[np.uint8],
    threads: int = 1,
) -> Outcome:
    """Run tasks one after another, as far as `stop` (uint8, shape (1,)) stays 0; a trial that fails, fails alone.

    So many `threads` do this at once and share the memory.
    """
    outcome: Outcome = []
    for task in bundle:
        if stop[0]:
            break
        try:
            outcome += _run(settings, seed, task, metrics, stop, threads)
        except InputError as error:
            parts = _parts(task)
            if len(parts) == 1:
                known = {one.setting for one in outcome if isinstance(one, Failure)}
                first = task.settings[0]
                told = first in known or isinstance(error, MetricFails)  # one line a setting: CPython is slow
                where = "" if told else line_of_failure(settings[first], seed, task.first, metrics.checkpoints)
                outcome += [Failure(n, task.first, f"{error}{where}") for n in task.settings]
            else:
                outcome += run_bundle(settings, seed, tuple(parts), metrics, stop, threads)
    return outcome


def _parts(task: Task) -> list[Task]:
    """The same trial by trial, and a ride also mind by mind."""
    together = [(n,) for n in task.settings] if task.kind == "ride" else [task.settings]
    trials = range(task.first, task.first + task.trials)
    share = task.cost / (len(together) * task.trials)
    return [replace(task, settings=n, first=t, trials=1, cost=share) for n in together for t in trials]


def _run(
    settings: Sequence[Setting], seed: int, task: Task, metrics: Metrics, stop: NDArray[np.uint8], threads: int
) -> list[Piece]:
    chosen = [settings[n] for n in task.settings]
    if task.kind == "ride":
        batches = run_ride(chosen, seed, task.first, metrics, stop)
    else:
        local = task.kind == "local"
        batch = run_batch(chosen[0], seed, task.first, task.trials, metrics, stop, local, threads)
        batches = None if batch is None else [batch] * len(chosen)
    local = task.kind == "local"
    pieces = []
    for number, batch in zip(task.settings, batches or [], strict=bool(batches)):
        # a sum costs half of a look at each number, and is finite but where one is not, or is beyond all reason
        if not math.isfinite(batch.error.sum() + batch.final.sum()) or (batch.kept is not None and not local):
            setting, kept = settings[number], batch.kept
            looked = [] if kept is None or local else [kept[np.array(metrics.checkpoints) <= setting.rounds]]
            if not all(np.isfinite(numbers).all() for numbers in (batch.error, batch.final, *looked)):
                what = ArithmeticError(NOT_FINITE)
                raise blame(setting, task.first, task.trials, what)
        pieces.append(Piece(number, task.first, columns(batch, local, metrics), local))
    return pieces


def columns(batch: Batch, local: bool, metrics: Metrics) -> Columns:
    """What came of some trials, by the variables' names; without the dimension `setting`.

    Variables of decisions are there if any brain of the study decides, NaN of one that does not; those of intervals
    likewise.
    """
    if local:
        return {
            "local_convergence_step": batch.convergence.astype(np.int32),
            "local_convergence_error": batch.error,
        }
    filled, sure = batch.true_fill_ratio, batch.intervals
    kept = {} if batch.kept is None else {"estimates": batch.kept}
    return (
        batch.watched
        | kept
        | _decided(batch, metrics)
        | ({"coverage": sure[COVERAGE], "interval_width": sure[WIDTH]} if metrics.intervals else {})
        | {
            "convergence_round": batch.convergence.astype(np.int32),
            "convergence_error": batch.error,
            "final_estimate": batch.final,
            "correct": batch.correct,
            "true_fill_ratio": np.full(len(batch.final), np.nan) if filled is None else filled,
            "messages_sent": batch.counts[:, SENT].astype(np.float64),
            "messages_heard": batch.counts[:, HEARD].astype(np.float64),
        }
    )


def _decided(batch: Batch, metrics: Metrics) -> Columns:
    """What robots decided, and when they were done."""
    verdicts = batch.verdicts
    if not verdicts.size and (metrics.decides or metrics.ends):
        verdicts = np.full((*batch.final.shape, VERDICTS), np.nan)
    found: Columns = {}
    if metrics.decides:
        places = {"decision": DECISION, "decision_round": DECIDED_IN, "decision_change": CHANGED}
        no_one = np.isnan(batch.consensus[:, :1])  # decides, and somebody may yet be done
        found |= {name: np.where(no_one, np.nan, verdicts[..., place]) for name, place in places.items()}
        names = ("consensus", "consensus_round", "consensus_right", "right_option")
        found |= {name: batch.consensus[:, k] for k, name in enumerate(names)}
    if metrics.ends:
        found |= {"done_round": verdicts[..., DONE_IN], "done_estimate": verdicts[..., DONE_ESTIMATE]}
    return found
