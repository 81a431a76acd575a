"""The log of a search: a CSV file with a line for each evaluation, from which a search can resume.

The first line identifies the search, the second holds the scales of each world (`scales_of` in training.py); both are
comments. `candidates_in` reads it, also of a search at work, as a dataset that `show` and `plot` take.
"""

import contextlib
import io
import json
import os
from dataclasses import dataclass
from itertools import chain
from pathlib import Path
from typing import BinaryIO, Self

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from swarmcensus.search.tuning.plans import TuningPlan
from swarmcensus.support.answers import Answer
from swarmcensus.support.errors import InputError
from swarmcensus.support.files import atomic_write, check_writable, remove_leftovers
from swarmcensus.support.formatting import counted
from swarmcensus.support.hints import did_you_mean
from swarmcensus.support.options import option, wrong_option
from swarmcensus.support.owners import Busy, Owner
from swarmcensus.support.quantities import BEST, PER_TRIAL, SEARCHED

FORMAT = "# swarmcensus tune 4 "
USUAL = "# usual "
FIRST, LAST = ("evaluation", "generation"), "failed"  # columns


def hint() -> str:
    """What to do about an existing log that the search cannot continue."""
    return f"Tune with {option('fresh', True)} to start again, or write elsewhere with {option('out')}"


@dataclass(frozen=True)
class Evaluation:
    """One candidate, its losses and its numbers; the first is the original brain, generation 0."""

    generation: int
    values: tuple[float, ...]
    losses: tuple[float, ...]  # by the metric, and by the measure that breaks its ties
    numbers: tuple[float, ...]  # of the same measures: the median or mean over all trials of all worlds
    failed: int  # number of failed trials

    @property
    def loss(self) -> float:
        """The loss by the metric, in [0, 1]."""
        return self.losses[0]


class Log:
    """The evaluations so far, on disk if there is a path; the file is locked for the `with` block."""

    def __init__(self, path: Path | None, plan: TuningPlan, fresh: bool = False) -> None:
        """Take the search's plan; if `fresh`, a file that exists is replaced."""
        self.path, self.identity, self.fresh = path, plan.identity, fresh
        self.head = FORMAT + json.dumps(self.identity) + "\n"
        self.places = [parameter.label for parameter in plan.ranges]
        self.parts = self.places, plan.losses, [measure.name for measure in plan.measures]
        self.columns = ",".join([*FIRST, *chain.from_iterable(self.parts), LAST])
        self.evaluations: list[Evaluation] = []
        self.usual: NDArray[np.float64] | None = None
        self._file: BinaryIO | None = None
        self._end = contextlib.ExitStack()

    def __enter__(self) -> Self:
        """Lock and read the file. Raises InputError if another search has locked it, or if it is of another search."""
        if self.path is None:
            return self
        check_writable(self.path)
        with contextlib.ExitStack() as stack:
            try:
                self._lock = stack.enter_context(Owner(self.path.with_name(f".{self.path.name}.lock")))
            except Busy as owner:
                raise InputError.of(self.path, f"another search is writing it ({owner})") from None
            except OSError as error:
                raise self._unwritten(error) from error
            remove_leftovers(self.path)
            end = 0 if self.fresh or not self.path.exists() else self._read(self.path.read_bytes())
            if not end:
                with atomic_write(self.path) as temporary:
                    temporary.write_text(self.head, encoding="utf-8")
            stack.callback(self._remove_if_empty, self.path)
            self._file = stack.enter_context(self.path.open("r+b"))
            self._file.truncate(end or len(self.head.encode()))
            self._file.seek(0, os.SEEK_END)
            self._end = stack.pop_all()
        return self

    def __exit__(self, *_: object) -> None:
        """Close the file; remove it if it has no evaluation."""
        self._end.close()

    def _remove_if_empty(self, path: Path) -> None:
        if not self.evaluations and self._lock.is_there():
            Path(os.path.realpath(path)).unlink(missing_ok=True)  # a link's target, not the link

    def set_usual(self, usual: NDArray[np.float64]) -> None:
        """Write the scales of the worlds, and the columns' names."""
        self.usual = usual
        self._add(f"{USUAL}{json.dumps(usual.tolist())}\n{self.columns}\n")

    def add(self, evaluation: Evaluation) -> None:
        """Write an evaluation as one line."""
        self.evaluations.append(evaluation)
        row = [len(self.evaluations) - 1, evaluation.generation, *evaluation.values, *evaluation.losses]
        self._add(",".join(map(repr, [*row, *evaluation.numbers, evaluation.failed])) + "\n")

    def _unwritten(self, error: OSError) -> InputError:
        return InputError(f"cannot write {self.path}: {error.strerror or error}", file=self.path)

    def _add(self, text: str) -> None:
        if self._file is None:
            return
        try:
            if not self._lock.keeps():
                raise InputError.of(self.path, "another search has taken it over: this one ends")
            self._file.write(text.encode())
            self._file.flush()
        except OSError as error:
            raise self._unwritten(error) from error

    def _read(self, data: bytes) -> int:
        """Read all complete lines, and return their length in bytes; an incomplete last line is ignored."""
        if self.head.encode().startswith(data):  # the first evaluation was not finished
            return 0
        try:
            head, *lines = data[: data.rfind(b"\n") + 1].decode().splitlines()
            identity = dict(json.loads(head.removeprefix(FORMAT) if head.startswith(FORMAT) else ""))
        except (ValueError, TypeError, RecursionError):  # the path may hold any file, which must not be overwritten
            raise InputError(f"{self.path} is no log of a search. {hint()}", file=self.path) from None
        differ = [
            f"{key} is {identity.get(key)!r} there and {value!r} here"
            for key, value in self.identity.items() if identity.get(key) != value
        ]  # fmt: skip
        if differ:
            raise InputError(f"{self.path} is of another search: {'; '.join(differ)}. {hint()}", file=self.path)
        if len(lines) < 3:
            return 0
        number = 3
        try:
            if not lines[0].startswith(USUAL) or lines[1] != self.columns:
                raise ValueError
            scales = json.loads(lines[0].removeprefix(USUAL))
            self.usual = np.array(scales, np.float64).reshape(len(self.parts[1]), -1, 2)
            for number, line in enumerate(lines[2:], start=4):
                self.evaluations.append(self._parsed(line, number - 4))
        except ValueError:
            where = f"{self.path}, line {number}: damaged or changed: remove it and all lines after it, or begin again"
            raise InputError(f"{where} with {option('fresh', True)}", file=self.path) from None
        return data.rfind(b"\n") + 1

    def _parsed(self, line: str, number: int) -> Evaluation:
        first, generation, *texts, failed = line.split(",")
        numbers, ends = [*map(float, texts)], np.cumsum([*map(len, self.parts)])
        values, losses, measured = (tuple(numbers[i:j]) for i, j in zip([0, *ends], ends, strict=False))
        if int(first) != number or len(numbers) != ends[-1] or not all(0.0 <= loss <= 1.0 for loss in losses):
            raise ValueError
        return Evaluation(int(generation), values, losses, measured, int(failed))


