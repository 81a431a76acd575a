"""What any variable of the dataset comes to: its median or mean over robots and trials, and an interval over trials."""

from __future__ import annotations

import math
from typing import Literal, NamedTuple

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from swarmcensus.basics.errors import InputError
from swarmcensus.basics.hints import did_you_mean
from swarmcensus.figures.clouds import by_trial
from swarmcensus.figures.coordinates import coordinates_of, texts_of
from swarmcensus.results.selecting import require
from swarmcensus.results.values import bounds_in, robots_in
from swarmcensus.statistics.intervals import interval_of

Statistic = Literal["median", "mean"]
SIDES = {"setting", "checkpoint", "trial", "robot"}


class Point(NamedTuple):
    """A value of the x coordinate as text, what the variable comes to there, and the ends of its 95 % interval.

    The value is infinite where that is what the statistic is, and NaN where nothing has been run; the ends are NaN
    where too few trials have been.
    """

    x: str
    value: float
    low: float
    high: float


def variables_of(results: xr.Dataset) -> list[str]:
    """The names of all that is measured in every trial, in numbers."""
    return [
        str(name)
        for name, one in results.data_vars.items()
        if {"setting", "trial"} <= {*one.dims} <= SIDES and one.dtype.kind in "biuf"
    ]


def measured(results: xr.Dataset, name: str, at_checkpoints: bool) -> xr.Dataset:
    """A variable alone, as float64 (setting, trial, robot), NaN where nothing was run, with the settings' coordinates.

    One that is recorded at checkpoints is taken at the last that its setting reaches, or `at_checkpoints` at each: a
    setting is then repeated, with another coordinate `checkpoint`. Raises InputError for a name that is not there.
    """
    require(results)
    known = variables_of(results)
    if name not in known:
        raise InputError(f"y {name!r}: {did_you_mean(name, known)}what is measured here is {', '.join(known)}")
    whole = results[name].dtype.kind == "i"
    found = results[name].astype(float)
    found = found.where(found >= 0) if whole else found
    if name == "correct":  # a share of robots: larger swarms weigh more
        exists = xr.DataArray(np.arange(results.sizes["robot"]), dims="robot") < robots_in(results)
        found = found.where(exists)
    elif "robot" not in found.dims:
        found = found.expand_dims("robot")
    settings = results[coordinates_of(results)].drop_vars("checkpoint", errors="ignore")
    if "checkpoint" in found.dims:
        rounds, recorded = results["rounds"].values, results["checkpoint"].values
        setting, place = np.nonzero(recorded <= rounds[:, np.newaxis])
        if not at_checkpoints:
            last = np.append(setting[1:] != setting[:-1], True)[: setting.size]
            setting, place = setting[last], place[last]
        at = {"setting": xr.DataArray(setting, dims="setting"), "checkpoint": xr.DataArray(place, dims="setting")}
        found = found.isel(at)
        settings = settings.isel(setting=setting)
        if at_checkpoints:
            settings = settings.assign_coords(checkpoint=("setting", recorded[place]))
    values = found.transpose("setting", "trial", "robot").values
    return xr.Dataset({name: (("setting", "trial", "robot"), values)}, settings.coords, results.attrs)


def points_of(part: xr.Dataset, name: str, x: str, statistic: Statistic, share: bool) -> list[Point]:
    """What a variable of `measured` comes to for every value of a coordinate; settings alike in it are pooled."""
    texts, points = texts_of(part, x), []
    for text in dict.fromkeys(texts.tolist()):
        mine = part.isel(setting=texts == text)
        value, low, high = _estimated(mine[name].values, statistic, share)
        if name == "convergence_round":  # none is after the last round, though a median's interval may reach on
            high = min(high, float(mine["rounds"].max()))
        least, most = bounds_in(part, name)
        low, high = max(low, least), min(high, most)
        points.append(Point(text, value, low, high))
    return points


def _estimated(values: NDArray[np.float64], statistic: Statistic, share: bool) -> tuple[float, float, float]:
    """The statistic of (setting, trial, robot), and its interval over trials: NaN where settings lack some of them."""
    kept = by_trial(values)
    if kept is None:
        known = values[~np.isnan(values)]
        if not known.size:
            return math.nan, math.nan, math.nan
        return float(np.median(known) if statistic == "median" else known.mean()), math.nan, math.nan
    endless = statistic == "mean" and not np.isfinite(kept).all()
    value, low, high = (math.inf, math.nan, math.nan) if endless else interval_of(kept, statistic, share)
    return value, low, high
