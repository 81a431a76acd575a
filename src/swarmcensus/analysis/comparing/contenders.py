"""The worlds and contenders of a dataset, and the setting of each contender in each world.

A contender is a brain with its parameters, or a level of another factor. A world is everything else of a setting.
"""

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass
from types import MappingProxyType
from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from swarmcensus.results import parameters_in
from swarmcensus.studies import COORDINATES, NUMERIC, caption_form, idle_caption
from swarmcensus.summaries import (
    contender_names,
    is_idle,
    labels_in,
    renamed_contender,
    repeated_coordinates,
    value_text,
)
from swarmcensus.support.errors import InputError
from swarmcensus.support.formatting import counted, distinct_texts
from swarmcensus.support.hints import did_you_mean
from swarmcensus.support.options import in_shell, option, wrong_option

NONE = -1
BRAIN = "brain"
LIARS = {"liars", "adversary"}
REPEATED = {  # coordinates that say the same in other words
    "density": {"side"}, "side": {"density"}, "members": {"liars", "adversary"}, "liars": {"members"},
    "adversary": {"members"}, "fill_ratio_change": {"fill_ratio"}, "fill_ratio_spread": {"fill_ratio"},
}  # fmt: skip


@dataclass(frozen=True)
class Grid:
    """Worlds and contenders; `place` (world, contender) is the position of their setting, -1 if there is none."""

    worlds: list[dict[str, Any]]  # each world's coordinates that differ among worlds
    common: dict[str, Any]  # coordinates that all worlds share
    contenders: list[str]
    place: NDArray[np.intp]
    coordinates: dict[str, list[Any]]  # of each world, "" if idle; empty for what differs between its settings
    factor: tuple[str, ...] = ()  # the coordinates that contenders are levels of; empty: brains

    @property
    def head(self) -> str:
        """What contenders are, as the head of a column."""
        return ", ".join(self.factor) if self.factor else "contender"

    def spread(self, values: NDArray[Any]) -> NDArray[np.float64]:
        """Values of settings (setting, ...) as (world, contender, ...), NaN if there is no such setting."""
        there = (self.place != NONE).reshape(*self.place.shape, *(1,) * (values.ndim - 1))
        return np.where(there, values[self.place], np.nan)


