"""Numbers for figures by the values of a coordinate: dots and medians of a scatter plot, shares of right robots."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from swarmcensus.figures.coordinates import texts_of
from swarmcensus.results import finished_trials
from swarmcensus.summaries import cells, require
from swarmcensus.support.formatting import counted
from swarmcensus.worlds import MOVING

Cloud = dict[str, tuple[NDArray[np.float64], NDArray[np.float64]]]  # value of the colour -> convergence, error
Dot = tuple[float, float]  # median convergence, median error
Cross = tuple[float, float, float, float]  # intervals of a median: low and high convergence, low and high error


class Share(NamedTuple):
    """The share of right robots at each checkpoint, whether all are right, and the ends of the interval."""

    right: NDArray[np.float64]
    all_right: NDArray[np.bool_]
    low: NDArray[np.float64]
    high: NDArray[np.float64]


Shares = dict[str, Share]  # value of the colour -> share


def lacking(parts: Sequence[xr.Dataset]) -> str:
    """The number of finished trials as text, such as "3 of 10 trials"; empty if the run is complete."""
    attributes = parts[0].attrs
    if not attributes.get("trials_done", 0) < attributes.get("trials_total", 0):
        return ""
    done = sum(int(finished_trials(part).sum()) for part in parts)
    total = sum(part.sizes["setting"] * part.sizes["trial"] for part in parts)
    if "half_width" in parts[0]:  # a rule stops the run, so the total is not known
        return f"{counted(done, 'trial')} so far"
    return f"{done:,} of {counted(total, 'trial')}" if done < total else ""


def _truth_name(trace: xr.Dataset) -> str:
    """The attribute of a trace that is its truth (see `truth` in docs/study-file.md)."""
    on_floor = trace.attrs.get("truth") == "floor" and "true_fill_ratio" in trace.attrs
    return "true_fill_ratio" if on_floor else "fill_ratio"


def truth_of(trace: xr.Dataset) -> float:
    """Return the true fill ratio of a trace."""
    return float(trace.attrs[_truth_name(trace)])


def truths_of(trace: xr.Dataset) -> NDArray[np.float64] | None:
    """True fill ratio per round, (round,); None if it is constant."""
    by_round = {str(name).rstrip("_"): each for name, each in trace.data_vars.items() if each.dims == ("round",)}
    found = by_round.get(_truth_name(trace))
    return None if found is None else np.asarray(found.values)


def unit_of(results: xr.Dataset, local: bool = False) -> str:
    """The unit of convergence and checkpoints: ticks if robots move, else communication rounds.

    For local estimates it is observations. Raises InputError if `results` has no topology.
    """
    if local:
        return "observations"
    require(results, "topology")
    moving = results["topology"].values == MOVING
    return "ticks" if moving.all() else "rounds or ticks" if moving.any() else "communication rounds"


def cloud_of(results: xr.Dataset, local: bool, color: str = "accuracy") -> Cloud:
    """Return convergence and error of every robot in every finished trial, by the values of `color`.

    Raises InputError if a variable is missing.
    """
    when, error = (results[name].transpose("setting", "trial", "robot").values for name in _names(results, local))
    done = (when >= 0) & np.isfinite(error)
    return {
        value: (when[settings][done[settings]].astype(float), error[settings][done[settings]])
        for value, settings in groups_of(results, color).items()
        if done[settings].any()
    }


def crosses_of(results: xr.Dataset, local: bool, color: str = "accuracy") -> dict[str, tuple[Dot, Cross | None]]:
    """Return the medians of a cloud, and their 95 % intervals over trials, by the values of `color`.

    A median has no interval if it has fewer than 6 trials, or settings with different trials. There is no median of
    robots that never learnt: half of them have K = 0.

    Raises InputError if a variable is missing.
    """
    groups = groups_of(results, color)
    when, error = (cells(results, name, [*groups.values()]) for name in _names(results, local))
    crosses: dict[str, tuple[Dot, Cross | None]] = {}
    for value, x, left, right, y, low, high in zip(groups, *(part.tolist() for part in (*when, *error)), strict=True):
        if x > 0 and np.isfinite([x, y]).all():
            crosses[value] = (x, y), (left, right, low, high) if np.isfinite([left, right, low, high]).all() else None
    return crosses


def _names(results: xr.Dataset, local: bool) -> tuple[str, str]:
    """The variables of a cloud. Raises InputError if one is missing."""
    names = "convergence_round", "convergence_error"
    if local:
        names = "local_convergence_step", "local_convergence_error"
    require(results, *names, "rounds", "observations_per_round")
    return names


def shares_of(results: xr.Dataset, color: str = "accuracy") -> Shares:
    """Return the share of right robots at each checkpoint (NaN: not run), whether all are right, and its interval.

    The 95 % interval is over trials. It is NaN for fewer than 6 trials, and for settings that have different trials.
    Raises InputError if a variable is missing.
    """
    require(results, "correct", "checkpoint", "robots")
    groups, checkpoints = groups_of(results, color), results["checkpoint"].values.tolist()
    found = [cells(results, "correct", [*groups.values()], checkpoint=checkpoint) for checkpoint in checkpoints]
    value, low, high = (np.stack(part, axis=1) for part in zip(*found, strict=True))
    return {
        text: Share(value[k], value[k] == 1.0, low[k], high[k])
        for k, text in enumerate(groups)
        if np.isfinite(value[k]).any()
    }


def groups_of(results: xr.Dataset, color: str) -> dict[str, NDArray[np.intp]]:
    """The places of the settings with each value of a coordinate, by its text."""
    texts = texts_of(results, color)
    return {text: np.flatnonzero(texts == text) for text in dict.fromkeys(texts.tolist())}
