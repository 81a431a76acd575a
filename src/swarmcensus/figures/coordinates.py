"""The coordinates that tell settings apart: which vary, how their values are written, what axes and keys call them."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from swarmcensus.basics.errors import InputError
from swarmcensus.basics.hints import did_you_mean
from swarmcensus.comparing.contenders import parameters_in
from swarmcensus.results.selecting import require
from swarmcensus.results.summaries import is_idle, told
from swarmcensus.vocabulary.coordinates import IN_CAPTIONS, caption_form, idle_caption, plural_of

LIARS = {"liars", "adversary"}  # how many lie, and who: together they tell what members do
NONE = "none"  # the density of a fixed network, the floor of one


def caption_of(world: Mapping[str, Any]) -> str:
    """What a caption says of a world of a comparison, by the coordinates in which it differs from others."""
    said = {
        name: idle_caption(name) if is_idle(value) else caption_form(name).format(value)
        for name, value in world.items()
        if idle_caption(name) or not is_idle(value)
    }
    return ", ".join(said.values())


def coordinates_of(results: xr.Dataset) -> list[str]:
    """The names of all that tells settings apart."""
    names = [str(name) for name, one in results.coords.items() if one.dims == ("setting",) and name != "setting"]
    return [*(name for name in IN_CAPTIONS if name in names), *sorted(set(names).difference(IN_CAPTIONS))]


def check_coordinates(results: xr.Dataset, also: Collection[str] = (), **given: str | Sequence[str] | None) -> None:
    """Raise InputError for the name of a coordinate that is not there, by the option that gives it.

    `also` are other names that are right.
    """
    require(results)
    known = coordinates_of(results)
    for option, names in given.items():
        for name in [names] if isinstance(names, str) else names or ():
            if name not in known and name not in also:
                several = ", ".join(varies(results)) or "none"
                raise InputError(
                    f"{option} {name!r}: {did_you_mean(name, [*known, *also])}the coordinates that vary here are "
                    f"{several}; others are {', '.join(one for one in [*known, *also] if one not in varies(results))}"
                )


def texts_of(results: xr.Dataset, name: str) -> NDArray[np.str_]:
    """Each setting's value of a coordinate as text. Raises InputError where there is no such coordinate."""
    require(results, name, dimensions=("setting", "trial"))
    values = results[name].values
    texts = values.astype(str)
    return np.where((texts == "") | (values != values), NONE, texts)


def varies(results: xr.Dataset, apart_from: Collection[str] = (), *, twice: bool = False) -> dict[str, list[Any]]:
    """Return every setting's value of each coordinate that has several; None is a value that says nothing.

    Of an arena's density and side one tells the other, members say who lies and how many, a single floor of all arenas
    tells no more than their topology does, a parameter with a single value no more than its brain, and nothing does
    that follows from `apart_from`, if these are the two axes of a figure or more: only `twice` names these too.
    """
    left_out = {*apart_from}
    if not twice:
        given = {*apart_from}
        left_out |= {"density", "side"} if given & {"density", "side"} else {told(results)}
        left_out |= _told_otherwise(results) if given & LIARS else LIARS
    restating = set() if twice else {"floor"}.union(*parameters_in(results).values())
    varying = {}
    for name in coordinates_of(results):
        if name in left_out:
            continue
        values = results[name].values.tolist()
        if name == "assumed_accuracy" and len(set(values)) > 1:
            # Robots that know their sensors assume the true accuracy: that tells no settings apart.
            pairs = zip(values, results["accuracy"].values.tolist(), strict=True)
            # Nor where they drift, and robots believe in those of the first round.
            values = [None if assumed == true.split(" drift=")[0] else assumed for assumed, true in pairs]
        # NaN and "", the density and floor of a fixed network
        values = [None if value != value or value == "" else value for value in values]
        distinct = set(values)
        if len(distinct - {None} if name in restating else distinct) > 1:
            varying[name] = values
    return varying if twice or len({*apart_from}) < 2 else _not_told_by(results, {*apart_from}, varying)


def pooled(parts: Sequence[xr.Dataset], axes: Sequence[str]) -> str:
    """What settings have several values of that are drawn as one, for a figure to say; nothing where none do.

    `parts` are its panels and `axes` the coordinates that tell apart what stands in one, as "7 accuracies".
    """
    found: dict[str, int] = {}
    for part in parts:
        at = list(zip(*(texts_of(part, name).tolist() for name in axes), strict=True))
        for name, values in varies(part, axes).items():
            together: dict[tuple[str, ...], set[Any]] = {}
            for place, value in zip(at, values, strict=True):
                together.setdefault(place, set()).add(value)
            found[name] = max(found.get(name, 1), *map(len, together.values()))
    told = [f"{count:,} {plural_of(name)}" for name, count in found.items() if count > 1]
    return " and ".join(filter(None, [", ".join(told[:-1]), *told[-1:]]))


def _not_told_by(results: xr.Dataset, axes: set[str], varying: dict[str, list[Any]]) -> dict[str, list[Any]]:
    """Those coordinates that differ where all axes are the same."""
    at = list(zip(*(texts_of(results, name).tolist() for name in sorted(axes)), strict=True))
    return {name: values for name, values in varying.items() if len({*zip(at, values, strict=True)}) > len({*at})}


def from_nobody(results: xr.Dataset) -> xr.Dataset:
    """Settings in which nobody lies, once for each adversary that there is in their world: its lines begin there."""
    who = results["adversary"].values.tolist()
    others = [name for name in coordinates_of(results) if name not in {"members", *LIARS}]
    worlds = list(zip(*(texts_of(results, name).tolist() for name in others), strict=True))
    met: dict[tuple[str, ...], dict[str, None]] = {}
    for world, one in zip(worlds, who, strict=True):
        if one:
            met.setdefault(world, {})[one] = None
    rows = [(k, name) for k, one in enumerate(who) for name in ([one] if one else met.get(worlds[k], [""]))]
    names = np.array([name for _, name in rows], dtype=object)
    return results.isel(setting=[k for k, _ in rows]).assign_coords(adversary=("setting", names))


def _told_otherwise(results: xr.Dataset) -> set[str]:
    """Members, where who lies, how many and in what swarm says all of them."""
    if "members" not in results.coords:
        return set()
    rows = set(zip(*(results[name].values.tolist() for name in ("robots", *sorted(LIARS), "members")), strict=True))
    return {"members"} if len({row[:-1] for row in rows}) == len(rows) else set()
