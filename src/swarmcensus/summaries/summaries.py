"""Summaries of results: one row per setting, with medians over robots and trials and their intervals."""

import warnings
from collections import Counter
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from swarmcensus.results import INTERVALS, as_dataset, metrics_in
from swarmcensus.studies import NUMERIC, OF_FIGURES, goes_unsaid, idle_caption
from swarmcensus.summaries import measures, selecting
from swarmcensus.summaries.cautions import cautions_of, failed_trials
from swarmcensus.summaries.estimates import cells
from swarmcensus.support.formatting import grouped
from swarmcensus.support.hints import did_you_mean
from swarmcensus.support.options import wrong_option
from swarmcensus.support.quantities import QUANTITIES

if TYPE_CHECKING:
    import pandas as pd

MEANS = tuple(
    name
    for name, quantity in QUANTITIES.items()
    if quantity.summary and quantity.statistic == "mean" and name not in ("correct", "reached")
)
MEDIANS = tuple(name for name, quantity in QUANTITIES.items() if quantity.summary and quantity.statistic == "median")

EMPTY_CELL = "-"  # shown where a coordinate has no value

Columns = dict[str, NDArray[Any]]


def summary(
    results: xr.Dataset | str | Path, where: str | None = None, checkpoint: int | None = None
) -> "pd.DataFrame":
    """Summarise results as a pandas table with one row per setting, with 95 % intervals over trials.

    Columns are the setting's coordinates, `trials` (done) and `failed`, and for each measured quantity its value and
    its interval, with the suffixes `_low` and `_high` (NaN for fewer than 6 trials). Times and errors are medians over
    robots and trials: `convergence_round`, `convergence_error`, `final_error`, those of the local estimate, decisions,
    consensus and `done` where they exist, and metric files. `agreement_round`, `error_90`, `worst_error` and
    `final_disagreement` are medians over trials. `correct` is the mean over trials after round `checkpoint` (default:
    the last one that the setting reaches); so are `coverage` (a mean) and `interval_width` (a median) if brains have
    intervals. `done` is the share of robots that were done. `where` selects settings, as in `swarmcensus show`. The
    coordinates that vary come first, and values, each before its interval, last: pandas shows the first and last
    columns of a wide table. Warns as `run` does. Raises InputError.
    """
    data = selecting.where(as_dataset(results), where)
    for caution in cautions_of(data):
        warnings.warn(caution, stacklevel=2)
    return table_of(data, checkpoint)


def table_of(data: xr.Dataset, checkpoint: int | None = None) -> "pd.DataFrame":
    """The table of `summary`, without warnings."""
    import pandas as pd

    columns = _columns(data, checkpoint)
    along = [str(k) for k, c in data.coords.items() if c.dims == ("setting",) and k not in NUMERIC]
    varied = [name for name in along if len(set(data[name].values.astype(str).tolist())) > 1]
    first = dict.fromkeys(["setting", *varied])
    values = [name for name in (*_medians_in(data), "correct", *INTERVALS) if name in columns]
    last = [f"{value}{end}" for value in values for end in ("", "_low", "_high")]
    between = [name for name in columns if name not in first and name not in last]
    return pd.DataFrame({name: columns[name] for name in (*first, *between, *last)})


def _medians_in(data: xr.Dataset) -> list[str]:
    """The names of quantities and metric files of which a summary has the median."""
    return [name for name in (*MEDIANS, *metrics_in(data)) if not measures.missing_inputs(data, name)]


def _columns(data: xr.Dataset, checkpoint: int | None) -> Columns:
    """The columns of a summary. Raises InputError."""
    columns = _before_values(data)
    for name in _medians_in(data):
        columns |= _with_interval(data, name, None)
    place = measures.reached(data, checkpoint)
    columns["checkpoint"] = np.where(place < 0, -1, data["checkpoint"].values[place])  # -1 if a setting ends before
    wanted = ["reached"] * (not measures.missing_inputs(data, "reached"))
    for name in ("correct", *wanted, *(name for name in INTERVALS if name in data)):
        columns |= _with_interval(data, name, checkpoint)
    for name in MEANS:
        if not measures.missing_inputs(data, name):
            columns[name] = cells(data, name, intervals=False).value
    if "half_width" in data:
        columns["half_width"] = data["half_width"].values
    return columns


