"""The arrays of a run: which variables there are, and values that arrive piece by piece."""

import functools
import json
import math
import mmap
import tempfile
from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass
from itertools import chain
from pathlib import Path
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray

from swarmcensus.brains.metrics import Metric, parse
from swarmcensus.results.plugin_files import plugin_files_in
from swarmcensus.studies import Setting, Study
from swarmcensus.support.errors import InputError, ResultsError
from swarmcensus.support.quantities import OPTIONS, PER_ROBOT, PER_TRIAL, QUANTITIES, stored

Kind = tuple[tuple[str, ...], Any, str, str]  # a variable's dimensions, type, unit and meaning


def _group(name: str) -> dict[str, Kind]:
    return {variable: (one.dims, one.kind, one.unit, one.meaning) for variable, one in stored(name).items()}


VARIABLES = _group("always") | _group("messages")  # of every run; counts are real, as R has no large whole numbers
AGREEMENT = _group("agreement")  # of every run
GROUPS = ("local", "estimates", "decisions", "formats", "networks", "drawn", "endings", "intervals")  # of some runs
OPTIONAL = {name: _group(name) for name in GROUPS}
LOCAL, ESTIMATES, INTERVALS = OPTIONAL["local"], OPTIONAL["estimates"], OPTIONAL["intervals"]
NETWORKS = OPTIONAL["networks"]
ALL_VARIABLES = dict(chain(VARIABLES.items(), AGREEMENT.items(), *map(dict.items, OPTIONAL.values())))
MARKS = "convergence_round", "local_convergence_step"  # present once a trial is done, and its local part
MISSING = -1  # in whole numbers; NaN in others

Columns = dict[str, NDArray[Any]]
LARGE_BYTES = 16_000_000  # from this size on, an array lies in a file
BLOCK = 2_000_000  # numbers that are written at once


class ArrayStore:
    """Allocates arrays of missing numbers. Large arrays are mapped to unnamed files in a folder, if it has one.

    The operating system keeps as much of these arrays in memory as fits. The files vanish when the process ends.
    """

    def __init__(self, folder: Path | None = None) -> None:
        """Set the folder of the files."""
        self.folder = folder

    def full(self, shape: tuple[int, ...], missing: float, kind: Any) -> NDArray[Any]:
        """An array in which all numbers are `missing`. Raises InputError if the disk is full."""
        size = math.prod(shape)
        if self.folder is None or size * np.dtype(kind).itemsize < LARGE_BYTES:
            return np.full(shape, missing, kind)
        try:
            with tempfile.TemporaryFile(dir=self.folder) as file:
                for first in range(0, size, BLOCK):  # written, not mapped: a full disk raises an error
                    file.write(np.full(min(BLOCK, size - first), missing, kind).tobytes())
                file.flush()
                pages = mmap.mmap(file.fileno(), 0)
        except OSError as error:
            why = error.strerror or error
            raise InputError(f"cannot keep results in {self.folder}: {why}", file=self.folder) from error
        return np.frombuffer(pages, kind).reshape(shape)


def missing_value(kind: Any) -> Any:
    """The missing value of an array of this type."""
    return MISSING if np.issubdtype(kind, np.integer) else np.nan


def is_missing(array: NDArray[Any]) -> NDArray[np.bool_]:
    """A mask of the missing values (same shape)."""
    return np.asarray(array == MISSING if array.dtype.kind == "i" else np.isnan(array))


def same_bits(first: NDArray[Any], second: NDArray[Any]) -> NDArray[np.bool_]:
    """A mask of the values that are equal to the last bit (same shape): 0 differs from -0, and two NaN may differ."""
    if first.dtype.kind == second.dtype.kind == "f" and first.dtype.itemsize == second.dtype.itemsize == 8:
        first, second = first.view(np.uint64), second.view(np.uint64)
    return np.asarray(first == second)


def others(dims: Sequence[str]) -> tuple[int, ...]:
    """The axes that are neither settings nor trials."""
    return tuple(k for k, dim in enumerate(dims) if dim not in PER_TRIAL)


def kinds_of(metrics: Iterable[Metric]) -> dict[str, Kind]:
    """The variables of metric files."""
    return {m.variable: (PER_TRIAL if m.of_swarm else PER_ROBOT, np.float64, m.unit, m.meaning) for m in metrics}


def kinds_in(data: Mapping[Any, Any]) -> dict[str, Kind]:
    """The variables of a dataset that a run fills: stored quantities and metric files."""
    kinds = {name: kind for name, kind in ALL_VARIABLES.items() if name in data}
    for name in (name for name in metrics_in(data) if name in data):
        unit, meaning = (str(data[name].attrs.get(key)) for key in ("units", "long_name"))
        kinds[name] = data[name].dims, np.float64, unit, meaning
    return kinds


