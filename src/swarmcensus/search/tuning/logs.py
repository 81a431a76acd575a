"""The log of a search: a CSV file with a line for each evaluation, from which a search can resume.

The first line identifies the search, the second holds the scales of each world (`scales_of` in training.py); both are
comments.
"""

import json
import os
import time
from dataclasses import dataclass
from pathlib import Path
from typing import BinaryIO, Self

import numpy as np
from numpy.typing import NDArray

from swarmcensus.search.tuning.plans import TuningPlan
from swarmcensus.support.errors import InputError
from swarmcensus.support.files import atomic_write, check_writable, remove_leftovers
from swarmcensus.support.options import option
from swarmcensus.support.owners import Busy, Owner

FORMAT = "# swarmcensus tune 2 "
USUAL = "# usual "
TO_DISK = 0.5  # seconds between waits for the disk: a power cut loses as much, a killed process loses nothing


def hint() -> str:
    """What to do about an existing log that the search cannot continue."""
    return f"Tune with {option('fresh', True)} to start again, or write elsewhere with {option('out')}"


@dataclass(frozen=True)
class Evaluation:
    """One candidate and its losses; the first is the original brain, generation 0."""

    generation: int
    values: tuple[float, ...]
    losses: tuple[float, ...]  # by the metric, and by the measure that breaks its ties
    failed: int  # number of failed trials
    seconds: float  # since the search began, without interruptions

    @property
    def loss(self) -> float:
        """The loss by the metric, in [0, 1]."""
        return self.losses[0]


class Log:
    """The evaluations so far, on disk if there is a path; the file is locked for the `with` block."""

    def __init__(self, path: Path | None, plan: TuningPlan, fresh: bool = False) -> None:
        """Take the search's plan; if `fresh`, a file that exists is replaced."""
        self.path, self.identity, self.losses, self.fresh = path, plan.identity, plan.losses, fresh
        self.places = [parameter.label for parameter in plan.ranges]
        self.evaluations: list[Evaluation] = []
        self.usual: NDArray[np.float64] | None = None
        self._file: BinaryIO | None = None
        self._last = 0.0

    def __enter__(self) -> Self:
        """Lock and read the file. Raises InputError if another search has locked it, or if it is of another search."""
        if self.path is None:
            return self
        check_writable(self.path)
        self._lock = Owner(self.path.with_name(f".{self.path.name}.lock"))
        try:
            self._lock.__enter__()
        except Busy as owner:
            raise InputError.of(self.path, f"another search is writing it ({owner})") from None
        except OSError as error:
            raise InputError(f"cannot write {self.path}: {error.strerror or error}", file=self.path) from error
        remove_leftovers(self.path)
        try:
            end = 0 if self.fresh or not self.path.exists() else self._read(self.path.read_bytes())
            if end == 0:
                with atomic_write(self.path) as temporary:
                    temporary.write_text(self._head(), encoding="utf-8")
            self._file = self.path.open("r+b")
            if end:
                self._file.truncate(end)
            self._file.seek(0, os.SEEK_END)
        except BaseException:
            self._lock.__exit__()
            raise
        return self

    def __exit__(self, *_: object) -> None:
        """Close the file; remove it if it has no evaluation."""
        if self._file is not None:
            self._to_disk()
            self._file.close()
            if not self.evaluations and self._lock.is_there():
                assert self.path is not None
                Path(os.path.realpath(self.path)).unlink(missing_ok=True)  # a link's target, not the link
            self._lock.__exit__()

    def set_usual(self, usual: NDArray[np.float64]) -> None:
        """Write the scales of the worlds, and the columns' names."""
        self.usual = usual
        self._add(USUAL + json.dumps(usual.tolist()) + "\n" + self._columns())

    def add(self, evaluation: Evaluation) -> None:
        """Write an evaluation as one line."""
        self.evaluations.append(evaluation)
        numbers = [len(self.evaluations) - 1, evaluation.generation, *evaluation.values, *evaluation.losses]
        numbers += [evaluation.failed, round(evaluation.seconds, 3)]
        self._add(",".join(map(repr, numbers)) + "\n")

    def _head(self) -> str:
        return FORMAT + json.dumps(self.identity) + "\n"

    def _columns(self) -> str:
        return ",".join(["evaluation", "generation", *self.places, *self.losses, "failed", "seconds"]) + "\n"

    def _add(self, text: str) -> None:
        if self._file is None:
            return
        try:
            if not self._lock.keeps():
                raise InputError.of(self.path, "another search has taken it over: this one ends")
            self._file.write(text.encode())
            self._file.flush()
            if time.monotonic() - self._last >= TO_DISK:
                self._to_disk()
        except OSError as error:
            raise InputError(f"cannot write {self.path}: {error.strerror or error}", file=self.path) from error

    def _to_disk(self) -> None:
        assert self._file is not None
        os.fsync(self._file.fileno())
        self._last = time.monotonic()

    def _read(self, data: bytes) -> int:
        """Read all complete lines, and return their length in bytes; an incomplete last line is ignored."""
        # the path may hold any file, which must not be overwritten
        no_log = InputError(f"{self.path} is no log of a search. {hint()}", file=self.path)
        end = data.rfind(b"\n") + 1
        if not end:
            if not self._head().encode().startswith(data):
                raise no_log
            return 0
        try:
            head, *lines = data[:end].decode().splitlines()
            if not head.startswith(FORMAT):
                raise no_log
            identity = dict(json.loads(head.removeprefix(FORMAT)))
        except (ValueError, TypeError, RecursionError):
            raise no_log from None
        differ = [
            f"{key} is {identity.get(key)!r} there and {value!r} here"
            for key, value in self.identity.items() if identity.get(key) != value
        ]  # fmt: skip
        if differ:
            raise InputError(f"{self.path} is of another search: {'; '.join(differ)}. {hint()}", file=self.path)
        if len(lines) < 3:  # the first evaluation was not finished
            return len(head.encode()) + 1
        try:
            if not lines[0].startswith(USUAL) or lines[1] + "\n" != self._columns():
                raise ValueError
            self.usual = np.array(json.loads(lines[0].removeprefix(USUAL)), np.float64).reshape(len(self.losses), -1, 2)
        except ValueError:
            raise InputError(f"{self.path}, line 2 or 3: damaged or changed. {hint()}", file=self.path) from None
        for number, line in enumerate(lines[2:]):
            try:
                self.evaluations.append(self._parsed(line, number))
            except ValueError:
                raise InputError(
                    f"{self.path}, line {number + 4}: damaged or changed: remove it and all lines after it, or begin "
                    f"again with {option('fresh', True)}",
                    file=self.path,
                ) from None
        return end

    def _parsed(self, line: str, number: int) -> Evaluation:
        first, generation, *rest = line.split(",")
        *numbers, failed, seconds = rest
        values = [float(text) for text in numbers]
        losses = tuple(values[len(self.places) :])
        if int(first) != number or len(losses) != len(self.losses) or not all(0.0 <= text <= 1.0 for text in losses):
            raise ValueError
        return Evaluation(int(generation), tuple(values[: len(self.places)]), losses, int(failed), float(seconds))
