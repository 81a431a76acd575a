"""Who met whom: the worlds of a dataset, the contenders in them, and which setting is of which of both.

A world is all that settings are but the brain and its parameters. A contender is a brain with its parameters.
"""

import json
from collections.abc import Collection, Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from swarmcensus.basics.errors import InputError
from swarmcensus.basics.formatting import counted, told_apart
from swarmcensus.basics.options import option
from swarmcensus.results.summaries import restated

NONE = -1


@dataclass(frozen=True)
class Field:
    """Worlds and contenders; `place` (world, contender) is the position of the setting of both, -1 where none is."""

    worlds: list[dict[str, Any]]  # the coordinates of each that differ among worlds
    common: dict[str, Any]  # and those that all have
    contenders: list[str]
    place: NDArray[np.intp]

    def spread(self, values: NDArray[Any]) -> NDArray[np.float64]:
        """What settings have, (setting, ...), as (world, contender, ...): NaN where there is no such setting."""
        there = (self.place != NONE).reshape(*self.place.shape, *(1,) * (values.ndim - 1))
        return np.where(there, values[self.place], np.nan)


def parameters_in(data: xr.Dataset) -> dict[str, list[str]]:
    """The names of each brain's parameters, which are coordinates. Raises InputError where that is not legible."""
    text = data.attrs.get("parameters", "{}")
    try:
        found = {str(brain): [str(name) for name in names] for brain, names in json.loads(text).items()}
    except (ValueError, TypeError, AttributeError) as error:
        raise InputError(f"the attribute parameters names no parameters of brains: {str(text)[:60]!r}") from error
    for brain, names in found.items():
        for name in names:
            if name not in data.coords or data[name].dims != ("setting",):
                raise InputError(f"these results have no coordinate {name}, the parameter of {brain}")
    return found


def field_of(
    data: xr.Dataset, whole: xr.Dataset, shown: Mapping[str, Collection[str]] = MappingProxyType({})
) -> tuple[Field, list[str]]:
    """Worlds, in the order of the settings, contenders likewise, and cautions.

    `whole` are the results that `data` are some settings of: contenders are called as in them. `shown` names, brain by
    brain, parameters that names of contenders have even where all have the same value. Worlds that only one contender
    has been in are left out. Raises InputError where nothing can be compared, and where
    two settings are the same contender in the same world.
    """
    parameters = parameters_in(data)
    called = dict(zip(whole["setting"].values.tolist(), _named(whole, parameters, shown), strict=True))
    names = [called[setting] for setting in data["setting"].values.tolist()]
    contenders = list(dict.fromkeys(names))
    if len(contenders) < 2:
        raise InputError(
            f"there is nothing to compare: all settings are of {contenders[0]}, and it takes two brains, or two values "
            "of a brain's parameter"
        )
    left_out = {"setting", "brain", *(name for several in parameters.values() for name in several)}
    left_out |= restated(data)
    coordinates = [str(k) for k, c in data.coords.items() if c.dims == ("setting",) and k not in left_out]
    columns = {name: data[name].values.tolist() for name in coordinates}
    keys = list(zip(*(map(repr, values) for values in columns.values()), strict=True)) or [()] * len(names)
    worlds = {key: k for k, key in enumerate(dict.fromkeys(keys))}
    places = {name: k for k, name in enumerate(contenders)}
    place = np.full((len(worlds), len(contenders)), NONE, np.intp)
    for setting, (key, name) in enumerate(zip(keys, names, strict=True)):
        at = worlds[key], places[name]
        if place[at] != NONE:
            one, other = data["setting"].values[[place[at], setting]].tolist()
            raise InputError(
                f"settings {one} and {other} are both of {name} in the same world, by all coordinates that they have: "
                f"leave one out, as {option('where', f'setting != {other}')}"
            )
        place[at] = setting
    met = (place != NONE).sum(axis=1) > 1
    if not met.any():
        raise InputError(f"no two of {_listed(contenders)} have met the same world: there are no pairs of trials")
    cautions = _cautions(place, met, contenders)
    others = len({*called.values()}) - len(contenders)
    if others:
        cautions.append(
            f"where leaves out {counted(others, 'contender')}: the correction is for those that are left, and "
            "holds if they were chosen before anybody looked at results"
        )
    kept = np.flatnonzero(met)
    seen = (place[kept] != NONE).any(axis=0)
    firsts = [next(s for s in place[w] if s != NONE) for w in kept]
    differing = [name for name in coordinates if len({repr(columns[name][s]) for s in firsts}) > 1]
    common = {name: columns[name][firsts[0]] for name in coordinates if name not in differing}
    if {"assumed_accuracy", "accuracy"} <= columns.keys() and all(
        columns["assumed_accuracy"][s] == columns["accuracy"][s] for s in firsts
    ):  # robots that know their sensors assume the true accuracy
        differing = [name for name in differing if name != "assumed_accuracy"]
        common.pop("assumed_accuracy", None)
    found = [{name: columns[name][s] for name in differing} for s in firsts]
    return Field(
        found, common, [c for c, so in zip(contenders, seen, strict=True) if so], place[kept][:, seen]
    ), cautions


def _named(data: xr.Dataset, parameters: dict[str, list[str]], shown: Mapping[str, Collection[str]]) -> list[str]:
    """What each setting's contender is called: its brain, and those of its parameters that vary or are to be shown."""
    brains = data["brain"].values.tolist()
    names = list(map(str, brains))
    for brain, several in parameters.items():
        mine = [k for k, one in enumerate(brains) if one == brain]
        for name in several:
            values = data[name].values[mine].tolist()
            if len(set(map(repr, values))) > 1 or name in shown.get(brain, ()):
                distinct = list(dict.fromkeys(values))
                text = dict(zip(distinct, told_apart(distinct), strict=True))
                for k, value in zip(mine, values, strict=True):
                    names[k] += f" {name}={text.get(value, value)}"
    return names


def _cautions(place: NDArray[np.intp], met: NDArray[np.bool_], contenders: list[str]) -> list[str]:
    cautions = []
    if not met.all():
        alone = int((~met).sum())
        verb = "world has" if alone == 1 else "worlds have"
        cautions.append(f"{alone} {verb} one contender only, and {'is' if alone == 1 else 'are'} left out")
    lacking = (place[met] == NONE).sum(axis=0)
    for name, count in zip(contenders, lacking.tolist(), strict=True):
        if count:
            where = "in no world that another one met" if count == met.sum() else (
                f"not in {count} of {met.sum():,} worlds: it is compared in the others, and overall all are compared "
                "in those worlds alone that all have met"
            )  # fmt: skip
            cautions.append(f"{name} is {where}")
    return cautions


def _listed(names: list[str]) -> str:
    return ", ".join(names[:-1]) + f" and {names[-1]}"
