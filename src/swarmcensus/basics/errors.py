"""What goes wrong through bad input, said in one sentence for a person."""

import linecache
import re
import traceback
from pathlib import Path

from swarmcensus.basics.formatting import counted

STOPPED = 130  # the exit code that a shell expects of a program that Ctrl-C ended


class InputError(ValueError):
    """Bad input: the message names the file, the key, the value and what would be right."""


class Interrupted(KeyboardInterrupt):
    """A run was stopped by Ctrl-C; `results` holds the dataset with the trials that were done."""

    def __init__(self, results: object, done: int, total: int) -> None:
        """Keep the partial dataset and how far it got."""
        super().__init__(f"stopped after {done:,} of {counted(total, 'trial')}")
        self.results = results
        self.done = done
        self.total = total


def without_colours(error: object) -> str:
    """What an error says, without the colours that Numba gives it where colorama is installed."""
    return re.sub(r"\x1b\[[0-9;]*m", "", str(error))


def line_of(error: BaseException, path: Path) -> str:
    """Where in this file an error came up, as ", at my_brain.py, line 12: x = 1 / me.n"; empty where it did not."""
    for frame in reversed(traceback.extract_tb(error.__traceback__)):
        if frame.filename == str(path):
            line = (frame.line or linecache.getline(frame.filename, frame.lineno or 0)).strip()
            return f", at {frame.filename}, line {frame.lineno}: {line}"
    return ""


def pydantic_message(message: str) -> str:
    """What pydantic says is wrong with a value, in our words: "should be less than 1,000"."""
    said = message.removeprefix("Value error, ").replace("Input should", "should")
    return re.sub(r"(?<=than |l to )\d{4,}", lambda found: f"{int(found[0]):,}", said)
