"""Ends calls of brains that do not return, in CPython: by their lines, or after some time, which slows nothing down."""

import contextlib
import math
import signal
import sys
import threading
import traceback
from collections.abc import Iterable, Iterator
from types import FrameType
from typing import Any, Self

from swarmcensus.brains.brain import Brain
from swarmcensus.support.errors import BrainError
from swarmcensus.support.options import command

PATIENCE = 5.0  # seconds of the processor: a call that lasts from one look to the next but one does not return


class TooManyLines(Exception):
    """A call of a brain was ended."""

    def __init__(self, brain: Brain, function: str, lines: float) -> None:
        """Say which function has not returned."""
        super().__init__(f"brain {brain.name!r}: {function} has run {lines:,} lines in one call and has not returned")
        self.brain = brain


class Lines:
    """Counts the lines of a brain's file that CPython runs in a `with` block, and ends a call that runs too many."""

    def __init__(self, brain: Brain, most_in_a_call: float = math.inf) -> None:
        """Count none yet."""
        self.brain, self.most = brain, most_in_a_call
        self.file = brain.functions.estimate.__code__.co_filename
        self.run = self.before = 0  # in all, and before the current call from outside of the file
        self.called = ""

    def __enter__(self) -> Self:
        """Begin."""
        self.usual = sys.gettrace()
        sys.settrace(self._enter)
        return self

    def __exit__(self, *_: object) -> None:
        """End."""
        sys.settrace(self.usual)

    def _enter(self, frame: Any, event: str, _: Any) -> Any:
        if frame.f_code.co_filename != self.file:  # finalisers of other objects may run in between
            return None
        if frame.f_back.f_code.co_filename != self.file:
            self.before, self.called = self.run, frame.f_code.co_name
        return self._line

    def _line(self, frame: Any, event: str, _: Any) -> Any:
        self.run += event == "line"
        if self.run - self.before > self.most:
            raise TooManyLines(self.brain, self.called, self.most)
        return self._line


class _Endless(BaseException):  # a robot's runtime goes on after an Exception of its brain
    pass


@contextlib.contextmanager
def returning(brains: Iterable[Brain]) -> Iterator[None]:
    """Raise BrainError if a call of a brain's function, in the block, does not return.

    Only the main thread is interrupted, and only where the system tells the time of the processor.
    """
    if not hasattr(signal, "setitimer") or threading.current_thread() is not threading.main_thread():
        yield
        return
    files = {brain.functions.estimate.__code__.co_filename: brain for brain in brains if brain.is_loaded}
    looks: list[FrameType | None] = []

    def look(_: int, frame: FrameType | None) -> None:
        outer = [one for one, _ in traceback.walk_stack(frame) if one.f_code.co_filename in files]
        looks[:-2] = []
        looks.append(outer[-1] if outer else None)
        if looks[-1] is not None and looks[-3:] == looks[-1:] * 3:
            raise _Endless

    usual = signal.signal(signal.SIGVTALRM, look)
    signal.setitimer(signal.ITIMER_VIRTUAL, PATIENCE / 2.0, PATIENCE / 2.0)
    try:
        yield
    except _Endless:
        frame = looks[-1]
        assert frame is not None
        brain, name = files[frame.f_code.co_filename], frame.f_code.co_name
        check = command("swarmcensus", "brains", "--check", brain.path)
        endless = f"{name} has run for {PATIENCE:g} s and has not returned"
        what = f"{endless}: does each of its loops end? {check} tells more"
        raise BrainError.named("brain", brain.name, what) from None
    finally:
        signal.setitimer(signal.ITIMER_VIRTUAL, 0.0)
        signal.signal(signal.SIGVTALRM, usual)
