"""Lines of right robots at each checkpoint, drawn in columns: one diamond for each accuracy, or another coordinate."""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch
from matplotlib.path import Path
from matplotlib.ticker import FixedLocator

from swarmcensus.figures.captions import captioned, on_edges, pooled_over, with_numbers
from swarmcensus.figures.coordinates import Panel, rows_of
from swarmcensus.figures.groups import Shares, shares_of, unit_of
from swarmcensus.figures.page import drawing, letters
from swarmcensus.figures.sheets import NOTHING, POOLED, UNRUN, add_key, name_axes, sheet
from swarmcensus.figures.styles import (
    ONE_END,
    ONE_SIDED,
    Look,
    add_dots,
    draw_intervals,
    key_mark,
    key_of,
    looks_of,
    outlined_dot,
)
from swarmcensus.figures.theory_lines import Curves, curves_of, entries as theory_entries, lines_to_draw
from swarmcensus.summaries import titles_in
from swarmcensus.support.errors import InputError
from swarmcensus.support.formatting import counted

MOST_CHECKPOINTS = 12  # of a panel
CLAIM: dict[str, Any] = {"facecolor": "#fdf0e6", "edgecolor": "none", "zorder": -1}
GAP = 1.5  # points between a diamond and the dash over it


@drawing()
def columns_grid(
    panels: Sequence[Panel | tuple[Any, ...]],
    *,
    color: str = "accuracy",
    theory: bool = False,
    title: str | None = None,
    claimed: str = "",
    as_paper: bool = False,
) -> Figure:
    """Draw the share of robots that choose the right bin at each checkpoint.

    Each checkpoint is a column, counted in communication rounds, or in ticks if robots move. A column has one diamond
    for each value of `color`, side by side in the order of the key. y is the percentage of right robots over all
    trials. A thin line through a marker is its 95 % interval over trials. A dash over a diamond means that all robots
    of all trials are right.

    A panel is a `Panel` or a tuple (caption, results). Panels without finished trials are left out. The checkpoint of a
    panel's claim is shaded, and the key says what is `claimed`. With `as_paper` there are no intervals, and a vertical
    line instead of a dash means that all robots are right.

    Raises InputError if there are no panels or too many, or if none holds a finished trial.
    """
    drawn = [Panel(*panel) for panel in panels]
    of_theory: list[tuple[Curves, str]] = [
        curves_of(panel, color, panel.results["checkpoint"].values.tolist()) if theory else ({}, "") for panel in drawn
    ]
    shares = [shares_of(panel.results, color) for panel in drawn]
    captions, has, curves = [panel.caption for panel in drawn], [*map(bool, shares)], [each for each, _ in of_theory]
    unrun, drawn, shares, expected = with_numbers(captions, has, UNRUN, drawn, shares, curves)
    parts = [panel.results for panel in drawn]
    looks = looks_of(itertools.chain(*shares), "d", color, titles_in(*parts))
    if panels and not drawn:
        raise InputError(NOTHING)
    axes = sheet([panel.caption for panel in drawn], title, rows=rows_of(drawn), fewer=POOLED)
    for panel, panel_shares, curves, place in zip(drawn, shares, expected, axes, strict=True):
        _draw_shares(place, panel, panel_shares, looks, curves, as_paper)
    heading, entries = key_of(looks, color, lambda look: outlined_dot(look, 6, 0.4))
    every_share = [share for panel_shares in shares for share in panel_shares.values()]
    if any(share.all_right.any() for share in every_share):
        mark = "line over it" if as_paper else "dash over it"
        entries[f"{mark}: all\nrobots of all trials\nare right"] = _mark(0.0, 7.0, "0.3", 1.6, as_paper)
    if any(panel.claim is not None for panel in drawn):
        entries[claimed] = Patch(**CLAIM)
    known = [share.all_right[np.isfinite(share.low)] for share in every_share if not as_paper]
    if not all(right.all() for right in known):
        entries["95 % interval"] = key_mark("|", mew=0.6)
    if any(right.any() for right in known):
        entries[f"dash-dotted: all right, {ONE_END}"] = Line2D([], [], linestyle=ONE_SIDED, linewidth=0.9, color="0.3")
    add_key(axes, heading, entries | theory_entries(expected))
    remarks = [*(why for _, why in of_theory), unrun, pooled_over(parts, [color]), on_edges(parts, ["correct"])]
    return captioned(axes, columns_grid, parts, remarks)


