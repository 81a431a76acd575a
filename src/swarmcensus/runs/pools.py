"""Where bundles of trials are run: the protocol of pools, and threads of this process (`clusters.py` has workers)."""

import contextlib
import os
from abc import ABC, abstractmethod
from collections.abc import Callable, Iterable
from concurrent.futures import Executor, Future
from dataclasses import replace
from functools import partial
from typing import TYPE_CHECKING, Literal
from weakref import WeakKeyDictionary

import numpy as np

from swarmcensus.brains import PLAIN
from swarmcensus.checks import caution
from swarmcensus.engine import IN_SUMS_OF_ALL, ONE_BY_ONE, code_cache, compiler, interruptible
from swarmcensus.runs.tasks import Bundle, Outcome, Task, ThreadBudget, metrics_of, run_bundle
from swarmcensus.simulation import prepare
from swarmcensus.studies import Setting, Study
from swarmcensus.support.fork import in_background
from swarmcensus.worlds import Topology

if TYPE_CHECKING:
    from swarmcensus.gpu import Card

BUNDLE_SECONDS = 0.1  # long compared with the cost of submitting a bundle, short for a person who waits

_MAKING_NATIVE: list[Callable[[], None]] = []  # the copy of this process that does so, and ends with it

LOOPS = {"networks": ("kernel", "simulate"), "moving": ("riding", "ride"), "steering": ("steering", "live")}


class Pool(ABC):
    """Where bundles are run: threads of this process, or the workers of a cluster."""

    @property
    @abstractmethod
    def queue_length(self) -> int:
        """How many bundles should be submitted at a time."""

    @property
    def note(self) -> str:
        """A note for a person who waits, or an empty text."""
        return ""

    def bundle_seconds(self, work: float) -> float:
        """How long a bundle should take, if `work` seconds of work remain."""
        return BUNDLE_SECONDS

    @abstractmethod
    def submit(self, bundle: Bundle) -> Future[Outcome]:
        """Start running a bundle."""

    def prepare(self, tasks: Iterable[Task]) -> None:  # noqa: B027 - workers compile for themselves
        """Compile what tasks need before they run."""

    def so_far(self, future: Future[Outcome]) -> Outcome:
        """What is known of a bundle that is given up while it runs: nothing where it is sent whole."""
        return []

    @abstractmethod
    def halt(self) -> None:
        """Make running bundles end soon, with what they have finished."""

    def why_lost(self, error: BaseException) -> str | None:
        """Why a bundle was lost, if the study can go on without it; None if it cannot, as after a bug of this package.

        Raises InputError if the cluster is lost.
        """
        return None


class Threads(Pool):
    """Threads of this process: the engine releases Python's lock while it computes. One more feeds a card."""

    def __init__(
        self,
        executor: Executor,
        jobs: int,
        study: Study,
        settings: list[Setting],
        card: "Card | None" = None,
        feeder: Executor | None = None,
    ) -> None:
        """Use the executor's threads, which are so many `jobs`, and the `feeder`'s one for a card."""
        self.executor, self.threads, self.card, self.feeder = executor, ThreadBudget(jobs), card, feeder
        self._on_card = set[object]()
        self.stop = np.zeros(1, np.uint8)
        self.common = settings, study.seed
        self.metrics = metrics_of(study)
        self._outcomes: WeakKeyDictionary[Future[Outcome], Outcome] = WeakKeyDictionary()

    @property
    def queue_length(self) -> int:
        """How many bundles should be submitted at a time: those for the card keep no thread waiting."""
        return 4 * self.threads.jobs + len(self._on_card)

    def prepare(self, tasks: Iterable[Task]) -> None:
        """Have a card compile what its tasks need; what fails there fails again where it runs, and is said."""
        settings, seed = self.common
        kinds = {(settings[task.settings[0]], task.kind == "local") for task in tasks if task.on_card}
        if kinds and self.card and self.feeder:
            self.feeder.submit(self.card.compile_for, kinds, seed)

    def submit(self, bundle: Bundle) -> Future[Outcome]:
        """Start a bundle on the next free thread, or on the card."""
        outcome: Outcome = []
        feeder = self.feeder if any(task.on_card for task in bundle) else None
        future = (feeder or self.executor).submit(
            run_bundle, *self.common, bundle, self.metrics, self.stop, self.threads, outcome, self.card
        )
        unfinished = self._on_card if feeder else self.threads.unfinished
        unfinished.add(future)
        future.add_done_callback(unfinished.discard)
        self._outcomes[future] = outcome
        return future

    def so_far(self, future: Future[Outcome]) -> Outcome:
        """What a bundle has done."""
        return list(self._outcomes[future])

    def halt(self) -> None:
        """Tell the engine to stop within a round."""
        self.stop[0] = 1


