"""What a panel holds: a study's results split into panels, and the numbers that are drawn in one."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Sequence
from typing import Any, NamedTuple

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from swarmcensus.basics.digits import told_apart
from swarmcensus.basics.statistics import interval_of
from swarmcensus.results.checking import finished
from swarmcensus.results.selecting import TooMuch, require
from swarmcensus.results.summaries import told
from swarmcensus.worlds.networks import MOVING

Cloud = dict[str, tuple[NDArray[np.float64], NDArray[np.float64]]]  # accuracy -> convergence, error
MOST_PANELS = 24
Cross = tuple[float, float, float, float]  # of a median: lowest and highest convergence, lowest and highest error

CAPTIONS = {  # how a caption names the coordinates that vary, in this order
    "topology": "{}",
    "brain": "{}",
    "robots": "N = {:,.0f}",
    "density": "D = {}",
    "side": "L = {} m",
    "fill_ratio": "f = {}",
    "floor": "floor {}",
    "rounds": "C = {:,.0f}",
    "observations_per_round": "R = {:,.0f}",
    "link_success": "link success {}",
    "assumed_accuracy": "assumed accuracy {}",
}


class Share(NamedTuple):
    """The share of right robots at each checkpoint, whether it is all of them, and the ends of its interval."""

    right: NDArray[np.float64]
    all_right: NDArray[np.bool_]
    low: NDArray[np.float64]
    high: NDArray[np.float64]


Shares = dict[str, Share]  # by accuracy


class Panel(NamedTuple):
    """One panel of a grid: its caption, its results and, for a scatter, two options."""

    caption: str
    results: xr.Dataset
    local: bool = False
    error_limit: float | None = None


def panels_of(results: xr.Dataset, apart_from: Collection[str] = ("accuracy",)) -> list[Panel]:
    """Split a study's results into panels, one for each combination of the coordinates but those of `apart_from`.

    Panels come in the order of the settings. Captions name only what varies, as in "ring, N = 100, f = 0.55", and
    a floor that is not of independent tiles.

    Raises InputError if `results` has no settings.
    """
    require(results, "accuracy")
    varying = varies(results, apart_from=set(apart_from))
    if "floor" not in varying and "floor" in results.coords and set(results["floor"].values) - {"tiles", ""}:
        varying["floor"] = results["floor"].values.tolist()
    written = {name: _written(name, values) for name, values in varying.items()}
    combinations = list(zip(*varying.values(), strict=True)) or [()] * results.sizes["setting"]
    panels = []
    for combination in dict.fromkeys(combinations):
        named = zip(varying, combination, strict=True)
        caption = ", ".join(written[name][value] for name, value in named if value is not None)
        mine = [i for i, other in enumerate(combinations) if other == combination]
        panels.append(Panel(caption, results.isel(setting=mine)))
    return panels


def _written(name: str, values: list[Any]) -> dict[Any, str]:
    """Each value of a coordinate that varies, as a caption says it: in as many digits as tell them apart."""
    distinct = [value for value in dict.fromkeys(values) if value is not None]
    form = CAPTIONS.get(name, name + " = {}")
    numbers = name == "assumed_accuracy" or all(isinstance(value, float) for value in distinct)
    texts = told_apart(distinct, 6) if numbers and ":" not in form else distinct
    return {value: form.format(text) for value, text in zip(distinct, texts, strict=True)}


def varies(results: xr.Dataset, apart_from: set[str]) -> dict[str, list[Any]]:
    """Return every setting's value of each coordinate that has several; None is a value that says nothing."""
    names = [*CAPTIONS, *sorted(str(name) for name in results.coords if name not in CAPTIONS)]
    other = told(results)
    varying = {}
    for name in names:
        if name not in results.coords or results[name].dims != ("setting",) or name in ("setting", other):
            continue
        values = results[name].values.tolist()
        if name == "assumed_accuracy" and len(set(values)) > 1:
            # Robots that know their sensors assume the true accuracy: that tells no settings apart.
            pairs = zip(values, results["accuracy"].values.tolist(), strict=True)
            values = [None if assumed == true else assumed for assumed, true in pairs]
        # NaN and "", the density and floor of a fixed network
        values = [None if value != value or value == "" else value for value in values]
        if name not in apart_from and len(set(values)) > 1:
            varying[name] = values
    return varying


def select_some(results: xr.Dataset, apart_from: Collection[str], most: int) -> dict[str, Any]:
    """Values of coordinates, by name, that leave at most so many panels: those first that leave the fewest."""
    chosen = {}
    while len(panels_of(results, apart_from)) > most:
        varying = varies(results, set(apart_from))
        name = max(varying, key=lambda name: len(set(varying[name])))
        chosen[name] = next(value for value in varying[name] if value is not None)
        results = results.isel(setting=results[name].values == chosen[name])
    return chosen


def check_few(panels: Sequence[Panel], apart_from: Collection[str] = ("accuracy",)) -> None:
    """Raise InputError for more panels than a figure holds, with advice on how to select some."""
    if len(panels) > MOST_PANELS:
        names = [name for name in (*CAPTIONS, "accuracy") if all(name in panel.results.coords for panel in panels)]
        values = {name: np.concatenate([panel.results[name].values for panel in panels]) for name in names}
        results = xr.Dataset(coords={name: ("setting", of_all) for name, of_all in values.items()})
        what = f"a figure holds 1 to {MOST_PANELS} panels, not {len(panels)}"
        raise TooMuch(what, select_some(results, apart_from, MOST_PANELS))


