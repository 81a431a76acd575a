"""Checks of a dataset that need nothing else: its structure, and which values are present.

`check_against_study` compares its settings with its study, and `runs.verifying` runs trials again.
"""

import json
import re
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from swarmcensus.brains.metrics import parse, variable_of
from swarmcensus.results.values import (
    AGREEMENT,
    ALL_VARIABLES,
    ENDLESS,
    LEADS,
    LOCAL,
    MARKS,
    MISSING,
    NAN_BITS,
    NETWORKS,
    VARIABLES,
    is_missing,
    kinds_in,
    metrics_in,
    robots_in,
)
from swarmcensus.studies import COORDINATES
from swarmcensus.support.errors import InputError, ResultsError
from swarmcensus.support.plugins import digest
from swarmcensus.support.quantities import PER_ROBOT, PER_TRIAL, stored
from swarmcensus.worlds import MOVING

FORMAT = "swarmcensus results 3"
TEXTS = tuple(name for name, kind in COORDINATES.items() if kind.always and kind.type == "text")
NUMBERS = tuple(name for name, kind in COORDINATES.items() if kind.always and kind.type != "text")
BRAIN_FACTS = tuple(name for name, quantity in stored("setting").items() if quantity.kind is np.int64)
ATTRIBUTES: dict[str, Any] = {
    "title": str, "study": str, "brains": str, "swarmcensus_version": str, "truth": str, "delta": float | np.floating,
    **dict.fromkeys(("seed", "bins", "trials_done", "trials_total"), int | np.integer),
}  # fmt: skip
OPTIONAL: dict[str, Any] = {
    **dict.fromkeys(("python_version", "library_versions", "machine", "processor", "device"), str),
    **dict.fromkeys(("started", "finished"), str),
    **dict.fromkeys(("wall_seconds", "cpu_seconds"), float | np.floating),
}  # fmt: skip
ONLY_WHERE = {  # a variable that a trial has only if another one has such a value
    "consensus_right": ("right_option", np.isfinite), "done_estimate": ("done_round", np.isfinite),
}  # fmt: skip
ALTERS = ("scale_factor", "add_offset", "missing_value", "valid_min", "valid_max", "valid_range", "_Unsigned")


def wrong_format(data: xr.Dataset) -> str | None:
    """Why the format of a dataset cannot be read, as a sentence; None if it can."""
    stored_format = data.attrs.get("format")
    if stored_format == FORMAT:
        return None
    return f"its format is {stored_format!r}, and this version of swarmcensus reads {FORMAT!r}"


def unmask(data: xr.Dataset) -> str | None:
    """Remove fill values from the attributes of a dataset as read; return a sentence if one alters its numbers.

    In memory whole numbers stay whole, and -1 means missing.
    """
    for key, array in data.variables.items():
        fill = array.attrs.pop("_FillValue", None)
        fills = [] if fill is None else np.ravel(fill).tolist()
        if fills:
            array.encoding["_FillValue"] = fill
        masked = key in ALL_VARIABLES and array.dtype.kind == "i"
        if fills != [MISSING] if masked else any(fill == fill for fill in fills):
            return f"{key} should have {'the' if masked else 'no'} _FillValue{f' {MISSING}' if masked else ''}"
        altered = [name for name in ALTERS if name in array.attrs]
        if altered:
            return f"{key} should have no {altered[0]}, which alters its numbers"
    return None


def fault_of(data: xr.Dataset) -> str | None:
    """What is wrong in a dataset that no run or merge could have made, as a sentence; None if nothing."""
    if why := wrong_format(data):
        return why
    newer = [name for group in (AGREEMENT, NETWORKS) if group.keys() & {*data.variables} for name in group]
    needed = (*VARIABLES, "fingerprint", *newer)
    lacking = [name for name in needed if name not in data]
    if lacking:
        return f"{lacking[0]} is missing"
    try:
        if why := _metrics(data) or _shape(data) or _attributes(data) or _missing(data):
            return why
        sources_and_studies(data), adversaries_in(data), _sources(data, "plugin_files", "file of the")
    except InputError as error:
        return str(error)
    return None