def _before_values(data: xr.Dataset) -> Columns:
    """The columns of coordinates and of numbers of trials."""
    columns: Columns = {"setting": data["setting"].values}
    columns |= {str(k): c.values for k, c in data.coords.items() if c.dims == ("setting",) and k != "setting"}
    failed = Counter(one["setting"] for one in failed_trials(data))
    columns["trials"] = done_trials(data).sum(axis=1)
    columns["failed"] = np.array([failed[setting] for setting in columns["setting"].tolist()])
    return columns


def _with_interval(data: xr.Dataset, name: str, checkpoint: int | None) -> Columns:
    return dict(zip((name, f"{name}_low", f"{name}_high"), cells(data, name, checkpoint=checkpoint), strict=True))


def sort_settings(
    data: xr.Dataset, column: str, reverse: bool = False, checkpoint: int | None = None
) -> tuple[xr.Dataset, str]:
    """Sort settings by a column of a summary or by a quantity, missing values last; returns its name too.

    Raises InputError.
    """
    coordinates = _before_values(data)
    sortable = [name for name, one in QUANTITIES.items() if one.bounds[0] == 0.0 and one.kind is not object]
    quantities = [name for name in (*sortable, *metrics_in(data)) if not measures.missing_inputs(data, name)]
    name = measures.name_of(data, column, (*coordinates, *quantities))
    if name in coordinates:
        values = coordinates[name]
    elif name in quantities:
        at = checkpoint if measures.at_checkpoints(data, name) else None
        values = cells(data, name, checkpoint=at, intervals=False).value
    else:
        known = [*(measures.head_of(data, one) for one in quantities), *coordinates]
        raise wrong_option("sort", column, f"{did_you_mean(column, known)}known are {', '.join(known)}")
    if values.dtype.kind in "OU":  # accuracies are text: those that are numbers come first, in order
        texts, place = np.unique(values.astype(str), return_inverse=True)
        values = np.argsort(np.lexsort((texts, selecting.numbers(texts))))[place]
    return data.isel(setting=np.argsort(-values if reverse else values, kind="stable")), name


def records(data: xr.Dataset, checkpoint: int | None = None) -> list[dict[str, Any]]:
    """The summary of these settings as a flat record for each, with names always in this order. Raises InputError.

    They are the columns of `summary`.
    """
    import pandas as pd

    rows: list[dict[str, Any]] = pd.DataFrame(_columns(data, checkpoint)).to_dict("records")
    return rows


def done_trials(data: xr.Dataset) -> NDArray[np.bool_]:
    """A mask of the trials that have run, (setting, trial)."""
    return np.asarray(data["convergence_round"].values[:, :, 0] >= 0)


def is_idle(value: object) -> bool:
    """Whether a coordinate has no value, as density and floor on a fixed network."""
    return str(value) in ("", "nan")


def value_text(name: str, value: object) -> str:
    """A value of a coordinate in tables; where it has none, a word for that, as "plain" for a swarm without members."""
    if is_idle(value):
        return idle_caption(name) or EMPTY_CELL
    is_parameter = isinstance(value, float) and name not in OF_FIGURES  # which may be a whole number
    return f"{value:g}" if is_parameter else grouped(value)


def world_text(world: Mapping[str, Any]) -> str:
    """Coordinates in a line, without those that have no value, and no word for that, or that go unsaid."""
    texts = [
        idle_caption(name) if is_idle(value) else f"{name} {value_text(name, value)}"
        for name, value in world.items() if not goes_unsaid(name, value)
    ]  # fmt: skip
    return ", ".join(filter(None, texts))


def repeated_coordinates(results: xr.Dataset) -> set[str]:
    """Coordinates that repeat others: one of density and side, and `liars` and `adversary` if there are `members`."""
    return {derived_size(results)} | ({"liars", "adversary"} if "members" in results.coords else set())


def derived_size(results: xr.Dataset) -> str:
    """Which of density and side follows from the other; the study gave the one with fewer or rounder values."""
    if not {"density", "side"} <= results.coords.keys():
        return ""
    texts = {name: {f"{value:.12g}" for value in results[name].values.tolist()} for name in ("side", "density")}
    return max(texts, key=lambda name: (len(texts[name]), len("".join(texts[name]))))
