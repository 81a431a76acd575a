"""Announces before a long run how long it takes at least, by the time that a simple brain takes."""

import logging
import warnings
from collections.abc import Sequence

from swarmcensus.runs.tasks import Task
from swarmcensus.simulation import is_shared
from swarmcensus.studies import Setting, Study
from swarmcensus.support.cores import cores
from swarmcensus.support.formatting import counted

LONG = 300.0  # seconds: a run that takes longer is announced
VERY_LONG = 86_400.0  # seconds: longer runs are warned of, as they may be a mistake
UNITS = (
    (365.25 * 86_400.0, "years"), (86_400.0, "days"), (3600.0, "hours"), (60.0, "minutes"), (1.0, "seconds"),
)  # fmt: skip

LOG = logging.getLogger(__name__)


def announce_length(study: Study, settings: Sequence[Setting], tasks: Sequence[Task], jobs: int | None) -> None:
    """Announce how long these tasks take in `jobs` threads, or on one core if None; nothing is said of a short run."""
    used = min(jobs or 1, cores())
    whole = _wall_seconds(settings, tasks, used)
    if not tasks or whole < LONG:
        return
    where = f"in {counted(jobs, 'thread')} if nothing else keeps the machine busy" if jobs else "of one core"
    line = f"{study.name}: this takes {duration_text(whole)} or more {where}"
    shares = [used if is_shared(settings[task.settings[0]]) else 1 for task in tasks]
    trial = max(task.cost / task.trials / n for task, n in zip(tasks, shares, strict=True))
    if trial >= LONG:
        line += f". A trial alone takes {duration_text(trial)} or more: nothing of it is kept before its end"
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


def _wall_seconds(settings: Sequence[Setting], tasks: Sequence[Task], cores: int) -> float:
    """The seconds that tasks take on `cores` cores; each task runs on one, but for trials that threads share."""
    alone = (task.cost for task in tasks if not is_shared(settings[task.settings[0]]))
    return max(sum(task.cost for task in tasks) / cores, max(alone, default=0.0))
