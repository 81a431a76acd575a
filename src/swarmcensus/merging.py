"""Puts results together whose settings or trials differ, such as the shares of several machines."""

import json
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr

from swarmcensus.errors import InputError
from swarmcensus.results import load
from swarmcensus.values import EVERY, MISSING

ALIKE = ("seed", "delta", "bins", "truth", "swarmcensus_version")  # attributes in which results must agree


def merge(results: Sequence[xr.Dataset | str | Path]) -> xr.Dataset:
    """One dataset of all settings and trials of several, settings in the order in which they first appear.

    A setting is known by its fingerprint. Where two hold the same trial of one setting, it must be the same to the
    last bit. Raises InputError where that is not so, or where the results cannot go together.
    """
    names = [str(one) if isinstance(one, str | Path) else f"results {k + 1}" for k, one in enumerate(results)]
    datasets = [one if isinstance(one, xr.Dataset) else load(one) for one in results]
    if not datasets:
        raise InputError("nothing to merge")
    for name, data in zip(names, datasets, strict=True):
        for key in ALIKE:
            if data.attrs.get(key) != datasets[0].attrs.get(key):
                raise InputError(
                    f"{name} and {names[0]} cannot go together: {key} is {data.attrs.get(key)} and "
                    f"{datasets[0].attrs.get(key)}"
                )
    merged = _blank(datasets)
    rows = {mark: k for k, mark in enumerate(merged["fingerprint"].values.tolist())}
    origin = np.full((merged.sizes["setting"], merged.sizes["trial"]), -1)
    for k, data in enumerate(datasets):
        place = np.array([rows[mark] for mark in data["fingerprint"].values.tolist()])
        _put(merged, data, place, origin, k, names)
    _describe(merged, datasets, names, origin)
    return merged


def _blank(datasets: Sequence[xr.Dataset]) -> xr.Dataset:
    """A dataset with room for all, its coordinates filled in."""
    marks: dict[str, tuple[int, int]] = {}
    for k, data in enumerate(datasets):
        for place, mark in enumerate(data["fingerprint"].values.tolist()):
            marks.setdefault(mark, (k, place))
    checkpoints = np.unique(np.concatenate([d["checkpoint"].values for d in datasets]))
    sizes = {
        "setting": len(marks),
        "trial": max(int(d["trial"].values.max()) + 1 for d in datasets),
        "robot": max(d.sizes["robot"] for d in datasets),
        "checkpoint": checkpoints.size,
    }
    first = datasets[0]
    coordinates: dict[str, Any] = {name: np.arange(n) for name, n in sizes.items()}
    coordinates["checkpoint"] = ("checkpoint", checkpoints, first["checkpoint"].attrs)
    for name, column in first.coords.items():
        if column.dims == ("setting",) and name != "setting":
            values = [datasets[k][name].values[place] for k, place in marks.values()]
            coordinates[str(name)] = ("setting", np.array(values, dtype=object if isinstance(values[0], str) else None))
    variables: dict[str, Any] = {}
    for name, (dims, kind, *_) in EVERY.items():
        holders = [d for d in datasets if name in d]
        if holders:
            blank = MISSING if np.issubdtype(kind, np.integer) else np.nan
            variables[name] = (dims, np.full([sizes[d] for d in dims], blank, kind), holders[0][name].attrs)
    variables["fingerprint"] = ("setting", np.array(list(marks), dtype=object), first["fingerprint"].attrs)
    return xr.Dataset(variables, coordinates)


def _put(
    merged: xr.Dataset, data: xr.Dataset, place: np.ndarray, origin: np.ndarray, number: int, names: Sequence[str]
) -> None:
    """Copy one dataset to its place. Raises InputError where it disagrees with what is there."""
    trials, robots = data["trial"].values, np.arange(data.sizes["robot"])
    ours = np.searchsorted(merged["checkpoint"].values, data["checkpoint"].values)
    for name, (dims, *_) in EVERY.items():
        if name not in data:
            continue
        where = np.ix_(*[{"setting": place, "trial": trials, "robot": robots, "checkpoint": ours}[d] for d in dims])
        array, new = merged[name].values, data[name].values
        old = array[where]
        blank = new == MISSING if new.dtype.kind == "i" else np.isnan(new)
        unset = old == MISSING if old.dtype.kind == "i" else np.isnan(old)
        differ = np.argwhere(~blank & ~unset & (old != new))
        if differ.size:
            at = dict(zip(dims, differ[0].tolist(), strict=True))
            setting, trial = int(place[at["setting"]]), int(trials[at["trial"]])
            before = names[origin[setting, trial]]
            mine, other = new[tuple(differ[0])].item(), old[tuple(differ[0])].item()
            raise InputError(
                f"{names[number]} and {before} disagree: setting {data['setting'].values[at['setting']]} of "
                f"{names[number]}, trial {trial}: {name} is {mine!r} and {other!r}"
            )
        array[where] = np.where(blank, old, new)
    done = np.argwhere(data["convergence_round"].values[:, :, 0] != MISSING)
    fresh = origin[place[done[:, 0]], trials[done[:, 1]]] < 0
    origin[place[done[fresh, 0]], trials[done[fresh, 1]]] = number


def _describe(merged: xr.Dataset, datasets: Sequence[xr.Dataset], names: Sequence[str], origin: np.ndarray) -> None:
    """Say what was merged; Raises InputError where one name stands for two brains or two edge lists."""
    brains: dict[str, Any] = {}
    texts: list[str] = []
    failed: dict[tuple[int, int], Any] = {}
    rows = {mark: k for k, mark in enumerate(merged["fingerprint"].values.tolist())}
    for name, data in zip(names, datasets, strict=True):
        for brain, source in json.loads(data.attrs["brains"]).items():
            if brains.setdefault(brain, source)["sha256"] != source["sha256"]:
                raise InputError(f"{name} and another of the results name two different brains {brain!r}")
        for key, array in data.data_vars.items():
            if str(key).startswith(("edges_", "floor_")):
                if key in merged and not array.equals(merged[key]):
                    raise InputError(f"{name} and another of the results have two different {key}")
                merged[key] = array
        texts += json.loads(data.attrs["merged"]) if "merged" in data.attrs else [data.attrs["study"]]
        marks = dict(zip(data["setting"].values.tolist(), data["fingerprint"].values.tolist(), strict=True))
        for one in json.loads(data.attrs.get("failed", "[]")):
            failed[rows[marks[one["setting"]]], one["trial"]] = one
    texts = list(dict.fromkeys(texts))
    first = datasets[0].attrs
    merged.attrs = first | {
        "title": " + ".join(dict.fromkeys(str(d.attrs["title"]) for d in datasets)),
        "study": texts[0],
        "brains": json.dumps(brains, sort_keys=True),
        "trials_done": int((origin >= 0).sum()),
        "trials_total": int(origin.size),
        **{key: sum(float(d.attrs.get(key, 0.0)) for d in datasets) for key in ("wall_seconds", "cpu_seconds")},
    }
    if len(texts) > 1:
        merged.attrs["merged"] = json.dumps(texts)
    merged.attrs.pop("failed", None)
    still = [one | {"setting": k, "trial": t} for (k, t), one in sorted(failed.items()) if origin[k, t] < 0]
    if still:
        merged.attrs["failed"] = json.dumps(still)