def _metrics(data: xr.Dataset) -> str | None:
    """What is wrong with the metric files of a dataset; their sources are read and not run."""
    try:
        named = [(str(v), str(s["name"]), str(s["sha256"]), str(s["source"])) for v, s in metrics_in(data).items()]
    except (KeyError, TypeError, ValueError, AttributeError, RecursionError):
        return "the attribute metrics does not name metrics and their sources"
    for variable, name, sha256, source in named:
        if digest(source) != sha256:
            return f"the source of the metric {name!r} does not match its hash"
        dims = PER_TRIAL if parse(source, name, Path(name)).of_swarm else PER_ROBOT
        if variable != variable_of(name) or variable not in data or data.variables[variable].dims != dims:
            return f"{variable} should be what the metric {name!r} says, ({', '.join(dims)})"
        if data.variables[variable].dtype != np.float64:
            return f"{variable} should be float64 ({', '.join(dims)})"
    return None


def _shape(data: xr.Dataset) -> str | None:
    counts = (*BRAIN_FACTS, "honest") if "honest" in data else BRAIN_FACTS
    kinds = {"fingerprint": "UO"}
    kinds |= dict.fromkeys(NUMBERS, "iuf") | dict.fromkeys(counts, "iu") | dict.fromkeys(TEXTS, "UO")
    for name, (dims, kind, *_) in ALL_VARIABLES.items():
        if name in data and (data.variables[name].dims != dims or data.variables[name].dtype != kind):
            return f"{name} should be {np.dtype(kind)} ({', '.join(dims)})"
    for name, allowed in kinds.items():
        known = data.coords if name in (*NUMBERS, *TEXTS) else data
        column = data.variables[name] if name in known else xr.Variable((), 0.0)
        if column.dims != ("setting",) or column.dtype.kind not in allowed:
            return f"{name} should have one {'text' if allowed == 'UO' else 'number'} a setting"
        if allowed == "UO" and not all(isinstance(value, str) for value in column.values.tolist()):
            return f"{name} should be text"
    for name in ("setting", "trial", "robot", "checkpoint"):
        numbers = data.variables[name].values if name in data.coords else np.zeros(0)
        if numbers.dtype.kind not in "iu" or numbers.shape != (data.sizes[name],) or not numbers.size:
            return f"{name} should number what there is of it"
        if (np.diff(numbers) <= 0).any() or numbers[0] < 0 or numbers[-1] >= 2**31:
            return f"{name} should be numbers from 0 in rising order"
    size = robots_in(data)
    if not (size.values == np.clip(size.values, 1, data.sizes["robot"])).all():
        return f"{size.name} should be 1 to {data.sizes['robot']}"
    if "honest" in data and (data.variables["honest"].values > data.variables["robots"].values).any():
        return "honest should be robots at the most"
    if len(set(data.variables["fingerprint"].values.tolist())) < data.sizes["setting"]:
        return "two settings have one fingerprint"
    for key, array in data.data_vars.items():
        inside = "iu" if str(key).startswith("edges_") else "u" if str(key).startswith("floor_") else ""
        source = array.attrs.get("source")
        if inside and (array.ndim != 2 or array.dtype.kind not in inside or not isinstance(source, str)):
            return f"{key} should be whole numbers in rows, with their source"
    return None