def grid_of(
    data: xr.Dataset, whole: xr.Dataset, shown: Mapping[str, Collection[str]] = MappingProxyType({}),
    factor: Sequence[str] = (),
) -> tuple[Grid, list[str]]:  # fmt: skip
    """Worlds and contenders, both in the order of the settings, and cautions.

    `data` are some settings of `whole`, and brains have the names that they have in `whole`. `shown` names, by brain,
    parameters that appear in contenders' names even if all have the same value. Contenders are the levels of `factor`,
    by default brains with their parameters. Worlds with a single contender are left out. Raises InputError if nothing
    can be compared, or if two settings are the same contender in the same world.
    """
    factor = tuple(dict.fromkeys(factor))
    check_coordinates(data, factor)
    parameters = parameters_in(data)
    names = level_names(data, whole, factor, shown=shown)
    contenders = list(dict.fromkeys(names))
    if len(contenders) < 2:
        raise InputError(f"there is nothing to compare: all settings are of {contenders[0]}{_other_factors(data)}")
    columns = {name: data[name].values.tolist() for name in _of_worlds(data, parameters, factor)}
    if BRAIN in columns:
        columns[BRAIN] = level_names(data, whole, (BRAIN,), factor, shown)
    if {"assumed_accuracy", "accuracy"} <= data.coords.keys() and "assumed_accuracy" in columns:
        true = [str(text).split(" drift=")[0] for text in data["accuracy"].values.tolist()]
        if columns["assumed_accuracy"] == true:  # all robots know their sensors
            columns["assumed_accuracy"] = [""] * len(names)
    if LIARS & {*factor} and "members" in data.coords:  # members that are honest differ between worlds
        texts = [str(text).split("; ") for text in data["members"].values.tolist()]
        honest = ([part for part in several if not part.endswith("not honest")] for several in texts)
        columns["members"] = ["; ".join(several) for several in honest]
    if "members" in columns:
        columns["members"] = [value_text("members", text) for text in columns["members"]]
    kinds = {*columns.get("adversary", [])} - {""}
    if "liars" in factor and len(kinds) == 1:  # without liars all else is equal
        columns["adversary"] = [*kinds] * len(names)
    # texts, as values may be of several types, and NaN is not equal to itself
    keys = list(zip(*(map(repr, values) for values in columns.values()), strict=True)) or [()] * len(names)
    worlds = {key: k for k, key in enumerate(dict.fromkeys(keys))}
    places = {name: k for k, name in enumerate(contenders)}
    place = np.full((len(worlds), len(contenders)), NONE, np.intp)
    for setting, (key, name) in enumerate(zip(keys, names, strict=True)):
        at = worlds[key], places[name]
        if place[at] != NONE:
            first, second = data["setting"].values[[place[at], setting]].tolist()
            without = option("where", f"setting != {second}")
            both = f"settings {first} and {second} are both of {name} in the same world"
            raise InputError(f"{both}: leave one out, for example by {without}", key="setting", value=second)
        place[at] = setting
    has_pairs = (place != NONE).sum(axis=1) > 1
    if not has_pairs.any():
        names_of_all = f"{', '.join(contenders[:-1])} and {contenders[-1]}"
        others = _other_factors(data, factor)
        raise InputError(f"no two of {names_of_all} have met the same world: there are no pairs of trials{others}")
    cautions = _cautions(place, has_pairs, contenders)
    # whoever drops contenders after looking at their results makes fewer tests than were looked at
    unseen = len({*level_names(whole, whole, factor, shown=shown)} - {*contenders})
    if unseen:
        cautions.append(
            f"where leaves out {counted(unseen, 'contender')}: p-values are corrected for the others alone, which is "
            "valid only if they were chosen before looking at results"
        )
    kept = np.flatnonzero(has_pairs)
    seen = (place[kept] != NONE).any(axis=0)
    firsts = [next(s for s in place[w] if s != NONE) for w in kept]
    differing = [name for name in columns if len({repr(columns[name][s]) for s in firsts}) > 1]
    same = {name: values[firsts[0]] for name, values in columns.items() if name not in differing}
    common = {name: v for name, v in same.items() if v != "" or name not in ("assumed_accuracy", "members")}
    differing_worlds = [{name: columns[name][s] for name in differing} for s in firsts]
    there = [c for c, so in zip(contenders, seen, strict=True) if so]
    place = place[kept][:, seen]
    every = {name: data[name].values.tolist() for name in _along(data)} | columns
    coordinates: dict[str, list[Any]] = {}
    for name, values in every.items():
        distinct = [{repr(values[s]): values[s] for s in row if s != NONE} for row in place.tolist()]
        same_in_each = all(len(several) == 1 for several in distinct)
        coordinates[name] = ["" if is_idle(v) else v for [v] in map(dict.values, distinct)] if same_in_each else []
    return Grid(differing_worlds, common, there, place, coordinates, factor), cautions


def contender_index(name: str, contenders: list[str], whole: xr.Dataset) -> int:
    """The place of the contender with this name or label, or of the only contender of the brain with it."""
    if not isinstance(name, str):
        raise wrong_option("against", name, "should be the name of a contender")
    if name not in contenders:
        name = renamed_contender(name, labels_in(whole))
    levels = [contender for contender in contenders if contender.partition("=")[2] == name]
    matches = [contender for contender in contenders if contender.startswith(f"{name} ")]
    found = [name] if name in contenders else levels if len(levels) == 1 else matches
    if len(found) > 1:
        raise wrong_option("against", name, f"these are several, {', '.join(found)}: name one")
    if not found:
        raise wrong_option("against", name, f"{did_you_mean(name, contenders)}there are {', '.join(contenders)}")
    return contenders.index(found[0])


def factors_in(data: xr.Dataset) -> list[str]:
    """The coordinates in which settings differ, by which they can be compared.

    A parameter counts if settings of one brain differ in it.
    """
    along = [name for name in _along(data) if name not in repeated_coordinates(data)]
    parameters = {name: brain for brain, several in parameters_in(data).items() for name in several}

    def varies(name: str) -> bool:
        own = data["brain"].values == parameters[name] if name in parameters else slice(None)
        return len({repr(value) for value in data[name].values[own].tolist()}) > 1

    return [name for name in along if varies(name)]


def _other_factors(data: xr.Dataset, factor: Sequence[str] = ()) -> str:
    """A phrase with the factors, apart from `factor`, by which these settings can be compared."""
    names = [name for name in factors_in(data) if name not in factor]
    if not names:
        return ""
    how = option("factor", names[0]) if in_shell() else f"factor={names[0]!r}"
    return f". They differ in {', '.join(names)}: choose what to compare, as {how}"


