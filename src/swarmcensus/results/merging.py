"""Merging: results with different settings or trials are put together, such as the shares of several machines."""

import json
from collections.abc import Sequence
from pathlib import Path

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from swarmcensus.results.outlines import differences, most_trials, outline, positions
from swarmcensus.results.plugin_files import accuracies_in
from swarmcensus.results.reading import packed, readable
from swarmcensus.results.schema import check_dataset
from swarmcensus.results.shards import Identity, Parts, shard_files
from swarmcensus.results.source_study import studies_of
from swarmcensus.results.store import load_packed, save
from swarmcensus.results.values import (
    failed_in,
    failed_trials,
    finished_trials,
    is_missing,
    kinds_in,
    others,
    same_bits,
)
from swarmcensus.studies import Study
from swarmcensus.support.errors import InputError, ResultsError
from swarmcensus.support.files import check_writable
from swarmcensus.support.options import option
from swarmcensus.support.quantities import PER_TRIAL

MAKERS = ("swarmcensus_version", "python_version", "library_versions", "machine", "processor")  # what made the numbers
ALIKE = ("seed", "delta", "bins", "truth", "swarmcensus_version")  # attributes in which results must agree


def merge(results: Sequence[xr.Dataset | str | Path]) -> xr.Dataset:
    """Merge several results into one dataset with all their settings and trials.

    Settings are identified by their fingerprints and are in the order in which they first appear. A trial that two
    results have must be the same to the last bit, and each dataset must match its study. Raises InputError otherwise,
    and if the results cannot go together.
    """
    names = [str(given) if isinstance(given, str | Path) else f"results {k + 1}" for k, given in enumerate(results)]
    datasets = [packed(given) if isinstance(given, xr.Dataset) else load_packed(given) for given in results]
    if not datasets:
        raise InputError("nothing to merge")
    studies: dict[object, Study] = {}  # each once
    planned = []
    for name, data in zip(names, datasets, strict=True):
        for key in ALIKE:
            if data.attrs.get(key) != datasets[0].attrs.get(key):
                both = f"{key} is {data.attrs.get(key)} and {datasets[0].attrs.get(key)}"
                raise ResultsError(f"{name} and {names[0]} cannot go together: {both}", file=name, key=key)
        try:
            check_dataset(data)
        except ResultsError as error:
            raise ResultsError.of(name, error) from None
        own = studies_of(data, run=False)
        for wrong in differences(data, outline(own, "merged" in data.attrs), own, whole=False):
            raise ResultsError.of(name, f"not what its study gives: {wrong}")
        for study in own:
            studies.setdefault((study.text, *study.settings()), study)
        planned.append(_planned(data, own))
    trials = max(int(data["trial"].values.max()) + 1 for data in datasets)
    return readable(_together(names, datasets, outline(list(studies.values()), True, trials), planned))


def write(out: Path, results: Sequence[str | Path], *, fresh: bool = False) -> xr.Dataset:
    """Merge files into the file `out`, which no run may be writing.

    With `fresh` it replaces a file that is there. Raises InputError.
    """
    check_writable(out, *map(Path, results))
    data = merge(results)
    checkpoints, marks = (data[name].values.tolist() for name in ("checkpoint", "fingerprint"))
    with Parts(out, Identity.of(data), checkpoints, marks) as parts:
        if not fresh and shard_files(parts.folder):
            fresh_run = option("fresh", True)
            cut_off = f"{parts.folder} holds the work of a run that was cut off: end that run first, or {fresh_run}"
            raise ResultsError(cut_off, file=out)
        if not fresh and out.exists():
            instead = f"write elsewhere with {option('out')}, or replace it with {option('fresh', True)}"
            raise ResultsError(f"{out} is there: {instead}", file=out)
        save(data, out)
        parts.clear()
    return data


def _planned(data: xr.Dataset, studies: Sequence[Study]) -> dict[str, int]:
    """The number of trials that each setting of a dataset has or will have, by fingerprint."""
    marks, tried = data["fingerprint"].values.tolist(), finished_trials(data) | failed_trials(data)
    if any(study.until for study in studies) and data.attrs["trials_total"] == tried.sum():
        return dict(zip(marks, tried.sum(axis=1).tolist(), strict=True))
    most = most_trials(studies)
    return {mark: most[mark] for mark in marks}


