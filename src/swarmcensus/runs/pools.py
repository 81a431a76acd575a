"""Where bundles of trials are run: threads of this process here, the workers of a cluster in `clusters.py`."""

import os
from collections.abc import Callable
from concurrent.futures import Future, ThreadPoolExecutor
from dataclasses import replace
from typing import Protocol

import numpy as np

from swarmcensus.basics.errors import InputError
from swarmcensus.engine import compiler
from swarmcensus.runs.tasks import Bundle, Outcome, Task, metrics_of, run_bundle
from swarmcensus.studies.settings import Setting
from swarmcensus.studies.study import Study
from swarmcensus.worlds.networks import Topology

BUNDLE_SECONDS = 0.1  # long against the cost of handing it out, short against a person's patience
MOST_JOBS = 256  # threads, or the machine's cores if it has more: each takes memory, and none beyond the cores helps


class Pool(Protocol):
    """Where bundles are run: threads here, or the workers of a cluster."""

    @property
    def width(self) -> int:
        """How many bundles it should have at hand."""

    @property
    def note(self) -> str:
        """What to tell a person who waits, or nothing."""

    def bundle_seconds(self, work: float) -> float:
        """How long a bundle should be, of so many seconds of work."""

    def submit(self, bundle: Bundle) -> Future[Outcome]:
        """Have a bundle run."""

    def halt(self) -> None:
        """Have what runs end soon, with what it has."""

    def explain(self, error: BaseException) -> str | None:
        """Why a bundle was lost though the study goes on; None where it cannot."""


class Threads:
    """Threads of this process: the engine holds no lock while it computes."""

    note = ""

    def __init__(self, executor: ThreadPoolExecutor, jobs: int, study: Study, settings: list[Setting]) -> None:
        """Take the executor's threads."""
        self.executor, self.width = executor, 4 * jobs
        self.stop = np.zeros(1, np.uint8)
        self.common = settings, study.seed
        self.metrics = metrics_of(study)

    def submit(self, bundle: Bundle) -> Future[Outcome]:
        """Have a bundle run by the next thread that is free."""
        return self.executor.submit(run_bundle, *self.common, bundle, self.metrics, self.stop)

    def halt(self) -> None:
        """Tell the engine to stop within a round."""
        self.stop[0] = 1

    def bundle_seconds(self, work: float) -> float:
        """How long a bundle should be."""
        return BUNDLE_SECONDS

    def explain(self, error: BaseException) -> str | None:
        """Nothing is lost here but by a fault of swarmcensus."""
        return None


def threads(jobs: int | None) -> int:
    """How many threads to compute with: by default one a core. Raises InputError for none, or too many."""
    cores = os.cpu_count() or 1
    most = max(MOST_JOBS, cores)
    jobs = cores if jobs is None else jobs
    if not 1 <= jobs <= most:
        raise InputError(
            f"jobs = {jobs}: should be 1 to {most} threads; more than this machine has cores ({cores}) gain nothing"
        )
    return jobs


def compile_for(study: Study, settings: list[Setting], show: Callable[[str], None]) -> None:
    """Compile here what all settings of a study need, so that threads do not wait for one another."""
    for setting in smallest(settings):
        if not compiler.is_compiled(setting.brain, "moving" if setting.body else "network"):
            what = "robots that move" if setting.body else "fixed networks"
            show(f"compiling {setting.brain.name} for {what}, once on this machine")
        task = Task("batch" if setting.body is None else "ride", (0,), 0, 1, 0.0)
        # a brain that fails is named by the real run
        run_bundle([setting], 0, (task,), metrics_of(study), np.zeros(1, np.uint8))


def smallest(settings: list[Setting]) -> list[Setting]:
    """One tiny setting for each brain and kind of world or floor: to run it compiles all that the others need."""
    found = {}
    for setting in settings:
        key = setting.brain.name, setting.body is None, setting.floor and setting.floor.kind
        if key not in found:
            tiny = replace(setting, robots=1, rounds=1, topology=Topology("line"), faults=())
            if setting.body is not None:
                tiny = replace(tiny, topology=setting.topology, density=1.0)
            found[key] = tiny
    return list(found.values())
