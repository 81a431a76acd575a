"""The log of a search: a CSV file with a line for each evaluation, from which a search can resume.

A comment in its first line identifies the search. It is written whole after each generation, so it never ends in half a
line. `candidates_in` reads it, also of a search at work, as a dataset that `show` and `plot` take.
"""

import contextlib
import functools
import io
import json
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, Self

import numpy as np
import xarray as xr

from swarmcensus.search.tuning.plans import TuningPlan
from swarmcensus.support.answers import Answer
from swarmcensus.support.errors import InputError
from swarmcensus.support.files import atomic_write, remove_leftovers
from swarmcensus.support.formatting import counted
from swarmcensus.support.hints import did_you_mean
from swarmcensus.support.options import option, wrong_option
from swarmcensus.support.owners import Busy, Owner
from swarmcensus.support.quantities import BEST, PER_TRIAL, SEARCHED

if TYPE_CHECKING:
    import pandas as pd

FORMAT = "# swarmcensus tune 5 "
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

    @functools.cached_property  # as a log is written whole after each generation
    def text(self) -> str:
        """Its line in a log."""
        return ",".join(map(repr, [self.generation, *self.values, *self.losses, *self.numbers, self.failed]))


class Log:
    """The evaluations so far, on disk if there is a path; no other search can write the file in the `with` block."""

    def __init__(self, path: Path | None, plan: TuningPlan, fresh: bool = False) -> None:
        """Read the file, if it exists; if `fresh`, it is replaced. Raises InputError if it is of another search."""
        self.path, self.identity = path, plan.identity
        self.places = [parameter.label for parameter in plan.ranges]
        self.columns = [*FIRST, *self.places, *plan.losses, *(measure.name for measure in plan.measures), LAST]
        is_there = path is not None and path.exists() and not fresh
        self.evaluations = self._read(path) if path is not None and is_there else []
        self._lock = contextlib.ExitStack()

    def __enter__(self) -> Self:
        """Lock the file. Raises InputError if another search has it."""
        if self.path is not None:
            try:
                self._lock.enter_context(Owner(self.path.with_name(f".{self.path.name}.lock")))
            except Busy as owner:
                raise InputError.of(self.path, f"another search is writing it ({owner})") from None
            remove_leftovers(self.path)
        return self

    def __exit__(self, *_: object) -> None:
        """Free the file."""
        self._lock.close()

    def add(self, generation: Sequence[Evaluation]) -> None:
        """Add a generation, and write the file."""
        self.evaluations += generation
        if self.path is None:
            return
        lines = [FORMAT + json.dumps(self.identity), ",".join(self.columns)]
        lines += [f"{n},{one.text}" for n, one in enumerate(self.evaluations)]
        with atomic_write(self.path) as temporary:
            temporary.write_text("\n".join([*lines, ""]), encoding="utf-8")

    def _read(self, path: Path) -> list[Evaluation]:
        try:
            identity, table = _contents(path)
        except Damaged as error:
            raise InputError.of(path, f"{error}. {hint()}") from None
        differ = [
            f"{key} is {identity.get(key)!r} there and {value!r} here"
            for key, value in self.identity.items() if identity.get(key) != value
        ]  # fmt: skip
        if differ or [*table] != self.columns:
            raise InputError(f"{path} is of another search: {'; '.join(differ)}. {hint()}", file=path)
        values, n = len(self.places), (len(self.columns) - len(self.places) - 3) // 2
        return [
            Evaluation(int(row[1]), row[2 : values + 2], row[values + 2 : -1 - n], row[-1 - n : -1], int(row[-1]))
            for row in table.itertuples(index=False, name=None)
        ]


class Damaged(ValueError):
    """A file is no log, or was changed; the message says which."""


def _contents(path: Path) -> "tuple[dict[str, Any], pd.DataFrame]":
    """What identifies the search of a log, and its evaluations, all of them numbers. Raises Damaged."""
    import pandas as pd

    first, _, lines = path.read_bytes().decode(errors="replace").partition("\n")
    try:
        identity = dict(json.loads(first.removeprefix(FORMAT) if first.startswith(FORMAT) else ""))
    except (ValueError, TypeError, RecursionError):  # the path may hold any file, which must not be overwritten
        raise Damaged("is no log of a search") from None
    try:
        table = pd.read_csv(io.StringIO(lines), float_precision="round_trip").astype(np.float64)
        if table.empty or (table[FIRST[0]] != range(len(table))).any():
            raise ValueError
    except (ValueError, KeyError):
        raise Damaged("has no evaluation, or is damaged") from None
    return identity, table.astype(dict.fromkeys((*FIRST, LAST), np.int64))


def is_log(path: Path) -> bool:
    """Whether a file is the log of a search."""
    with contextlib.suppress(OSError), path.open("rb") as file:
        return file.read(len(FORMAT)) == FORMAT.encode()
    return False


def candidates_in(path: str | Path) -> xr.Dataset:
    """The candidates of a log as a dataset: a setting and one trial each, with parameters as coordinates.

    Its variables are the measure, with the best number so far after each generation (`best_` and its name), and what
    else the log has. Raises InputError.
    """
    path = Path(path)
    try:
        about, table = _contents(path)
        ranges = {part.partition("=")[0]: part.endswith(":log") for part in about["parameters"].split()}
        names = ["generation", *ranges]
        others = [name for name in table if name not in (FIRST[0], *names)]
        measure = others[len(others) // 2]
        best = table[measure].cummin() if about["better"] == "low" else table[measure].cummax()
        table[f"{BEST}{measure}"] = best.groupby(table["generation"]).transform("last")
    except (Damaged, KeyError, IndexError, TypeError, AttributeError) as error:
        raise InputError.of(path, str(error) if isinstance(error, Damaged) else "is damaged") from error
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
