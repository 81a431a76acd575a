"""Where bundles of trials are run: threads of this process here, the workers of a cluster in `clusters.py`."""

import logging
import os
import time
from collections import deque
from collections.abc import Callable, Iterable
from concurrent.futures import Future, ThreadPoolExecutor
from dataclasses import replace
from typing import Literal, Protocol

import numpy as np

from swarmcensus.basics.errors import InputError
from swarmcensus.basics.fork import beside
from swarmcensus.engine import code_cache, compiler
from swarmcensus.engine.compiler import IN_SUMS_OF_ALL, ONE_BY_ONE
from swarmcensus.runs.tasks import Bundle, Outcome, Task, metrics_of, run_bundle
from swarmcensus.studies.settings import Setting
from swarmcensus.studies.study import Study
from swarmcensus.worlds.networks import Topology

BUNDLE_SECONDS = 0.1  # long against the cost of handing it out, short against a person's patience
MOST_JOBS = 256  # threads, or the machine's cores if it has more: each takes memory, and none beyond the cores helps

LOG = logging.getLogger(__name__)


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
        """Take the executor's threads, of which so many will have something to do at once."""
        self.executor, self.width, self.busy = executor, 4 * jobs, jobs
        self.stop = np.zeros(1, np.uint8)
        self.common = settings, study.seed
        self.metrics = metrics_of(study)

    def submit(self, bundle: Bundle) -> Future[Outcome]:
        """Have a bundle run by the next thread that is free."""
        return self.executor.submit(run_bundle, *self.common, bundle, self.metrics, self.stop, self.busy)

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
            f"jobs = {jobs}: should be 1 to {most:,} threads; more than this machine has cores ({cores}) gain nothing"
        )
    return jobs


def compile_for(studies: Iterable[tuple[Study, list[Setting]]], show: Callable[[str, tuple[int, int]], None]) -> None:
    """Compile here what all settings of some studies need, so that threads do not wait for one another.

    `show` is told for which kind of swarm, and how many kinds are done, of how many. Where nobody else runs in this
    process, a copy of it compiles for robots that move while this one compiles for networks, and leaves it on disk.
    """
    tiny = [(setting, study) for study, settings in studies for setting in smallest(settings)]
    new = [one for one in tiny if not _is_compiled(*one)]
    for setting, study in tiny:
        if (setting, study) not in new:
            LOG.debug("%s: machine code found in %s", _loops(setting), code_cache.cache_root())
    begun = time.monotonic()
    kinds = len({_loops(setting) for setting, _ in new})
    here, beside_it = deque(new), deque[tuple[Setting, Study]]()

    def tell() -> None:
        while beside_it and _is_compiled(*beside_it[0]):
            beside_it.popleft()
        if left := [*here, *beside_it]:
            show(_note(left[0][0]), (kinds - len({_loops(setting) for setting, _ in left}), kinds))

    moving = [one for one in new if one[0].body]

    def compile_moving() -> None:
        _run_all(moving)

    alone = not moving or len(moving) == len(new) or not code_cache.keeps()
    ended = compile_moving if alone else beside(compile_moving, tell)
    if ended is not compile_moving:
        here, beside_it = deque(one for one in new if not one[0].body), deque(moving)
    while here:
        tell()
        _run_once(*here[0])
        here.popleft()
    if beside_it:
        tell()
        ended()
    _run_all(tiny)
    if new:
        kept = f", kept in {code_cache.cache_root()}" if code_cache.keeps() else ""
        LOG.debug("compiled in %.1f s%s", time.monotonic() - begun, kept)


def _note(setting: Setting) -> str:
    """What is compiled for a setting, to a person who waits for it."""
    moves = bool(setting.body)
    engine = "" if _has_loops(setting) else "the engine and "
    crew = " and ".join(brain.name for brain in setting.crew)
    return f"compiling {engine}{crew} for {'robots that move' if moves else 'fixed networks'}, once on this machine"


def _loops(setting: Setting) -> str:
    """What is compiled for a setting."""
    brains = " and ".join(brain.name for brain in setting.crew)
    return f"{brains}, {'robots that move' if setting.body else 'fixed networks'}"


def _run_all(tiny: list[tuple[Setting, Study]]) -> None:
    for setting, study in tiny:
        _run_once(setting, study)


def _has_loops(setting: Setting) -> bool:
    """Whether the engine's loop for such robots is on disk."""
    if not setting.body:
        return compiler.is_known("kernel", "simulate")
    steers = any(brain.steers for brain in setting.crew)
    return compiler.is_known("steering", "live") if steers else compiler.is_known("riding", "ride")


def _is_compiled(setting: Setting, study: Study) -> bool:
    uses = [setting.use] + ["alone"] * (study.measure.local and not setting.body)
    mixed = len(setting.crew) > 1
    minds = all(compiler.is_compiled(brain, use, mixed) for use in uses for brain in setting.crew)
    return minds and _has_loops(setting)


def _run_once(setting: Setting, study: Study) -> None:
    """Run one trial of a tiny setting; a brain that fails is named by the real run."""
    kinds: list[Literal["ride", "batch", "local"]] = ["ride"] if setting.body else ["batch"]
    if study.measure.local and not setting.body:
        kinds.append("local")
    for kind in kinds:
        run_bundle([setting], 0, (Task(kind, (0,), 0, 1, 0.0),), metrics_of(study), np.zeros(1, np.uint8))


def smallest(settings: list[Setting]) -> list[Setting]:
    """One tiny setting for each brain, use of it and floor: to run it compiles all that the others need."""
    found = {}
    for setting in settings:
        crew = tuple(brain.name for brain in setting.crew)
        key = crew, setting.use, setting.floor and setting.floor.kind
        if key not in found:
            one_of_each = tuple(replace(m, robots=1, share=False, honest=True) for m in setting.members)
            tiny = replace(setting, robots=1 + len(one_of_each), rounds=1, faults=(), members=one_of_each)
            if setting.body is not None:
                tiny = replace(tiny, density=1.0)
            else:
                links = 0.5 if setting.use == ONE_BY_ONE else setting.link_success  # as where robots fail
                graph = Topology("full" if setting.use == IN_SUMS_OF_ALL else "line")
                tiny = replace(tiny, topology=graph, link_success=links)
            found[key] = tiny
    return list(found.values())
