"""Metrics of files: each watches the estimates of one trial, and its results are kept."""

from collections.abc import Callable, Iterable
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from swarmcensus.brains.metrics import GIVEN, Metric
from swarmcensus.engine import blank_record, compile_metric
from swarmcensus.studies import Setting
from swarmcensus.support.bins import right_bin, right_bins
from swarmcensus.support.errors import InputError, line_of, without_colours
from swarmcensus.support.formatting import counted

MOST_SHOWN = 1_000_000  # estimates, to CPython
WIDEST_CHECKED = 100  # robots
MOST_CHECKED = 2_000  # by it, of each metric that this process has not met: some milliseconds
CHECKED: set[Metric] = set()
IDLE = ("Failed in nopython", "No implementation of function", "There are", ">>>", "During:", "File ", "<source", "^")

Truths = Callable[[ArrayLike], np.ndarray]  # of rounds


class MetricFails(InputError):
    """A metric that fails, or that cannot be compiled."""


class Watch:
    """One metric on one trial."""

    def __init__(self, metric: Metric, setting: Setting, trial: int, truths: Truths, delta: float, bins: int) -> None:
        """Make room for its records; `truths` gives the true fill ratio of a round."""
        self.metric, self.truths, self.bins = metric, truths, bins
        self.where = f"trial {trial} of {setting}"
        self.changes = setting.change is not None
        low, high = right_bin(float(truths(np.arange(1, 2))[0]), bins)
        self.blank = blank_record(metric, low=low, high=high, delta=delta, rounds=setting.rounds, robots=setting.honest)
        self.records = np.repeat(self.blank, 1 if metric.of_swarm else setting.honest)
        self.out = np.empty(self.records.size)

    def see(self, rows: np.ndarray, first: int) -> None:
        """Look at estimates (round, robot) from round `first` on. Raises MetricFails."""
        truths = self._of(first, len(rows))
        try:
            follow = compile_metric(self.metric).follow
            if first == 1 and len(rows) > 1 and self.metric not in CHECKED:  # a single round only compiles it
                few = rows[:, :WIDEST_CHECKED]
                self._check(np.ascontiguousarray(few[: MOST_CHECKED // few.shape[1] + 2]), truths, follow)
                CHECKED.add(self.metric)
            follow(self.blank, self.records, rows, first, truths, self.out)
        except MetricFails:
            raise
        except Exception as error:
            text = without_colours(error).strip()
            what = f"{type(error).__name__}: {text.splitlines()[0] if text else ''}"
            if "numba" in type(error).__module__:
                lines = (line.strip(" -\t") for line in text.splitlines())
                # the first that is not about Numba itself or a place in a file
                telling = next((line for line in lines if line and not line.startswith(IDLE)), text)
                what = f"it cannot be compiled: {telling}"
            raise self._wrong(f"{what}{self._line(rows, truths) if first == 1 else ''}") from error

    def _of(self, first: int, rounds: int) -> np.ndarray:
        """The truths of so many rounds and the ends of their bins, (round, 3); (1, 3) where they never change."""
        truths = self.truths(np.arange(first, first + (rounds if self.changes else 1)))
        return np.column_stack([truths, right_bins(truths, self.bins)])

    def _wrong(self, what: str) -> "MetricFails":
        return MetricFails(f"metric {self.metric.name!r} fails in {self.where}: {what}")

    def _check(self, rows: np.ndarray, truths: np.ndarray, follow: Callable[..., None]) -> None:
        """Raise MetricFails if the metric fails in CPython, or its record is another than in machine code."""
        try:
            slow = self._lived(rows, truths, whole=False)
        except Exception as error:
            raise self._wrong(f"{type(error).__name__}: {error}{line_of(error, self.metric.path)}") from error
        fast = np.repeat(self.blank, len(slow))
        follow(self.blank, fast, rows, 1, truths, self.out[:0])
        for i, record in enumerate(slow):
            for name in self.metric.fields:
                expected = float(getattr(record, name))
                # their mathematical functions may differ in the last bit, and differences of like numbers by more
                if not np.isclose(fast[name][i], expected, rtol=1e-6, atol=1e-9, equal_nan=True):
                    raise self._wrong(
                        f"after {counted(len(rows), 'round')} {name} is {fast[name][i]} in machine code and {expected} "
                        "in Python: are there whole numbers that grow beyond 64 bits?"
                    )

    def _line(self, rows: np.ndarray, truths: np.ndarray) -> str:
        """Where in its file the metric fails, found by CPython on the first estimates."""
        try:
            self._lived(rows[: MOST_SHOWN // rows.shape[1] + 1], truths)
        except Exception as error:
            return line_of(error, self.metric.path)
        return ""

    def _lived(self, rows: np.ndarray, truths: np.ndarray, whole: bool = True) -> list[Any]:
        """The metric's records after these estimates, computed by CPython; with `whole`, it computes results, too."""
        functions, given = self.metric.functions, dict(zip(GIVEN, self.blank[0].tolist(), strict=False))
        records = [self.metric.record(**given) for _ in range(1 if self.metric.of_swarm else rows.shape[1])]
        for my in records:
            functions.begin(my)
        for k, row in enumerate(rows.tolist(), start=1):
            truth, low, high = truths[min(k, len(truths)) - 1].tolist()
            for my in records:
                my.low, my.high = low, high
            for i, x in enumerate(row):
                functions.watch(records[min(i, len(records) - 1)], k, x, truth)
            if self.metric.of_swarm:
                functions.after(records[0], k)
        for my in records if whole else ():
            functions.result(my)
        return records

    @property
    def result(self) -> np.ndarray:
        """The result: (1, robot), or (1,) for a swarm. Raises MetricFails if it is not a number."""
        if (np.isnan(self.out) | np.isneginf(self.out)).any():
            raise self._wrong("its result is no number (of what never comes, infinity is right)")
        low, high = self.metric.bounds
        beyond = self.out[(self.out < low - 1e-9) | (self.out > high + 1e-9)]
        if beyond.size:
            raise self._wrong(f"its result {beyond[0]:g} is outside its BOUNDS, {low:g} to {high:g}")
        return self.out if self.metric.of_swarm else self.out[np.newaxis]


def results_of(watches: Iterable[Watch]) -> dict[str, np.ndarray]:
    """The results of a trial by variable. Raises MetricFails if one is not a number."""
    return {watch.metric.variable: watch.result for watch in watches}
