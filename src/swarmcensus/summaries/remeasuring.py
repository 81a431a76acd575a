"""Remeasuring: decisions for other bins, or convergence for another delta, from stored estimates."""

import json
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr

from swarmcensus.brains.metrics import parse
from swarmcensus.results import LOCAL, metrics_in, robots_in
from swarmcensus.simulation import metrics
from swarmcensus.studies import Measure
from swarmcensus.summaries.measures import truth as truth_of
from swarmcensus.support.errors import InputError
from swarmcensus.worlds import along, read_change

DERIVED = ("half_width", *LOCAL)  # depend on bins or delta, and cannot be derived from the estimates


def remeasure(results: xr.Dataset, *, delta: float | None = None, bins: int | None = None) -> xr.Dataset:
    """Measure results again with other `bins` for decisions, or another `delta` for convergence.

    The numbers come from `estimates`, which a study with `[measure] estimates = true` stores at its checkpoints.
    `correct` is exactly what a run with these bins would have measured. `convergence_round` is the first checkpoint
    from which on the estimate is within delta of all later checkpoints, `convergence_error` the error there, and
    `agreement_round` the first checkpoint from which on the robots stay within delta of each other: this is what a run
    would have measured if every round is a checkpoint, and an approximation otherwise. Variables that
    depend on the old values are dropped: half widths of rules, local estimates, and metric files that use them. Paper,
    Sec. IV-A.

    The attribute `asked_anew` names what was changed. Values equal to those of the results change nothing.

    Raises InputError if no estimates were stored, or if delta or bins are not valid in a study.
    """
    delta = None if delta == results.attrs.get("delta") else delta
    bins = None if bins == results.attrs.get("bins") else bins
    changed: dict[str, Any] = {k: v for k, v in (("delta", delta), ("bins", bins)) if v is not None}
    if not changed:
        return results
    if "estimates" not in results:
        none = "these results have none: set estimates = true under [measure] and run again"
        only = f"{' and '.join(changed)} can be changed only if estimates are stored"
        raise InputError(f"{only}, and {none}", key=next(iter(changed)))
    Measure(**changed)  # raises StudyError for what no study may have
    sources = metrics_in(results)
    looked = {"delta"} & {*changed} | ({"low", "high"} if "bins" in changed else set())
    lost = [v for v, s in sources.items() if parse(s["source"], s["name"], Path(s["name"])).uses & looked]
    new = results.drop_vars([*DERIVED, *lost], errors="ignore")
    kept = {"metrics": json.dumps({v: s for v, s in sources.items() if v not in lost})} if lost else {}
    before = str(results.attrs.get("asked_anew", "")).split(", ")
    ever_changed = ", ".join(k for k in ("bins", "delta") if k in (*before, *changed))
    new.attrs = results.attrs | changed | kept | {"asked_anew": ever_changed}
    estimates = results["estimates"].transpose("setting", "checkpoint", "trial", "robot").values
    reached = results["checkpoint"].values <= results["rounds"].values[:, np.newaxis]
    truth, then = truth_of(results), _then(results, bins)
    for name in ("correct", "convergence_round", "convergence_error", "agreement_round"):
        if name in results:
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
        if delta is None or not len(curves):
            continue
        checkpoints, robots = results["checkpoint"].values[reached[k]], curves.shape[2]
        columns = curves[:, done].reshape(len(curves), -1)
        index = metrics.convergence(columns, delta)
        error = metrics.error_at(columns, index, np.repeat(truth[k, done], robots))
        new["convergence_round"].values[k, done, :robots] = checkpoints[index].reshape(-1, robots)
        new["convergence_error"].values[k, done, :robots] = error.reshape(-1, robots)
        if "agreement_round" in new:
            since = [metrics.agreement(curves[:, trial], delta) for trial in np.flatnonzero(done)]
            new["agreement_round"].values[k, done] = [checkpoints[int(s)] if np.isfinite(s) else s for s in since]
    return new


def _then(results: xr.Dataset, bins: int | None) -> dict[int, np.ndarray]:
    """Fill ratios at the checkpoints, by the index of each setting with a changing fill ratio.

    Raises InputError for `bins` with `truth = "floor"`: the true fill ratio at earlier checkpoints is not stored.
    """
    if "fill_ratio_change" not in results:
        return {}
    if bins is not None and results.attrs["truth"] == "floor":
        last = "these results store a changing floor only at the last round: set bins under [measure] and run again"
        raise InputError.at("bins", bins, f"decisions are compared with the floor at each checkpoint, and {last}")
    changes = {k: read_change(text) for k, text in enumerate(results["fill_ratio_change"].values.tolist())}
    return {k: along(change.course, results["checkpoint"].values) for k, change in changes.items() if change}
