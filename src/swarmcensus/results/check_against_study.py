"""Everything in results except the values of trials, compared with the studies that they name.

The expected content is made by the code that writes it: a dataset of the same studies before any trial is run.
"""

import functools
import json
from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from swarmcensus.results.store import column_of, dataset, filled, widths_of_rule
from swarmcensus.results.structure import BRAIN_FACTS, failed_pairs, finished_trials
from swarmcensus.results.values import (
    AGREEMENT,
    NETWORKS,
    Values,
    additions_in,
    changed_plugin,
    is_missing,
    metrics_in,
    same_bits,
)
from swarmcensus.studies import Member, Setting, Study, addresses
from swarmcensus.support.errors import InputError
from swarmcensus.support.formatting import counted
from swarmcensus.support.version import __version__
from swarmcensus.worlds import Floor, Topology

MAKERS = ("swarmcensus_version", "python_version", "library_versions", "machine", "processor")  # what made the numbers
SOURCES = ("brains", "adversaries", "plugin_files", "metrics", "merged", "parameters", "accuracies")  # in JSON
UNCHECKABLE = (  # attributes that cannot be checked, and why
    (("python_version", "library_versions", "machine", "processor", "device"), "only whoever made the file knows them"),
    (("started", "finished", "wall_seconds", "cpu_seconds"), "only whoever made the file knows them"),
    (("study", "merged"), "blanks and comments; what the study says is compared"),
    (("share",), "trials of other parts may be there from before"),
    (("failed",), "the messages; trials that failed must fail again"),
    (("additions",), "the versions of other packages; their files are compared"),
)
BOOKKEEPING = (
    "how a file lays out what is compared: byte order, _FillValue, free space, and what netCDF and HDF5 note for "
    "themselves"
)


def outline(studies: Sequence[Study], merged: bool) -> xr.Dataset:
    """The dataset of one study, or of several merged ones, before any trial is run.

    Settings are in the order in which they first appear. Raises InputError if one name stands for two brains, metrics,
    edge lists or images.
    """
    parts = []
    for study in studies:
        marked = settings_of(study)
        settings = list(marked.values())
        parts.append(dataset(study, settings, list(marked), Values(study, settings, 0)))
        if study.until and not merged:
            parts[-1]["half_width"] = widths_of_rule(study, np.full(len(settings), np.nan))
    first = parts[0]
    if len(parts) > 1:
        _check_labels(studies)
        first = _together(parts)
        first.attrs["title"] = " + ".join(dict.fromkeys(study.name for study in studies))
    if merged:
        first.attrs["merged"] = json.dumps([study.text for study in studies])
    return first


def _check_labels(studies: Sequence[Study]) -> None:
    """Raise InputError if two topologies, floors or tables of members would have one label."""
    for key, what in (("topology", "topologies"), ("floor", "floors")):
        known: dict[str, Topology | Floor] = {}
        for one in (one for study in studies for one in getattr(study, what)):
            other = known.setdefault(one.title, one)
            if other != one and (other.label or one.label):
                raise InputError.named(key, one.title, f"the label of two {what}, {other.name} and {one.name}")
    members: dict[str, Member] = {}
    for member in (m for study in studies for setting in settings_of(study).values() for m in setting.members):
        if members.setdefault(str(member), member) != member:
            raise InputError.named("members", str(member), "the label of members that differ in the studies")


@functools.lru_cache(maxsize=8)
def settings_of(study: Study) -> dict[str, Setting]:
    """A study's settings by their fingerprints, in order."""
    return {addresses.fingerprint(setting, study.seed): setting for setting in study.settings()}


