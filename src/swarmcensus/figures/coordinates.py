"""The coordinates that distinguish settings: which ones vary, and how their values are written."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from swarmcensus.results import derived_size, is_idle, parameters_in, require
from swarmcensus.studies import IN_CAPTIONS, NUMERIC, caption_form, idle_caption, plural_of
from swarmcensus.support.errors import InputError
from swarmcensus.support.hints import did_you_mean

LIARS = {"liars", "adversary"}  # how many robots lie, and how: together they are equivalent to `members`
NONE = "none"  # the text of a missing value


def caption_of(world: Mapping[str, Any]) -> str:
    """The caption of a world of a comparison: the coordinates in which it differs from others."""
    return ", ".join(
        idle_caption(name) if is_idle(value) else caption_form(name).format(_plain(name, value))
        for name, value in world.items()
        if idle_caption(name) or not is_idle(value)
    )


def _plain(name: str, value: Any) -> Any:
    """A value as captions write it: 1.0 as 1."""
    return f"{value:.12g}" if isinstance(value, float) and ":" not in caption_form(name) else value


def coordinates_of(results: xr.Dataset) -> list[str]:
    """The names of all coordinates along `setting`."""
    names = [str(name) for name, values in results.coords.items() if values.dims == ("setting",) and name != "setting"]
    return [*(name for name in IN_CAPTIONS if name in names), *sorted(set(names).difference(IN_CAPTIONS))]


def check_coordinates(results: xr.Dataset, also: Collection[str] = (), **given: str | Sequence[str] | None) -> None:
    """Raise InputError if an option, given as option=names, names no coordinate; names in `also` are allowed too."""
    require(results)
    known = coordinates_of(results)
    for option, names in given.items():
        for name in [names] if isinstance(names, str) else names or ():
            if name not in known and name not in also:
                varying = varies(results)
                others = [other for other in [*known, *also] if other not in varying]
                here = f"the coordinates that vary here are {', '.join(varying) or 'none'}"
                meant = did_you_mean(name, [*known, *also])
                raise InputError.named(option, name, f"{meant}{here}; others are {', '.join(others)}")


def texts_of(results: xr.Dataset, name: str) -> NDArray[np.str_]:
    """Each setting's value of a coordinate as text. Raises InputError if there is no such coordinate."""
    require(results, name, dimensions=("setting", "trial"))
    values = results[name].values
    texts = values.astype(str)
    return np.where((texts == "") | (values != values), NONE, texts)


def varies(results: xr.Dataset, apart_from: Collection[str] = (), *, twice: bool = False) -> dict[str, list[Any]]:
    """Return every setting's value of each coordinate that varies; None stands for a missing value.

    The coordinates `apart_from` are left out. So are coordinates that repeat others, unless `twice`: density or side of
    an arena; `liars` and `adversary` if there are `members`; the accuracy, if `apart_from` has its numbers; a floor
    that all arenas share; a parameter with a single value; and, if `apart_from` are the two or more axes of a figure,
    everything that follows from them.
    """
    left_out = {*apart_from, *NUMERIC}
    if not twice:
        given = {*apart_from}
        left_out |= {"density", "side"} if given & {"density", "side"} else {derived_size(results)}
        left_out |= _restated_by_liars(results) if given & LIARS else LIARS
        left_out |= _restated_by_numbers(results, given & NUMERIC.keys())
    restating = set() if twice else {"floor"}.union(*parameters_in(results).values())
    varying = {}
    for name in coordinates_of(results):
        if name in left_out:
            continue
        values = results[name].values.tolist()
        if name == "assumed_accuracy" and len(set(values)) > 1:
            # Robots that know their sensors assume the true accuracy, or that of the first round if sensors drift.
            # This distinguishes no settings.
            pairs = zip(values, results["accuracy"].values.tolist(), strict=True)
            values = [None if assumed == true.split(" drift=")[0] else assumed for assumed, true in pairs]
        # fixed networks have NaN as density and "" as floor
        values = [None if value != value or value == "" else value for value in values]
        distinct = set(values)
        if len(distinct - {None} if name in restating else distinct) > 1:
            varying[name] = values
    return varying if twice or len({*apart_from}) < 2 else _independent_of(results, {*apart_from}, varying)


def pooled(parts: Sequence[xr.Dataset], axes: Sequence[str]) -> str:
    """The coordinates that a figure pools, such as "7 accuracies"; empty if there are none.

    `parts` are the panels, and `axes` the coordinates that a panel distinguishes.
    """
    counts: dict[str, int] = {}
    for part in parts:
        at = list(zip(*(texts_of(part, name).tolist() for name in axes), strict=True))
        for name, values in varies(part, axes).items():
            together: dict[tuple[str, ...], set[Any]] = {}
            for place, value in zip(at, values, strict=True):
                together.setdefault(place, set()).add(value)
            counts[name] = max(counts.get(name, 1), *map(len, together.values()))
    texts = [f"{count:,} {plural_of(name)}" for name, count in counts.items() if count > 1]
    return " and ".join(filter(None, [", ".join(texts[:-1]), *texts[-1:]]))


def _independent_of(results: xr.Dataset, axes: set[str], varying: dict[str, list[Any]]) -> dict[str, list[Any]]:
    """The coordinates that differ between settings with the same values on all axes."""
    at = list(zip(*(texts_of(results, name).tolist() for name in sorted(axes)), strict=True))
    return {name: values for name, values in varying.items() if len({*zip(at, values, strict=True)}) > len({*at})}


def from_nobody(results: xr.Dataset) -> xr.Dataset:
    """Repeat each setting without liars for each adversary of its world, so that all lines begin at it."""
    adversaries = results["adversary"].values.tolist()
    others = [name for name in coordinates_of(results) if name not in {"members", *LIARS}]
    worlds = list(zip(*(texts_of(results, name).tolist() for name in others), strict=True))
    of_world: dict[tuple[str, ...], dict[str, None]] = {}
    for world, adversary in zip(worlds, adversaries, strict=True):
        if adversary:
            of_world.setdefault(world, {})[adversary] = None
    rows = [
        (k, name)
        for k, adversary in enumerate(adversaries)
        for name in ([adversary] if adversary else of_world.get(worlds[k], [""]))
    ]
    names = np.array([name for _, name in rows], dtype=object)
    return results.isel(setting=[k for k, _ in rows]).assign_coords(adversary=("setting", names))


def _restated_by_numbers(results: xr.Dataset, numbers: set[str]) -> set[str]:
    """The accuracy, if it follows from some of its numbers; else nothing."""
    if not numbers:
        return set()
    at = list(zip(*(texts_of(results, name).tolist() for name in sorted(numbers)), strict=True))
    return {"accuracy"} if len({*zip(at, results["accuracy"].values.tolist(), strict=True)}) == len({*at}) else set()


def _restated_by_liars(results: xr.Dataset) -> set[str]:
    """`members`, if it follows from the adversary, the number of liars and the number of robots; else nothing."""
    if "members" not in results.coords:
        return set()
    rows = set(zip(*(results[name].values.tolist() for name in ("robots", *sorted(LIARS), "members")), strict=True))
    return {"members"} if len({row[:-1] for row in rows}) == len(rows) else set()
