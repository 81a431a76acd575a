"""Runs a study: settings become tasks of a fair size, threads run them, Ctrl-C keeps what is done."""

import contextlib
import itertools
import os
import time
from collections.abc import Callable, Iterator
from concurrent.futures import FIRST_COMPLETED, Future, ThreadPoolExecutor, wait
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np
import xarray as xr

from swarmcensus import results
from swarmcensus.engine import compiler
from swarmcensus.engine.rides import run_ride
from swarmcensus.engine.trials import Batch, Metrics, run_batch, seconds, walk_seconds
from swarmcensus.errors import InputError, Interrupted
from swarmcensus.networks import Topology
from swarmcensus.settings import Setting
from swarmcensus.studies import Study

TASK_SECONDS = 0.1  # long against the cost of starting a task, short against a person's patience
WAIT_SECONDS = 0.1
RIDERS_BYTES = 256_000_000  # of curves that the minds on one walk may fill


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
    cost: float


@dataclass(frozen=True)
class Progress:
    """How far a run is: trials, and predicted seconds of work."""

    done: int
    total: int
    work_done: float
    work_total: float
    note: str = ""  # what is going on where it is not trials


def run(study: Study, jobs: int | None = None, progress: Callable[[Progress], None] | None = None) -> xr.Dataset:
    """Run every trial of every setting and return the dataset (see docs/data-format.md).

    `jobs` threads, by default one a core; the numbers do not depend on it. `progress` is called from this
    thread about ten times a second. Ctrl-C raises Interrupted, which carries the dataset of what was done.
    """
    jobs = jobs or os.cpu_count() or 1
    if jobs < 1:
        raise InputError(f"jobs = {jobs}: at least one thread is needed")
    settings = study.settings()
    tasks = list(plan(study, settings))
    report = progress or (lambda _: None)
    total = study.trials * len(settings)
    metrics = Metrics(study.measure.delta, study.measure.bins, tuple(study.checkpoints), study.measure.truth == "floor")
    for setting in _smallest(settings):  # here, so that threads do not wait for one another
        if not compiler.is_compiled(setting.brain, "ride" if setting.body else "simulate"):
            report(Progress(0, total, 0.0, 1.0, f"compiling {setting.brain.name}, once on this machine"))
        with contextlib.suppress(InputError):  # a brain that fails is named by the real run
            _run_once(setting, metrics)
    begun, cpu = time.monotonic(), time.process_time()
    data = results.empty(study, settings)
    done, interrupted = _work(study, settings, tasks, metrics, jobs, data, report)
    data.attrs |= {
        "trials_done": done,
        "trials_total": total,
        "wall_seconds": round(time.monotonic() - begun, 3),
        "cpu_seconds": round(time.process_time() - cpu, 3),
    }
    if interrupted:
        raise Interrupted(data, done, total)
    return data


def _smallest(settings: list[Setting]) -> list[Setting]:
    """One tiny setting for each brain and kind of world or floor: to run it compiles all that the others need."""
    found = {}
    for setting in settings:
        tiny = replace(setting, robots=1, rounds=1, topology=Topology("line"), faults=())
        if setting.body is not None:
            tiny = replace(tiny, topology=setting.topology, density=1.0)
        found[setting.brain.name, setting.body is None, setting.floor and setting.floor.kind] = tiny
    return list(found.values())


def _run_once(setting: Setting, metrics: Metrics) -> None:
    go = np.zeros(1, np.uint8)
    if setting.body is None:
        run_batch(setting, 0, 0, 1, metrics, go)
    else:
        run_ride([setting], 0, 0, metrics, go)


def plan(study: Study, settings: list[Setting]) -> Iterator[Task]:
    """The tasks of a study, in the order of its settings."""
    for number, setting in enumerate(settings):
        if setting.body is None:
            yield from _split("batch", (number,), setting, study.trials)
    if study.measure.local:
        for numbers in _alike(settings, lambda s: replace(s, topology=settings[0].topology, link_success=1.0)):
            yield from _split("local", numbers, settings[numbers[0]], study.trials)
    for numbers in _alike(settings, lambda s: s.walk_group if s.body else None):
        if settings[numbers[0]].body is not None:
            yield from _rides(numbers, settings, study.trials)


def _rides(numbers: tuple[int, ...], settings: list[Setting], trials: int) -> Iterator[Task]:
    first = settings[numbers[0]]
    some = max(1, RIDERS_BYTES // (8 * first.robots * first.rounds))
    for trial, k in itertools.product(range(trials), range(0, len(numbers), some)):
        riders = numbers[k : k + some]
        yield Task("ride", riders, trial, 1, walk_seconds(first) + len(riders) * seconds(first))


def _alike(settings: list[Setting], content: Callable[[Setting], object]) -> list[tuple[int, ...]]:
    groups: dict[object, list[int]] = {}
    for number, setting in enumerate(settings):
        groups.setdefault(content(setting), []).append(number)
    return [tuple(numbers) for numbers in groups.values()]


def _split(kind: Literal["batch", "local"], numbers: tuple[int, ...], setting: Setting, trials: int) -> Iterator[Task]:
    cost = seconds(setting, kind == "local")
    size = max(1, min(trials, int(TASK_SECONDS / cost)))
    for first in range(0, trials, size):
        count = min(size, trials - first)
        yield Task(kind, numbers, first, count, cost * count)


def _work(
    study: Study,
    settings: list[Setting],
    tasks: list[Task],
    metrics: Metrics,
    jobs: int,
    data: xr.Dataset,
    progress: Callable[[Progress], None],
) -> tuple[int, bool]:
    stop = np.zeros(1, np.uint8)
    total, work_total = study.trials * len(settings), sum(t.cost for t in tasks)
    done, work_done, interrupted = 0, 0.0, False

    def job(task: Task) -> list[Batch] | None:
        chosen = [settings[n] for n in task.settings]
        if task.kind == "ride":
            return run_ride(chosen, study.seed, task.first, metrics, stop)
        batch = run_batch(chosen[0], study.seed, task.first, task.trials, metrics, stop, task.kind == "local")
        return None if batch is None else [batch] * len(chosen)

    waiting: dict[Future[list[Batch] | None], Task] = {}
    rest = iter(tasks)
    with ThreadPoolExecutor(jobs, thread_name_prefix="swarmcensus") as pool:
        try:
            while True:
                while len(waiting) < 4 * jobs and (task := next(rest, None)) is not None:
                    waiting[pool.submit(job, task)] = task
                if not waiting:
                    break
                progress(Progress(done, total, work_done, work_total))
                finished, _ = wait(waiting, timeout=WAIT_SECONDS, return_when=FIRST_COMPLETED)
                for future in finished:
                    task = waiting.pop(future)
                    done += _keep(data, task, future)
                    work_done += task.cost
        except KeyboardInterrupt:
            interrupted = True
        finally:
            stop[0] = 1
            for future in waiting:
                future.cancel()
        if interrupted:
            for future, task in waiting.items():
                if not future.cancelled():
                    done += _keep(data, task, future)
    progress(Progress(done, total, work_done, work_total))
    return done, interrupted


def _keep(data: xr.Dataset, task: Task, future: Future[list[Batch] | None]) -> int:
    batches = future.result()
    if batches is None:
        return 0
    for number, batch in zip(task.settings, batches, strict=True):
        results.store(data, number, task.first, batch, task.kind == "local")
    return 0 if task.kind == "local" else task.trials * len(batches)
