"""Submits bundles to a pool and collects their results, until all are done or Ctrl-C is pressed."""

import time
from collections.abc import Callable
from concurrent.futures import FIRST_COMPLETED, Future, wait
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from swarmcensus.results import Values
from swarmcensus.runs.devices import WhereToRun
from swarmcensus.runs.pools import Pool
from swarmcensus.runs.resuming import HeldOutput
from swarmcensus.runs.tasks import Bundle, Failure, Outcome, Task, bundle_tasks
from swarmcensus.studies import Setting, Study
from swarmcensus.support.errors import InputError

WAIT_SECONDS = 0.1
GRACE_SECONDS = 0.5  # of a processor, for bundles to end after Ctrl-C: a round takes less


@dataclass(frozen=True)
class Progress:
    """How far a run is: trials, and predicted seconds of work."""

    done: int
    total: int
    work_done: float
    work_total: float
    note: str = ""  # what happens while no trials run, such as compiling
    stage: str = ""  # which of several parts this is
    part: str = ""  # what the totals are of, if an unknown amount of work may follow


Report = Callable[[Progress], None]  # what an argument `progress` may be, besides True and False


@dataclass
class State:
    """A run's results and counts so far."""

    study: Study
    settings: list[Setting]
    values: Values
    report: Callable[[Progress], None]
    output: HeldOutput | None
    widths: NDArray[np.float64]  # half-width of the interval that a rule bounds, by setting
    share: slice  # which trials are to be run
    placing: WhereToRun
    failures: list[Failure] = field(default_factory=list)
    done: int = 0
    total: int = 0
    work_done: float = 0.0
    work_total: float = 0.0
    part: str = ""
    devices: set[str] = field(default_factory=set)  # cards that ran something

    def show(self, note: str = "") -> None:
        """Report the run's progress."""
        self.report(Progress(self.done, self.total, self.work_done, self.work_total, note, part=self.part))


def run_bundles(state: State, tasks: list[Task], seconds: float, pool: Pool) -> bool:
    """Run tasks in bundles of about `seconds` to their end. Returns whether Ctrl-C was pressed before."""
    rest = bundle_tasks(tasks, seconds)
    pool.prepare(tasks)
    waiting: dict[Future[Outcome], Bundle] = {}
    try:
        while True:
            while len(waiting) < pool.queue_length and (bundle := next(rest, None)) is not None:
                waiting[pool.submit(bundle)] = bundle
            if not waiting:
                break
            state.show(pool.note)
            for future in wait(waiting, timeout=WAIT_SECONDS, return_when=FIRST_COMPLETED).done:
                _store_outcome(state, _outcome_of(pool, future, waiting[future]), waiting[future])
                del waiting[future]  # only now: if Ctrl-C interrupts storing it, it is stored again
    except KeyboardInterrupt:
        pool.halt()
        begun = {future: bundle for future, bundle in waiting.items() if not future.cancel()}
        ended = _ended(begun)
        for future, bundle in begun.items():
            outcome = _outcome_of(pool, future, bundle) if future in ended else pool.so_far(future)
            _store_outcome(state, outcome, bundle)
        return True
    except InputError:  # a card or a cluster was lost
        for future, bundle in waiting.items():
            if outcome := pool.so_far(future):
                _store_outcome(state, outcome, bundle)
        raise
    finally:
        for future in waiting:
            future.cancel()
    state.show()
    return False


def _ended(begun: dict[Future[Outcome], Bundle]) -> set[Future[Outcome]]:
    """Which of some bundles have ended soon; brains that never return are not waited for."""
    wall, cpu, ended = time.monotonic(), time.process_time(), set[Future[Outcome]]()
    while len(ended) < len(begun):
        ended = wait(begun, WAIT_SECONDS).done
        waited, worked = time.monotonic() - wall, time.process_time() - cpu
        if min(waited, worked) > GRACE_SECONDS or waited > 4 * GRACE_SECONDS:
            break
    return ended


def _outcome_of(pool: Pool, future: Future[Outcome], bundle: Bundle) -> Outcome:
    try:
        return future.result()
    except Exception as error:
        why = pool.why_lost(error)
        if why is None:
            raise
        return [Failure(s, task.first + k, why) for task in bundle for s in task.settings for k in range(task.trials)]


def _store_outcome(state: State, outcome: Outcome, bundle: Bundle) -> None:
    pieces = [entry for entry in outcome if not isinstance(entry, Failure)]
    failures = [entry for entry in outcome if isinstance(entry, Failure)]
    for piece in pieces:
        state.values.put(piece.setting, piece.first, piece.columns)
        state.done += 0 if piece.local else piece.shape[0]
    state.failures += failures
    cost = sum(task.cost for task in bundle)
    state.work_done += cost
    if state.output:
        state.output.parts.add(pieces, cost)
