"""A study's numbers as they come in: which variables there are, and arrays that fill up piece by piece."""

import contextlib
import ctypes
import functools
import json
import math
import mmap
import tempfile
from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray

from swarmcensus.basics.errors import InputError
from swarmcensus.metrics import Metric, parse
from swarmcensus.studies.settings import Setting
from swarmcensus.studies.study import Study
from swarmcensus.vocabulary.quantities import OPTIONS, PER_ROBOT, PER_TRIAL, QUANTITIES, Quantity, stored

Kind = tuple[tuple[str, ...], Any, str, str]  # a variable's dimensions, type, unit and meaning


def kind_of(quantity: Quantity) -> Kind:
    """What a file says of a quantity."""
    return quantity.dims, quantity.kind, quantity.unit, quantity.meaning


def _group(name: str) -> dict[str, Kind]:
    return {one: kind_of(quantity) for one, quantity in stored(name).items()}


VARIABLES = _group("always")
DECISIONS = _group("decisions")
ENDINGS = _group("endings")
INTERVALS = _group("intervals")
LOCAL = _group("local")
ESTIMATES = _group("estimates")
EVERY = VARIABLES | DECISIONS | ENDINGS | INTERVALS | LOCAL | ESTIMATES  # but for metrics of files
# a trial has all of such a group or nothing of it: the first variable of the group tells which
LEADS = {name: next(iter(group)) for group in (DECISIONS, ENDINGS, INTERVALS, LOCAL) for name in group}
ENDLESS = tuple(name for name, quantity in QUANTITIES.items() if quantity.never)  # what never comes is infinite
MARKS = "convergence_round", "local_convergence_step"  # by which one knows that a trial is done, and its local part
MISSING = -1  # for whole numbers; NaN for the others
NAN_BITS = np.array(np.nan).view(np.uint64)  # there are many NaN, and what is missing is this one

Columns = dict[str, NDArray[Any]]


LARGE_BYTES = 16_000_000  # of an array from which on it lies in a file


BLOCK = 2_000_000  # numbers that are written at once


FRESH_BYTES = 16_000_000  # that are put into arrays before memory is looked after


class Room:
    """Makes arrays of missing numbers: large ones in files of a folder, if one is given.

    The system then keeps of them in memory what there is room for. The files go with the process, however it ends.
    """

    def __init__(self, folder: Path | None = None) -> None:
        """Know the folder."""
        self.folder = folder
        self._maps: list[mmap.mmap] = []
        self._fresh = 0

    def full(self, shape: tuple[int, ...], missing: float, kind: Any) -> NDArray[Any]:
        """An array in which all numbers are `missing`. Raises InputError where the folder's disk is full."""
        size = math.prod(shape)
        if self.folder is None or size * np.dtype(kind).itemsize < LARGE_BYTES:
            return np.full(shape, missing, kind)
        try:
            with tempfile.TemporaryFile(dir=self.folder) as file:
                for first in range(0, size, BLOCK):  # written, not mapped: where there is no room, one is told
                    file.write(np.full(min(BLOCK, size - first), missing, kind).tobytes())
                file.flush()
                pages = mmap.mmap(file.fileno(), 0)
        except OSError as error:
            raise InputError(f"cannot keep results in {self.folder}: {error.strerror or error}") from error
        self._maps.append(pages)
        return np.frombuffer(pages, kind).reshape(shape)

    def wrote(self, size: int) -> None:
        """So many bytes were put into arrays: now and then memory that is not needed goes back to the system."""
        self._fresh += size
        if self._fresh < FRESH_BYTES:
            return
        self._fresh = 0
        if hasattr(mmap, "MADV_DONTNEED"):  # what was put there is in the file
            for pages in self._maps:
                pages.madvise(mmap.MADV_DONTNEED)
        with contextlib.suppress(OSError, AttributeError, TypeError):  # other C libraries have none of its name
            ctypes.CDLL(None).malloc_trim(0)  # glibc keeps arrays of some megabytes that were freed, thread by thread


def blank(kind: Any) -> Any:
    """What stands for a missing number in an array of this type."""
    return MISSING if np.issubdtype(kind, np.integer) else np.nan


