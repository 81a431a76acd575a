"""Errors for people, and the text of errors that other libraries raise."""

import linecache
import re
import threading
import traceback
from collections.abc import Mapping
from pathlib import Path
from typing import Any, Self

from swarmcensus.support.formatting import counted
from swarmcensus.support.hints import did_you_mean

MEANT = re.compile(r"""did you mean (['"])(.+?)\1\?""")  # as `did_you_mean` writes it
LONGEST = 4000  # characters of a message; files may hold keys and values of any length
STOPPED = 130  # the usual exit code of a program that was stopped with Ctrl-C
STOPPING = threading.Event()  # set by Ctrl-C in a command


class InputError(ValueError):
    """Bad input: the message names the file, the key, the value and what would be right.

    The fields have the same for programs, and are None if they do not apply: `file`, a path as it was given; `key`,
    the name of a key, option or argument; `value`, what it has; `hint`, the name that was probably meant.
    """

    def __init__(
        self, message: str = "", *, file: object = None, key: str | None = None, value: Any = None,
        hint: str | None = None,
    ) -> None:  # fmt: skip
        """Keep the message and the fields; a suggestion in the message, as `did_you_mean` writes it, is the hint."""
        if len(message) > LONGEST:
            message = f"{message[: LONGEST // 2]} ... {message[-LONGEST // 2 :]}"
        super().__init__(message)
        suggested = MEANT.search(message)
        self.file = None if file is None else str(file)
        self.key, self.value = key, value
        self.hint = hint if hint is not None or suggested is None else suggested[2]

    @classmethod
    def of(cls, file: object, what: object, key: str | None = None, value: Any = None, *, where: str = "") -> Self:
        """The error of a file: "ring.nc: cannot be read"; the message may say more than its path, in `where`.

        The fields of an error in place of `what` are kept.
        """
        error = what if isinstance(what, InputError) else cls(key=key, value=value)
        return cls(f"{where or file}: {what}", file=file, key=error.key, value=error.value, hint=error.hint)

    @classmethod
    def within(cls, where: str, what: object, key: str | None = None, value: Any = None) -> Self:
        """The error of a file of some kind, "study file ring.toml", or of "study", for tables in Python."""
        return cls.of(where.partition(" file ")[2] or None, what, key, value, where=where)

    @classmethod
    def at(cls, key: str, value: Any, what: object) -> Self:
        """The error of a key: "rounds = 0: should be above 0"."""
        return cls(f"{key} = {value}: {what}", key=key, value=value)

    @classmethod
    def named(cls, key: str, value: Any, what: object) -> Self:
        """The error of one of several things: "setting 7: it has not been run", "metric 'mean': it has changed"."""
        shown = repr(value) if isinstance(value, str) else value
        return cls(f"{key} {shown}: {what}", key=key, value=value)


class OptionError(InputError):
    """A wrong option of a command, or argument of a function; `key` is its name with underscores, as in Python."""


class StudyError(InputError):
    """A study, mission or other TOML file, or tables in Python, with a wrong key or value."""


class BrainError(InputError):
    """A file of code with a fault: a brain, an adversary, a metric or another plugin."""


class ResultsError(InputError):
    """A results file, or a robot's log, that is damaged or lacks what is needed."""


class TableError(InputError):
    """A table of a user's, such as recorded observations or links, with a wrong row, column or cell."""


class Interrupted(KeyboardInterrupt):
    """Raised when Ctrl-C stops a run; `results` is the dataset of the trials that were completed."""

    def __init__(self, results: object, done: int, total: int, noun: str = "trial") -> None:
        """Keep the partial results, and how many trials, or rounds of a swarm, are done."""
        super().__init__(f"stopped after {done:,} of {counted(total, noun)}")
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


def pydantic_message(error: Mapping[str, Any]) -> str:
    """Pydantic's message of an error about a wrong value in our wording: "should be less than 1,000"."""
    text = error["msg"].removeprefix("Value error, ").replace("Input should", "should")
    if error["type"] == "literal_error" and isinstance(error["input"], str):
        hint = did_you_mean(error["input"], re.findall("'(.*?)'", error["ctx"]["expected"])).rstrip()
        text += f": {hint}" * bool(hint)
    text = text.replace("should be a valid boolean", "should be true or false")
    text = text.replace("should be a valid integer", "should be a whole number")
    text = "should be a list of at least one" if "at least 1 item" in text else text
    return re.sub(r"(?<=than |l to )\d{4,}", lambda number: f"{int(number[0]):,}", text)
