"""Numbers for figures, by the values of a coordinate: robots and medians of a scatter, shares of right robots."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any, NamedTuple

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from swarmcensus.basics.formatting import counted
from swarmcensus.figures.coordinates import texts_of
from swarmcensus.results.selecting import require
from swarmcensus.results.structure import finished
from swarmcensus.results.values import robots_in
from swarmcensus.statistics.intervals import estimate_pooled
from swarmcensus.worlds.networks import MOVING

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
    """How many trials these results hold, if the run is not complete; else an empty text."""
    attributes = parts[0].attrs
    if not attributes.get("trials_done", 0) < attributes.get("trials_total", 0):
        return ""
    done, total = sum(int(finished(part).sum()) for part in parts), 0
    for part in parts:
        total += part.sizes["setting"] * part.sizes["trial"]
    if "half_width" in parts[0]:  # a rule decides how many trials there will be
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
    of_rounds = (one for one in trace.data_vars.values() if one.dims == ("round",))
    return next((np.asarray(one.values) for one in of_rounds if str(one.name).rstrip("_") == wanted), None)


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
        value: (when[mine][done[mine]].astype(float), error[mine][done[mine]])
        for value, mine in _values(results, color)
        if done[mine].any()
    }


def crosses_of(results: xr.Dataset, local: bool, color: str = "accuracy") -> dict[str, Cross]:
    """Return the 95 % intervals over trials of the medians of a cloud, by the values of `color`.

    There is none for fewer than 6 trials, and for settings that have different trials.

    Raises InputError if a variable is missing.
    """
    when, error, done = _converged(results, local)
    crosses = {}
    for value, mine in _values(results, color):
        each = [estimate_pooled(np.where(done[mine], values[mine], np.nan), "median") for values in (when, error)]
        ends = [end for one in each for end in (one.low, one.high)]
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
    for value, mine in _values(results, color):
        asked = robots[mine].sum((0, 1))
        if asked.any():
            share = np.full(asked.shape, np.nan)
            np.divide(right[mine].sum((0, 1)), asked, out=share, where=asked > 0)
            all_right = ((correct[mine] == 1) | ~known[mine]).all((0, 1)) & (asked > 0)
            low, high = np.full((2, share.size), np.nan)
            if np.unique(robots_in(results).values[mine]).size == 1:
                for k in np.flatnonzero(asked):
                    _, low[k], high[k] = estimate_pooled(correct[mine, :, k, np.newaxis], "mean", share=True)
            shares[value] = Share(share, all_right, low, high)
    return shares


def _values(results: xr.Dataset, color: str) -> Iterator[tuple[str, NDArray[np.bool_]]]:
    """Every distinct value of a coordinate as text, and a mask of the settings that have it."""
    texts = texts_of(results, color)
    for text in dict.fromkeys(texts.tolist()):
        yield text, texts == text
