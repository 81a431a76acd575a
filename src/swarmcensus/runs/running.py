"""Runs a study: threads or a cluster run its trials in bundles, and finished work is never lost."""

import contextlib
import json
import os
import time
import warnings
from collections.abc import Callable, Iterable, Iterator
from functools import partial
from pathlib import Path

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from swarmcensus.engine import LeavableThreads
from swarmcensus.engine.compiler import array_layout
from swarmcensus.results import ArrayStore, Values, outline, readable, store
from swarmcensus.runs import pools
from swarmcensus.runs.collect import Report, State, run_bundles
from swarmcensus.runs.devices import Device, Hardware, WhereToRun, placing_of
from swarmcensus.runs.progress import showing
from swarmcensus.runs.resuming import hold_output
from swarmcensus.runs.tasks import Failure, plan_tasks
from swarmcensus.simulation import seconds, warn_of_connections
from swarmcensus.studies import Setting, Study, addresses, warn_of_needs
from swarmcensus.summaries import cautions_of_fill_ratios, cautions_of_trials
from swarmcensus.support.errors import InputError, Interrupted, StudyError
from swarmcensus.support.formatting import counted
from swarmcensus.support.options import in_shell, wrong_option


def run(
    study: Study,
    jobs: int | None = None,
    progress: Report | bool = True,
    *,
    out: str | Path | None = None,
    fresh: bool = False,
    cluster: str | None = None,
    share: tuple[int, int] | None = None,
    say: Callable[[str], None] | None = None,
    cautions: bool = True,
    device: Device = "cpu",
) -> xr.Dataset:
    """Run every trial of every setting and return the dataset (see docs/data-format.md).

    `jobs` is the number of threads, by default one per core; the numbers do not depend on it. On a terminal a bar
    shows the progress, and in a notebook lines, unless `progress` is False. If `progress` is a function, it is called
    instead, from this thread, about ten times a second. With `out`, the dataset is written there. Finished work is kept
    next to it during the run, and is not run again unless `fresh`; `say` receives a line about it. `cluster` is the
    address of a Dask scheduler (docs/long-studies.md). With `share` = (k, n), only the k-th of n parts of the
    trials is run, counted from 1: for machines that share no disk, followed by `merge`.

    With `device` = "gpu", networks run on a graphics card, and what a card cannot run on the CPU, with the same
    numbers (docs/long-studies.md). "auto" uses a card where there is one and it is faster.

    Unless `cautions` is False, warnings name brains that need another study than this one, and settings with results
    that are easily misread, such as a fill ratio on the edge between two bins. A trial that fails is missing in the
    dataset and named in its attribute `failed`. Ctrl-C raises Interrupted, which carries the dataset of the finished
    trials. Raises InputError if nothing could be run.
    """
    study = study if isinstance(study, Study) else Study.load(study)
    study.check_trials()
    hardware = Hardware(jobs, device, cluster)
    if share is not None:
        _check_share(study, share)
    settings = study.settings()
    if cluster is None:
        _check_memory(study.name, max(settings, key=lambda setting: setting.robots))
    marks = [addresses.fingerprint(setting, study.seed) for setting in settings]
    if cautions:
        warn_of_needs(settings, study.measure.bins)
        warn_of_connections(settings, study.seed, study.trials)
        _warn(cautions_of_fill_ratios(settings, study.measure))
    placing = placing_of(hardware, study, settings, study.trials, quiet=not cautions)
    first = next(study.stages())
    with contextlib.ExitStack() as stack:
        report, output, arrays = stack.enter_context(showing(progress, study.name)), None, ArrayStore()
        if out is not None:
            output = stack.enter_context(hold_output(Path(out), study, settings, marks, fresh, say or (lambda _: None)))
            arrays = ArrayStore(output.parts.folder.parent)
        state = State(
            study, settings, Values([study], settings, first, store=arrays), report, output,
            np.full(len(settings), np.nan),
            slice(*(study.trials * k // share[1] for k in (share[0] - 1, share[0]))) if share else slice(None),
            placing,
        )  # fmt: skip
        if state.output is not None:
            state.output.share = "{}/{}".format(*share) if share else ""
            state.output.parts.device = placing.label
            state.output.fill(state.values)
            known, total = _so_far(state, first, np.ones(len(settings), np.bool_))
            state.output.announce(known, total, 0.0)  # for `status`, while brains compile or workers start
            state.output.parts.sketch = partial(_save_without_trials, study, share)
        begun, cpu, started = time.monotonic(), time.process_time(), time.strftime("%Y-%m-%dT%H:%M:%S%z")
        pool = stack.enter_context(_pool(state))
        try:
            interrupted = _run_stages(state, pool)
        except KeyboardInterrupt:  # between two stages
            interrupted = True
        if interrupted:
            state.values.forget_halves()
        data = store.dataset([study], settings, marks, state.values)
        before = state.output.seconds if state.output else (0.0, 0.0)
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
        if devices := {*(state.output.devices if state.output else ()), *state.devices}:
            data.attrs["device"] = ", ".join(sorted(devices))
        if study.until is not None:
            data["half_width"] = store.widths_of_rule(study, state.widths)
        if state.failures:
            _report_failures(state, data)
        if state.output is not None:
            state.output.finish(data)
    if interrupted:
        raise Interrupted(readable(data, arrays), data.attrs["trials_done"], data.attrs["trials_total"])
    if cautions:
        _warn(cautions_of_trials(data))
    return readable(data, arrays)


def _warn(cautions: Iterable[str]) -> None:
    """Give these as warnings, for the line that called the caller."""
    for caution in cautions:
        warnings.warn(caution, stacklevel=3)


def _save_without_trials(study: Study, share: tuple[int, int] | None, path: Path) -> None:
    """Write the dataset without trials; together with the shards it shows the run so far."""
    data = outline([study], merged=False)
    data.attrs |= {"trials_done": 0, "trials_total": study.trials * data.sizes["setting"]}
    if share is not None:
        data.attrs["share"] = "{}/{}".format(*share)
    store.save(data, path)


def recompute(
    study: Study,
    settings: list[Setting],
    wanted: NDArray[np.bool_],
    local: bool,
    placing: WhereToRun,
    progress: Report = lambda _: None,
) -> tuple[Values, list[Failure]]:
    """Run the trials of some settings that are `wanted`, (setting, trial); trials that fail stay missing.

    Returns the values, and what failed.
    """
    values = Values([study], settings, wanted.shape[1], local)
    state = State(study, settings, values, progress, None, np.zeros(0), slice(None), placing)
    tasks = plan_tasks(settings, wanted, wanted if local else None, pools.BUNDLE_SECONDS, placing.room)
    state.total, state.work_total = int(wanted.sum()), sum(task.cost for task in tasks)
    with _pool(state) as pool:
        if run_bundles(state, tasks, pools.BUNDLE_SECONDS, pool):
            raise KeyboardInterrupt
    return values, state.failures


def _report_failures(state: State, data: xr.Dataset) -> None:
    """Record failed trials in `data` and warn of them. Raises InputError if all trials failed."""
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


def _check_share(study: Study, share: tuple[int, int]) -> None:
    shown = "{}/{}".format(*share) if in_shell() else share
    if study.until:
        why = "a study whose trials follow a rule cannot be shared, because their number is not known beforehand"
        raise wrong_option("share", shown, f"{why}: give trials a number")
    if not 1 <= share[0] <= share[1] <= study.trials:
        should = f"should be k/n with 1 <= k <= n, and n no more than the study's trials ({study.trials})"
        raise wrong_option("share", shown, should)


def _check_memory(name: str, setting: Setting) -> None:
    """Raise InputError if this machine's memory cannot hold the states of a swarm."""
    takes = setting.robots * min(array_layout(brain).record.itemsize for brain in setting.brains)
    there = os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES") if hasattr(os, "sysconf") else takes
    if takes > there:
        why = f"their states take at least {takes / 1e9:,.0f} GB of memory, and this machine has {there / 1e9:,.0f} GB"
        raise StudyError.within(f"study {name}", f"robots = {setting.robots}: {why}", "robots", setting.robots)


@contextlib.contextmanager
def _pool(state: State) -> Iterator[pools.Pool]:
    hardware, card = state.placing.hardware, state.placing.card
    if hardware.cluster is not None and not _is_complete(state):
        from swarmcensus.runs.clusters import workers

        with workers(hardware, state.study) as pool:
            yield pool
        return
    if not _is_complete(state):
        pools.compile_for([(state.study, state.placing.on_cpu(state.settings))], state.show)
    jobs = hardware.threads
    with LeavableThreads(jobs) as executor, LeavableThreads(1 if card else 0) as feeder:
        threads = pools.Threads(executor, jobs, state.study, state.settings, card, feeder)
        try:
            yield threads
        finally:
            threads.halt()


def predicted_seconds(study: Study, settings: list[Setting]) -> float:
    """The predicted seconds that a study takes on one core."""
    every = np.ones((len(settings), study.trials), np.bool_)
    local = every if study.measure.local else None
    return sum(task.cost for task in plan_tasks(settings, every, local, pools.BUNDLE_SECONDS))


def _is_complete(state: State) -> bool:
    return state.study.until is None and bool(state.values.done().all())


def _run_stages(state: State, pool: pools.Pool) -> bool:
    """Run all trials, in stages if they follow a rule. Returns whether Ctrl-C ended the run."""
    unsettled = np.ones(len(state.settings), np.bool_)
    for trials in state.study.stages():
        state.values.grow(trials)
        wanted = unsettled[:, np.newaxis] & _in_share(state, trials)
        lacking = wanted & ~state.values.done()[:, :trials]
        local = None
        if state.study.measure.local:
            local = wanted & ~state.values.done(local=True)[:, :trials]
        bundle_seconds = pool.bundle_seconds(
            sum(seconds(s) * n for s, n in zip(state.settings, lacking.sum(axis=1), strict=True))
        )
        tasks = plan_tasks(state.settings, lacking, local, bundle_seconds, state.placing.room)
        if any(task.on_card for task in tasks):
            state.devices = {state.placing.label}
        state.done, state.total = _so_far(state, trials, unsettled)
        state.work_done, state.work_total = 0.0, sum(task.cost for task in tasks)
        state.part = "this stage" if trials < state.study.trials else ""
        if state.output:
            state.output.announce(state.done, state.total, state.work_total)
        if tasks and run_bundles(state, tasks, bundle_seconds, pool):
            return True
        if state.study.until is not None:
            unsettled[[f.setting for f in state.failures]] = False
            for number in np.flatnonzero(unsettled):
                state.widths[number] = half_width(state.study, state.values, int(number), trials)
                unsettled[number] = not state.study.until.holds(state.widths[number])
        if not unsettled.any():
            break
    return False


def _in_share(state: State, trials: int) -> NDArray[np.bool_]:
    return np.isin(np.arange(trials), np.arange(trials)[state.share])


def _so_far(state: State, trials: int, unsettled: NDArray[np.bool_]) -> tuple[int, int]:
    """How many of the first `trials` trials are finished, and how many will be, counting unsettled settings alone."""
    done = state.values.done()[:, :trials] & _in_share(state, trials)
    lacking = unsettled[:, np.newaxis] & _in_share(state, trials) & ~done
    return int(done.sum()), int(done.sum() + lacking.sum())


def half_width(study: Study, values: Values, number: int, trials: int) -> float:
    """Half the width of the interval that a study's rule bounds, from a setting's first `trials` trials."""
    assert study.until is not None
    array = values.arrays[study.until.variable][number]
    if study.until.checkpoint is not None:
        array = array[study.checkpoints.index(study.until.checkpoint), :, np.newaxis]
    else:
        array = array[:, : values.robots[number]]
    return study.until.half_width(array[:trials].astype(np.float64))
