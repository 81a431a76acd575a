"""Finds the function of a brain that does not return: runs its trial again in CPython, where lines are counted."""

import contextlib
import logging
import sys
import threading
import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from types import FrameType, SimpleNamespace
from typing import Any

from numba.core.compiler_lock import global_compiler_lock

from swarmcensus import brains
from swarmcensus.brains import Brain
from swarmcensus.engine import WHILE_WAITING
from swarmcensus.simulation.failure_lines import MOST_STEPS, run_in_cpython
from swarmcensus.studies import Setting

PATIENCE = 5.0  # seconds that machine code may take before its brains are examined
MOST_LINES = 3_000_000  # in one call of a brain's function: a second of CPython, some milliseconds of machine code
MOST_SECONDS = 15.0  # of CPython for one examination
EXAMINES = "swarmcensus examines"  # what such threads are called

LOG = logging.getLogger(__name__)
_EXAMINED: set[str] = set()  # hashes of brains: each is examined once
_running: dict[int, tuple[float, Sequence[Setting], int, range]] = {}  # what each thread runs, and since when


class _Endless(Exception):
    pass


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
    begun: list[float] = []  # once the brains run: before, machine code makes readings and links

    def counted(brain: Brain, name: str, function: Callable[..., Any]) -> Callable[..., Any]:
        """The function of a brain; raises _Endless after too many lines."""

        def call(*given: Any) -> Any:
            begun[:] = begun or [time.monotonic()]
            if time.monotonic() - begun[0] > MOST_SECONDS or not runs():
                raise TimeoutError("given up")
            lines = 0

            def trace(_: FrameType, event: str, __: object) -> Any:
                nonlocal lines
                lines += event == "line"
                if lines > MOST_LINES:
                    raise _Endless(brain, name)
                return trace

            sys.settrace(trace)
            try:
                return function(*given)
            finally:
                sys.settrace(None)

        return call

    def of(brain: Any) -> Any:
        return brain and replace(
            brain,
            functions=SimpleNamespace(
                **{k: counted(brain, k, f) if callable(f) else f for k, f in vars(brain.functions).items()}
            ),
        )

    few = replace(
        setting, rounds=min(setting.rounds, MOST_STEPS // setting.robots), brain=of(setting.brain),
        members=tuple(replace(member, brain=of(member.brain)) for member in setting.members),
    )  # fmt: skip
    try:
        for trial in trials if few.rounds else ():
            run_in_cpython(few, seed, trial)
    except _Endless as endless:
        brain, name = endless.args
        if runs():
            LOG.warning(
                "brain %r: %s has run more than %s lines in one call and has not returned: does each of its loops end? "
                "swarmcensus brains --check %s tells more, and Ctrl-C ends this",
                brain.name, name, f"{MOST_LINES:,}", brain.path,
            )  # fmt: skip
    except Exception:  # given up, or a fault that the run itself reports
        pass
