"""A study's numbers as they come in: which variables there are, and arrays that fill up piece by piece."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray

from swarmcensus.simulation.trials import Batch
from swarmcensus.studies.settings import Setting

PER_ROBOT = ("setting", "trial", "robot")
VARIABLES: dict[str, tuple[tuple[str, ...], Any, str, str]] = {
    "convergence_round": (PER_ROBOT, np.int32, "rounds", "K, the convergence of the informed estimate"),
    "convergence_error": (PER_ROBOT, np.float64, "1", "|x^K - f|, the informed estimate's error at convergence"),
    "final_estimate": (PER_ROBOT, np.float64, "1", "the informed estimate after the last round"),
    "correct": (("setting", "checkpoint", "trial"), np.float64, "1", "fraction of robots in the correct bin"),
    "true_fill_ratio": (("setting", "trial"), np.float64, "1", "black share of the floor that robots can reach"),
}
LOCAL: dict[str, tuple[tuple[str, ...], Any, str, str]] = {
    "local_convergence_step": (PER_ROBOT, np.int32, "observations", "convergence of the local estimate"),
    "local_convergence_error": (PER_ROBOT, np.float64, "1", "the local estimate's error at convergence"),
}
ESTIMATES: dict[str, tuple[tuple[str, ...], Any, str, str]] = {
    "estimates": (
        ("setting", "checkpoint", "trial", "robot"), np.float64, "1", "the informed estimate at the checkpoints"
    ),
}  # fmt: skip
OPTIONAL = LOCAL | ESTIMATES  # what a study need not ask for
EVERY = VARIABLES | OPTIONAL
MARKS = "convergence_round", "local_convergence_step"  # by which one knows that a trial is done, and its local part
ORDER = (*(name for name in EVERY if name not in MARKS), *MARKS)
MISSING = -1  # for whole numbers; NaN for the others

Columns = dict[str, NDArray[Any]]


@dataclass(frozen=True)
class Piece:
    """What came of some trials of one setting."""

    setting: int
    first: int
    columns: Columns
    local: bool = False

    @property
    def shape(self) -> tuple[int, int]:
        """How many trials, and robots."""
        name = "local_convergence_error" if self.local else "convergence_error"
        trials, robots = self.columns[name].shape
        return trials, robots


def columns(batch: Batch, local: bool) -> Columns:
    """What came of some trials, by the variables' names; without the dimension `setting`."""
    if local:
        return {
            "local_convergence_step": batch.convergence.astype(np.int32),
            "local_convergence_error": batch.error,
        }
    filled = batch.true_fill_ratio
    kept = {} if batch.kept is None else {"estimates": batch.kept}
    return kept | {
        "convergence_round": batch.convergence.astype(np.int32),
        "convergence_error": batch.error,
        "final_estimate": batch.final,
        "correct": batch.correct,
        "true_fill_ratio": np.full(len(batch.final), np.nan) if filled is None else filled,
    }


def shapes(trials: int, robots: int, checkpoints: int, local: bool, estimates: bool) -> dict[str, tuple[int, ...]]:
    """The shapes of those."""
    sizes = {"trial": trials, "robot": robots, "checkpoint": checkpoints}
    names = LOCAL if local else VARIABLES | (ESTIMATES if estimates else {})
    return {name: tuple(sizes[d] for d in dims[1:]) for name, (dims, *_) in names.items()}


class Values:
    """Arrays of the dataset's shapes, missing values where nothing has run yet."""

    def __init__(
        self, settings: Sequence[Setting], trials: int, checkpoints: int, local: bool, estimates: bool = False
    ) -> None:
        """Make room for so many trials."""
        self.robots = [s.robots for s in settings]
        sizes = {"setting": len(settings), "trial": trials, "robot": max(self.robots), "checkpoint": checkpoints}
        self.arrays: Columns = {}
        names = VARIABLES | (LOCAL if local else {}) | (ESTIMATES if estimates else {})
        for name, (dims, kind, *_) in names.items():
            shape = [sizes[d] for d in dims]
            self.arrays[name] = np.full(shape, MISSING if np.issubdtype(kind, np.integer) else np.nan, kind)

    @classmethod
    def of(cls, data: Mapping[Any, Any]) -> Self:
        """Those of a dataset, which are not copied."""
        values = cls.__new__(cls)
        values.robots = data["robots"].values.tolist()
        values.arrays = {name: data[name].values for name in EVERY if name in data}
        return values

    @property
    def trials(self) -> int:
        """For how many trials there is room."""
        return int(self.arrays["convergence_round"].shape[1])

    def grow(self, trials: int) -> None:
        """Make room for so many trials, if there is less."""
        more = trials - self.trials
        if more <= 0:
            return
        for name, array in self.arrays.items():
            axis = EVERY[name][0].index("trial")
            blank = MISSING if array.dtype.kind == "i" else np.nan
            self.arrays[name] = np.pad(
                array, [(0, more * (k == axis)) for k in range(array.ndim)], constant_values=blank
            )

    def put(self, setting: int, first: int, taken: Columns) -> None:
        """Store the numbers of some trials of a setting; what `done` looks at last: Ctrl-C may fall between."""
        for name in ORDER:
            if name not in taken:
                continue
            values, array = taken[name], self.arrays[name][setting]
            if name == "correct":
                array[:, first : first + values.shape[1]] = values
            elif name == "estimates":
                _, trials, robots = values.shape
                array[:, first : first + trials, :robots] = values
            elif name == "true_fill_ratio":
                array[first : first + len(values)] = values
            else:
                trials, robots = values.shape
                array[first : first + trials, :robots] = values

    def forget_halves(self) -> None:
        """Make missing again what Ctrl-C left of trials that were just being stored."""
        for name, array in self.arrays.items():
            by_trial = np.moveaxis(array, EVERY[name][0].index("trial"), 1)
            by_trial[~self.done(name in LOCAL)] = MISSING if array.dtype.kind == "i" else np.nan

    def done(self, local: bool = False) -> NDArray[np.bool_]:
        """Which trials have run, (setting, trial)."""
        return np.asarray(self.arrays[MARKS[local]][:, :, 0] != MISSING)

    def finished(self) -> NDArray[np.bool_]:
        """Of which trials there is all that was asked for, (setting, trial)."""
        return self.done() & self.done(local=True) if MARKS[True] in self.arrays else self.done()