def compile_for(studies: Iterable[tuple[Study, list[Setting]]], show: Callable[[str], None]) -> None:
    """Compile what all settings of some studies need, so that threads do not wait for one another.

    Brain files that break their contract are warned of first. `show` is called with notes on what is compiled.

    If the process has no other threads, a forked copy compiles for robots that move, into the cache on disk, while this
    process compiles for networks. If there is one kind of robots only, each compiles half of what they need
    (`simulation.prepare`). While a study runs with code that came with the package, a copy makes native code for later.
    """
    studies = list(studies)
    caution(brain for study, _ in studies for brain in study.brains)
    tiny = [(setting, study) for study, settings in studies for setting in tiny_settings(settings)]
    pieces = {pair: _pieces(*pair) for pair in tiny}
    wanted = set[compiler.Piece]().union(*pieces.values())
    lacking = {piece for piece in wanted if not code_cache.is_kept(*piece)}
    if not _MAKING_NATIVE and not all(code_cache.is_kept(*piece, native=True) for piece in wanted - lacking):
        _MAKING_NATIVE.append(in_background(partial(_make_native, tiny)))
    new = [pair for pair in tiny if pieces[pair] & lacking]

    def report_rest() -> None:
        lacking.difference_update([piece for piece in lacking if code_cache.is_kept(*piece)])
        if left := [pair for pair in new if pieces[pair] & lacking]:
            count = f"{len(new) - len(left) + 1:,} of {len(new):,}"
            show(f"compiling {count}, once on this machine: {_kind_of_swarm(left[0][0])}")

    moving = [pair for pair in new if pair[0].body]
    both = 0 < len(moving) < len(new)
    # the engine's loop may be lacking too; robots that steer have another one, which this process compiles
    needs_loop = bool(new) and not compiler.is_known(*_loop_of(new[0][0])) and not new[0][0].steers
    alone = not code_cache.keeps() or not (both or needs_loop)
    aside: Callable[[], None] = partial(_run_each, moving) if both else lambda: _prepare(*new[0], aside=True)
    if not alone:
        report_rest()
    ended = aside if alone else in_background(aside, report_rest)
    has_copy = ended is not aside
    if has_copy and not both:
        _prepare(*new[0], aside=False)
        ended()
    for pair in new:
        if not (has_copy and both and pair in moving):
            report_rest()
            _run_once(*pair)
            lacking -= pieces[pair]
    if has_copy and both:
        report_rest()
        ended()
    _run_each(tiny)


def _make_native(tiny: list[tuple[Setting, Study]]) -> None:
    """Compile for this very processor what was shipped, with time that nobody else wants."""
    os.nice(19)
    code_cache.NATIVE.set()
    _run_each(tiny)


def _kind_of_swarm(setting: Setting) -> str:
    """A setting's brains, how messages arrive or robots move, and their numbers: what machine code depends on."""
    brains = " and ".join(brain.name for brain in setting.brains)
    formats = f", {setting.precision} precision, messages as {setting.message}"
    formats = "" if setting.brain.numbers == PLAIN else formats
    messages = "late" if setting.message_delay else setting.use
    return f"{brains}, {'robots that move' if setting.body else f'networks, messages {messages}'}{formats}"


def _run_each(tiny: list[tuple[Setting, Study]]) -> None:
    for setting, study in tiny:
        _run_once(setting, study)


@interruptible
def _prepare(setting: Setting, study: Study, aside: bool) -> None:
    """Compile half of what one kind of swarm needs; if its brain fails, the real run reports it."""
    with contextlib.suppress(Exception):
        prepare(setting, study.seed, aside)


def _loop_of(setting: Setting) -> tuple[str, str]:
    steers = any(brain.steers for brain in setting.brains)
    return LOOPS["networks" if not setting.body else "steering" if steers else "moving"]


def _pieces(setting: Setting, study: Study) -> set[compiler.Piece]:
    """The machine code that such a swarm needs."""
    uses = [setting.use] + ["alone"] * (study.measure.local and not setting.body)
    mixed = len(setting.brains) > 1
    own = (compiler.pieces(brain, use, mixed) for use in uses for brain in setting.brains)
    return {compiler.loop_piece(*_loop_of(setting))}.union(*own)


@interruptible
def _run_once(setting: Setting, study: Study) -> None:
    """Run one trial of a tiny setting; if its brain fails, the real run reports it."""
    kinds: tuple[Literal["ride", "batch", "local"], ...] = ("ride",) if setting.body else ("batch", "local")
    for kind in kinds[: 1 + study.measure.local]:
        run_bundle([setting], 0, (Task(kind, (0,), 0, 1, 0.0),), metrics_of(study), np.zeros(1, np.uint8))


def tiny_settings(settings: list[Setting]) -> list[Setting]:
    """One tiny setting for each combination of brains, number formats, use and kind of floor.

    Running it compiles all that they need.
    """
    tiny_by_kind = {}
    for setting in settings:
        code = tuple((brain.name, brain.numbers) for brain in setting.brains)
        key = code, setting.use, setting.floor and setting.floor.kind
        if key not in tiny_by_kind:
            one_of_each = tuple(replace(m, robots=1, share=False, honest=True) for m in setting.members)
            tiny = replace(setting, robots=1 + len(one_of_each), rounds=1, faults=(), members=one_of_each)
            if setting.body is not None:
                tiny = replace(tiny, density=1.0)
            else:
                # losses use the code that faults need
                links = 0.5 if setting.use == ONE_BY_ONE else setting.link_success
                graph = Topology("full" if setting.use == IN_SUMS_OF_ALL else "line")
                tiny = replace(tiny, topology=graph, link_success=links)
            tiny_by_kind[key] = tiny
    return list(tiny_by_kind.values())
