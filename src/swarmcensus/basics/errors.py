"""Errors for people, and the text of errors that other libraries raise."""

import linecache
import re
import traceback
from pathlib import Path

from swarmcensus.basics.formatting import counted

STOPPED = 130  # the usual exit code of a program that was stopped with Ctrl-C


class InputError(ValueError):
    """Bad input. The message names the file, the key, the value and what would be right."""


class Interrupted(KeyboardInterrupt):
    """Raised when Ctrl-C stops a run; `results` is the dataset of the trials that were completed."""

    def __init__(self, results: object, done: int, total: int) -> None:
        """Keep the partial dataset, and how many trials are done."""
        super().__init__(f"stopped after {done:,} of {counted(total, 'trial')}")
        self.results = results
        self.done = done
        self.total = total


def without_colours(error: object) -> str:
    """The text of an error without colour codes, which Numba adds if colorama is installed."""
    return re.sub(r"\x1b\[[0-9;]*m", "", str(error))


def line_of(error: BaseException, path: Path) -> str:
    """Where an error occurred in a file: ", at my_brain.py, line 12: x = 1 / me.n"; empty if it was elsewhere."""
    for frame in reversed(traceback.extract_tb(error.__traceback__)):
        if frame.filename == str(path):
            line = (frame.line or linecache.getline(frame.filename, frame.lineno or 0)).strip()
            return f", at {frame.filename}, line {frame.lineno}: {line}"
    return ""


def pydantic_message(message: str) -> str:
    """Pydantic's message about a wrong value in our wording: "should be less than 1,000"."""
    text = message.removeprefix("Value error, ").replace("Input should", "should")
    text = text.replace("should be a valid boolean", "should be true or false")
    text = re.sub(r".*at least 1 item.*", "should be a list of at least one", text)
    return re.sub(r"(?<=than |l to )\d{4,}", lambda number: f"{int(number[0]):,}", text)
