"""Metrics of files, as they watch one trial: its estimates go by, and what each metric then says is kept."""

from collections.abc import Iterable

import numpy as np

from swarmcensus.basics.errors import InputError
from swarmcensus.engine.compiler import blank_record, compile_metric
from swarmcensus.metrics import Metric
from swarmcensus.simulation.metrics import right_bin
from swarmcensus.studies.settings import Setting


class Watch:
    """One metric on one trial."""

    def __init__(self, metric: Metric, setting: Setting, trial: int, truth: float, delta: float, bins: int) -> None:
        """Make room for its records. Raises InputError where it cannot be compiled."""
        self.metric, self.truth = metric, truth
        self.where = f"trial {trial} of {setting}"
        low, high = right_bin(truth, bins)
        self.blank = blank_record(metric, low=low, high=high, delta=delta, rounds=setting.rounds, robots=setting.robots)
        self.records = np.repeat(self.blank, 1 if metric.of_swarm else setting.robots)
        self.out = np.empty(self.records.size)

    def see(self, rows: np.ndarray, first: int) -> None:
        """Look at estimates (round, robot) from round `first` on. Raises InputError where the metric fails."""
        try:
            module = compile_metric(self.metric)
            module.follow(self.blank, self.records, rows, first, self.truth, self.out)
        except Exception as error:
            text = str(error).strip()
            what = f"{type(error).__name__}: {text.splitlines()[0] if text else ''}"
            if "numba" in type(error).__module__:
                what = f"it cannot be compiled: {_told(text)}"
            raise InputError(f"metric {self.metric.name!r} fails in {self.where}: {what}") from error

    @property
    def result(self) -> np.ndarray:
        """What came of it: (1, robot), or (1,) of a swarm. Raises InputError where it is no number."""
        if np.isnan(self.out).any():
            raise InputError(
                f"metric {self.metric.name!r} fails in {self.where}: its result is no number (of what never comes, "
                "infinity is right)"
            )
        return self.out if self.metric.of_swarm else self.out[np.newaxis]


def _told(text: str) -> str:
    """What of Numba's message tells most: its last line that is not of a place."""
    lines = [line.strip() for line in text.splitlines() if line.strip()]
    said = [line for line in lines if not line.startswith(("File ", "During", "<source", "^", "-"))]
    return next((line for line in said if "not" in line.lower() or "invalid" in line.lower()), said[0] if said else "")


def results_of(watches: Iterable[Watch]) -> dict[str, np.ndarray]:
    """What came of a trial, by the metrics' variables. Raises InputError where one is no number."""
    return {watch.metric.variable: watch.result for watch in watches}
