"""The coordinates that distinguish settings: which ones vary, how they are written, and the panels that they make."""

from __future__ import annotations

import json
from collections.abc import Collection, Hashable, Iterable, Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from swarmcensus.results import parameters_in
from swarmcensus.studies import IN_CAPTIONS, NUMERIC, caption_form, idle_caption, plural_of
from swarmcensus.summaries import contender_names, derived_size, is_idle, renamed_contender, require, titles_in
from swarmcensus.support.formatting import distinct_texts
from swarmcensus.support.hints import did_you_mean
from swarmcensus.support.options import wrong_option

Names = Sequence[str] | str | None  # of coordinates

LIARS = {"liars", "adversary"}  # how many robots lie, and how: together they are equivalent to `members`
NONE = "none"  # the text of a missing value that has no other word


class Panel(NamedTuple):
    """One panel: its caption, its results, two options of `scatter`, what is claimed of it, and the label of its row.

    A claim is an error that medians are below (`scatter_grid`), or a checkpoint by which all are right
    (`columns_grid`).
    """

    caption: str
    results: xr.Dataset
    local: bool = False
    error_limit: float | None = None
    claim: float | None = None
    row: str = ""


def caption_of(world: Mapping[str, Any]) -> str:
    """The caption of a world of a comparison: the coordinates in which it differs from others."""
    return ", ".join(_captions_in(world).values())


def _captions_in(world: Mapping[str, Any]) -> dict[str, str]:
    """The caption of each coordinate of a world of a comparison; none of what is missing and has no word for it."""
    return {
        name: idle_caption(name) if is_idle(value) else caption_form(name).format(_plain(name, value))
        for name, value in world.items()
        if idle_caption(name) or not is_idle(value)
    }


def worlds_apart(
    worlds: Sequence[Mapping[str, Any]], rows: Names = None, cols: Names = None
) -> tuple[list[str], list[str]]:
    """The captions of the panels of a comparison, one for each world, and the labels of their rows.

    Raises InputError for rows or columns in which worlds do not differ.
    """
    known = check_worlds(worlds, rows, cols)
    over = None if cols is None else [name for name in known if name not in (listed(rows) or ())]
    return _arranged([*map(_captions_in, worlds)], known, rows, over)


def check_worlds(worlds: Sequence[Mapping[str, Any]], rows: Names, cols: Names) -> list[str]:
    """The coordinates in which worlds differ. Raises InputError for rows or columns that are none of them."""
    _check_apart(rows, cols)
    known = list(dict.fromkeys(name for world in worlds for name in world))
    for option, names in (("rows", rows), ("cols", cols)):
        for name in listed(names) or ():
            if name not in known:
                differ = f"worlds differ in {', '.join(known)}" if known else "there is one world"
                raise wrong_option(option, name, f"{did_you_mean(name, known)}{differ}")
    return known


def _check_apart(rows: Names, cols: Names) -> None:
    """Raise InputError for a coordinate that has rows and columns."""
    for name in listed(cols) or ():
        if name in (listed(rows) or ()):
            raise wrong_option("cols", name, "it has the rows: name another coordinate")


def _arranged(
    texts: Sequence[Mapping[str, str]], names: Sequence[str], rows: Names, cols: Names
) -> tuple[list[str], list[str]]:
    """The captions of panels, and the labels of their rows, by the texts of their coordinates.

    By default, panels by two coordinates are a table if it is full. Without rows, there are no labels.
    """
    rows, cols = listed(rows), listed(cols)
    _check_apart(rows, cols)
    if rows is None and cols is None and len(names) == 2:
        sides = [{each.get(name, "") for each in texts} for name in names]
        full = len(sides[0]) * len(sides[1]) == len(texts) and min(map(len, sides)) > 1
        rows = [names[len(sides[0]) > len(sides[1])]] if full else None
    rows = rows or []
    cols = [name for name in names if name not in rows] if cols is None else cols
    captions, labels = (
        [", ".join(each[name] for name in side if name in each) for each in texts] for side in (cols, rows)
    )
    return captions, labels if any(labels) else []


