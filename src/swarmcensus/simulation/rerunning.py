"""Runs a trial again in CPython if its brain fails or does not return: machine code names no line and no function."""

import contextlib
import functools
import logging
import threading
import time
from collections import deque
from collections.abc import Callable, Container, Iterator, Sequence
from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
from numba.core.compiler_lock import global_compiler_lock

from swarmcensus import brains
from swarmcensus.brains import Brain, Lines, TooManyLines
from swarmcensus.engine import WHILE_WAITING, heard_by, works
from swarmcensus.engine.constants import FULL, PAIRS, SENSING, TALKING
from swarmcensus.simulation import reference, sampling
from swarmcensus.simulation.inputs import inputs_of
from swarmcensus.simulation.living import Stepped
from swarmcensus.simulation.swarming import foreknowledge
from swarmcensus.studies import Setting
from swarmcensus.support.errors import line_of
from swarmcensus.support.options import command

MOST_STEPS = 3_000_000  # robots times rounds that are run again: about ten seconds of CPython
PATIENCE = 5.0  # seconds that machine code may take before its brains are examined
MOST_LINES = 3_000_000  # in one call of a brain's function: a second of CPython, some milliseconds of machine code
MOST_SECONDS = 15.0  # of CPython for one examination
EXAMINES = "swarmcensus examines"  # what such threads are called

LOG = logging.getLogger(__name__)
_EXAMINED: set[str] = set()  # hashes of brains: each is examined once
_running: dict[int, tuple[float, Sequence[Setting], int, range]] = {}  # what each thread runs, and since when


def line_of_failure(setting: Setting, seed: int, trial: int, checkpoints: Container[int] = ()) -> str:
    """The place where the brain fails, as ", at my_brain.py, line 12: x = 1 / me.n"; empty if it is not found.

    At `checkpoints` robots are asked for intervals.
    """
    if setting.robots * setting.rounds > MOST_STEPS:
        return ""
    try:
        run_in_cpython(setting, seed, trial, checkpoints)
    except Exception as error:
        lines = (line_of(error, brain.path) for brain in setting.brains)
        return next(filter(None, lines), "")
    return ""


@contextlib.contextmanager
def watched(settings: Sequence[Setting], seed: int, first: int, trials: int = 1) -> Iterator[None]:
    """Have the brains of these trials examined if the block, in machine code, takes long."""
    _running[threading.get_ident()] = time.monotonic(), settings, seed, range(first, first + trials)
    try:
        yield
    finally:
        _running.pop(threading.get_ident(), None)


def look() -> None:
    """Examine brains that have been running for long; a line on stderr names one that does not return."""
    if not global_compiler_lock._lock.acquire(blocking=False):  # compiling takes long, and no brain
        return
    global_compiler_lock._lock.release()
    for thread, run in list(_running.items()):
        begun, settings, seed, trials = run
        if time.monotonic() - begun > PATIENCE:
            examine(settings, seed, trials, lambda thread=thread, run=run: _running.get(thread) is run)  # type: ignore[misc]


WHILE_WAITING.append(look)


def examine(settings: Sequence[Setting], seed: int, trials: Sequence[int], runs: Callable[[], bool]) -> None:
    """Look for a function that does not return, in a thread, while the trials go on; shipped brains are trusted."""
    for setting in settings:
        new = {brain.sha256 for brain in setting.brains if not brains.is_shipped(brain)} - _EXAMINED
        if new:
            _EXAMINED.update(new)
            threading.Thread(None, _examine, EXAMINES, (setting, seed, trials, runs), daemon=True).start()


