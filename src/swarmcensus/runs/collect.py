"""Bundles go out to a pool and come back: what a run has so far grows by them, until all are done or Ctrl-C comes."""

import logging
from collections.abc import Callable, Iterator
from concurrent.futures import FIRST_COMPLETED, Future, wait
from contextlib import AbstractContextManager
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from swarmcensus.results.values import Values
from swarmcensus.runs.pools import Pool
from swarmcensus.runs.resuming import Holding
from swarmcensus.runs.tasks import Bundle, Failure, Outcome
from swarmcensus.studies.settings import Setting
from swarmcensus.studies.study import Study

LOG = logging.getLogger(__name__)
WAIT_SECONDS = 0.1


@dataclass(frozen=True)
class Progress:
    """How far a run is: trials, and predicted seconds of work."""

    done: int
    total: int
    work_done: float
    work_total: float
    note: str = ""  # what is going on where it is not trials
    stage: str = ""  # which part of several this is
    steps: tuple[int, int] = (0, 0)  # of what the note says: how many are done, of how many


Reporting = Callable[[str], AbstractContextManager[Callable[[Progress], None]]]  # a bar of a label


@dataclass
class State:
    """What a run has so far."""

    study: Study
    settings: list[Setting]
    values: Values
    report: Callable[[Progress], None]
    holding: Holding | None
    widths: NDArray[np.float64]  # half the interval that a rule looks at, of each setting
    share: slice  # which trials are to be run
    failures: list[Failure] = field(default_factory=list)
    done: int = 0
    total: int = 0
    work_done: float = 0.0
    work_total: float = 0.0

    def show(self, note: str = "", steps: tuple[int, int] = (0, 0)) -> None:
        """Report how far the run is."""
        self.report(Progress(self.done, self.total, self.work_done, self.work_total, note, steps=steps))


def work(state: State, rest: Iterator[Bundle], pool: Pool) -> bool:
    """Run bundles to their end; whether Ctrl-C came before."""
    waiting: dict[Future[Outcome], Bundle] = {}
    try:
        while True:
            while len(waiting) < pool.width and (bundle := next(rest, None)) is not None:
                waiting[pool.submit(bundle)] = bundle
            if not waiting:
                break
            state.show(pool.note)
            _take_in(state, pool, waiting)
    except KeyboardInterrupt:
        pool.halt()
        for future in waiting:
            future.cancel()
        for future, bundle in waiting.items():
            if not future.cancelled():
                _keep(state, pool, future, bundle)
        return True
    finally:
        for future in waiting:
            future.cancel()
    state.show()
    return False


def _take_in(state: State, pool: Pool, waiting: dict[Future[Outcome], Bundle]) -> None:
    """Wait a moment, and keep what is finished; nothing of it stays in memory once this returns."""
    for future in wait(waiting, timeout=WAIT_SECONDS, return_when=FIRST_COMPLETED).done:
        _keep(state, pool, future, waiting[future])
        del waiting[future]  # now: what Ctrl-C breaks is kept anew


def _keep(state: State, pool: Pool, future: Future[Outcome], bundle: Bundle) -> None:
    try:
        outcome = future.result()
    except Exception as error:
        why = pool.explain(error)
        if why is None:
            raise
        outcome = [
            Failure(number, task.first + k, why)
            for task in bundle
            for number in task.settings
            for k in range(task.trials)
        ]
    pieces = [one for one in outcome if not isinstance(one, Failure)]
    failures = [one for one in outcome if isinstance(one, Failure)]
    for piece in pieces:
        state.values.put(piece.setting, piece.first, piece.columns)
        state.done += 0 if piece.local else piece.shape[0]
    state.failures += failures
    if LOG.isEnabledFor(logging.DEBUG):
        for number in dict.fromkeys(piece.setting for piece in pieces):
            _tell_of(state, number)
    cost = sum(task.cost for task in bundle)
    state.work_done += cost
    if state.holding:
        state.holding.parts.add(pieces, cost)


def _tell_of(state: State, number: int) -> None:
    """Log that a setting has all trials that are asked for so far."""
    wanted = len(range(state.values.trials)[state.share])
    done = int(state.values.finished()[number, state.share].sum())
    if done == wanted:
        setting = state.settings[number]
        LOG.debug("setting %s: %s trials done: %s, %s", number, f"{done:,}", setting.brain.told, setting)
