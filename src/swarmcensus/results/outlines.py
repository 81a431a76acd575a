"""Files made again from their studies: everything but the values of trials, and what may differ.

It is made by the code that writes results: a dataset of the same studies before any trial is run.
"""

import functools
import json
from collections.abc import Callable, Iterator, Sequence
from typing import Any, NamedTuple

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from swarmcensus.results.schema import INDICES
from swarmcensus.results.store import dataset, widths_of_rule
from swarmcensus.results.values import Values, changed_plugin, kinds_in, missing_value, same_bits
from swarmcensus.studies import Member, Setting, Study, addresses
from swarmcensus.support.errors import InputError
from swarmcensus.support.formatting import counted, short_repr
from swarmcensus.worlds import Floor, Topology


class Allowed(NamedTuple):
    """Something that may differ between a file and the same made again."""

    names: tuple[str, ...]  # of attributes, or what else it is
    why: str
    only_with: str = ""  # an attribute without which it may not


MAY_DIFFER = (
    Allowed(("swarmcensus_version", "python_version", "library_versions"), "only whoever made the file knows them"),
    Allowed(("machine", "processor", "device"), "only whoever made the file knows them"),
    Allowed(("started", "finished", "wall_seconds", "cpu_seconds"), "only whoever made the file knows them"),
    Allowed(("share",), "trials of other parts may be there from before"),
    Allowed(("failed",), "the messages; trials that failed must fail again"),
    Allowed(("additions",), "the versions of other packages; their files are compared"),
    Allowed(("trials_done", "trials_total"), "runs are cut off, and rules end when they hold; what is there must fit"),
    Allowed(("measures of a trial",), "they must be all of one of the merged studies", only_with="merged"),
    Allowed(("numbers of a card",), "those of exp, log and lgamma may be off as between machines", only_with="device"),
)


def outline(studies: Sequence[Study], merged: bool, trials: int = 0) -> xr.Dataset:
    """The dataset of one study, or of several merged ones, before any of so many trials of each setting is run.

    Settings are in the order in which they first appear. Raises InputError if one name stands for two brains, metrics,
    edge lists, images, or for two topologies, floors or tables of members.
    """
    marked: dict[str, Setting] = {}
    for mark, setting in (item for study in studies for item in settings_of(study).items()):
        marked.setdefault(mark, setting)
    settings = list(marked.values())
    if len(studies) > 1:
        _check_labels(studies)
    data = dataset(studies, settings, list(marked), Values(studies, settings, trials))
    if merged:
        data.attrs["merged"] = json.dumps([study.text for study in studies])
    elif studies[0].until:
        data["half_width"] = widths_of_rule(studies[0], np.full(len(settings), np.nan))
    return data


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


def laid_out(data: xr.Dataset, want: xr.Dataset) -> xr.Dataset:
    """The measurements of results in the order and the sizes of an outline; what that has no place for is left out."""
    place = _places(data, want)
    first = np.unique(place, return_index=True)[1]
    first = first[place[first] >= 0]
    names = [name for name in (*kinds_in(want), "half_width") if name in data and name in want]
    kept = data[names].isel(setting=first).assign_coords(setting=place[first]).drop_duplicates(INDICES[1:])
    missing = {name: one.dtype.type(missing_value(one.dtype)) for name, one in kept.data_vars.items()}
    kept = kept.reindex({name: want[name] for name in INDICES}, fill_value=missing, copy=False)
    settings = {name: want[name] for name in ("robots", "honest", "fingerprint") if name in want}
    return kept.assign(settings)


def _places(data: xr.Dataset, want: xr.Dataset) -> NDArray[np.intp]:
    """The places of the settings of results in an outline, by their fingerprints; -1 if it has none."""
    places = {mark: k for k, mark in enumerate(want.variables["fingerprint"].values.tolist())}
    return np.array([places.get(mark, -1) for mark in data.variables["fingerprint"].values.tolist()], np.intp)


def positions(whole: xr.Dataset, part: xr.Dataset, rows: NDArray[np.intp]) -> Callable[[Sequence[str]], Any]:
    """A function that gives the indices of a part in the arrays of a whole, by their dimensions.

    `rows` are the places of its settings.
    """
    checkpoints = np.searchsorted(whole["checkpoint"].values, part["checkpoint"].values)
    at = {"setting": rows, "trial": part["trial"].values, "checkpoint": checkpoints, "robot": part["robot"].values}
    return lambda dims: np.ix_(*(at[dim] for dim in dims))