def _together(parts: Sequence[xr.Dataset]) -> xr.Dataset:
    marks = np.concatenate([part["fingerprint"].values for part in parts])
    kept = np.sort(np.unique(marks, return_index=True)[1])
    checkpoints = np.unique(np.concatenate([part["checkpoint"].values for part in parts]))
    robots = max(part.sizes["robot"] for part in parts)
    sizes = {"setting": kept.size, "trial": 0, "robot": robots, "checkpoint": checkpoints.size}
    coordinates: dict[Any, Any] = {name: np.arange(n) for name, n in sizes.items()}
    coordinates["checkpoint"] = ("checkpoint", checkpoints, parts[0]["checkpoint"].attrs)
    variables: dict[Any, Any] = {}
    for name, variable in (item for part in parts for item in part.variables.items()):
        if name in sizes:
            continue
        if "trial" in variable.dims:
            shape = [sizes[str(d)] for d in variable.dims]
            variables[name] = (variable.dims, np.zeros(shape, variable.dtype), variable.attrs, variable.encoding)
        elif variable.dims == ("setting",):
            values: list[Any] = []
            for part in parts:  # some of which may lack it: without liars, all robots are honest
                blank = part["robots"].values.tolist() if name == "honest" else [None] * part.sizes["setting"]
                values += part[name].values.tolist() if name in part.variables else blank
            column = column_of(filled(values, str(name)))
            is_coordinate = any(name in part.coords for part in parts)
            (coordinates if is_coordinate else variables)[name] = ("setting", column[kept], variable.attrs)
        elif name in variables and not variable.equals(variables[name]):  # type: ignore[no-untyped-call]
            raise InputError(f"two of the studies have two different {name}", key=str(name))
        else:
            variables[name] = variable
    keys = ("brains", "adversaries", "plugin_files", "metrics", "additions", "parameters", "accuracies")
    sources = {key: text for key in keys if (text := _sources(parts, key)) is not None}
    return xr.Dataset(variables, coordinates, parts[0].attrs | sources)


def _sources(parts: Sequence[xr.Dataset], key: str) -> str | None:
    """What all parts name under an attribute in JSON, such as "brains"; files of one name must be equal."""
    known: dict[str, Any] = {}
    for name, value in (item for part in parts for item in json.loads(part.attrs.get(key, "{}")).items()):
        if isinstance(value, dict) and known.get(name, value)["sha256"] != value["sha256"]:
            raise InputError(f"two of the studies name two different {key} {name!r}", key=key, value=name)
        known[name] = value
    return json.dumps(known, sort_keys=key not in ("metrics", "additions")) if known else None


def differences_from_study(data: xr.Dataset, studies: Sequence[Study], *, whole: bool = True) -> list[str]:
    """The differences between results and the studies that they name, as sentences.

    With whole=False, results may be a selection of settings and trials.
    """
    want = outline(studies, "merged" in data.attrs)
    size = _size(data, studies, want) if whole else ()
    trials = _trials(data, studies, "merged" in data.attrs)
    changed = (sentence for study in studies if (sentence := changed_plugin(data, study)))
    return [*changed, *_names(data, want), *_settings(data, want), *_rest(data, want), *trials, *size]


def uncheckable(data: xr.Dataset) -> list[str]:
    """What in a dataset cannot be checked, and why, as phrases."""
    present = [([name for name in names if name in data.attrs], why) for names, why in UNCHECKABLE]
    return [*(f"{', '.join(names)}: {why}" for names, why in present if names), BOOKKEEPING]


def _names(data: xr.Dataset, want: xr.Dataset) -> Iterator[str]:
    """Differences in the names of variables and coordinates."""
    stored, expected = ({str(name) for name in dataset.variables} for dataset in (data, want))
    for name in sorted(stored - expected):
        yield f"{name} is in the file, and no run of its study writes it"
    for name in sorted(expected - stored - {*AGREEMENT, *NETWORKS}):
        yield f"{name} is not in the file"
    for name in sorted(stored & expected):
        if (name in data.coords) != (name in want.coords):
            yield f"{name} should be a {'coordinate' if name in want.coords else 'variable, and no coordinate'}"