def _along(data: xr.Dataset) -> list[str]:
    """The coordinates of settings."""
    return [str(k) for k, c in data.coords.items() if c.dims == ("setting",) and k not in ("setting", *NUMERIC)]


def check_coordinates(data: xr.Dataset, names: Sequence[str], option: str = "factor") -> None:
    """Raise InputError unless these names, given as an option, are coordinates in which settings differ."""
    for name in names:
        known, there = _along(data), ", ".join(factors_in(data)) or "nothing"
        if name in NUMERIC:
            raise wrong_option(option, name, "it follows from accuracy: name that")
        if name not in known:
            raise wrong_option(option, name, f"{did_you_mean(name, known)}settings differ in {there}")
        values = {repr(value) for value in data[name].values.tolist()}
        if len(values) < 2:
            raise wrong_option(option, name, f"all settings have the same, {values.pop()}; they differ in {there}")


def _of_worlds(data: xr.Dataset, parameters: Mapping[str, list[str]], factor: Sequence[str]) -> list[str]:
    """The coordinates that tell worlds apart: all but the factor, and what follows from it or from others."""
    repeated: set[str] = set().union(*(REPEATED.get(name, set()) for name in factor))
    left_out = {*factor, *repeated}
    left_out |= {name for name in repeated_coordinates(data) if not REPEATED.get(name, set()) & {*factor, *repeated}}
    left_out |= {name for several in parameters.values() for name in several}  # parts of brains' names
    left_out |= {BRAIN} if not factor else set()
    left_out |= _of_topologies(data) if "topology" in factor else set()
    return [name for name in _along(data) if name not in left_out]


def _of_topologies(data: xr.Dataset) -> set[str]:
    """Coordinates of robots that move, or of networks, with one value for each topology, which then implies it."""
    topologies = data["topology"].values.tolist()
    found = set()
    for name in _along(data):
        pairs = {*zip(topologies, map(repr, data[name].values.tolist()), strict=True)}
        is_of_some = name in COORDINATES and COORDINATES[name].world not in (None, "any")
        if is_of_some and len(pairs) == len({*topologies}):
            found.add(name)
    return found


def level_names(
    data: xr.Dataset, whole: xr.Dataset, factor: Sequence[str], apart_from: Collection[str] = (),
    shown: Mapping[str, Collection[str]] = MappingProxyType({}),
) -> list[str]:  # fmt: skip
    """The name of each setting's level of a factor; brains are named without parameters in it, or in `apart_from`."""
    parts = [_levels(data, name) for name in factor if name != BRAIN]
    if not factor or BRAIN in factor:
        left_out = {*factor, *apart_from}
        own = {brain: [n for n in several if n not in left_out] for brain, several in parameters_in(data).items()}
        labels, names = labels_in(whole), contender_names(whole, own, shown)
        name_of = dict(zip(whole["setting"].values.tolist(), names, strict=True))
        parts.insert(0, [renamed_contender(name_of[n], labels) for n in data["setting"].values.tolist()])
    return [", ".join(several) for several in zip(*parts, strict=True)]


def _levels(data: xr.Dataset, name: str) -> list[str]:
    """The level of each setting: its value, with the coordinate's name unless the value speaks for itself."""
    values = data[name].values.tolist()
    distinct = [value for value in dict.fromkeys(values) if not (isinstance(value, int) or is_idle(value))]
    texts = dict(zip(distinct, distinct_texts(distinct), strict=True))
    plain = caption_form(name) == "{}"
    none = idle_caption(name) or f"no {name}"
    return [none if is_idle(value) else f"{'' if plain else f'{name}='}{texts.get(value, value)}" for value in values]


def _cautions(place: NDArray[np.intp], met: NDArray[np.bool_], contenders: list[str]) -> list[str]:
    cautions = []
    if alone := int((~met).sum()):
        have, are = ("world has", "is") if alone == 1 else ("worlds have", "are")
        cautions.append(f"{alone} {have} only one contender, and {are} left out")
    lacking = (place[met] == NONE).sum(axis=0)
    for name, count in zip(contenders, lacking.tolist(), strict=True):
        if count:
            overall = "the overall comparison uses only worlds that all contenders have met"
            some = f"not in {count} of {counted(int(met.sum()), 'world')}: it is compared in the others, and {overall}"
            cautions.append(f"{name} is {'in no world with another contender' if count == met.sum() else some}")
    return cautions