def _attributes(data: xr.Dataset) -> str | None:
    for name, kind in ATTRIBUTES.items():
        if not isinstance(data.attrs.get(name), kind):
            return f"the attribute {name} is missing or of another kind"
    for name, kind in OPTIONAL.items():
        value = data.attrs.get(name, "")
        if name in data.attrs and (not isinstance(value, kind) or (kind is not str and not 0.0 <= value < np.inf)):
            return f"the attribute {name} is of another kind"
    parts = re.fullmatch(r"([1-9]\d{0,9})/([1-9]\d{0,9})", str(data.attrs.get("share", "1/1")))
    if parts is None or int(parts[1]) > int(parts[2]):
        return "the attribute share should be such as 1/4"
    try:
        failed = failed_pairs(data)
        kept = failed_in(data)
    except (ValueError, KeyError, TypeError, AttributeError, RecursionError):
        return "the attribute failed is no list of failures"
    if "failed" in data.attrs and (data.attrs["failed"] != json.dumps(kept) or not 0 < len(kept) == len(failed)):
        return "the attribute failed is no list of failures, each once"
    done = finished_trials(data)
    rows, columns = ({n: k for k, n in enumerate(data.variables[d].values.tolist())} for d in ("setting", "trial"))
    for setting, trial in sorted(failed):
        if setting not in rows or trial not in columns:
            return f"the attribute failed names setting {setting}, trial {trial}, which has no place here"
        if done[rows[setting], columns[trial]]:
            return f"the attribute failed names setting {setting}, trial {trial}, which is there"
    return None


def finished_trials(data: xr.Dataset) -> NDArray[np.bool_]:
    """A mask of the trials that have all requested values, (setting, trial)."""
    local = "local_convergence_step" in data and "merged" not in data.attrs
    names = MARKS if local else MARKS[:1]
    return np.asarray(np.all([~is_missing(data.variables[name].values[:, :, 0]) for name in names], axis=0))


def failed_in(data: xr.Dataset) -> list[dict[str, Any]]:
    """The failed trials, also of settings that were not selected, each with `setting`, `trial` and `why`."""
    return list(json.loads(data.attrs.get("failed", "[]")))


def failed_pairs(data: xr.Dataset) -> set[tuple[int, int]]:
    """The failed trials, as numbers of setting and trial."""
    return {(int(failure["setting"]), int(failure["trial"])) for failure in failed_in(data)}


def _missing(data: xr.Dataset) -> str | None:
    """What is wrong with missing values: a finished trial has all its values, and an unfinished one has none."""
    done = data.variables["convergence_round"][:, :, 0] != MISSING
    exists = xr.Variable("robot", np.arange(data.sizes["robot"])) < robots_in(data).variable
    reached = xr.Variable("checkpoint", data.variables["checkpoint"].values) <= data.variables["rounds"]
    merged = "merged" in data.attrs
    for name, (dims, *_) in kinds_in(data).items():
        array = data.variables[name]
        there = _there(array)
        if (lead := LEADS.get(name)) in data:
            expected = _of_trial(_there(data.variables[lead]))
            expected = expected if name in LOCAL else expected & done
        else:  # merged studies may measure different things: a trial has all or nothing of each
            expected = _of_trial(there) if merged and name not in VARIABLES else done
        if name == "true_fill_ratio":
            expected = expected & xr.Variable("setting", data.variables["topology"].values == MOVING)
        if "robot" in dims:
            expected = expected & exists
        if "checkpoint" in dims:  # in merged results, at the checkpoints of the study that ran the trial
            looked = _there(data.variables["correct"]) if name in AGREEMENT else _any(there, set(dims) & {"robot"})
            expected = expected & reached & (looked if merged else True)
        if name == "right_option":
            expected = expected & there
        elif name in ONLY_WHERE and ONLY_WHERE[name][0] in data:
            variable, allows = ONLY_WHERE[name]
            expected = expected & allows(data.variables[variable])
        if places := _place(data, dims, there != expected):
            at, where = places
            ran = expected.isel(at, missing_dims="ignore")
            return f"{name} of {where} {'is missing, though the trial ran' if ran else 'should be missing'}"
        if places := _place(data, dims, _malformed(name, array)):
            at, where = places
            return f"{name} of {where} is {array.values[tuple(at.values())].item()!r}, which no run writes there"
    count = int(finished_trials(data).sum())
    if data.attrs["trials_done"] != count:
        return f"trials_done is {data.attrs['trials_done']}, and {count} trials are there"
    if data.attrs["trials_total"] < count + len(failed_pairs(data)):
        return f"trials_total is {data.attrs['trials_total']}, and {count} trials are there or failed"
    return None


