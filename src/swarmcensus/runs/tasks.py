"""Cuts a study into tasks, bundles short ones, and runs bundles."""

from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import nullcontext
from dataclasses import dataclass, field, replace
from threading import Lock
from typing import TYPE_CHECKING, Any, Literal

import numpy as np
from numpy.typing import NDArray

from swarmcensus.engine.constants import (
    CHANGED,
    CLIPPED,
    DECIDED_IN,
    DECISION,
    DONE_ESTIMATE,
    DONE_IN,
    HEARD,
    SENT,
    VERDICTS,
)
from swarmcensus.results import INTERVALS, Columns, Piece
from swarmcensus.simulation import (
    Batch,
    MetricFails,
    Metrics,
    is_crowd,
    line_of_failure,
    run_batch,
    run_ride,
    seconds,
    walk_seconds,
)
from swarmcensus.studies import KEYS, Setting, Study, addresses
from swarmcensus.support.errors import InputError

if TYPE_CHECKING:
    from swarmcensus.gpu import Card

RIDE_BYTES = 256_000_000  # most memory for the curves of all states on one trajectory
CROWDS = Lock()  # for trials that run one at a time, as they take much memory: each uses all threads
EARLY_ONE_IN = 10  # one in so many trials of each setting is run first: a run that is cut off covers all settings
EARLY_SECONDS = 5e-3  # a setting that takes less is not split for that: one more task costs 0.1 ms
CARD_SPEED = 300.0  # cores that a card is about as fast as


@dataclass(frozen=True)
class Task:
    """Some trials of one setting, or of several at once.

    A "batch" is of one setting. A "local" task computes local estimates for all settings with equal
    observations. A "ride" is one trial of all settings that share its trajectories.
    """

    kind: Literal["batch", "local", "ride"]
    settings: tuple[int, ...]
    first: int
    trials: int
    cost: float  # predicted seconds on one core, or on a card
    on_card: bool = False


@dataclass(frozen=True)
class Failure:
    """A trial that could not be run, and why."""

    setting: int
    trial: int
    why: str


@dataclass
class ThreadBudget:
    """The threads of a run, the bundles that they have not finished, and memory for their next trials."""

    jobs: int = 1
    unfinished: set[object] = field(default_factory=set)
    spare: dict[tuple[int, ...], NDArray[np.float64]] = field(default_factory=dict)  # see `run_batch`

    def idle(self) -> int:
        """How many threads a bundle may use: those that have none are shared among all that have."""
        return max(1, self.jobs // max(1, len(self.unfinished)))


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
        study.stored,
    )


def plan_tasks(
    settings: Sequence[Setting],
    wanted: Wanted,
    local: Wanted | None,
    seconds: float,
    room: NDArray[np.int64] | None = None,
) -> list[Task]:
    """The tasks for all trials that are `wanted`, each of at most about `seconds`.

    Some trials of every setting come first, so that a run that is cut off covers the whole study. `local` marks the
    trials of which local estimates are wanted. `room`, (setting,), is how many trials a card runs at a time, and 0 for
    settings that run on the CPU.
    """
    tasks: list[Task] = []
    rooms = [0] * len(settings) if room is None else room.tolist()
    # usually all trials are wanted, and finding spans setting by setting costs as much as a tiny trial
    every = [bool(row) for row in np.atleast_1d(wanted.all(axis=1))]
    for number, setting in enumerate(settings):
        if setting.body is None:
            spans = [(0, wanted.shape[1])] if every[number] else _spans(wanted[number])
            tasks += _split("batch", (number,), setting, spans, seconds, rooms[number])
    if local is not None:
        deaf: dict[str, Any] = {key.field: key.default for key in KEYS.values() if key.messages}
        for numbers in _group_by(settings, lambda s: replace(s, topology=settings[0].topology, **deaf)):
            lacking = np.asarray(local[list(numbers)].any(axis=0))
            tasks += _split("local", numbers, settings[numbers[0]], _spans(lacking), seconds, rooms[numbers[0]])
    for numbers in _group_by(settings, lambda s: addresses.walk_group(s) if s.body else None):
        if settings[numbers[0]].body is not None:
            tasks += _shared_walks(numbers, settings, wanted)
    return sorted(tasks, key=lambda task: task.first)


def bundle_tasks(tasks: Iterable[Task], seconds: float) -> Iterator[Bundle]:
    """Tasks, in order, as bundles of about `seconds` each; those for a card come first, because they wait for it."""
    bundle: list[Task] = []
    cost = 0.0
    for task in sorted(tasks, key=lambda task: not task.on_card):
        if bundle and (cost >= seconds or bundle[-1].on_card != task.on_card):
            yield tuple(bundle)
            bundle, cost = [], 0.0
        bundle.append(task)
        cost += task.cost
    if bundle:
        yield tuple(bundle)


