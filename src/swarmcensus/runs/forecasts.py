"""Announces how long a long run will take, after measuring how fast each of its brains is on this machine."""

import logging
import time
import warnings
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from swarmcensus.engine import interruptible
from swarmcensus.runs.tasks import Task, metrics_of
from swarmcensus.simulation import is_shared, run_batch, run_ride, watched
from swarmcensus.studies import Setting, Study
from swarmcensus.support.cores import cores
from swarmcensus.support.errors import InputError
from swarmcensus.support.formatting import counted

LONG = 300.0  # seconds: a run that takes longer is announced
VERY_LONG = 86_400.0  # seconds: longer runs are warned of, as they may be a mistake
SLOWEST = 30.0  # no shipped brain takes more than this many times the prediction
PROBE_SECONDS = 0.05  # predicted seconds of the trials by which a brain's speed is measured
MOST_PROBE_SECONDS = 1.0  # if a probe would take longer, the prediction is used unmeasured
UNITS = (
    (365.25 * 86_400.0, "years"), (86_400.0, "days"), (3600.0, "hours"), (60.0, "minutes"), (1.0, "seconds"),
)  # fmt: skip

LOG = logging.getLogger(__name__)


def announce_length(study: Study, settings: Sequence[Setting], tasks: Sequence[Task], jobs: int | None) -> None:
    """Announce how long these tasks take in `jobs` threads, or on one core if None; nothing is said of a short run."""
    used, slowdowns = min(jobs or 1, cores()), [1.0] * len(tasks)
    if jobs and _wall_seconds(settings, tasks, slowdowns, used) * SLOWEST >= LONG:
        slowdowns = _slowdowns(study, settings, tasks)
    whole = _wall_seconds(settings, tasks, slowdowns, used)
    if not tasks or whole < LONG:
        return
    where = f"in {counted(jobs, 'thread')} if nothing else keeps the machine busy" if jobs else "of one core"
    line = f"{study.name}: this takes {'at least' if study.until else 'about'} {duration_text(whole)} {where}"
    shares = [used if is_shared(settings[task.settings[0]]) else 1 for task in tasks]
    trial = max(_trial_seconds(task) * slow / n for task, slow, n in zip(tasks, slowdowns, shares, strict=True))
    if trial >= LONG:
        line += f". A trial alone takes up to {duration_text(trial)}: nothing of it is kept before its end"
    if whole < VERY_LONG:
        LOG.info("%s", line)
    else:
        warnings.warn(line, stacklevel=4)


def duration_text(seconds: float) -> str:
    """A time in two digits, such as "7.2 hours", and at least a second."""
    seconds = max(seconds, 1.0)
    unit, name = next(entry for entry in UNITS if seconds >= entry[0])
    number = float(f"{seconds / unit:.2g}")
    return f"{number:,.12g} {name[:-1] if number == 1.0 else name}"


def _wall_seconds(settings: Sequence[Setting], tasks: Sequence[Task], slowdowns: Sequence[float], cores: int) -> float:
    """The seconds that tasks take on `cores` cores; each task runs on one, but for trials that threads share."""
    each = [task.cost * slowdown for task, slowdown in zip(tasks, slowdowns, strict=True)]
    alone = (cost for cost, task in zip(each, tasks, strict=True) if not is_shared(settings[task.settings[0]]))
    return max(sum(each) / cores, max(alone, default=0.0))


def _trial_seconds(task: Task) -> float:
    return task.cost / task.trials


def _slowdowns(study: Study, settings: Sequence[Setting], tasks: Sequence[Task]) -> list[float]:
    """The ratio of measured to predicted time of each task, measured on a part of its brains' longest trial."""
    longest: dict[object, Task] = {}
    keys = [(task.kind, task.on_card, settings[task.settings[0]].brains) for task in tasks]
    for key, task in zip(keys, tasks, strict=True):
        if key not in longest or _trial_seconds(task) > _trial_seconds(longest[key]):
            longest[key] = task
    slowdowns = {key: _slowdown(study, [settings[n] for n in task.settings], task) for key, task in longest.items()}
    return [slowdowns[key] for key in keys]


def _slowdown(study: Study, settings: Sequence[Setting], task: Task) -> float:
    """The ratio of measured to predicted time of a task's trials.

    Long trials are run in two parts of different length, which gives the time before the first round and the time per
    round; of short trials some are run whole.
    """
    if task.on_card:  # there its brain may not be compiled for this processor
        return 1.0
    cost, rounds = _trial_seconds(task), settings[0].rounds
    short = min(rounds, 1 + max(setting.message_delay for setting in settings))
    longer = min(rounds, max(short + 1, int(rounds * PROBE_SECONDS / cost)))
    if cost * longer / rounds > MOST_PROBE_SECONDS:
        return 1.0
    try:
        if longer == rounds:
            trials = min(task.trials, max(1, int(PROBE_SECONDS / cost)))
            return _measured_seconds(study, settings, task.kind, rounds, trials) / (trials * cost)
        short_seconds, long_seconds = (
            _measured_seconds(study, settings, task.kind, part, 1) for part in (short, longer)
        )
        per_round = max(long_seconds - short_seconds, 0.0) / (longer - short)
        return (short_seconds + per_round * (rounds - short)) / cost
    except InputError:  # the run itself reports it
        return 1.0


@interruptible
def _measured_seconds(study: Study, settings: Sequence[Setting], kind: str, rounds: int, trials: int) -> float:
    """The processor time of some trials in seconds; the time on the clock may include other programs."""
    parts, stop = [replace(setting, rounds=rounds) for setting in settings], np.zeros(1, np.uint8)
    begun = time.thread_time()
    with watched(settings, study.seed, 0, trials):
        if kind == "ride":
            run_ride(parts, study.seed, 0, metrics_of(study), stop)
        else:
            run_batch(parts[0], study.seed, 0, trials, metrics_of(study), stop, kind == "local")
    return time.thread_time() - begun
