"""Interaction plot: whether the effect of one factor differs between the levels of another."""

from __future__ import annotations

from collections.abc import Sequence
from operator import itemgetter
from typing import Unpack

import numpy as np
import xarray as xr
from matplotlib.artist import Artist
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from swarmcensus.analysis import Interaction, column_head, comparison
from swarmcensus.figures.axes import coordinate_axis, measured_axis, places_of
from swarmcensus.figures.captions import captioned, on_edges
from swarmcensus.figures.coordinates import Names
from swarmcensus.figures.kinds.lines import SIZE, WIDTH, draw_line, say_marks, sideways
from swarmcensus.figures.page import PageOptions, on_page
from swarmcensus.figures.sheets import Own, add_key, name_axes, sheet
from swarmcensus.figures.styles import looks_of, looks_of_contenders
from swarmcensus.studies import title_of
from swarmcensus.support.errors import InputError
from swarmcensus.support.formatting import counted

MOST_NAMED = 3  # effects that a caption names


@on_page
def interaction(
    results: xr.Dataset,
    *,
    by: str | Sequence[str],
    metric: Names = None,
    factor: Names = None,
    against: str | None = None,
    title: str | None = None,
    ax: Own = None,
    **more: Unpack[PageOptions],
) -> Figure:
    """Draw each measure at the levels of two factors: a line for each level of one, over the levels of the other.

    Lines are parallel where the effect of the factor is the same everywhere; `sc.compare` tests that. A dot is the mean
    over trials, each averaged over the worlds that have all levels. Vertical lines are 95 % intervals over trials.

    - `by`: coordinates on the x axis, between the levels of which the effect of the factor is compared.
    - `metric`: measures, as in `sc.compare`, with a panel each; by default the usual ones.
    - `factor`: coordinates with one line for each value; by default brains.
    - `against`: the level that others are compared with in tests.
    - `title`: the title of the figure.
    - `ax`: axes of your own, one for each measure. Leave room for the key on their right.
    - `width`, `height`, `font_size`, `labels`: the page, and names of brains (see `PageOptions`).

    Raises InputError as `sc.compare` does, and if no world has all levels of both.
    """
    found = comparison.compare(results, metric or (), None, against, factor or (), interaction=by)
    return draw_interaction(found, title, ax, [results])


def draw_interaction(
    found: Interaction, title: str | None = None, ax: Own = None, results: Sequence[xr.Dataset] = ()
) -> Figure:
    """Draw an interaction; see `interaction`. Raises InputError if no world has all levels."""
    looks = looks_of_contenders(found.levels, found.factor, results)
    by, factor = ", ".join(found.by), ", ".join(found.factor)
    texts = [level.removeprefix(f"{by}=") for level in found.by_levels]
    across = looks_of(texts, "o", by)
    places, numbers = places_of(across)
    x = np.array([places[text] for text in texts])
    order, middle = np.argsort(x), (len(found.levels) - 1) / 2
    with_ends = [[cell.get(part, np.nan) for part in ("value", "low", "high")] for cell in found.cells]
    means = np.reshape(with_ends, (len(found.measures), len(found.levels), len(texts), 3))
    if np.isnan(means).all():
        raise InputError(f"no world has all levels of {factor} and {by}: select some", key="by")
    names = [column_head(m) + f" ({m.unit})" * (m.unit != "1" and not m.share) for m in found.measures]
    several = len(names) > 1
    axes = sheet(ax, names if several else [""], title, fewer="name one metric")
    step = sideways(axes[0], len(texts), numbers, len(found.levels))
    coordinate_axis(axes, by, across, step * middle)
    entries: dict[str, Artist] = {}
    for measure, name, place, of_measure in zip(found.measures, names, axes, means, strict=True):
        shown = (100.0 if measure.share else 1.0) * of_measure
        measured_axis([place], shown[..., 0].ravel().tolist(), shown[..., 1:].ravel().tolist())
        full = 100.0 if measure.share else np.nan
        points = np.stack([np.broadcast_to(x, shown.shape[:2]), *np.moveaxis(shown, -1, 0), np.zeros(shown.shape[:2])])
        for k, look in enumerate(looks[level] for level in found.levels):
            draw_line(place, points[:, k, order], look.line, look, step * (k - middle), full)
            entries[look.name] = Line2D([], [], ls=look.line, lw=WIDTH, color=look.colour, marker=look.marker, ms=SIZE)
        say_marks(entries, points[1:].reshape(4, -1), "mean", full)
        name_axes(place, title_of(by), "mean over trials" if several else f"{name}, mean")
    add_key(axes, title_of(factor), entries)
    called = {level: look.name for level, look in looks.items()}
    called |= {level: across[text].name for level, text in zip(found.by_levels, texts, strict=True)}
    remark = on_edges(results, [measure.name for measure in found.measures])
    return captioned(axes, interaction, results, [remark], [_told_apart(found, called)])


def _told_apart(found: Interaction, called: dict[str, str]) -> str:
    """How many effects are told apart, and the clearest, by what levels are `called`."""
    apart = sorted((row for row in found.rows if row["told_apart"]), key=itemgetter("p_holm"))
    heads = {**called, **{measure.name: column_head(measure) for measure in found.measures}}
    named = [[heads[row[part]] for part in ("one", "other", "level", "other_level", "measure")] for row in apart]
    clearest = "; ".join("{} vs. {} with {} vs. {} on {}".format(*names) for names in named[:MOST_NAMED])
    sentence = (
        f"Told apart by rank tests, corrected after Holm: {len(apart)} of {counted(len(found.rows), 'pair')} of effects"
    )
    return f"{sentence}{', most clearly ' * bool(apart)}{clearest}."
