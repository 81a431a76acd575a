"""Interaction plot: whether the effect of one factor differs between the levels of another."""

from __future__ import annotations

import itertools
from collections.abc import Mapping, Sequence
from typing import Unpack

import numpy as np
import xarray as xr
from matplotlib.artist import Artist
from matplotlib.figure import Figure

from swarmcensus.analysis import Interaction, column_head, comparison
from swarmcensus.figures.axes import coordinate_axis, measured_axis, places_of
from swarmcensus.figures.captions import captioned, on_edges
from swarmcensus.figures.coordinates import Names, check_coordinates, panels_of, rows_of
from swarmcensus.figures.kinds.lines import draw_line, key_dot, say_marks, sideways
from swarmcensus.figures.page import PageOptions, on_page
from swarmcensus.figures.sheets import add_key, name_axes, sheet
from swarmcensus.figures.styles import looks_of, looks_of_contenders
from swarmcensus.studies import title_of
from swarmcensus.summaries import Measure
from swarmcensus.support.errors import InputError
from swarmcensus.support.intervals import Floats

MOST_SAID = 3  # effects that a caption names


@on_page
def interaction(
    results: xr.Dataset,
    *,
    by: str | Sequence[str],
    metric: Names = None,
    factor: Names = None,
    against: str | None = None,
    rows: Names = None,
    cols: Names = None,
    title: str | None = None,
    **more: Unpack[PageOptions],
) -> Figure:
    """Draw each measure at the levels of two factors: a line for each level of one, over the levels of the other.

    Lines are parallel where the effect of the factor is the same everywhere; `sc.compare` tests that. A dot is the mean
    over trials, each averaged over the worlds that have all levels. Vertical lines are 95 % intervals over trials.

    - `by`: coordinates on the x axis, between the levels of which the effect of the factor is compared.
    - `metric`: measures, as in `sc.compare`, with a panel each; by default the usual ones.
    - `factor`: coordinates with one line for each value; by default brains.
    - `against`: the level that others are compared with in tests.
    - `rows`, `cols`: coordinates; each combination of their values has panels, and tests of its own.
    - `title`: the title of the figure.
    - `width`, `height`, `font_size`, `labels`: the page, and names of brains (see `PageOptions`).

    Raises InputError as `sc.compare` does, and if no world has all levels of both.
    """
    check_coordinates(results, rows=rows, cols=cols)
    parts = panels_of(results, (), rows or [], cols or [])
    every = [results.sel(setting=part.results["setting"].values) for part in parts]
    found = [comparison.compare(each, metric or (), None, against, factor or (), interaction=by) for each in every]
    return draw_interaction(found, title, [results], [part.caption for part in parts], rows_of(parts))


def draw_interaction(
    found: Interaction | Sequence[Interaction], title: str | None = None,
    results: Sequence[xr.Dataset] = (), captions: Sequence[str] = ("",), rows: Sequence[str] = (),
) -> Figure:  # fmt: skip
    """Draw interactions, each with its caption and perhaps the label of its row; see `interaction`.

    Raises InputError if no world has all levels.
    """
    every = [found] if isinstance(found, Interaction) else found
    by, factor, several = ", ".join(every[0].by), ", ".join(every[0].factor), len(every[0].measures) > 1
    if all(np.isnan(cell.get("value", np.nan)) for each in every for cell in each.cells):
        raise InputError(f"no world has all levels of {factor} and {by}: select some", key="by")
    levels = list(dict.fromkeys(level for each in every for level in each.levels))
    texts = {level: level.removeprefix(f"{by}=") for each in every for level in each.by_levels}
    looks, across = looks_of_contenders(levels, every[0].factor, results), looks_of(texts.values(), "o", by)
    places, are_numbers = places_of(across)
    panels = [(each, at, m) for each, at in zip(every, captions, strict=True) for m in each.measures]
    names = [column_head(m) + f" ({m.unit})" * (m.unit != "1" and not m.share) for *_, m in panels]
    over = [", ".join(filter(None, (name * several, at))) for name, (_, at, _) in zip(names, panels, strict=True)]
    labels = [row for each, row in zip(every, rows, strict=False) for _ in each.measures]
    axes = sheet(over, title, rows=labels, fewer="name one metric")
    step, middle = sideways(axes[0], len(across), are_numbers, len(levels)), (len(levels) - 1) / 2
    coordinate_axis(axes, by, across, step * middle)
    entries: dict[str, Artist] = {}
    drawn = [
        _points(each, measure, {level: places[text] for level, text in texts.items()}) for each, _, measure in panels
    ]
    for measure in every[0].measures:  # its panels have the same y axis
        same = [k for k, (*_, other) in enumerate(panels) if other.name == measure.name]
        numbers = np.concatenate([points for k in same for points in drawn[k].values()], axis=1)[1:]
        measured_axis([axes[k] for k in same], numbers[0].tolist(), numbers[1:3].ravel().tolist())
        full = 100.0 if measure.share else np.nan
        for k in same:
            for level, points in drawn[k].items():
                look, aside = looks[level], step * (levels.index(level) - middle)
                draw_line(axes[k], points, look.line, look, aside, full)
                entries[look.name] = key_dot(look, lined=True)
            name_axes(axes[k], title_of(by), "mean over trials" if several else f"{names[k]}, mean")
        say_marks(entries, numbers, "mean", full)
    add_key(axes, title_of(factor), entries)
    where = [", ".join(filter(None, pair)) for pair in itertools.zip_longest(captions, rows)]
    said = [f"{at}: " * bool(at) + f"{text}." for at, one in zip(where, every, strict=True) for text in _clearest(one)]
    return captioned(axes, interaction, results, [on_edges(results, [m.name for m in every[0].measures])], said)


def _points(found: Interaction, measure: Measure, places: Mapping[str, float]) -> dict[str, Floats]:
    """For each level x, the mean, the ends of its interval, and 0, (5, point), from left to right."""
    times, rows = 100.0 if measure.share else 1.0, dict[str, list[list[float]]]()
    for cell in found.cells:
        if cell["measure"] == measure.name:
            numbers = [times * cell.get(part, np.nan) for part in ("value", "low", "high")]
            rows.setdefault(cell["level"], []).append([places[cell["by"]], *numbers, 0.0])
    return {level: np.array(sorted(each)).T for level, each in rows.items()}


def _clearest(found: Interaction) -> list[str]:
    """The sentences of the effects that differ most clearly."""
    order = np.argsort([row["p_holm"] for row in found.rows], kind="stable")[:MOST_SAID]
    return [found.sentences[k] for k in order]