def is_log(path: Path) -> bool:
    """Whether a file is the log of a search."""
    with contextlib.suppress(OSError), path.open("rb") as file:
        return file.read(len(FORMAT)) == FORMAT.encode()
    return False


def candidates_in(path: str | Path) -> xr.Dataset:
    """The candidates of a log as a dataset: a setting and one trial each, with parameters as coordinates.

    Its variables are the measure, with the best number so far after each generation (`best_` and its name), and what
    else the log has. An incomplete last line is left out. Raises InputError.
    """
    import pandas as pd

    path = Path(path)
    try:
        text = path.read_bytes().rpartition(b"\n")[0].decode()
        about = json.loads(text.partition("\n")[0].removeprefix(FORMAT))
        table = pd.read_csv(io.StringIO(text + "\n"), comment="#", float_precision="round_trip")
        ranges = {part.partition("=")[0]: part.endswith(":log") for part in about["parameters"].split()}
        names = ["generation", *ranges]
        others = [name for name in table if name not in (FIRST[0], *names)]
        measure = others[len(others) // 2]
        best = table[measure].cummin() if about["better"] == "low" else table[measure].cummax()
        table[f"{BEST}{measure}"] = best.groupby(table["generation"]).transform("last")
        if table.empty:
            raise ValueError
    except (OSError, ValueError, KeyError, IndexError, TypeError, AttributeError) as error:
        raise InputError(f"{path} has no evaluation yet, or is damaged", file=path) from error
    searched, count = about.get("adversary", about["brain"]), len(table)
    ones = {"brain": np.full(count, searched, object), "robots": np.ones(count, np.int64)}  # a number each
    along = {name: table[name].to_numpy() for name in names} | ones
    coordinates = {n: ("setting", values, {"log": ranges[n]} if n in ranges else {}) for n, values in along.items()}
    columns = {name: (PER_TRIAL, table[[name]].to_numpy(np.float64)) for name in [*others, f"{BEST}{measure}"]}
    attributes = {"title": f"search of {searched}", "seed": about["seed"],
                  "swarmcensus_version": about["version"], SEARCHED: measure,
                  "trials_done": count, "trials_total": count}  # fmt: skip
    return xr.Dataset(columns, {"setting": table[FIRST[0]].to_numpy(), "trial": [0], **coordinates}, attributes)


class Candidates(Answer):
    """The candidates of a search, a row each, and which was the best so far."""

    def __init__(self, data: xr.Dataset, path: Path, sort: str | None = None, reverse: bool = False) -> None:
        """Take the dataset of a log. Raises InputError for a column that it has not."""
        places = [str(name) for name in data.coords if name not in ("trial", "brain", "robots")]
        measure, table = data.attrs[SEARCHED], data.isel(trial=0).to_dataframe().reset_index()
        table = table[[*places, *map(str, data.data_vars)]].rename(columns={"setting": FIRST[0]})
        if sort is not None and sort not in table:
            raise wrong_option("sort", sort, f"{did_you_mean(sort, table)}there are {', '.join(table)}")
        best = table.loc[table["loss"].idxmin()]
        values = ", ".join(f"{name} = {best[name]:.6g}" for name in places[2:])
        super().__init__(
            title=f"{path}: {data.attrs['title']} by {measure} (seed {data.attrs['seed']}), "
            f"{counted(len(table), 'evaluation')} in {counted(int(table['generation'].max()), 'generation')}",
            sentences=[
                f"the least loss so far, {best['loss']:.4g}, has evaluation {best[FIRST[0]]:g}: {values}; "
                f"{measure} {best[measure]:.4g}"
            ],
            rows=(table.sort_values(sort, ascending=not reverse, kind="stable") if sort else table).to_dict("records"),
        )