def robots_in(data: Any) -> Any:
    """The number of measured robots, (setting,): all, or only the honest ones if some lie."""
    return data["honest"] if "honest" in data else data["robots"]


def parameters_in(data: Any) -> dict[str, list[str]]:
    """The names of each brain's parameters, which are coordinates. Raises InputError if one is missing."""
    parameters: dict[str, list[str]] = _json(data.attrs.get("parameters", "{}"))
    for name, brain in ((name, brain) for brain, names in parameters.items() for name in names):
        if name not in data.coords or data[name].dims != ("setting",):
            raise ResultsError(f"these results have no coordinate {name}, the parameter of {brain}", key=name)
    return parameters


def metrics_in(data: Any) -> dict[str, dict[str, Any]]:
    """The metric files of a dataset by variable, each with `name`, `sha256` and `source`."""
    return dict(_json(data.attrs.get("metrics", "{}")))


_json = functools.lru_cache(maxsize=16)(json.loads)  # read for every column of a table


def metric_of(data: Any, name: str) -> Metric:
    """The metric file of a variable, from the source in the dataset; it is not run."""
    about = metrics_in(data)[name]
    return parse(about["source"], about["name"], Path(about["name"]))


def bounds_in(data: Any, name: str) -> tuple[float, float | NDArray[np.float64]]:
    """The lowest and the highest possible value of a variable; the highest may be an array (setting,)."""
    if name in metrics_in(data):
        return metric_of(data, name).bounds
    quantity = QUANTITIES.get(name)
    if quantity is None:
        return -np.inf, np.inf
    if quantity.within_rounds:
        return 0.0, np.asarray(data["rounds"].values, np.float64)
    if quantity.bounds == OPTIONS:
        return -1.0, float(np.nanmax(data[name].values, initial=0.0))
    return quantity.bounds


def additions_in(data: Any) -> dict[str, dict[str, str]]:
    """The additions of other packages that a dataset used, as `Study.additions`."""
    return dict(_json(data.attrs.get("additions", "{}")))


def changed_plugin(data: Any, study: Study) -> str:
    """A sentence that names a file of others which has changed since the results were made; empty if none has."""
    stored = plugin_files_in(data)
    for file in study.plugin_files:
        title = f"{file.kind} {file.name}"
        if stored.get(title, {}).get("sha256", file.sha256) != file.sha256:
            return f"the {title} was changed since these results were made"
    for name, addition in additions_in(data).items():
        if study.additions.get(name, addition)["sha256"] != addition["sha256"]:
            return f"the {name} of {addition['package']} was changed since these results were made"
    return ""


def finished_trials(data: Any) -> NDArray[np.bool_]:
    """A mask of the trials that have all requested values, (setting, trial)."""
    local = "local_convergence_step" in data and "merged" not in data.attrs
    names = MARKS if local else MARKS[:1]
    return np.asarray(np.all([~is_missing(data.variables[name].values[:, :, 0]) for name in names], axis=0))


def failed_in(data: Any) -> list[dict[str, Any]]:
    """The failed trials, also of settings that were not selected, each with `setting`, `trial` and `why`."""
    return list(json.loads(data.attrs.get("failed", "[]")))


def failed_trials(data: Any) -> NDArray[np.bool_]:
    """A mask of the trials that failed, (setting, trial)."""
    mask = np.zeros((data.sizes["setting"], data.sizes["trial"]), np.bool_)
    for failure in failed_in(data):
        settings, trials = (data.variables[key].values == failure[key] for key in ("setting", "trial"))
        mask |= np.outer(settings, trials)
    return mask


def selected(data: Any) -> dict[str, Any]:
    """The attributes of a selection of a dataset, with its own number of trials."""
    settings, trials = (data.variables[key].values for key in ("setting", "trial"))
    left = [failure for failure in failed_in(data) if failure["setting"] in settings and failure["trial"] in trials]
    counted = {"trials_done": int(finished_trials(data).sum())} if "trials_done" in data.attrs else {}
    others = {k: v for k, v in data.attrs.items() if k != "failed"} | counted
    return others | ({"failed": json.dumps(left)} if left else {})


def sources_of(metrics: Iterable[Metric]) -> dict[str, dict[str, Any]]:
    """Metric files as a dataset stores them: `name`, `sha256` and `source` by variable."""
    return {m.variable: {"name": m.name, "sha256": m.sha256, "source": m.source} for m in metrics}


def metrics_label(sources: Mapping[str, Mapping[str, Any]]) -> str:
    """Metric files as one line, with the start of each hash."""
    return ", ".join(f"{variable} ({source['sha256'][:8]})" for variable, source in sorted(sources.items()))


