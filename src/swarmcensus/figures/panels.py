"""Panels of a figure: results split by the coordinates that vary."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from typing import Any, NamedTuple

import xarray as xr

from swarmcensus.figures.coordinates import brains_first_of_own, caption_of, of_contenders, varies
from swarmcensus.studies import caption_form, idle_caption
from swarmcensus.summaries import TooMuch, renamed_contender, require, titles_in
from swarmcensus.support.errors import InputError
from swarmcensus.support.formatting import distinct_texts

MOST_PANELS = 24
Names = Sequence[str] | str | None  # of coordinates


class Panel(NamedTuple):
    """One panel: its caption, its results, two options of `scatter`, and what is claimed of it.

    A claim is an error that medians are below (`scatter_grid`), or a checkpoint by which all are right
    (`decisions_grid`).
    """

    caption: str
    results: xr.Dataset
    local: bool = False
    error_limit: float | None = None
    claim: float | None = None


def captions_of(worlds: Sequence[Mapping[str, Any]]) -> list[str]:
    """The captions of the panels of a comparison, one for each world. Raises InputError for more than 24."""
    if len(worlds) > MOST_PANELS:
        raise InputError(f"a figure holds 1 to {MOST_PANELS:,} worlds, not {len(worlds)}: select some settings")
    return [caption_of(world) for world in worlds]


def panels_of(results: xr.Dataset, apart_from: Collection[str] = ("accuracy",), by: Names = None) -> list[Panel]:
    """Split results into panels, one for each combination of values of the coordinates `by`.

    By default `by` is every coordinate that varies, except those in `apart_from`. Brains are contenders, as
    `of_contenders` names them. Panels are in the order of the settings. Captions name the coordinates that vary, such
    as "ring, N = 100, f = 0.55", and a floor that is not of independent tiles.

    Raises InputError if `results` has no settings, and for more than 24 panels; the message says how to select fewer.
    """
    by = [by] if isinstance(by, str) else by
    panels = _split(results, apart_from, by)
    if len(panels) > MOST_PANELS:
        what = f"a figure holds 1 to {MOST_PANELS} panels, not {len(panels)}"
        raise TooMuch(what, select_some(results, apart_from, MOST_PANELS, by))
    return panels


def _split(results: xr.Dataset, apart_from: Collection[str], by: Sequence[str] | None) -> list[Panel]:
    require(results, dimensions=("setting", "trial"))
    results = of_contenders(results, [*apart_from, *(by or ())])
    varying = _varying(results, apart_from, by)
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
    panels = []
    for combination, settings in members.items():
        caption = ", ".join(
            written[name].get(value, idle_caption(name) or f"no {name}")
            for name, value in zip(varying, combination, strict=True)
            if value is not None or idle_caption(name) or (by is not None and name != "assumed_accuracy")
        )
        panels.append(Panel(caption, results.isel(setting=settings)))
    return panels


def _varying(results: xr.Dataset, apart_from: Collection[str], by: Sequence[str] | None) -> dict[str, list[Any]]:
    """Every setting's value of each coordinate that makes panels."""
    if by is None:
        return varies(results, apart_from)
    return {name: values for name, values in varies(results, twice=True).items() if name in by}


def _written(name: str, values: list[Any]) -> dict[Any, str]:
    """Each value of a coordinate as a caption writes it, with enough digits to distinguish the values."""
    distinct = [value for value in dict.fromkeys(values) if value is not None]
    form = caption_form(name)
    numbers = name.endswith("accuracy") or all(isinstance(value, float) for value in distinct)
    texts = distinct_texts(distinct, 6) if numbers and ":" not in form else distinct
    return {value: form.format(text) for value, text in zip(distinct, texts, strict=True)}


def select_some(
    results: xr.Dataset, apart_from: Collection[str], most: int, by: Sequence[str] | None = None
) -> dict[str, Any]:
    """Values of coordinates by name. Selecting the settings that have them leaves at most `most` panels."""
    chosen = {}
    while len(_split(results, apart_from, by)) > most:
        varying = _varying(results, apart_from, by)
        name = max(varying, key=lambda name: len(set(varying[name])))
        chosen[name] = brains_first_of_own(varying[name])[0]
        results = results.isel(setting=results[name].values == chosen[name])
    return chosen