def _examine(setting: Setting, seed: int, trials: Sequence[int], runs: Callable[[], bool]) -> None:
    end = time.monotonic() + MOST_SECONDS

    def counted(brain: Brain, function: Callable[..., Any]) -> Callable[..., Any]:
        """The function of a brain; raises TooManyLines after too many."""

        def call(*given: Any) -> Any:
            if time.monotonic() > end or not runs():
                raise TimeoutError("given up")
            with Lines(brain, MOST_LINES):
                return function(*given)

        return call

    def of(brain: Any) -> Any:
        functions = {k: counted(brain, f) if callable(f) else f for k, f in vars(brain.functions).items()}
        return replace(brain, functions=SimpleNamespace(**functions))

    members = tuple(replace(one, brain=one.brain and of(one.brain)) for one in setting.members)
    rounds = min(setting.rounds, MOST_STEPS // setting.robots)
    few = replace(setting, rounds=rounds, brain=of(setting.brain), members=members)
    try:
        for trial in trials if rounds else ():
            run_in_cpython(few, seed, trial)
    except TooManyLines as endless:
        if runs():
            check = command("swarmcensus", "brains", "--check", endless.brain.path)
            LOG.warning("%s: does each of its loops end? %s tells more, and Ctrl-C ends this", endless, check)
    except Exception:  # given up, or a fault that the run itself reports
        pass


def run_in_cpython(setting: Setting, seed: int, trial: int, checkpoints: Container[int] = ()) -> None:
    """Run the trial's states step by step, like the engine.

    Readings and links are those of the same trial with a shipped brain: they do not depend on the brain, unless it
    steers.
    """
    alone = tuple(replace(member, brain=None) for member in setting.members)
    known = replace(setting, brain=brains.load("minimalistic"), members=alone)
    given = inputs_of(setting, seed, trial)
    stops, radio, moves = given.stops[0], given.radio, setting.body is not None
    group = given.group[0] if given.group.size else np.zeros(setting.robots, np.int64)
    brain_of = [setting.brains[one] for one in group]
    b, w = (side[0] for side in given.beliefs)
    states = [one.robot(float(b[i % b.size]), float(w[i % w.size]), float(i)) for i, one in enumerate(brain_of)]
    for one, me in zip(brain_of, states, strict=True):
        for name, value in foreknowledge(setting).items():
            setattr(me, name, value)
        one.functions.estimate(me)
    now = 0

    def arriving(pairs: np.ndarray, said: reference.Said) -> Iterator[reference.Heard]:
        for message in said[-1] if setting.additive else ():  # a message is added as it is sent
            if reference.speaks(message):
                setting.brain.functions.receive(setting.brain.robot(0.0, 0.0), message)
        if now < radio.delay + (not moves):  # moving robots also hear messages from before the first tick
            return
        news, at = said[0], now - radio.delay
        talking = [works(stops, TALKING, i, at) for i in range(setting.robots)]
        drowned = {int(to) for to, by in pairs if news[by] is reference.JAMS and talking[by]}
        for receiver, sender in pairs:
            gets_through = not radio.threshold or heard_by(radio.key, trial, now, receiver, sender, radio.threshold)
            speaks = talking[sender] and reference.speaks(news[sender])
            if gets_through and speaks and int(receiver) not in drowned:
                yield receiver, news[sender], (trial, now, receiver, sender)

    def steps() -> Iterator[reference.Step]:
        nonlocal now
        for now, (blacks, pairs) in enumerate(_readings_and_links(known, seed, trial), start=1):
            sees = [works(stops, SENSING, i, now) for i in range(setting.robots)]
            heard = functools.partial(arriving, pairs)
            yield reference.Step(np.where(sees, blacks, np.nan), float(setting.observations_per_round), heard)

    def after(i: int, steered: np.ndarray) -> None:
        one, me = brain_of[i], states[i]
        one.functions.estimate(me)
        for name in ("decide", "done", *(["interval"] if now in checkpoints else [])):
            if name in one.contents.functions:
                getattr(one.functions, name)(me)
        if one.steers and moves:
            reference.give(one, me, steered, i)
            one.functions.steer(me)

    said: reference.Said = deque(maxlen=radio.delay + 1)
    if moves:
        said.append([reference.message_by(one, me) for one, me in zip(brain_of, states, strict=True)])
    reference.live(brain_of, states, steps(), given.draws, trial, said, after)


def _readings_and_links(setting: Setting, seed: int, trial: int) -> Iterator[tuple[np.ndarray, np.ndarray]]:
    """By round or tick: black readings of each robot, NaN where it made none, and rows of receiver and sender."""
    trace = Stepped(setting, seed, trial, use=setting.use)
    if trace.moves:
        for stretch, _ in trace.parts(1, trace.rounds + 1):
            both = np.concatenate([stretch.links, stretch.links[:, [0, 2, 1]]])
            both = both[np.lexsort(both.T[::-1])]
            ends = np.searchsorted(both[:, 0], stretch.first + np.arange(len(stretch.readings) + 1))
            for row, readings in enumerate(stretch.readings):
                yield readings, both[ends[row] : ends[row + 1], 1:]
        return
    links = sampling.links(setting, seed, trial, 1)
    if links.mode in (FULL, PAIRS):
        pairs = np.argwhere(~np.eye(setting.robots, dtype=np.bool_))
    else:
        pairs = np.stack([links.receivers, links.senders], axis=1).astype(np.int64)
    for row in trace.blacks()[1:]:
        yield row, pairs
