"""Summaries of results: one row per setting, with medians over robots and trials and their intervals."""

from collections import Counter
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from swarmcensus.results import measures, selecting
from swarmcensus.results.cautions import warn_of
from swarmcensus.results.store import loaded
from swarmcensus.results.structure import failed_in
from swarmcensus.results.values import INTERVALS, bounds_in, is_missing, metrics_in, robots_in
from swarmcensus.studies import NUMERIC
from swarmcensus.support.bootstrap import centres
from swarmcensus.support.documents import json_value
from swarmcensus.support.errors import InputError
from swarmcensus.support.hints import did_you_mean
from swarmcensus.support.intervals import LEVEL, estimate
from swarmcensus.support.options import wrong_option
from swarmcensus.support.quantities import QUANTITIES

if TYPE_CHECKING:
    import pandas as pd

SHORT = {  # names of columns on a terminal
    quantity.column: name for name, quantity in QUANTITIES.items() if quantity.column and quantity.group != "intervals"
}
MEANS = tuple(name for name, quantity in QUANTITIES.items() if quantity.summary and quantity.statistic == "mean")
MEDIANS = tuple(name for name, quantity in QUANTITIES.items() if quantity.summary and quantity.statistic == "median")
BLOCK = 2**22  # values that are sorted at once

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
    data = selecting.where(loaded(results), where)
    warn_of(data)
    return table_of(data, checkpoint)


def table_of(data: xr.Dataset, checkpoint: int | None = None) -> "pd.DataFrame":
    """The table of `summary`, without warnings."""
    import pandas as pd

    data = _ready(data)
    columns = _with_intervals(data, checkpoint)
    along = [str(k) for k, c in data.coords.items() if c.dims == ("setting",) and k not in NUMERIC]
    varied = [name for name in along if len(set(data[name].values.astype(str).tolist())) > 1]
    first = dict.fromkeys(["setting", *varied])
    values = [name for name in (*medians_in(data), "correct", *INTERVALS) if name in columns]
    last = [f"{value}{end}" for value in values for end in ("", "_low", "_high")]
    between = [name for name in columns if name not in first and name not in last]
    return pd.DataFrame({name: columns[name] for name in (*first, *between, *last)})


def medians_in(data: xr.Dataset) -> list[str]:
    """The names of quantities and metric files of which a summary has the median."""
    return [name for name in (*MEDIANS, *metrics_in(data)) if name in data]


def _ready(data: xr.Dataset) -> xr.Dataset:
    """Results with the derived quantities of a summary as variables."""
    for name in MEDIANS:
        data = measures.with_measure(data, name)
    return data


def _with_intervals(data: xr.Dataset, checkpoint: int | None) -> Columns:
    columns: Columns = {}
    looked = {*medians_in(data), "correct", *INTERVALS}
    for name, values in points(data, checkpoint).items():
        columns[name] = values
        if name in looked:
            ends = _intervals(data, name, checkpoint)
            columns |= {f"{name}_low": ends[:, 0], f"{name}_high": ends[:, 1]}
    return columns


def points(data: xr.Dataset, checkpoint: int | None = None) -> Columns:
    """The columns of a summary without intervals, which take most of the time. Raises InputError."""
    data, ran = _ready(data), done(data)
    columns: Columns = {"setting": data["setting"].values}
    columns |= {str(k): c.values for k, c in data.coords.items() if c.dims == ("setting",) and k != "setting"}
    failed = Counter(one["setting"] for one in failed_trials(data))
    columns["trials"] = ran.sum(axis=1)
    columns["failed"] = np.array([failed[setting] for setting in columns["setting"].tolist()])
    for name in medians_in(data):
        columns[name] = _medians(data, name, ran)
    place = _reached(data, checkpoint)
    columns["checkpoint"] = np.where(place < 0, -1, data["checkpoint"].values[place])
    correct = np.where(ran, data["correct"].values[np.arange(len(ran)), place], 0.0)
    columns["correct"] = np.where(columns["trials"] > 0, correct.sum(axis=1) / np.maximum(columns["trials"], 1), np.nan)
    for name in (name for name in INTERVALS if name in data):
        seen = [values[~np.isnan(values)] for values in _looked_at(data, name, ran, place)]
        centre = np.mean if measures.is_share(name) else np.median
        columns[name] = np.array([centre(values) if values.size else np.nan for values in seen])
    for name in MEANS:
        if not measures.lacks(data, name):
            columns[name] = _means(data, name, ran)
    if "half_width" in data:
        columns["half_width"] = data["half_width"].values
    return columns


