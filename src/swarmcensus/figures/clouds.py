"""Numbers for figures by the values of a coordinate: dots and medians of a scatter plot, shares of right robots."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any, NamedTuple

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from swarmcensus.figures.coordinates import texts_of
from swarmcensus.results import finished, require, robots_in
from swarmcensus.support.formatting import counted
from swarmcensus.support.intervals import estimate_pooled
from swarmcensus.worlds import MOVING

Cloud = dict[str, tuple[NDArray[np.float64], NDArray[np.float64]]]  # value of the colour -> convergence, error
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
    done, total = sum(int(finished(part).sum()) for part in parts), 0
    for part in parts:
        total += part.sizes["setting"] * part.sizes["trial"]
    if "half_width" in parts[0]:  # a rule stops the run, so the total is not known
        return f"{counted(done, 'trial')} so far"
    return f"{done:,} of {counted(total, 'trial')}" if done < total else ""


def truth_of(trace: xr.Dataset) -> float:
    """Return the true fill ratio of a trace (see `truth` in docs/study-file.md)."""
    on_floor = trace.attrs.get("truth") == "floor" and "true_fill_ratio" in trace.attrs
    return float(trace.attrs["true_fill_ratio" if on_floor else "fill_ratio"])


def truths_of(trace: xr.Dataset) -> NDArray[np.float64] | None:
    """True fill ratio per round, (round,); None if it is constant."""
    on_floor = trace.attrs.get("truth") == "floor" and "true_fill_ratio" in trace.attrs
    wanted = "true_fill_ratio" if on_floor else "fill_ratio"
    for name, variable in trace.data_vars.items():
        if variable.dims == ("round",) and str(name).rstrip("_") == wanted:
            return np.asarray(variable.values)
    return None


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
    when, error, done = _converged(results, local)
    return {
        value: (when[settings][done[settings]].astype(float), error[settings][done[settings]])
        for value, settings in _values(results, color)
        if done[settings].any()
    }


def crosses_of(results: xr.Dataset, local: bool, color: str = "accuracy") -> dict[str, Cross]:
    """Return the 95 % intervals over trials of the medians of a cloud, by the values of `color`.

    A value has no interval if it has fewer than 6 trials, or settings with different trials.

    Raises InputError if a variable is missing.
    """
    when, error, done = _converged(results, local)
    crosses = {}
    for value, settings in _values(results, color):
        medians = [
            estimate_pooled(np.where(done[settings], values[settings], np.nan), "median") for values in (when, error)
        ]
        ends = [end for median in medians for end in (median.low, median.high)]
        if np.isfinite(ends).all():
            crosses[value] = (ends[0], ends[1], ends[2], ends[3])
    return crosses


def _converged(results: xr.Dataset, local: bool) -> tuple[NDArray[Any], NDArray[Any], NDArray[np.bool_]]:
    """Convergence, error, and whether both exist, each (setting, trial, robot)."""
    names = ("convergence_round", "convergence_error")
    if local:
        names = ("local_convergence_step", "local_convergence_error")
    require(results, *names, "rounds", "observations_per_round")
    when, error = (results[name].transpose("setting", "trial", "robot").values for name in names)
    return when, error, (when >= 0) & np.isfinite(error)


def shares_of(results: xr.Dataset, color: str = "accuracy") -> Shares:
    """Return the share of right robots at each checkpoint (NaN: not run), whether all are right, and its interval.

    The 95 % interval is over trials. It is NaN for fewer than 6 trials, for settings that have different trials, and
    for swarms of several sizes. Raises InputError if a variable is missing.
    """
    require(results, "correct", "checkpoint", "robots")
    correct = results["correct"].transpose("setting", "trial", "checkpoint").values
    known = np.isfinite(correct)
    robots = known * robots_in(results).values[:, None, None]
    right = np.nan_to_num(correct) * robots
    shares = {}
    for value, settings in _values(results, color):
        measured = robots[settings].sum((0, 1))
        if measured.any():
            share = np.full(measured.shape, np.nan)
            np.divide(right[settings].sum((0, 1)), measured, out=share, where=measured > 0)
            all_right = ((correct[settings] == 1) | ~known[settings]).all((0, 1)) & (measured > 0)
            low, high = np.full((2, share.size), np.nan)
            if np.unique(robots_in(results).values[settings]).size == 1:
                for k in np.flatnonzero(measured):
                    _, low[k], high[k] = estimate_pooled(correct[settings, :, k, np.newaxis], "mean", share=True)
            shares[value] = Share(share, all_right, low, high)
    return shares


def _values(results: xr.Dataset, color: str) -> Iterator[tuple[str, NDArray[np.bool_]]]:
    """Every distinct value of a coordinate as text, with a mask of the settings that have it."""
    texts = texts_of(results, color)
    for text in dict.fromkeys(texts.tolist()):
        yield text, texts == text
