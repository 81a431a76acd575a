"""The worlds and contenders of a dataset, and the setting of each contender in each world.

A contender is a brain with its parameters. A world is everything else of a setting.
"""

from collections.abc import Collection, Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from swarmcensus.results import labels_in, parameters_in, restated
from swarmcensus.studies import NUMERIC
from swarmcensus.support.errors import InputError
from swarmcensus.support.formatting import counted, distinct_texts
from swarmcensus.support.options import option

NONE = -1


@dataclass(frozen=True)
class Grid:
    """Worlds and contenders; `place` (world, contender) is the position of their setting, -1 if there is none."""

    worlds: list[dict[str, Any]]  # each world's coordinates that differ among worlds
    common: dict[str, Any]  # coordinates that all worlds share
    contenders: list[str]
    place: NDArray[np.intp]

    def spread(self, values: NDArray[Any]) -> NDArray[np.float64]:
        """Values of settings (setting, ...) as (world, contender, ...), NaN if there is no such setting."""
        there = (self.place != NONE).reshape(*self.place.shape, *(1,) * (values.ndim - 1))
        return np.where(there, values[self.place], np.nan)


def grid_of(
    data: xr.Dataset, whole: xr.Dataset, shown: Mapping[str, Collection[str]] = MappingProxyType({})
) -> tuple[Grid, list[str]]:
    """Worlds and contenders, both in the order of the settings, and cautions.

    `data` are some settings of `whole`, and contenders have the names that they have in `whole`. `shown` names, by
    brain, parameters that appear in contenders' names even if all have the same value. Worlds with a single contender
    are left out. Raises InputError if nothing can be compared, or if two settings are the same contender in the same
    world.
    """
    parameters = parameters_in(data)
    name_of = dict(zip(whole["setting"].values.tolist(), _contender_names(whole, parameters, shown), strict=True))
    names = [name_of[setting] for setting in data["setting"].values.tolist()]
    contenders = list(dict.fromkeys(names))
    if len(contenders) < 2:
        raise InputError(
            f"there is nothing to compare: all settings are of {contenders[0]}, and it takes two brains, or two values "
            "of a brain's parameter"
        )
    left_out = {"setting", "brain", *(name for several in parameters.values() for name in several)}
    left_out |= restated(data) | NUMERIC.keys()
    coordinates = [str(k) for k, c in data.coords.items() if c.dims == ("setting",) and k not in left_out]
    columns = {name: data[name].values.tolist() for name in coordinates}
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
        raise InputError(f"no two of {names_of_all} have met the same world: there are no pairs of trials")
    cautions = _cautions(place, has_pairs, contenders)
    others = len({*name_of.values()}) - len(contenders)
    if others:
        cautions.append(
            f"where leaves out {counted(others, 'contender')}: p-values are corrected for the others alone, which is "
            "valid only if they were chosen before looking at results"
        )
    kept = np.flatnonzero(has_pairs)
    seen = (place[kept] != NONE).any(axis=0)
    firsts = [next(s for s in place[w] if s != NONE) for w in kept]
    differing = [name for name in coordinates if len({repr(columns[name][s]) for s in firsts}) > 1]
    common = {name: columns[name][firsts[0]] for name in coordinates if name not in differing}
    if {"assumed_accuracy", "accuracy"} <= columns.keys() and all(
        columns["assumed_accuracy"][s] == columns["accuracy"][s] for s in firsts
    ):  # robots that know their sensors assume the true accuracy
        differing = [name for name in differing if name != "assumed_accuracy"]
        common.pop("assumed_accuracy", None)
    differing_worlds = [{name: columns[name][s] for name in differing} for s in firsts]
    return Grid(
        differing_worlds, common, [c for c, so in zip(contenders, seen, strict=True) if so], place[kept][:, seen]
    ), cautions


def _contender_names(
    data: xr.Dataset, parameters: dict[str, list[str]], shown: Mapping[str, Collection[str]]
) -> list[str]:
    """The name of each setting's contender: its brain, and its parameters that vary or are to be shown."""
    brains = data["brain"].values.tolist()
    labels = labels_in(data)
    names = [labels.get(str(name), str(name)) for name in brains]
    for brain, several in parameters.items():
        rows = [k for k, name in enumerate(brains) if name == brain]
        for name in several:
            values = data[name].values[rows].tolist()
            if len(set(map(repr, values))) > 1 or name in shown.get(brain, ()):
                distinct = list(dict.fromkeys(values))
                text = dict(zip(distinct, distinct_texts(distinct), strict=True))
                for k, value in zip(rows, values, strict=True):
                    names[k] += f" {name}={text.get(value, value)}"
    return names


def _cautions(place: NDArray[np.intp], met: NDArray[np.bool_], contenders: list[str]) -> list[str]:
    cautions = []
    if not met.all():
        alone = int((~met).sum())
        verb = "world has" if alone == 1 else "worlds have"
        cautions.append(f"{alone} {verb} only one contender, and {'is' if alone == 1 else 'are'} left out")
    lacking = (place[met] == NONE).sum(axis=0)
    for name, count in zip(contenders, lacking.tolist(), strict=True):
        if count:
            where = "in no world with another contender" if count == met.sum() else (
                f"not in {count} of {counted(int(met.sum()), 'world')}: it is compared in the others, and the "
                "overall comparison uses only worlds that all contenders have met"
            )  # fmt: skip
            cautions.append(f"{name} is {where}")
    return cautions