def cells(data: xr.Dataset, name: str) -> tuple[NDArray[np.float64], ...]:
    """The value of a measure as summaries and figures have it, and the ends of its interval, each (setting,).

    Medians are over all robots of all trials. Means, and the round of a right consensus, are of one number a trial.
    """
    data, statistic = measures.with_measure(data, name), measures.statistic_of(name)
    if "checkpoint" in data[name].dims:
        return centres(measures.numbers(data, name), statistic), *_intervals(data, name, None).T
    if statistic == "median" and name != "consensus_round":  # a summary also has those on wrong options
        return _medians(data, name, done(data)), *_intervals(data, name, None).T
    numbers = measures.numbers(data, name)
    ends = np.full((len(numbers), 2), np.nan)
    for row, trials in enumerate(numbers):
        _, *ends[row] = estimate(trials[~np.isnan(trials), np.newaxis], statistic, share=measures.is_share(name))
    return centres(numbers, statistic), *_within_bounds(data, name, ends).T


def ordered(data: xr.Dataset, column: str, reverse: bool = False, checkpoint: int | None = None) -> xr.Dataset:
    """Sort settings by a column of `points`, missing values last. Raises InputError."""
    found = points(data, checkpoint)
    if column not in found and column not in SHORT:
        known = [*SHORT, *(k for k in found if k not in SHORT.values())]
        raise wrong_option("sort", column, f"{did_you_mean(column, known)}known are {', '.join(known)}")
    values = found[SHORT.get(column, column)]
    if values.dtype.kind in "OU":  # accuracies are text: those that are numbers come first, in order
        texts, place = np.unique(values.astype(str), return_inverse=True)
        values = np.argsort(np.lexsort((texts, selecting.numbers(texts))))[place]
    return data.isel(setting=np.argsort(-values if reverse else values, kind="stable"))


def asked_anew(data: xr.Dataset) -> list[str]:
    """Which of "bins" and "delta" were changed by `remeasure`."""
    return [key for key in str(data.attrs.get("asked_anew", "")).split(", ") if key]


def failed_trials(data: xr.Dataset) -> list[dict[str, Any]]:
    """The failed trials of these settings, each with `setting`, `trial` and `why`."""
    there = set(data["setting"].values.tolist())
    return [one for one in failed_in(data) if one["setting"] in there]


def records(data: xr.Dataset, checkpoint: int | None = None) -> list[dict[str, Any]]:
    """The summary of these settings as a flat record for each, with names always in this order. Raises InputError.

    They are the columns of `summary`.
    """
    import pandas as pd

    rows: list[dict[str, Any]] = pd.DataFrame(_with_intervals(_ready(data), checkpoint)).to_dict("records")
    return rows


def as_dict(stored: xr.Dataset, data: xr.Dataset, checkpoint: int | None = None) -> dict[str, Any]:
    """The summary of these settings for JSON (see docs/data-format.md). Raises InputError."""
    rule = data["half_width"].attrs.get("rule") if "half_width" in data else None
    return {
        "title": str(data.attrs["title"]),
        **{key: json_value(data.attrs[key]) for key in ("seed", "delta", "bins", "truth", "swarmcensus_version")},
        "asked_anew": asked_anew(stored),
        "rule": rule,
        "level": LEVEL,
        "settings_total": stored.sizes["setting"],
        "trials_done": int(done(stored).sum()),
        "trials_total": int(stored.attrs["trials_total"]),
        "trials_failed": len(failed_trials(stored)),
        "failed": failed_trials(data),
        "settings": [_nested(row) for row in records(data, checkpoint)],
    }


def _nested(row: dict[str, Any]) -> dict[str, Any]:
    out: dict[str, Any] = {}
    for name, value in row.items():
        if f"{name}_low" in row:
            ends = [json_value(row[f"{name}_low"]), json_value(row[f"{name}_high"])]
            what = "mean" if measures.is_share(name) else "median"
            out[name] = {what: json_value(value), "interval": None if None in ends else ends}
        elif name == "checkpoint":
            out[name] = None if value < 0 else value
        elif name.removesuffix("_low").removesuffix("_high") not in out:
            out[name] = json_value(value)
    return out


def done(data: xr.Dataset) -> NDArray[np.bool_]:
    """A mask of the trials that have run, (setting, trial)."""
    return np.asarray(data["convergence_round"].values[:, :, 0] >= 0)


def _reached(data: xr.Dataset, checkpoint: int | None) -> NDArray[np.intp]:
    """The index of the checkpoint for each setting, by default the last one that it reaches; -1 if it ends before.

    At index -1, the last checkpoint, such a setting has no values either.
    """
    known, rounds = data["checkpoint"].values, data["rounds"].values
    if checkpoint is None:
        return np.searchsorted(known, rounds, side="right") - 1
    if checkpoint not in known:
        after = ", ".join(map(str, known))
        raise InputError.named("checkpoint", checkpoint, f"decisions were recorded after round {after}")
    return np.where(rounds >= checkpoint, np.searchsorted(known, checkpoint), -1)


