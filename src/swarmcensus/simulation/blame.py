"""Whose fault a failure is: which brain fails, in which trial, at which robot and round, and at which line of its file.

Machine code names no line, and not the function that never returns. So such a trial is run again in CPython.
"""

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
from swarmcensus.brains import INTERVAL, Brain, Lines, TooManyLines
from swarmcensus.engine import WHILE_WAITING, Inputs, Intervals, compiler, heard_by, works
from swarmcensus.engine.constants import FULL, PAIRS, SENSING, TALKING, WRONG, WRONG_IN
from swarmcensus.simulation import reference, sampling
from swarmcensus.simulation.inputs import inputs_of
from swarmcensus.simulation.swarming import foreknowledge
from swarmcensus.studies import Setting
from swarmcensus.support.errors import BrainError, line_of
from swarmcensus.support.options import command

NO_ESTIMATE = "a number in [0, 1] is right"
MOST_STEPS = 3_000_000  # robots times rounds that are run again: about ten seconds of CPython
PATIENCE = 5.0  # seconds that machine code may take before its brains are examined
MOST_LINES = 3_000_000  # in one call of a brain's function: a second of CPython, some milliseconds of machine code
MOST_SECONDS = 15.0  # of CPython for one examination
EXAMINES = "swarmcensus examines"  # what such threads are called

LOG = logging.getLogger(__name__)
_EXAMINED: set[str] = set()  # hashes of brains: each is examined once
_running: dict[int, tuple[float, Sequence[Setting], int, range]] = {}  # what each thread runs, and since when


class BrainFails(BrainError):
    """A brain fails in a trial, or gives what the contract does not allow."""


def failure(setting: Setting, blamed: Sequence[Brain], first: int, trials: int, what: str) -> BrainFails:
    """The error that names the brains that may have failed, and in which trials."""
    which = f"trials {first} to {first + trials - 1}" if trials > 1 else f"trial {first}"
    names = " or ".join(repr(brain.name) for brain in blamed)
    return BrainFails(f"brain {names} fails in {which} of {setting}: {what}", key="brain", value=blamed[0].name)


@contextlib.contextmanager
def blaming(setting: Setting, first: int, trials: int = 1) -> Iterator[None]:
    """Turn any error of a brain in here into a BrainFails that names it."""
    try:
        yield
    except BrainFails:
        raise
    except compiler.NotCompiled as error:
        check = command("swarmcensus", "brains", "--check", error.brain.path)
        what = f"it cannot be compiled: {check} says why"
        raise failure(setting, [error.brain], first, trials, what) from error
    except Exception as error:
        said = str(error).strip().partition("\n")[0]
        raise failure(setting, setting.brains, first, trials, f"{type(error).__name__}: {said}") from error


def check_answers(
    setting: Setting, given: Inputs, estimates: np.ndarray, verdicts: np.ndarray, intervals: Intervals,
    local: bool = False,
) -> None:  # fmt: skip
    """Raise BrainFails if a robot gave an invalid estimate, decision or interval.

    The first wrong `estimates` (trial, 3) are those of `Measures`. With `local`, they count single observations.
    """
    for trial in np.flatnonzero(estimates[:, 0] >= 0.0)[:1]:
        robot, tick, estimate = estimates[trial]
        raise _wrong(setting, given, trial, robot, tick, f"estimate gives {estimate:.9g}: {NO_ESTIMATE}", local)
    for trial, robot in np.argwhere(verdicts[..., WRONG] != -1.0)[:1] if verdicts.size else ():
        choice, tick = verdicts[trial, robot, [WRONG, WRONG_IN]]
        options = next(brain.options for brain in setting.brains if brain.decides)  # of all the same
        right = f"-1 (undecided) or an option from 0 to {options - 1} is right"
        raise _wrong(setting, given, trial, robot, tick, f"decide gives {choice:g}: {right}")
    for trial in np.flatnonzero(intervals.wrong[:, 0] >= 0.0)[:1]:
        robot, tick, low, high = intervals.wrong[trial]
        raise _wrong(setting, given, trial, robot, tick, f"interval gives ({low:g}, {high:g}): {INTERVAL}")


def check_commands(setting: Setting, given: Inputs, commands: np.ndarray) -> None:
    """Raise BrainFails if a robot steered by what is no number; `commands` (3, robot) are as the engine left them."""
    for robot in np.flatnonzero(~(np.abs(commands[1:]) < 1e300).all(axis=0))[:1]:
        tick, speed, turn = commands[:, robot]
        right = "two finite numbers, a speed and a turn, or None are right"
        raise _wrong(setting, given, 0, robot, tick, f"steer gives ({speed:g}, {turn:g}): {right}")


def _wrong(
    setting: Setting, given: Inputs, trial: int, robot: float, tick: float, what: str, local: bool = False
) -> BrainFails:
    """The error that names the brain of a robot in the `trial`-th trial of a batch, and after which round it was."""
    i = int(robot)
    brain = setting.brains[given.group[trial, i]] if given.group.size else setting.brain
    when = f"after {'observation' if local else 'tick' if setting.body else 'round'} {tick:.0f}"
    return failure(setting, [brain], given.first + int(trial), 1, f"robot {i}, {when}: {what}")


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
    """Examine brains whose machine code has been running for long; a line on stderr names one that does not return."""
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
    from swarmcensus.simulation import rides, trials  # which blame brains, too

    if setting.body is not None:
        ride = rides.record_ride(setting, seed, trial)
        both = np.concatenate([ride.links, ride.links[:, [0, 2, 1]]])
        both = both[np.lexsort(both.T[::-1])]
        first = np.searchsorted(both[:, 0], np.arange(setting.rounds + 2))
        for tick in range(1, setting.rounds + 1):
            yield ride.readings[tick], both[first[tick] : first[tick + 1], 1:]
        return
    _, _, blacks = trials.record_trial(setting, seed, trial)
    links = sampling.links(setting, seed, trial, 1)
    if links.mode in (FULL, PAIRS):
        pairs = np.argwhere(~np.eye(setting.robots, dtype=np.bool_))
    else:
        pairs = np.stack([links.receivers, links.senders], axis=1).astype(np.int64)
    for row in blacks[1:]:
        yield row.astype(np.float64), pairs
