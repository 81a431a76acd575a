"""Remeasuring: right decisions for other bins, from stored estimates."""

import json
from pathlib import Path

import numpy as np
import xarray as xr

from swarmcensus.brains.metrics import parse
from swarmcensus.results import metrics_in, robots_in
from swarmcensus.simulation import metrics
from swarmcensus.studies import Measure
from swarmcensus.summaries.measures import truth as truth_of
from swarmcensus.support.errors import InputError


def remeasure(results: xr.Dataset, *, bins: int | None = None) -> xr.Dataset:
    """Measure right decisions again with other `bins`: exactly what a run with them would have measured.

    The numbers come from `estimates`, which a study with `[measure] estimates = true` stores at its checkpoints.
    Variables that depend on the old bins are dropped: half widths of rules, and metric files that use them. Paper,
    Sec. IV-A.

    The attribute `asked_anew` is then "bins". The bins of the results change nothing.

    Raises InputError if no estimates were stored, if a fill ratio changes, or for bins that are not valid in a study.
    """
    if bins in (None, results.attrs.get("bins")):
        return results
    if "estimates" not in results or "fill_ratio_change" in results:
        needed = "estimates = true under [measure], and a fill ratio that stays: set bins there and run again"
        raise InputError(f"bins = {bins}: results are measured again if they have {needed}", key="bins", value=bins)
    Measure(bins=bins)  # raises StudyError for what no study may have
    sources = metrics_in(results)
    lost = [v for v, s in sources.items() if parse(s["source"], s["name"], Path(s["name"])).uses & {"low", "high"}]
    new = results.drop_vars(["half_width", *lost], errors="ignore")
    kept = {"metrics": json.dumps({v: s for v, s in sources.items() if v not in lost})} if lost else {}
    new.attrs = results.attrs | {"bins": bins, "asked_anew": "bins"} | kept
    estimates = results["estimates"].transpose("setting", "checkpoint", "trial", "robot").values
    reached = results["checkpoint"].values <= results["rounds"].values[:, np.newaxis]
    truth, robots = truth_of(results), robots_in(results).values
    new["correct"] = results["correct"].copy()
    for k, trial in np.ndindex(truth.shape):
        curves = estimates[k, reached[k], trial, : robots[k]]
        if np.isfinite(curves).all():
            new["correct"].values[k, reached[k], trial] = metrics.correct(curves, float(truth[k, trial]), bins)
    return new