def _together(
    names: Sequence[str], datasets: Sequence[xr.Dataset], want: xr.Dataset, planned: Sequence[dict[str, int]]
) -> xr.Dataset:
    present = {mark for data in datasets for mark in data["fingerprint"].values.tolist()}
    merged = want.isel(setting=[mark in present for mark in want["fingerprint"].values.tolist()])
    rows = {mark: k for k, mark in enumerate(merged["fingerprint"].values.tolist())}
    origin = np.full((merged.sizes["setting"], merged.sizes["trial"]), -1)
    failed: dict[tuple[int, int], dict[str, object]] = {}
    for k, data in enumerate(datasets):
        place = np.array([rows[mark] for mark in data["fingerprint"].values.tolist()])
        _put(merged, data, place, origin, k, names)
        row_of = dict(zip(data["setting"].values.tolist(), place.tolist(), strict=True))
        for failure in failed_in(data):
            failed[row_of[failure["setting"]], failure["trial"]] = failure
    total = sum(max(each.get(mark, 0) for each in planned) for mark in rows)
    merged.attrs |= {"trials_done": int((origin >= 0).sum()), "trials_total": total}
    numbers = merged["setting"].values.tolist()
    still_failed = [at for at in sorted(failed) if origin[at] < 0]
    if still_failed:
        named = [failed[k, t] | {"setting": numbers[k], "trial": t} for k, t in still_failed]
        merged.attrs["failed"] = json.dumps(named)
    merged.attrs |= _making_of(datasets, origin)
    numbers = {text: found for data in datasets for text, found in accuracies_in(data).items()}
    return merged.assign_attrs(accuracies=json.dumps(numbers, sort_keys=True)) if numbers else merged


def _making_of(datasets: Sequence[xr.Dataset], origin: NDArray[np.int64]) -> dict[str, object]:
    """What made the merged numbers, and how long it took, in proportion to the trials taken from each dataset."""
    first = datasets[0].attrs
    taken = [int((origin == k).sum()) / max(1, int(d.attrs["trials_done"])) for k, d in enumerate(datasets)]
    devices = sorted({name for d in datasets for name in d.attrs.get("device", "").split(", ") if name})
    making: dict[str, object] = {"device": ", ".join(devices)} if devices else {}
    making |= {key: first[key] for key in (*MAKERS, "started", "finished") if key in first}
    for key in ("wall_seconds", "cpu_seconds"):
        seconds = [float(data.attrs.get(key, 0.0)) * part for data, part in zip(datasets, taken, strict=True)]
        making[key] = round(sum(seconds), 3)
    return making


def _put(
    merged: xr.Dataset, data: xr.Dataset, place: np.ndarray, origin: np.ndarray, number: int, names: Sequence[str]
) -> None:
    """Copy a dataset's finished trials to their place. Raises InputError if they disagree with trials already there."""
    trials, done, where = data["trial"].values, finished_trials(data), positions(merged, data, place)
    for name, (dims, *_) in kinds_in(data).items():
        array, new = merged[name].values, data[name].values
        old = array[where(dims)]
        nothing = np.expand_dims(~done, others(dims)) | is_missing(new)
        differ = np.argwhere(~nothing & ~is_missing(old) & ~same_bits(old, new))
        if differ.size:
            at = dict(zip(dims, differ[0].tolist(), strict=True))
            setting, trial = int(place[at["setting"]]), int(trials[at["trial"]])
            value, before = new[tuple(differ[0])].item(), old[tuple(differ[0])].item()
            both, ours = f"{names[number]} and {names[origin[setting, trial]]}", data["setting"].values[at["setting"]]
            what = f"setting {ours} of {names[number]}, trial {trial}: {name} is {value!r} and {before!r}"
            raise ResultsError(f"{both} disagree: {what}", file=names[number], key=name, value=value)
        array[where(dims)] = np.where(nothing, old, new)
    own = where(PER_TRIAL)
    origin[own] = np.where(done & (origin[own] < 0), number, origin[own])