def lacking(parts: Sequence[xr.Dataset]) -> str:
    """How many trials these parts of a study's results hold, where the run did not finish all of them; else nothing."""
    attributes = parts[0].attrs
    if not attributes.get("trials_done", 0) < attributes.get("trials_total", 0):
        return ""
    done, total = sum(int(finished(part).sum()) for part in parts), 0
    for part in parts:
        total += part.sizes["setting"] * part.sizes["trial"]
    if "half_width" in parts[0]:  # a rule ends the trials: nobody knows when
        return f"{done:,} trials so far"
    return f"{done:,} of {total:,} trials" if done < total else ""


def truth_of(trace: xr.Dataset) -> float:
    """Return the fill ratio that a trace's estimates are held against: see `truth` in docs/study-file.md."""
    on_floor = trace.attrs.get("truth") == "floor" and "true_fill_ratio" in trace.attrs
    return float(trace.attrs["true_fill_ratio" if on_floor else "fill_ratio"])


def unit_of(results: xr.Dataset, local: bool = False) -> str:
    """What convergence and checkpoints count: ticks where robots move, else communication rounds.

    Of local estimates, observations. Raises InputError if `results` does not say whether robots move.
    """
    if local:
        return "observations"
    require(results, "topology")
    moving = results["topology"].values == MOVING
    return "ticks" if moving.all() else "rounds or ticks" if moving.any() else "communication rounds"


def cloud_of(results: xr.Dataset, local: bool) -> Cloud:
    """Return convergence and error of every robot in every finished trial, by accuracy.

    Raises InputError if a variable is missing.
    """
    when, error, done = _converged(results, local)
    return {
        accuracy: (when[mine][done[mine]].astype(float), error[mine][done[mine]])
        for accuracy, mine in _accuracies(results)
        if done[mine].any()
    }


def crosses_of(results: xr.Dataset, local: bool) -> dict[str, Cross]:
    """Return the 95 % intervals over trials of the medians of a cloud, by accuracy.

    There is none of fewer than 6 trials, and of swarms of several sizes. Raises InputError if a variable is missing.
    """
    when, error, done = _converged(results, local)
    crosses = {}
    for accuracy, mine in _accuracies(results):
        sizes = np.unique(done[mine].sum(axis=2))
        if sizes[-1] == 0 or sizes.size > 1 + (sizes[0] == 0):
            continue
        whole = done[mine].any(axis=2)
        rows = [values[mine][whole][done[mine][whole]].reshape(-1, sizes[-1]).astype(float) for values in (when, error)]
        ends = [end for values in rows for end in interval_of(values, "median")[1:]]
        if np.isfinite(ends).all():
            crosses[accuracy] = (ends[0], ends[1], ends[2], ends[3])
    return crosses


def _converged(results: xr.Dataset, local: bool) -> tuple[NDArray[Any], NDArray[Any], NDArray[np.bool_]]:
    """Convergence, error and whether there is one, each (setting, trial, robot)."""
    names = ("convergence_round", "convergence_error")
    if local:
        names = ("local_convergence_step", "local_convergence_error")
    require(results, *names, "accuracy", "rounds", "observations_per_round")
    when, error = (results[name].transpose("setting", "trial", "robot").values for name in names)
    return when, error, (when >= 0) & np.isfinite(error)


def shares_of(results: xr.Dataset) -> Shares:
    """Return the fraction of right robots at each checkpoint (NaN: never run), whether it is all, and its interval.

    The interval of 95 % is over trials; it is NaN for fewer than 6 and for swarms of several sizes. Raises InputError
    if a variable is missing.
    """
    require(results, "correct", "checkpoint", "accuracy", "robots")
    correct = results["correct"].transpose("setting", "trial", "checkpoint").values
    known = np.isfinite(correct)
    robots = known * results["robots"].values[:, None, None]
    right = np.nan_to_num(correct) * robots
    shares = {}
    for accuracy, mine in _accuracies(results):
        asked = robots[mine].sum((0, 1))
        if asked.any():
            share = np.full(asked.shape, np.nan)
            np.divide(right[mine].sum((0, 1)), asked, out=share, where=asked > 0)
            all_right = ((correct[mine] == 1) | ~known[mine]).all((0, 1)) & (asked > 0)
            low, high = np.full((2, share.size), np.nan)
            if np.unique(results["robots"].values[mine]).size == 1:
                for k in np.flatnonzero(asked):
                    one_a_trial = correct[mine, :, k][known[mine, :, k]][:, np.newaxis]
                    low[k], high[k] = interval_of(one_a_trial, "mean", share=True)[1:]
            shares[accuracy] = Share(share, all_right, low, high)
    return shares


def _accuracies(results: xr.Dataset) -> Iterator[tuple[str, NDArray[np.bool_]]]:
    """Every distinct accuracy and which settings have it."""
    accuracy = results["accuracy"].values.astype(str)
    for text in dict.fromkeys(accuracy.tolist()):
        yield text, accuracy == text