@dataclass(frozen=True)
class Piece:
    """The values of some consecutive trials of one setting, by its number; by its fingerprint where it is read."""

    setting: Any
    first: int
    columns: Columns
    local: bool = False

    @property
    def shape(self) -> tuple[int, int]:
        """The numbers of trials and robots."""
        trials, robots = self.columns["local_convergence_error" if self.local else "convergence_error"].shape
        return trials, robots


def shapes(
    trials: int, robots: int, checkpoints: int, local: bool, names: Iterable[str], of_swarm: Collection[str]
) -> dict[str, tuple[int, ...]]:
    """The shapes of a piece's columns; `of_swarm` names the metrics with one number per trial."""
    sizes = {"trial": trials, "robot": robots, "checkpoint": checkpoints}
    by_name = {}
    for name in LOCAL if local else [name for name in names if name not in LOCAL]:
        dims = ALL_VARIABLES[name][0] if name in ALL_VARIABLES else PER_TRIAL if name in of_swarm else PER_ROBOT
        by_name[name] = tuple(sizes[d] for d in dims[1:])
    return by_name


class Values:
    """Arrays with the shapes of the dataset, filled with missing values where nothing has run yet."""

    def __init__(
        self,
        studies: Sequence[Study],
        settings: Sequence[Setting],
        trials: int,
        local: bool | None = None,
        store: ArrayStore | None = None,
    ) -> None:
        """Allocate arrays of what studies measure; `local` is whether estimates of robots alone are among them.

        By default the studies say so. `store` allocates the arrays, by default in memory. Raises InputError if the
        disk is full.
        """
        self.robots = [s.honest for s in settings]
        self.checkpoints = sorted({checkpoint for study in studies for checkpoint in study.checkpoints})
        robots, checkpoints = max(self.robots), len(self.checkpoints)
        sizes = {"setting": len(settings), "trial": trials, "robot": robots, "checkpoint": checkpoints}
        stored = frozenset[str]().union(*(study.stored for study in studies))
        if local is not None:
            stored = stored | {"local"} if local else stored - {"local"}
        optional = chain.from_iterable(OPTIONAL[name].items() for name in GROUPS if name in stored)
        metrics = chain.from_iterable(study.measure.metrics for study in studies)
        self.kinds = VARIABLES | AGREEMENT | dict(optional) | kinds_of(metrics)
        self.store = store or ArrayStore()
        self.arrays: Columns = {
            name: self.store.full(tuple(sizes[d] for d in dims), missing_value(kind), kind)
            for name, (dims, kind, *_) in self.kinds.items()
        }

    @classmethod
    def of(cls, data: Mapping[Any, Any]) -> Self:
        """The arrays of a dataset, without copying."""
        values = cls.__new__(cls)
        values.store = ArrayStore()
        values.robots = robots_in(data).values.tolist()
        values.checkpoints = data["checkpoint"].values.tolist()
        values.kinds = kinds_in(data)
        values.arrays = {name: data[name].values for name in values.kinds}
        return values

    @property
    def trials(self) -> int:
        """The number of trials that the arrays hold."""
        return int(self.arrays["convergence_round"].shape[1])

    def grow(self, trials: int) -> None:
        """Enlarge the arrays to at least `trials` trials."""
        if trials <= self.trials:
            return
        for name, array in self.arrays.items():
            axis = self.kinds[name][0].index("trial")
            shape = (*array.shape[:axis], trials, *array.shape[axis + 1 :])
            wider = self.store.full(shape, missing_value(array.dtype), array.dtype)
            wider[tuple(map(slice, array.shape))] = array
            self.arrays[name] = wider

    def put(self, setting: int, first: int, taken: Columns) -> None:
        """Store the values of some trials of a setting. What `done` reads is written last, as Ctrl-C may interrupt."""
        for name in (*(name for name in taken if name not in MARKS), *(name for name in MARKS if name in taken)):
            dims, values = self.kinds[name][0][1:], taken[name]
            array = self.arrays[name][setting]
            last = first + values.shape[dims.index("trial")]
            where = array[first:last] if dims[0] == "trial" else array[:, first:last]
            (where[..., : values.shape[-1]] if dims[-1] == "robot" else where)[...] = values

    def forget_halves(self) -> None:
        """Clear trials that Ctrl-C interrupted while they were stored."""
        for name, array in self.arrays.items():
            by_trial = np.moveaxis(array, self.kinds[name][0].index("trial"), 1)
            by_trial[~self.done(name in LOCAL)] = missing_value(array.dtype)

    def done(self, local: bool = False) -> NDArray[np.bool_]:
        """A mask of the trials that have run, (setting, trial)."""
        return np.asarray(self.arrays[MARKS[local]][:, :, 0] != MISSING)

    def finished(self) -> NDArray[np.bool_]:
        """A mask of the trials that have all requested values, (setting, trial)."""
        return self.done() & self.done(local=True) if MARKS[True] in self.arrays else self.done()