def _settings(data: xr.Dataset, want: xr.Dataset) -> Iterator[str]:
    """Differences in the settings, found by their fingerprints: numbers and coordinates."""
    places = {mark: k for k, mark in enumerate(want.variables["fingerprint"].values.tolist())}
    numbers = data.variables["setting"].values
    place = np.array([places.get(mark, -1) for mark in data.variables["fingerprint"].values.tolist()])
    for number in numbers[place < 0][:1]:
        yield f"setting {number} is not of the study that these results name ({(place < 0).sum()} of them are not)"
    known = np.flatnonzero(place >= 0)
    coordinates = (k for k, v in want.coords.items() if v.dims == ("setting",) and k != "setting")
    for name in ("setting", *coordinates, *BRAIN_FACTS, "honest"):
        if name not in data or data.variables[name].dims != ("setting",):
            continue
        stored, expected = data.variables[name].values[known], want.variables[name].values[place[known]]
        wrong = np.flatnonzero(~same_bits(stored, expected))
        if wrong.size:
            k = wrong[0]
            more = f" ({counted(wrong.size, 'setting')} differ)" if wrong.size > 1 else ""
            both = f"{_plain(stored[k])!r} in the file and {_plain(expected[k])!r} by its study"
            yield f"setting {numbers[known[k]]}: {name} is {both}{more}"


def _rest(data: xr.Dataset, want: xr.Dataset) -> Iterator[str]:
    """Differences in other variables, in attributes of variables, and in attributes of the dataset."""
    ours = data.attrs["swarmcensus_version"] == __version__  # then every text must be equal
    for name, expected in want.variables.items():
        if name not in data.variables:
            continue
        stored = data.variables[name]
        if stored.dims != expected.dims:
            dims, expected_dims = (", ".join(map(str, each.dims)) for each in (stored, expected))
            yield f"{name} has the dimensions {dims}, not {expected_dims}"
        elif name != "trial" and not {"trial", "setting"} & {*expected.dims} and not _alike(stored, expected):
            yield f"{name} is not what its study says"
        elif stored.dtype != expected.dtype and expected.dtype.kind != "O":
            yield f"{name} is {stored.dtype} in the file, and should be {expected.dtype}"
        for key in sorted({*stored.attrs, *expected.attrs} if ours else {"units"} & {*stored.attrs, *expected.attrs}):
            in_file, by_study = stored.attrs.get(key), expected.attrs.get(key)
            if not _same(in_file, by_study):
                yield f"{name}: {key} is {in_file!r} in the file, and should be {by_study!r}"
    for key in sorted({*want.attrs} - {*MAKERS, "format", "additions"}):
        in_file, by_study = data.attrs.get(key), want.attrs[key]
        if key in SOURCES and key in data.attrs and not ours:
            in_file, by_study = json.loads(data.attrs[key]), json.loads(want.attrs[key])
        if not _same(in_file, by_study):
            yield f"the attribute {key} is {_short(in_file)} in the file and {_short(by_study)} by its study"
    # additions of other packages, as far as these are installed here
    named_in_file, known = additions_in(data), json.loads(want.attrs.get("additions", "{}"))
    named = {"brain": "brains", "adversary": "adversaries", "metric": "metrics"}
    sources = {f"{what} {name}" for what, key in named.items() for name in json.loads(want.attrs.get(key, "{}"))}
    for name in sorted({*named_in_file, *known} - (sources - {*known})):
        in_file, by_study = (each.get(name, {}).get("package", "no package") for each in (named_in_file, known))
        if in_file != by_study:
            yield f"the attribute additions says that the {name} is of {in_file}, and by its study it is of {by_study}"