def most_trials(studies: Sequence[Study]) -> dict[str, int]:
    """The largest number of trials that the studies ask for, by the fingerprint of a setting."""
    ordered = sorted(studies, key=lambda study: study.trials)
    return {mark: study.trials for study in ordered for mark in settings_of(study)}


def differences(data: xr.Dataset, want: xr.Dataset, studies: Sequence[Study], *, whole: bool = True) -> list[str]:
    """The differences between results and the outline of their studies, as sentences.

    With whole=False, results may be a selection of settings and trials, and have attributes of their own.
    """
    place = _places(data, want)
    unknown, lacking = data.variables["setting"].values[place < 0], want.sizes["setting"] - np.unique(place).size
    found = [sentence for study in studies if (sentence := changed_plugin(data, study))]
    if unknown.size:
        many = f"{unknown.size} of them are not"
        found.append(f"setting {unknown[0]} is not of the study that these results name ({many})")
    if np.unique(place[place >= 0]).size < (place >= 0).sum():
        found.append("a setting is in the file more than once")
    if whole and lacking > 0:
        found.append(f"{lacking} of the {counted(want.sizes['setting'], 'setting')} of its study are not in the file")
    known, made = data.isel(setting=place >= 0), want.isel(setting=place[place >= 0])
    for name in sorted({*map(str, data.variables)} | {*map(str, want.variables)}):
        if name not in want.variables:
            found.append(f"{name} is in the file, and no run of its study writes it")
        elif name not in data.variables:
            found.append(f"{name} is not in the file")
        else:
            found += _of_variable(known, made, name)
    allowed = {name for one in MAY_DIFFER for name in one.names}
    for key in sorted({*want.attrs, *(data.attrs if whole else ())} - allowed):
        in_file, by_study = _plain(data.attrs.get(key)), _plain(want.attrs.get(key))
        if not _same(in_file, by_study):
            two = f"{short_repr(in_file)} in the file and {short_repr(by_study)} by its study"
            found.append(f"the attribute {key} is {two}")
    return found


def _of_variable(data: xr.Dataset, want: xr.Dataset, name: str) -> Iterator[str]:
    """Differences in a variable of the same settings in the same order, as sentences."""
    stored, made = data.variables[name], want.variables[name]
    if (name in data.coords) != (name in want.coords):
        yield f"{name} should be a {'coordinate' if name in want.coords else 'variable, and no coordinate'}"
    if stored.dims != made.dims:
        yield f"{name} has the dimensions {', '.join(map(str, stored.dims))}, not {', '.join(map(str, made.dims))}"
        return
    if stored.dtype != made.dtype and made.dtype.kind != "O":
        yield f"{name} is {stored.dtype} in the file, and should be {made.dtype}"
    said = sorted({*stored.attrs, *made.attrs})
    for key in (key for key in said if not _same(stored.attrs.get(key), made.attrs.get(key))):
        yield f"{name}: {key} is {stored.attrs.get(key)!r} in the file, and should be {made.attrs.get(key)!r}"
    if "trial" in made.dims or name == "half_width":  # which depend on trials
        return
    if stored.shape != made.shape:
        yield f"{name} has {stored.shape} values in the file, and should have {made.shape}"
        return
    wrong = np.argwhere(~same_bits(stored.values, made.values))
    if wrong.size:
        at = tuple(wrong[0])
        where = f"setting {data.variables['setting'].values[at[0]]}: " if made.dims == ("setting",) else ""
        both = f"{_plain(stored.values[at])!r} in the file and {_plain(made.values[at])!r} by its study"
        more = f" ({len(wrong):,} values differ)" if len(wrong) > 1 else ""
        yield f"{where}{name} is {both}{more}"


def _same(first: Any, second: Any) -> bool:
    """Whether two attributes are equal and of one type; a file returns Python's numbers as NumPy's."""
    first, second = _plain(first), _plain(second)
    return type(first) is type(second) and bool(np.all(first == second))


def _plain(value: Any) -> Any:
    return value.item() if isinstance(value, np.generic) else value