def _looked_at(
    data: xr.Dataset, name: str, ran: NDArray[np.bool_], place: NDArray[np.intp]
) -> Iterator[NDArray[np.float64]]:
    """Yield the values of a variable at the checkpoints `place` for the finished trials of each setting."""
    return (data[name].values[k, place[k], trials] for k, trials in enumerate(ran))


def _medians(data: xr.Dataset, name: str, ran: NDArray[np.bool_]) -> NDArray[np.float64]:
    """The median over finished trials and robots, (setting,); NaN without a trial."""
    array, robots = _by_robot(data, name), robots_in(data).values
    settings, trials, widest = array.shape
    out = np.full(settings, np.nan)
    step = max(1, BLOCK // (trials * widest))
    for first in range(0, settings, step):
        rows = slice(first, first + step)
        here = ran[rows, :, np.newaxis] & (np.arange(widest) < robots[rows, np.newaxis, np.newaxis])
        here &= ~is_missing(array[rows])  # not every merged study asks for every metric, or for local estimates
        values = np.sort(np.where(here, array[rows], np.inf).reshape(len(here), -1), axis=1)
        count = here.sum(axis=(1, 2))[:, np.newaxis]
        middle = np.take_along_axis(values, np.concatenate([(count - 1) // 2, count // 2], axis=1), axis=1)
        out[rows] = np.where(count[:, 0] > 0, middle.mean(axis=1), np.nan)
    return out


def _intervals(data: xr.Dataset, name: str, checkpoint: int | None) -> NDArray[np.float64]:
    """The ends of a column's intervals over trials, (setting, 2), within the bounds of the quantity."""
    ran = done(data)
    ends = np.full((len(ran), 2), np.nan)
    if "checkpoint" in data[name].dims:
        statistic = measures.statistic_of(name)
        for row, seen in enumerate(_looked_at(data, name, ran, _reached(data, checkpoint))):
            kept = seen[~np.isnan(seen)] if name in INTERVALS else seen
            _, *ends[row] = estimate(kept[:, np.newaxis], statistic, share=measures.is_share(name))
    else:
        array, robots = _by_robot(data, name), robots_in(data).values.tolist()
        for row, trials in enumerate(ran):
            kept = array[row, trials, : robots[row]]
            kept = np.where(is_missing(kept), np.nan, kept)
            _, *ends[row] = estimate(kept[~np.isnan(kept).all(axis=1)], "median")  # none if only some robots lack it
    return _within_bounds(data, name, ends)


def _within_bounds(data: xr.Dataset, name: str, ends: NDArray[np.float64]) -> NDArray[np.float64]:
    """The ends of intervals, (setting, 2), within the bounds of the quantity."""
    least, most = bounds_in(data, name)
    return np.asarray(np.clip(ends, least, np.reshape(most, (-1, 1))))


def _means(data: xr.Dataset, name: str, ran: NDArray[np.bool_]) -> NDArray[np.float64]:
    """The mean over finished trials of the mean over robots, (setting,); NaN without a trial."""
    values = measures.numbers(data, name)
    known = ran & ~np.isnan(values)
    total = np.where(known, values, 0.0).sum(axis=1)
    return np.where(known.any(axis=1), total / np.maximum(known.sum(axis=1), 1), np.nan)


def _by_robot(data: xr.Dataset, name: str) -> NDArray[Any]:
    """A variable as (setting, trial, robot), with one robot for a metric of the swarm."""
    array = data[name].values
    return array if array.ndim == 3 else array[:, :, np.newaxis]


def is_idle(value: object) -> bool:
    """Whether a coordinate has no value, as density and floor on a fixed network."""
    return str(value) in ("", "nan")


def restated(results: xr.Dataset) -> set[str]:
    """Coordinates that repeat others: one of density and side, and `liars` and `adversary` if there are `members`."""
    return {derived_size(results)} | ({"liars", "adversary"} if "members" in results.coords else set())


def derived_size(results: xr.Dataset) -> str:
    """Which of density and side follows from the other; the study gave the one with fewer or rounder values."""
    if not {"density", "side"} <= results.coords.keys():
        return ""
    texts = {name: {f"{value:.12g}" for value in results[name].values.tolist()} for name in ("side", "density")}
    return max(texts, key=lambda name: (len(texts[name]), len("".join(texts[name]))))
