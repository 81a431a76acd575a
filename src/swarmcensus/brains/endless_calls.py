"""Ends calls of brains that do not return, in CPython: by the lines that they run."""

import math
import sys
from typing import Any, Self

from swarmcensus.brains.brain import Brain


class TooManyLines(Exception):
    """A call of a brain was ended."""


class Lines:
    """Counts the lines of a brain's file that CPython runs in a `with` block, and ends a call that runs too many."""

    def __init__(self, brain: Brain, most_in_a_call: float = math.inf) -> None:
        """Count none yet."""
        self.most = most_in_a_call
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
            raise TooManyLines(f"{self.called} has run {self.most:,} lines in one call and has not returned")
        return self._line