def _shared_walks(numbers: tuple[int, ...], settings: Sequence[Setting], wanted: Wanted) -> Iterator[Task]:
    first = settings[numbers[0]]
    most = max(1, RIDE_BYTES // (8 * first.robots * first.rounds))
    for trial in range(wanted.shape[1]):
        walking = [n for n in numbers if wanted[n, trial]]
        for k in range(0, len(walking), most):
            sharing = tuple(walking[k : k + most])
            yield Task("ride", sharing, trial, 1, walk_seconds(first) + len(sharing) * seconds(first))


def _group_by(settings: Sequence[Setting], content: Callable[[Setting], object]) -> list[tuple[int, ...]]:
    groups: dict[object, list[int]] = {}
    for number, setting in enumerate(settings):
        groups.setdefault(content(setting), []).append(number)
    return [tuple(numbers) for numbers in groups.values()]


def _spans(wanted: NDArray[np.bool_]) -> list[tuple[int, int]]:
    """Ranges of consecutive wanted trials: (first, last + 1) of each."""
    edges = np.flatnonzero(np.diff(wanted, prepend=False, append=False)).tolist()
    return list(zip(edges[::2], edges[1::2], strict=True))


def _split(
    kind: Literal["batch", "local"],
    numbers: tuple[int, ...],
    setting: Setting,
    spans: Sequence[tuple[int, int]],
    limit: float,
    room: int,
) -> Iterator[Task]:
    cost = seconds(setting, kind == "local") / (CARD_SPEED if room else 1.0)
    size = room or max(1, int(limit / cost))  # few trials would leave most of a card idle
    for begin, end in spans:
        some_early = not room and cost * (end - begin) >= EARLY_SECONDS
        early = -(-(end - begin) // EARLY_ONE_IN) if some_early else 0
        first = begin
        while first < end:
            count = min(size, end - first, early or size)
            yield Task(kind, numbers, first, count, cost * count, room > 0)
            first, early = first + count, 0


def run_bundle(
    settings: Sequence[Setting],
    seed: int,
    bundle: Bundle,
    metrics: Metrics,
    stop: NDArray[np.uint8],
    threads: ThreadBudget | None = None,
    outcome: Outcome | None = None,
    card: "Card | None" = None,
) -> Outcome:
    """Run tasks one after another, while `stop` (uint8, shape (1,)) is 0; a failing trial does not affect others.

    Threads of the run that have nothing to do help with large trials. What is done is added to `outcome` at once.
    Tasks for a card run on the CPU if there is no `card`. Raises CardError, also for a card that is full or lost.
    """
    outcome, threads = [] if outcome is None else outcome, threads or ThreadBudget()
    for task in bundle:
        if stop[0]:
            break
        if task.on_card and card is not None:
            _run_on_card(card, settings, seed, task, metrics, stop, outcome)
            continue
        try:
            outcome += _run(settings, seed, task, metrics, stop, threads)
        except InputError as error:
            # single trials, and of a ride also single settings
            together = [(n,) for n in task.settings] if task.kind == "ride" else [task.settings]
            trials, cost = range(task.first, task.first + task.trials), task.cost / (len(together) * task.trials)
            singles = [replace(task, settings=n, first=t, trials=1, cost=cost) for n in together for t in trials]
            if len(singles) == 1:
                is_known = isinstance(error, MetricFails)
                failed = settings[task.settings[0]], seed, task.first, metrics
                location = "" if is_known else line_of_failure(*failed, error)
                outcome += [Failure(n, task.first, f"{error}{location}") for n in task.settings]
            else:
                outcome += run_bundle(settings, seed, tuple(singles), metrics, stop, threads)
    return outcome


def _run_on_card(
    card: "Card",
    settings: Sequence[Setting],
    seed: int,
    task: Task,
    metrics: Metrics,
    stop: NDArray[np.uint8],
    outcome: Outcome,
) -> None:
    """Run a task in batches that fit the card; trials that fail there are run on the CPU, which says why."""
    from swarmcensus.gpu import CardError, CardFull

    setting, local = settings[task.settings[0]], task.kind == "local"
    most, rest = task.trials, [task]
    while rest and not stop[0]:
        part = rest.pop()
        if part.trials > most:
            rest += _cut(part, most)
            continue
        try:
            batch = card.run_batch(setting, seed, part.first, part.trials, metrics, stop, local)
        except CardFull as error:
            if part.trials == 1:
                raise CardFull(f"{error}: it is too small for a trial of {setting}") from error
            most = part.trials // 2
            rest.append(part)
        except CardError:
            raise
        except InputError:
            if part.trials > 1:
                rest += _cut(part, part.trials // 2)
            else:
                run_bundle(settings, seed, (replace(part, on_card=False),), metrics, stop, outcome=outcome)
        else:
            outcome += _pieces(part, [batch] * len(part.settings) if batch else [], metrics)


def _cut(task: Task, trials: int) -> list[Task]:
    """A task without its first trials, and these: the last is run first."""
    share = task.cost / task.trials
    first = replace(task, trials=trials, cost=share * trials)
    left = task.trials - trials
    return [replace(task, first=task.first + trials, trials=left, cost=share * left), first]


def _run(
    settings: Sequence[Setting], seed: int, task: Task, metrics: Metrics, stop: NDArray[np.uint8], threads: ThreadBudget
) -> list[Piece]:
    chosen, local = [settings[n] for n in task.settings], task.kind == "local"
    crowd = task.kind != "ride" and is_crowd(chosen[0], local)
    with CROWDS if crowd else nullcontext():
        if task.kind == "ride":
            batches = run_ride(chosen, seed, task.first, metrics, stop)
        else:
            idle = (lambda: threads.jobs) if crowd else threads.idle
            given = chosen[0], seed, task.first, task.trials, metrics, stop, local, threads.spare, idle
            batch = None if stop[0] else run_batch(*given)
            batches = None if batch is None else [batch] * len(chosen)
    return _pieces(task, batches or [], metrics)


def _pieces(task: Task, batches: Sequence[Batch], metrics: Metrics) -> list[Piece]:
    """The results of a task by setting; none if it was stopped."""
    local = task.kind == "local"
    pairs = zip(task.settings, batches, strict=bool(batches))
    return [Piece(number, task.first, columns(batch, local, metrics), local) for number, batch in pairs]


def columns(batch: Batch, local: bool, metrics: Metrics) -> Columns:
    """The results of some trials by variable, without the dimension `setting`.

    Variables of decisions exist if any brain of the study decides, and are NaN for brains that do not; likewise for
    intervals.
    """
    if local:
        steps = batch.convergence.astype(np.int32)
        return {"local_convergence_step": steps, "local_convergence_error": batch.error}
    fill_ratios = batch.true_fill_ratio
    estimates = {} if batch.kept is None else {"estimates": batch.kept}
    networks = np.full((2, len(batch.final)), np.nan) if batch.networks is None else batch.networks
    return (
        batch.watched
        | estimates
        | _decision_columns(batch, metrics)
        | ({"messages_clipped": batch.counts[:, CLIPPED].astype(np.float64)} if "formats" in metrics.stored else {})
        | ({"drawn_fill_ratio": batch.fill_ratio} if "drawn" in metrics.stored else {})
        | ({"components": networks[0], "mean_degree": networks[1]} if "networks" in metrics.stored else {})
        | (dict(zip(INTERVALS, batch.intervals, strict=True)) if "intervals" in metrics.stored else {})
        | {
            "convergence_round": batch.convergence.astype(np.int32),
            "convergence_error": batch.error,
            "final_estimate": batch.final,
            "correct": batch.correct,
            "agreement_round": batch.agreement,
            "disagreement": batch.disagreement,
            "true_fill_ratio": np.full(len(batch.final), np.nan) if fill_ratios is None else fill_ratios,
            "messages_sent": batch.counts[:, SENT].astype(np.float64),
            "messages_heard": batch.counts[:, HEARD].astype(np.float64),
        }
    )


def _decision_columns(batch: Batch, metrics: Metrics) -> Columns:
    """What robots decided, and when they were done."""
    verdicts = batch.verdicts
    if not verdicts.size and metrics.stored & {"decisions", "endings"}:
        verdicts = np.full((*batch.final.shape, VERDICTS), np.nan)
    out: Columns = {}
    if "decisions" in metrics.stored:
        places = {"decision": DECISION, "decision_round": DECIDED_IN, "decision_change": CHANGED}
        undecided = np.isnan(batch.consensus[:, :1])  # nobody decides, though robots may be done
        out |= {name: np.where(undecided, np.nan, verdicts[..., place]) for name, place in places.items()}
        names = ("consensus", "consensus_round", "consensus_right", "right_option")
        out |= {name: batch.consensus[:, k] for k, name in enumerate(names)}
    if "endings" in metrics.stored:
        out |= {"done_round": verdicts[..., DONE_IN], "done_estimate": verdicts[..., DONE_ESTIMATE]}
    return out