def is_missing(array: NDArray[Any]) -> NDArray[np.bool_]:
    """Which numbers are missing, or padding (the same shape)."""
    return np.asarray(array == MISSING if array.dtype.kind == "i" else np.isnan(array))


def same_bits(one: NDArray[Any], other: NDArray[Any]) -> NDArray[np.bool_]:
    """Which values are the same to the last bit (the same shape): 0 is not -0, and two NaN may differ."""
    if one.dtype.kind == other.dtype.kind == "f" and one.dtype.itemsize == other.dtype.itemsize == 8:
        one, other = one.view(np.uint64), other.view(np.uint64)
    return np.asarray(one == other)


def _place(kind: Kind) -> tuple[int, bool]:
    """Which axis of a setting's array is the trial, and whether the last one is the robot."""
    return kind[0].index("trial") - 1, kind[0][-1] == "robot"


PLACES = {name: _place(kind) for name, kind in EVERY.items()}  # of every piece, each name is looked up


def kinds_of(metrics: Iterable[Metric]) -> dict[str, Kind]:
    """The variables of metrics."""
    return {m.variable: (PER_TRIAL if m.of_swarm else PER_ROBOT, np.float64, m.unit, m.meaning) for m in metrics}


def kinds_in(data: Mapping[Any, Any]) -> dict[str, Kind]:
    """The variables of a dataset that a run fills: those of old, and those of the metrics that it names."""
    known = {name: kind for name, kind in EVERY.items() if name in data}
    return known | {
        name: (data[name].dims, np.float64, str(data[name].attrs.get("units")), str(data[name].attrs.get("long_name")))
        for name in metrics_in(data)
        if name in data
    }


def robots_in(data: Any) -> Any:
    """How many robots a setting has numbers of: all of them, or where some lie the honest ones (setting)."""
    return data["honest"] if "honest" in data else data["robots"]


def parameters_in(data: Any) -> list[str]:
    """The coordinates that are brains' parameters."""
    return list(dict.fromkeys(name for names in _read(data.attrs.get("parameters", "{}")).values() for name in names))


def metrics_in(data: Any) -> dict[str, dict[str, Any]]:
    """The metrics that a dataset names, by their variables: `name`, `sha256` and `source`."""
    return _read(data.attrs.get("metrics", "{}"))


@functools.lru_cache(maxsize=16)
def _read(text: str) -> dict[str, Any]:
    found: dict[str, Any] = json.loads(text)
    return found


def metric_of(data: Any, name: str) -> Metric:
    """The metric file that a variable comes from, as the dataset holds it; it is not run."""
    about = metrics_in(data)[name]
    return parse(about["source"], about["name"], Path(about["name"]))


def bounds_in(data: Any, name: str) -> tuple[float, float | NDArray[np.float64]]:
    """The least and the largest number that a variable can be, the latter also by setting, (setting,)."""
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
    """What of other packages a dataset says that it used, as `Study.additions`; nothing where that is not legible."""
    try:
        said = json.loads(data.attrs.get("additions", "{}"))
        return {str(name): {k: str(one[k]) for k in ("package", "version", "sha256")} for name, one in said.items()}
    except (ValueError, TypeError, KeyError, AttributeError, RecursionError):
        return {}


def edited(data: Any, study: Study) -> str:
    """Which of them is of another edition here, as a sentence; empty where none is."""
    for name, one in additions_in(data).items():
        if study.additions.get(name, one)["sha256"] != one["sha256"]:
            return f"the {name} of {one['package']} was changed since these results were made"
    return ""


def sources_of(metrics: Iterable[Metric]) -> dict[str, dict[str, Any]]:
    """The same of metrics themselves, as a dataset is to name them."""
    return {m.variable: {"name": m.name, "sha256": m.sha256, "source": m.source} for m in metrics}


def told(sources: Mapping[str, Mapping[str, Any]]) -> str:
    """The same in a line that tells two versions of a metric apart."""
    return ", ".join(f"{variable} ({one['sha256'][:8]})" for variable, one in sorted(sources.items()))


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