def listed(names: Names) -> list[str] | None:
    """The names of coordinates as a list; None if none are given."""
    return [names] if isinstance(names, str) else None if names is None else [*names]


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
                raise wrong_option(option, name, f"{meant}{here}; others are {', '.join(others)}")


def texts_of(results: xr.Dataset, name: str) -> NDArray[np.str_]:
    """Each setting's value of a coordinate as text. Raises InputError if there is no such coordinate."""
    require(results, name, dimensions=("setting", "trial"))
    values = results[name].values
    texts = values.astype(str)
    return np.where((texts == "") | (values != values), idle_caption(name) or NONE, texts)


def varies(results: xr.Dataset, apart_from: Collection[str] = (), *, twice: bool = False) -> dict[str, list[Any]]:
    """Return every setting's value of each coordinate that varies; None stands for a missing value.

    The coordinates `apart_from` are left out. So are coordinates that repeat others, unless `twice`: density or side of
    an arena; `liars` and `adversary` if there are `members`; the accuracy, if `apart_from` has its numbers; a floor
    that all arenas share; a parameter that follows from the brain, or that some brains lack; and, if `apart_from` are
    the two or more axes of a figure, everything that follows from them.
    """
    left_out = {*apart_from, *NUMERIC}
    if not twice:
        given = {*apart_from}
        left_out |= {"density", "side"} if given & {"density", "side"} else {derived_size(results)}
        left_out |= _restated(results, "members", {"robots", *LIARS}) if given & LIARS else LIARS
        left_out |= _restated(results, "accuracy", given & NUMERIC.keys())
        lacked, parameters = _lacked(results), set().union(*parameters_in(results).values())
        brains = results["brain"].values.tolist() if parameters else []
        left_out |= lacked | {
            name for name in parameters - lacked if _follow(map(repr, results[name].values.tolist()), brains)
        }
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
        if len(distinct - {None} if name == "floor" and not twice else distinct) > 1:
            varying[name] = values
    if twice or len({*apart_from}) < 2:
        return varying
    at = _rows(results, {*apart_from})
    return {name: values for name, values in varying.items() if not _follow(values, at)}


def of_contenders(results: xr.Dataset, named: Collection[str]) -> xr.Dataset:
    """Results in which brains have the names of contenders, such as "mine.py gain=0.1".

    A parameter that differs between settings of a brain, and that other brains lack, is part of its name, unless it is
    one of the coordinates `named`.
    """
    parameters, lacked = parameters_in(results), _lacked(results)
    if not lacked:
        return results
    parts = {
        brain: [name for name in several if name in lacked.difference(named)] for brain, several in parameters.items()
    }
    brains, names = results["brain"].values.tolist(), contender_names(results, parts)
    of_names = {name: parameters.get(brain, []) for name, brain in zip(names, brains, strict=True)}
    named_so = results.assign_coords(brain=("setting", np.array(names, object)))
    return named_so.assign_attrs(parameters=json.dumps(of_names))


def _lacked(results: xr.Dataset) -> set[str]:
    """The parameters that some brains lack."""
    parameters = parameters_in(results)
    if not parameters:
        return set()
    there = [{*parameters.get(brain, [])} for brain in dict.fromkeys(results["brain"].values.tolist())]
    return {name for names in there for name in names if not all(name in others for others in there)}


def pooled(parts: Sequence[xr.Dataset], axes: Sequence[str]) -> str:
    """The coordinates that a figure pools, such as "7 accuracies"; empty if there are none.

    `parts` are the panels, and `axes` the coordinates that a panel distinguishes.
    """
    counts: dict[str, int] = {}
    for part in parts:
        at = _rows(part, axes)
        for name, values in varies(part, axes).items():
            together: dict[tuple[str, ...], set[Any]] = {}
            for place, value in zip(at, values, strict=True):
                together.setdefault(place, set()).add(value)
            counts[name] = max(counts.get(name, 1), *map(len, together.values()))
    texts = [f"{count:,} {plural_of(name)}" for name, count in counts.items() if count > 1]
    return " and ".join(filter(None, [", ".join(texts[:-1]), *texts[-1:]]))