def _trials(data: xr.Dataset, studies: Sequence[Study], merged: bool) -> Iterator[str]:
    """Trials that no study asks for, and, in merged results, trials that lack something that their study measures."""
    checkpoints, trials, done = (
        data.variables["checkpoint"].values,
        data.variables["trial"].values,
        finished_trials(data),
    )
    wanted: dict[str, list[tuple[int, NDArray[np.bool_]]]] = {}
    for study in studies:
        looked = np.isin(checkpoints, study.checkpoints)
        for mark, setting in settings_of(study).items():
            ours = looked & (checkpoints <= setting.rounds)
            watched = np.isin(list(metrics_in(data)), [metric.variable for metric in study.measure.metrics])
            needs = np.array([*ours, *(ours & study.measure.estimates), study.measure.local, *watched])
            wanted.setdefault(mark, []).append((study.trials, needs))
    for k, mark in enumerate(data.variables["fingerprint"].values.tolist()):
        if mark not in wanted:
            continue
        number, there = data.variables["setting"].values[k], trials[done[k]]
        most = max(trials for trials, _ in wanted[mark])
        if there.size and there[-1] >= most:
            yield f"setting {number}: trial {there[-1]} is in the file, and its study asks for {most}"
        elif merged:
            measured = _measured(data, k)[done[k]]
            made = np.zeros_like(measured)
            for most, needs in wanted[mark]:
                made |= needs & ((there < most) & (measured >= needs).all(axis=1))[:, np.newaxis]
            for trial in there[(measured != made).any(axis=1) | ~made.any(axis=1)][:1]:
                yield f"setting {number}, trial {trial}: some of what its study measures is missing"


def _measured(data: xr.Dataset, k: int) -> NDArray[np.bool_]:
    """What the trials of a setting have, (trial, what).

    The second axis is decisions and estimates at each checkpoint, then local estimates, then metric files.
    """
    decisions = ~is_missing(data.variables["correct"].values[k].T)
    nothing = np.zeros_like(decisions)
    estimates = ~is_missing(data.variables["estimates"].values[k, :, :, 0].T) if "estimates" in data else nothing
    firsts = {name: data.variables[name].values[k].reshape(len(nothing), -1)[:, :1] for name in metrics_in(data)}
    name = "local_convergence_step"
    local = ~is_missing(data.variables[name].values[k, :, :1]) if name in data else nothing[:, :1]
    return np.hstack([decisions, estimates, local, *(~is_missing(first) for first in firsts.values())])


def _size(data: xr.Dataset, studies: Sequence[Study], want: xr.Dataset) -> Iterator[str]:
    """Settings and trials that a complete run would have."""
    lacking = want.sizes["setting"] - data.sizes["setting"]
    if lacking > 0:
        yield f"{lacking} of the {counted(want.sizes['setting'], 'setting')} of its study are not in the file"
    trials = data.variables["trial"].values
    most = max(study.trials for study in studies)
    ruled = any(study.until for study in studies)
    if not np.array_equal(trials, np.arange(trials.size)) or trials.size > most or (trials.size < most and not ruled):
        yield f"trial should number the {counted(most, 'trial')} of each setting"
    stored, total = int(data.attrs["trials_done"]) + len(failed_pairs(data)), int(data.attrs["trials_total"])
    planned = sum(most_trials(studies, want))
    if total != planned and not (ruled and stored <= total <= planned):
        yield f"the attribute trials_total is {total} in the file and {planned} by its study"


def most_trials(studies: Sequence[Study], want: xr.Dataset) -> list[int]:
    """The largest number of trials that the studies ask for, by setting of their outline."""
    most = dict.fromkeys(want.variables["fingerprint"].values.tolist(), 0)
    for study in studies:
        for mark in settings_of(study):
            most[mark] = max(most[mark], study.trials)
    return list(most.values())


def _alike(first: xr.Variable, second: xr.Variable) -> bool:
    same = first.dtype.kind == second.dtype.kind and first.shape == second.shape
    return same and bool(same_bits(first.values, second.values).all())


def _same(first: Any, second: Any) -> bool:
    """Whether two attributes are equal and of one type; a file returns Python's numbers as NumPy's."""
    first, second = _plain(first), _plain(second)
    return type(first) is type(second) and bool(np.all(first == second))


def _plain(value: Any) -> Any:
    return value.item() if isinstance(value, np.generic) else value


def _short(value: Any) -> str:
    text = repr(_plain(value))
    return text if len(text) <= 60 else f"{text[:57]}..."