def _draw_shares(
    axes: Axes, panel: Panel, shares: Shares, looks: dict[str, Look], expected: Curves, as_paper: bool
) -> None:
    checkpoints, unit = panel.results["checkpoint"].values, unit_of(panel.results)
    known = np.flatnonzero(np.any([np.isfinite(share.right) for share in shares.values()], axis=0))
    width = axes.bbox.width * 72 / axes.figure.dpi
    widest = max(2 * len(looks), 0.7 * letters() * len(f"{checkpoints.max():,}"))  # of markers and of tick labels
    columns = min(known.size, MOST_CHECKPOINTS, max(1, int(width / widest)))
    kept = known[np.linspace(known.size - 1, 0, columns).round().astype(int)[::-1]]
    size = float(np.clip(width / columns / len(looks), 2, 7))  # the thin diamond is 0.85 times as wide
    aside = (np.arange(len(looks)) - (len(looks) - 1) / 2) * 0.86 / len(looks)
    x_of = {text: np.arange(columns) + aside[i] for i, text in enumerate(looks)}
    for text, line, style in lines_to_draw(expected, looks):
        present = np.isfinite(shares[text].right[kept] if text else line.right[kept])
        x = x_of[text] if text else np.arange(columns)
        axes.plot(x[present], 100 * line.right[kept][present], zorder=1.5, **style)
    for text, look in looks.items():
        if text not in shares:
            continue
        present = np.isfinite(shares[text].right[kept])
        x, right, all_right, low, high = (values[present] for values in (x_of[text], *(v[kept] for v in shares[text])))
        dashes = _mark(size / 2 + GAP, 0.75 * size, look.colour, float(np.clip(0.3 * size, 0.7, 1.6)), as_paper)
        label: dict[str, Any] = {"label": f"all right {text}", "zorder": 3, "clip_on": False}
        add_dots(axes, dashes, x[all_right], 100 * right[all_right], **label)
        if not as_paper:
            thin: dict[str, Any] = {"colors": look.colour, "linewidths": float(np.clip(0.12 * size, 0.4, 0.7))}
            draw_intervals(axes, x, 100 * low, 100 * high, all_right, text, alpha=0.7, zorder=2, **thin)
        diamonds = outlined_dot(look, size if look.marker == "d" else 0.7 * size, 0.06 * size)
        label |= {"label": f"right {text}", "zorder": 4}
        add_dots(axes, diamonds, x, 100 * right, **label)
    for column in np.flatnonzero(checkpoints[kept] == panel.claim):
        axes.axvspan(column - 0.5, column + 0.5, **CLAIM)
    for edge in np.arange(1, columns) - 0.5:
        axes.axvline(edge, color="0.88", linewidth=0.6, zorder=0)
    axes.axhline(100, color="0.88", linewidth=0.6, zorder=0)
    axes.set_xlim(-0.5, columns - 0.5)
    axes.set_ylim(-4, 108)  # room for diamonds at 0 and at 100
    axes.set_xticks(np.arange(columns), [f"{checkpoints[c]:,}" for c in kept])
    axes.tick_params(axis="x", length=0)
    axes.yaxis.set_major_locator(FixedLocator([0, 20, 40, 60, 80, 100]))
    note = f"; {columns} of {counted(known.size, 'checkpoint')}" if columns < known.size else ""
    name_axes(axes, f"{unit}{note}", "robots in the right bin (%)")


def _mark(height: float, width: float, colour: str, thick: float, upright: bool) -> Line2D:
    """A line of markers: dashes, `height` points above their places and `width` points long."""
    reach = max(height + width * upright, width / 2)  # matplotlib scales a marker's path to its size
    ends = [(0.0, height), (0.0, height + width)] if upright else [(-width / 2, height), (width / 2, height)]
    shape: Any = Path(ends)
    return Line2D([], [], linestyle="", marker=shape, markersize=2 * reach, color=colour, markeredgewidth=thick)