def _there(array: xr.Variable) -> xr.Variable:
    return xr.Variable(array.dims, ~is_missing(array.values))


def _of_trial(there: xr.Variable) -> xr.Variable:
    """A mask of the trials that have any value, (setting, trial)."""
    return _any(there, {str(dim) for dim in there.dims} - {"setting", "trial"})


def _any(there: xr.Variable, dims: set[str]) -> xr.Variable:
    return there.any(dims) if dims else there


def _malformed(name: str, array: xr.Variable) -> xr.Variable:
    """A mask of missing or infinite values in a form that no run writes."""
    values = array.values
    if values.dtype.kind == "i":
        return xr.Variable(array.dims, values < MISSING)
    endless = name in ENDLESS or name not in ALL_VARIABLES  # metric files use infinity for "never" too
    other_nan = np.isnan(values) & (values.view(np.uint64) != NAN_BITS)
    return xr.Variable(array.dims, other_nan | (np.isinf(values) & (values < 0 if endless else True)))


def _place(data: xr.Dataset, dims: tuple[str, ...], wrong: xr.Variable) -> tuple[dict[str, int], str] | None:
    """The indices of the first wrong value, and its name for a message."""
    indices = np.argwhere(wrong.transpose(*dims).values)
    if not indices.size:
        return None
    at = dict(zip(dims, indices[0].tolist(), strict=True))
    return at, ", ".join(f"{d} {data.variables[d].values[k]}" for d, k in at.items())


def selected(data: xr.Dataset) -> dict[str, Any]:
    """The attributes of a selection of a dataset, with its own number of trials."""
    settings, trials = (data.variables[key].values for key in ("setting", "trial"))
    left = [failure for failure in failed_in(data) if failure["setting"] in settings and failure["trial"] in trials]
    counted = {"trials_done": int(finished_trials(data).sum())} if "trials_done" in data.attrs else {}
    others = {k: v for k, v in data.attrs.items() if k != "failed"} | counted
    return others | ({"failed": json.dumps(left)} if left else {})


def sources_and_studies(data: xr.Dataset) -> tuple[dict[str, dict[str, str]], list[str]]:
    """The brains of a dataset by name, and the texts of its studies. Raises InputError."""
    sources = _sources(data, "brains", "brain")
    try:
        texts = [str(text) for text in json.loads(data.attrs["merged"])] if "merged" in data.attrs else []
        return sources, texts or [str(data.attrs["study"])]
    except (KeyError, TypeError, ValueError, AttributeError, RecursionError) as error:
        raise _unknown_origin("brains", error) from None


def adversaries_in(data: xr.Dataset) -> dict[str, dict[str, str]]:
    """The adversaries of a dataset, by name: `sha256` and `source`. Raises InputError."""
    return _sources(data, "adversaries", "adversary")


def _sources(data: xr.Dataset, key: str, what: str) -> dict[str, dict[str, str]]:
    try:
        items = json.loads(data.attrs[key] if key == "brains" else data.attrs.get(key, "{}")).items()
        sources = {str(n): {"sha256": str(s["sha256"]), "source": str(s["source"])} for n, s in items}
        changed = [n for n, s in sources.items() if digest(s["source"]) != s["sha256"]]
    except (KeyError, TypeError, ValueError, AttributeError, RecursionError) as error:
        raise _unknown_origin(key, error) from None
    if changed:
        why = f"the source of the {what} {changed[0]!r} does not match its hash"
        raise ResultsError(why, key=key, value=changed[0])
    return sources


def _unknown_origin(key: str, error: Exception) -> ResultsError:
    why = f"no attribute {error}" if isinstance(error, KeyError) else f"{key} should be names with sha256 and source"
    return ResultsError(f"these results do not say how they were made (attributes study and {key}): {why}", key=key)
