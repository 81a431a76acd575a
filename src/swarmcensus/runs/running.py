"""Runs a study: its work goes out in bundles to threads or to a cluster, and what is finished is never lost."""

import contextlib
import json
import logging
import time
import warnings
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from functools import partial
from pathlib import Path

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from swarmcensus.basics.errors import InputError, Interrupted
from swarmcensus.basics.formatting import counted
from swarmcensus.results import store
from swarmcensus.results.values import Room, Values
from swarmcensus.runs import pools
from swarmcensus.runs.collect import Progress, State, work
from swarmcensus.runs.forecasts import tell_length
from swarmcensus.runs.progress import showing
from swarmcensus.runs.resuming import hold
from swarmcensus.runs.tasks import bundled, plan
from swarmcensus.simulation.trials import seconds
from swarmcensus.studies.settings import Setting
from swarmcensus.studies.study import Study

LOG = logging.getLogger(__name__)


def run(
    study: Study,
    jobs: int | None = None,
    progress: Callable[[Progress], None] | bool | None = True,
    *,
    out: str | Path | None = None,
    fresh: bool = False,
    cluster: str | None = None,
    share: tuple[int, int] | None = None,
    say: Callable[[str], None] | None = None,
) -> xr.Dataset:
    """Run every trial of every setting and return the dataset (see docs/data-format.md).

    `jobs` threads, by default one a core; the numbers do not depend on it. On a terminal and in a notebook a bar shows
    how far it is, unless `progress` is False; a function is called in its place, from this thread about ten times a
    second. With `out`, the dataset is written there, finished work is kept beside it as
    the run goes on, and what is there already is not run again, unless `fresh`; `say` gets a line on it.
    `cluster` is a Dask scheduler's address, "local:4", or a TOML file (docs/clusters.md). With `share` = (k, n), only
    the k-th of n parts of the trials is run, k from 1: for machines that share nothing, and `merge` afterwards.

    A trial that fails is missing in the dataset and named in its attribute `failed`. Ctrl-C raises Interrupted,
    which carries the dataset of what was done. Raises InputError where nothing could be run.
    """
    study = study if isinstance(study, Study) else Study.load(study)
    jobs = pools.threads(jobs)
    if share is not None and study.until:
        raise InputError(
            f"share {share[0]}/{share[1]}: a study whose trials follow a rule cannot be shared, for how many they are "
            "is not known beforehand: give trials a number"
        )
    if share is not None and not 1 <= share[0] <= share[1] <= study.trials:
        raise InputError(
            f"share {share[0]}/{share[1]}: should be k/n with 1 <= k <= n, and n no more than the study's trials "
            f"({study.trials})"
        )
    settings = study.settings()
    marks = [setting.fingerprint(study.seed) for setting in settings]
    where = f"on {cluster}" if cluster else f"in {counted(jobs, 'thread')}"
    LOG.debug("%s: %s settings, %s trials each, %s", study.name, f"{len(settings):,}", f"{study.trials:,}", where)
    first = next(study.stages())
    with contextlib.ExitStack() as stack:
        report, holding, room = progress if callable(progress) else _quiet, None, Room()
        if progress is True:
            report = stack.enter_context(showing(study.name))
        if out is not None:
            holding = stack.enter_context(hold(Path(out), study, settings, marks, fresh, say or (lambda _: None)))
            room = Room(holding.parts.folder.parent)
        state = State(
            study, settings, Values(study, settings, first, room=room), report, holding, np.full(len(settings), np.nan),
            slice(*(study.trials * k // share[1] for k in (share[0] - 1, share[0]))) if share else slice(None),
        )  # fmt: skip
        if state.holding is not None:
            state.holding.share = "{}/{}".format(*share) if share else ""
            state.holding.fill(state.values)
            known, total = _so_far(state, first, np.ones(len(settings), np.bool_))
            state.holding.announce(known, total, 0.0)  # while it compiles, or waits for workers
            state.holding.parts.sketch = partial(_sketch, state, marks, share)
        begun, cpu, started = time.monotonic(), time.process_time(), time.strftime("%Y-%m-%dT%H:%M:%S%z")
        every = len(settings) * study.trials * (1 + study.measure.local)
        pool = stack.enter_context(_pool(state, min(jobs, every), cluster))
        try:
            interrupted = _run_stages(state, pool, None if cluster else jobs)
        except KeyboardInterrupt:  # between two stages
            interrupted = True
        if interrupted:
            state.values.forget_halves()
        data = store.dataset(study, settings, marks, state.values)
        before = state.holding.seconds if state.holding else (0.0, 0.0)
        done = int(state.values.finished().sum())
        state.failures = list({(f.setting, f.trial): f for f in reversed(state.failures)}.values())
        enough = study.until is not None and not interrupted  # a rule's total is known once it holds
        data.attrs |= {
            "trials_done": done,
            "trials_total": done + len(state.failures) if enough else study.trials * len(settings),
            "started": started,
            "finished": time.strftime("%Y-%m-%dT%H:%M:%S%z"),
            "wall_seconds": round(before[0] + time.monotonic() - begun, 3),
            "cpu_seconds": round(before[1] + time.process_time() - cpu, 3),
        }
        if share is not None:
            data.attrs["share"] = "{}/{}".format(*share)
        if study.until is not None:
            data["half_width"] = store.widths_of_rule(study, state.widths)
        if state.failures:
            _tell(state, data)
        if state.holding is not None:
            state.holding.finish(data)
    if interrupted:
        raise Interrupted(data, data.attrs["trials_done"], data.attrs["trials_total"])
    return data


def _quiet(_: Progress) -> None:
    """Show nothing."""


def _sketch(state: State, marks: list[str], share: tuple[int, int] | None, path: Path) -> None:
    """Write the dataset without any trial: with the shards an early picture of the run."""
    study, settings = state.study, state.settings
    data = store.dataset(study, settings, marks, Values(study, settings, 0))
    data.attrs |= {"trials_done": 0, "trials_total": study.trials * len(settings)}
    if share is not None:
        data.attrs["share"] = "{}/{}".format(*share)
    if study.until is not None:
        data["half_width"] = store.widths_of_rule(study, np.full(len(settings), np.nan))
    store.save(data, path)


def recompute(
    study: Study,
    settings: list[Setting],
    wanted: NDArray[np.bool_],
    local: bool,
    jobs: int | None = None,
    progress: Callable[[Progress], None] | None = None,
) -> Values:
    """Run the trials of these settings of a study that are `wanted`, (setting, trial); those that fail stay missing."""
    jobs = pools.threads(jobs)
    values = Values(study, settings, wanted.shape[1], local)
    state = State(study, settings, values, progress or _quiet, None, np.zeros(0), slice(None))
    tasks = plan(settings, wanted, wanted if local else None, pools.BUNDLE_SECONDS)
    state.total, state.work_total = int(wanted.sum()), sum(task.cost for task in tasks)
    LOG.debug("%s: %s trials again, in %s threads", study.name, f"{state.total:,}", jobs)
    with _pool(state, min(jobs, state.total * (1 + local)), None) as pool:
        if work(state, bundled(tasks, pools.BUNDLE_SECONDS), pool):
            raise KeyboardInterrupt
    return values


def _tell(state: State, data: xr.Dataset) -> None:
    """Say which trials failed; raise InputError where all did."""
    state.failures.sort(key=lambda f: (f.setting, f.trial))
    data.attrs["failed"] = json.dumps([vars(f) for f in state.failures])
    first = state.failures[0].why
    if not state.values.done().any():
        raise InputError(first)
    numbers = {f.setting for f in state.failures}
    warnings.warn(
        f"{counted(len(state.failures), 'trial')} of {counted(len(numbers), 'setting')} failed; the others are "
        "kept. The first: "
        f"setting {state.failures[0].setting}: {first}",
        stacklevel=3,
    )


@contextlib.contextmanager
def _pool(state: State, jobs: int, cluster: str | None) -> Iterator[pools.Pool]:
    if cluster is not None and not _everything_found(state):
        from swarmcensus.runs.clusters import workers

        if "://" not in cluster:  # those workers use the cache of this machine, or of a home that they share
            pools.compile_for([(state.study, state.settings)], state.show)
        with workers(cluster, state.study, state.show) as pool:
            yield pool
        return
    if not _everything_found(state):
        pools.compile_for([(state.study, state.settings)], state.show)
    with ThreadPoolExecutor(jobs, thread_name_prefix="swarmcensus") as executor:
        threads = pools.Threads(executor, jobs, state.study, state.settings)
        try:
            yield threads
        finally:
            threads.halt()


def work_of(study: Study, settings: list[Setting]) -> float:
    """The predicted seconds of a study on one core."""
    every = np.ones((len(settings), study.trials), np.bool_)
    local = every if study.measure.local else None
    return sum(task.cost for task in plan(settings, every, local, pools.BUNDLE_SECONDS))


def _everything_found(state: State) -> bool:
    return state.study.until is None and bool(state.values.done().all())


def _run_stages(state: State, pool: pools.Pool, jobs: int | None) -> bool:
    """Run all trials, of a rule in stages, in so many threads or on a cluster; whether Ctrl-C ended it."""
    open_ = np.ones(len(state.settings), np.bool_)
    for stage, trials in enumerate(state.study.stages()):
        state.values.grow(trials)
        mine = open_[:, np.newaxis] & _in_share(state, trials)
        lacking = mine & ~state.values.done()[:, :trials]
        local = None
        if state.study.measure.local:
            local = mine & ~state.values.done(local=True)[:, :trials]
        some = pool.bundle_seconds(
            sum(seconds(s) * n for s, n in zip(state.settings, lacking.sum(axis=1), strict=True))
        )
        tasks = plan(state.settings, lacking, local, some)
        state.done, state.total = _so_far(state, trials, open_)
        state.work_done, state.work_total = 0.0, sum(task.cost for task in tasks)
        if state.holding:
            state.holding.announce(state.done, state.total, state.work_total)
        if stage == 0:
            tell_length(state.study, state.settings, tasks, jobs)
        if tasks and work(state, bundled(tasks, some), pool):
            return True
        if state.study.until is not None:
            open_[[f.setting for f in state.failures]] = False
            for number in np.flatnonzero(open_):
                state.widths[number] = half_width(state.study, state.values, int(number), trials)
                open_[number] = not state.study.until.holds(state.widths[number])
        if not open_.any():
            break
    return False


def _in_share(state: State, trials: int) -> NDArray[np.bool_]:
    return np.isin(np.arange(trials), np.arange(trials)[state.share])


def _so_far(state: State, trials: int, open_: NDArray[np.bool_]) -> tuple[int, int]:
    """How many trials there are, and with those that the settings still open to a rule lack of so many each."""
    done = state.values.done()[:, :trials] & _in_share(state, trials)
    lacking = open_[:, np.newaxis] & _in_share(state, trials) & ~done
    return int(done.sum()), int(done.sum() + lacking.sum())


def half_width(study: Study, values: Values, number: int, trials: int) -> float:
    """Half the interval that a study's rule looks at, of the first so many trials of a setting."""
    assert study.until is not None
    array = values.arrays[study.until.variable][number]
    if study.until.checkpoint is not None:
        array = array[study.checkpoints.index(study.until.checkpoint), :, np.newaxis]
    else:
        array = array[:, : values.robots[number]]
    return study.until.half_width(array[:trials].astype(np.float64))