def _rows(results: xr.Dataset, names: Collection[str]) -> list[tuple[str, ...]]:
    """Each setting's values of these coordinates as texts."""
    return list(zip(*(texts_of(results, name).tolist() for name in names), strict=True))


def _follow(values: Iterable[Hashable], others: Sequence[Hashable]) -> bool:
    """Whether a coordinate's values follow from `others` of the same settings."""
    return len({*zip(others, values, strict=True)}) == len({*others})


def from_nobody(results: xr.Dataset) -> xr.Dataset:
    """Repeat each setting without liars for each adversary, so that all lines begin at it."""
    adversaries = results["adversary"].values.tolist()
    every = [*dict.fromkeys(filter(None, adversaries))] or [""]
    rows = [(k, name) for k, own in enumerate(adversaries) for name in ([own] if own else every)]
    names = np.array([name for _, name in rows], dtype=object)
    return results.isel(setting=[k for k, _ in rows]).assign_coords(adversary=("setting", names))


def _restated(results: xr.Dataset, name: str, others: Collection[str]) -> set[str]:
    """The coordinate of this name, if there is one and it follows from some others; else nothing."""
    if not others or name not in results.coords:
        return set()
    return {name} if _follow(results[name].values.tolist(), _rows(results, others)) else set()


def panels_of(
    results: xr.Dataset, apart_from: Collection[str] = ("accuracy",), rows: Names = None, cols: Names = None
) -> list[Panel]:
    """Split results into panels, one for each combination of values of the coordinates in rows and columns.

    By default these are all coordinates that vary, except those in `apart_from`: two are rows and columns if there are
    settings with all their values. Brains are contenders, as `of_contenders` names them. Panels are in the order of the
    settings. Captions name the coordinates that vary, such as "ring, N = 100, f = 0.55", and a floor that is not of
    independent tiles. Raises InputError if `results` has no settings.
    """
    require(results, dimensions=("setting", "trial"))
    by = None if rows is None and cols is None else [*(listed(rows) or ()), *(listed(cols) or ())]
    results = of_contenders(results, [*apart_from, *(by or ())])
    if by is None:
        varying = varies(results, apart_from)
    else:
        varying = {name: values for name, values in varies(results, twice=True).items() if name in by}
    by_floor = "floor" in by if by is not None else "floor" not in apart_from
    floors = results["floor"].values.tolist() if by_floor and "floor" in results.coords else []
    if {*floors} - {"tiles", ""}:
        varying.setdefault("floor", floors)
    written = {name: _written(name, values) for name, values in varying.items()}
    if "brain" in written:
        titles = titles_in(results)
        written["brain"] = {name: renamed_contender(text, titles) for name, text in written["brain"].items()}
    combinations = list(zip(*varying.values(), strict=True)) or [()] * results.sizes["setting"]
    members: dict[tuple[Any, ...], list[int]] = {}
    for setting, combination in enumerate(combinations):
        members.setdefault(combination, []).append(setting)
    texts = [
        {
            name: written[name].get(value, idle_caption(name) or f"no {name}")
            for name, value in zip(varying, combination, strict=True)
            if value is not None or idle_caption(name) or (by is not None and name != "assumed_accuracy")
        }
        for combination in members
    ]
    captions, labels = _arranged(texts, [*varying], rows, cols)
    labels = labels or [""] * len(captions)
    parts = [results.isel(setting=settings) for settings in members.values()]
    return [Panel(one, part, row=row) for one, part, row in zip(captions, parts, labels, strict=True)]


def _written(name: str, values: list[Any]) -> dict[Any, str]:
    """Each value of a coordinate as a caption writes it, with enough digits to distinguish the values."""
    distinct = [value for value in dict.fromkeys(values) if value is not None]
    form = caption_form(name)
    numbers = name.endswith("accuracy") or all(isinstance(value, float) for value in distinct)
    texts = distinct_texts(distinct, 6) if numbers and ":" not in form else distinct
    return {value: form.format(text) for value, text in zip(distinct, texts, strict=True)}


def rows_of(panels: Sequence[Panel]) -> list[str]:
    """The labels of the rows of panels, empty if rows have none."""
    labels = [panel.row for panel in panels]
    return labels if any(labels) else []