def shapes(
    trials: int, robots: int, checkpoints: int, local: bool, names: Iterable[str], of_swarm: Collection[str]
) -> dict[str, tuple[int, ...]]:
    """The shapes of those; `names` are all that there are, `of_swarm` those of metrics that have one number a trial."""
    sizes = {"trial": trials, "robot": robots, "checkpoint": checkpoints}
    if local:
        return {name: tuple(sizes[d] for d in dims[1:]) for name, (dims, *_) in LOCAL.items()}
    found = {}
    for name in names:
        if name not in LOCAL:
            dims = EVERY[name][0] if name in EVERY else PER_TRIAL if name in of_swarm else PER_ROBOT
            found[name] = tuple(sizes[d] for d in dims[1:])
    return found


class Values:
    """Arrays of the dataset's shapes, missing values where nothing has run yet."""

    def __init__(
        self,
        study: Study,
        settings: Sequence[Setting],
        trials: int,
        local: bool | None = None,
        room: Room | None = None,
    ) -> None:
        """Make room for so many trials of settings of a study; `local` instead of what it says of local estimates.

        Arrays lie in the `room`, by default in memory. Raises InputError where it is full.
        """
        self.robots = [s.honest for s in settings]
        sizes = {
            "setting": len(settings), "trial": trials, "robot": max(self.robots), "checkpoint": len(study.checkpoints)
        }  # fmt: skip
        local = study.measure.local if local is None else local
        asked = (LOCAL if local else {}) | (ESTIMATES if study.measure.estimates else {})
        asked |= DECISIONS if any(brain.decides for brain in study.brains) else {}
        asked |= ENDINGS if any(brain.ends for brain in study.brains) else {}
        asked |= INTERVALS if any(brain.has_interval for brain in study.brains) else {}
        self.kinds = VARIABLES | asked | kinds_of(study.measure.metrics)
        self.room = room or Room()
        self.arrays: Columns = {
            name: self.room.full(tuple(sizes[d] for d in dims), blank(kind), kind)
            for name, (dims, kind, *_) in self.kinds.items()
        }

    @classmethod
    def of(cls, data: Mapping[Any, Any]) -> Self:
        """Those of a dataset, which are not copied."""
        values = cls.__new__(cls)
        values.room = Room()
        values.robots = robots_in(data).values.tolist()
        values.kinds = kinds_in(data)
        values.arrays = {name: data[name].values for name in values.kinds}
        return values

    @property
    def trials(self) -> int:
        """For how many trials there is room."""
        return int(self.arrays["convergence_round"].shape[1])

    def grow(self, trials: int) -> None:
        """Make room for so many trials, if there is less."""
        if trials <= self.trials:
            return
        for name, array in self.arrays.items():
            axis = self.kinds[name][0].index("trial")
            shape = (*array.shape[:axis], trials, *array.shape[axis + 1 :])
            wider = self.room.full(shape, blank(array.dtype), array.dtype)
            wider[tuple(map(slice, array.shape))] = array
            self.arrays[name] = wider

    def put(self, setting: int, first: int, taken: Columns) -> None:
        """Store the numbers of some trials of a setting; what `done` looks at last: Ctrl-C may fall between."""
        for name in (*(name for name in taken if name not in MARKS), *(name for name in MARKS if name in taken)):
            axis, by_robot = PLACES.get(name) or _place(self.kinds[name])
            values, array = taken[name], self.arrays[name][setting]
            last = first + values.shape[axis]
            where = array[:, first:last] if axis else array[first:last]
            (where[..., : values.shape[-1]] if by_robot else where)[...] = values
            self.room.wrote(values.nbytes)

    def forget_halves(self) -> None:
        """Make missing again what Ctrl-C left of trials that were just being stored."""
        for name, array in self.arrays.items():
            by_trial = np.moveaxis(array, self.kinds[name][0].index("trial"), 1)
            by_trial[~self.done(name in LOCAL)] = blank(array.dtype)

    def done(self, local: bool = False) -> NDArray[np.bool_]:
        """Which trials have run, (setting, trial)."""
        return np.asarray(self.arrays[MARKS[local]][:, :, 0] != MISSING)

    def finished(self) -> NDArray[np.bool_]:
        """Of which trials there is all that was asked for, (setting, trial)."""
        return self.done() & self.done(local=True) if MARKS[True] in self.arrays else self.done()
