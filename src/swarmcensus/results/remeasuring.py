"""Asks kept estimates anew: other bins, another delta, without running anything again."""

import json
from pathlib import Path

import numpy as np
import xarray as xr

from swarmcensus.basics.errors import InputError, worded
from swarmcensus.metrics import parse
from swarmcensus.results.values import LOCAL, metrics_in, robots_in
from swarmcensus.simulation import metrics
from swarmcensus.studies.tables import Measure
from swarmcensus.worlds.changes import along, read_change

DERIVED = ("half_width", *LOCAL)  # of the old bins or delta, and not to be had from the estimates


def remeasure(results: xr.Dataset, *, delta: float | None = None, bins: int | None = None) -> xr.Dataset:
    """The same results with decisions among other `bins`, or with convergence within another `delta`.

    They are taken from `estimates`, which a study with `[measure] estimates = true` keeps at its checkpoints. So
    `correct` is what a run with these bins would have measured, to the bit; `convergence_round` is the first
    checkpoint (and `convergence_error` the error there) from which on an estimate is within delta of what it is at
    every later checkpoint: what a run would have measured if all rounds are checkpoints, and as near to it as they
    lie together otherwise. The rest is as it was, but for what belongs to the old delta or bins: half widths of rules,
    local estimates, and metrics of files that look at them. Paper, Sec. IV-A.

    The attribute `asked_anew` says which of the two were. To ask for those that the results have changes nothing.

    Raises InputError where estimates were not kept, or where delta or bins are not such as a study may have.
    """
    delta = None if delta == results.attrs.get("delta") else delta
    bins = None if bins == results.attrs.get("bins") else bins
    asked = {k: v for k, v in (("delta", delta), ("bins", bins)) if v is not None}
    if not asked:
        return results
    if "estimates" not in results:
        raise InputError(
            f"{' and '.join(asked)} can be asked anew of kept estimates alone, and these results hold none: "
            "set estimates = true under [measure] and run again"
        )
    _check(asked)
    sources = metrics_in(results)
    looked = {"delta"} & {*asked} | ({"low", "high"} if "bins" in asked else set())
    lost = [v for v, s in sources.items() if parse(s["source"], s["name"], Path(s["name"])).uses & looked]
    new = results.drop_vars([*DERIVED, *lost], errors="ignore")
    kept = {"metrics": json.dumps({v: s for v, s in sources.items() if v not in lost})} if lost else {}
    before = str(results.attrs.get("asked_anew", "")).split(", ")
    new.attrs = (
        results.attrs | asked | kept | {"asked_anew": ", ".join(k for k in ("bins", "delta") if k in (*before, *asked))}
    )
    estimates = results["estimates"].transpose("setting", "checkpoint", "trial", "robot").values
    reached = results["checkpoint"].values <= results["rounds"].values[:, np.newaxis]
    truth, then = _truth(results), _then(results, bins)
    for name in ("correct", "convergence_round", "convergence_error"):
        new[name] = results[name].copy()
    for k in range(results.sizes["setting"]):
        curves = estimates[k, reached[k], :, : int(robots_in(results).values[k])]
        done = np.isfinite(curves).all(axis=(0, 2))
        if bins is not None:
            for trial in np.flatnonzero(done):
                right = metrics.correct(curves[:, trial], float(truth[k, trial]), bins)
                if k in then:
                    every = zip(curves[:, trial], then[k][reached[k]], strict=True)
                    right = np.array([metrics.correct(row, float(f), bins) for row, f in every])
                new["correct"].values[k, reached[k], trial] = right
        if delta is not None and len(curves):
            _converge(new, k, curves[:, done], np.flatnonzero(done), results["checkpoint"].values[reached[k]], truth[k])
    return new


def _converge(
    new: xr.Dataset, k: int, curves: np.ndarray, trials: np.ndarray, checkpoints: np.ndarray, truth: np.ndarray
) -> None:
    """Put in the convergence of setting k: of `curves` (checkpoint, trial, robot) in these trials."""
    robots = curves.shape[2]
    index = metrics.convergence(curves.reshape(len(curves), -1), float(new.attrs["delta"])).reshape(-1, robots)
    value = np.take_along_axis(curves, index[np.newaxis], axis=0)[0]
    new["convergence_round"].values[k, trials, :robots] = checkpoints[index]
    new["convergence_error"].values[k, trials, :robots] = np.abs(value - truth[trials, np.newaxis])


def _check(asked: dict[str, float]) -> None:
    from pydantic import ValidationError

    try:
        Measure.model_validate(asked)
    except ValidationError as error:
        first = error.errors()[0]
        key = str(first["loc"][0])
        raise InputError(f"{key} = {asked[key]!r}: {worded(first['msg'])}") from None


def _then(results: xr.Dataset, bins: int | None) -> dict[int, np.ndarray]:
    """The fill ratios at checkpoints of settings where they change, by the settings' places.

    Raises InputError where `bins` are asked of floors, whose shares of then nobody knows.
    """
    if "fill_ratio_change" not in results:
        return {}
    if bins is not None and results.attrs["truth"] == "floor":
        raise InputError(
            f"bins = {bins}: decisions are held against the floor as it is at each checkpoint, and of floors that "
            "change these results know the last round's alone: set bins under [measure] and run again"
        )
    changes = {k: read_change(text) for k, text in enumerate(results["fill_ratio_change"].values.tolist())}
    return {k: along(change.course, results["checkpoint"].values) for k, change in changes.items() if change}


def _truth(results: xr.Dataset) -> np.ndarray:
    """What estimates are held against, (setting, trial)."""
    nominal = np.broadcast_to(
        results["fill_ratio"].values[:, np.newaxis], (results.sizes["setting"], results.sizes["trial"])
    )
    if results.attrs["truth"] != "floor":
        return nominal
    on_floor = results["true_fill_ratio"].transpose("setting", "trial").values
    return np.where(np.isnan(on_floor), nominal, on_floor)
