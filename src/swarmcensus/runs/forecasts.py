"""How long a run takes, told before it begins where that is long: by how fast each of its brains is here."""

import logging
import os
import time
import warnings
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from swarmcensus.basics.errors import InputError
from swarmcensus.runs.tasks import Task, metrics_of
from swarmcensus.simulation.rides import run_ride
from swarmcensus.simulation.trials import run_batch
from swarmcensus.studies.settings import Setting
from swarmcensus.studies.study import Study

LONG = 300.0  # seconds of a run that are worth a line
VERY_LONG = 86_400.0  # of one that is worth a warning: perhaps nobody meant it
SLOWEST = 30.0  # times the prediction: no shipped brain takes longer than that
TRIED = 0.05  # predicted seconds of a trial by which a brain's speed is measured
MOST_TRIED = 1.0  # where so little as two rounds take longer, the prediction is believed
UNITS = ((365.25 * 86_400.0, "years"), (86_400.0, "days"), (3600.0, "hours"), (60.0, "minutes"))

LOG = logging.getLogger(__name__)


def tell_length(study: Study, settings: Sequence[Setting], tasks: Sequence[Task], jobs: int | None) -> None:
    """Say how long these tasks take in so many threads, or of one core where `jobs` is None, if it is long."""
    if not tasks:
        return
    cores, paces = min(jobs or 1, os.cpu_count() or 1), [1.0] * len(tasks)
    if jobs and _wall(tasks, paces, cores) * SLOWEST >= LONG:
        paces = _paces(study, settings, tasks)
    whole, trial = _wall(tasks, paces, cores), max(_trial(task) * pace for task, pace in zip(tasks, paces, strict=True))
    if whole < LONG:
        return
    where = f"in {jobs} thread{'s' * (jobs > 1)} if nothing else keeps the machine busy" if jobs else "of one core"
    line = f"{study.name}: this takes {'at least' if study.until else 'about'} {told(whole)} {where}"
    if trial >= LONG:
        line += f". A trial alone takes up to {told(trial)}: nothing of it is kept before its end"
    if whole < VERY_LONG:
        LOG.info("%s", line)
    else:
        warnings.warn(line, stacklevel=4)


def told(seconds: float) -> str:
    """A long time in two digits, as "7.2 hours"."""
    unit, name = next((one for one in UNITS if seconds >= one[0]), UNITS[-1])
    return f"{float(f'{seconds / unit:.2g}'):,.12g} {name}"


def _wall(tasks: Sequence[Task], paces: Sequence[float], cores: int) -> float:
    """The seconds that so many cores take: a task is one core's."""
    each = [task.cost * pace for task, pace in zip(tasks, paces, strict=True)]
    return max(sum(each) / cores, max(each))


def _trial(task: Task) -> float:
    return task.cost / task.trials


def _paces(study: Study, settings: Sequence[Setting], tasks: Sequence[Task]) -> list[float]:
    """How many times as long as predicted each task takes: that of its brains' longest trial, of which some is run."""
    longest: dict[object, Task] = {}
    keys = [(task.kind, settings[task.settings[0]].crew) for task in tasks]
    for key, task in zip(keys, tasks, strict=True):
        if key not in longest or _trial(task) > _trial(longest[key]):
            longest[key] = task
    found = {key: _pace(study, [settings[n] for n in task.settings], task) for key, task in longest.items()}
    return [found[key] for key in keys]


def _pace(study: Study, settings: Sequence[Setting], task: Task) -> float:
    """By two parts of a trial, what goes before its first round and what each takes; of short ones, by some whole."""
    cost, rounds = _trial(task), settings[0].rounds
    least = min(rounds, 1 + max(setting.message_delay for setting in settings))
    some = min(rounds, max(least + 1, int(rounds * TRIED / cost)))
    if cost * some / rounds > MOST_TRIED:
        return 1.0
    try:
        if some == rounds:
            trials = min(task.trials, max(1, int(TRIED / cost)))
            return _lived(study, settings, task.kind, rounds, trials) / (trials * cost)
        short, longer = (_lived(study, settings, task.kind, part, 1) for part in (least, some))
        return (short + max(longer - short, 0.0) * (rounds - least) / (some - least)) / cost
    except InputError:  # the run itself says what is wrong
        return 1.0


def _lived(study: Study, settings: Sequence[Setting], kind: str, rounds: int, trials: int) -> float:
    """The processor's seconds of some trials: others may keep the machine busy now, and not later."""
    parts, stop = [replace(setting, rounds=rounds) for setting in settings], np.zeros(1, np.uint8)
    begun = time.thread_time()
    if kind == "ride":
        run_ride(parts, study.seed, 0, metrics_of(study), stop)
    else:
        run_batch(parts[0], study.seed, 0, trials, metrics_of(study), stop, kind == "local")
    return time.thread_time() - begun
