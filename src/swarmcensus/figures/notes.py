"""Notes at the foot of a figure: what it lacks, pools and leaves out, and what its trials are too few for."""

from __future__ import annotations

import logging
from collections.abc import Sequence
from typing import Any, Literal

import xarray as xr
from matplotlib.axes import Axes

from swarmcensus.figures.clouds import lacking
from swarmcensus.figures.coordinates import pooled
from swarmcensus.figures.lettering import width_of, wrapped
from swarmcensus.figures.page import KEY_BELOW, SHEET, letters, on_dark, page, scale
from swarmcensus.figures.sheets import Own, make_room
from swarmcensus.results import TAIL, settled_far_off, shows_tail

HIDING = {"convergence_error", "final_error"}  # errors of which medians are drawn

LOG = logging.getLogger(__name__)

MOST_NAMED = 8  # settings
WARM, WARM_ON_DARK = "#a03000", "#ff9c6b"  # colours of notes
NOTES = ("key", "lacking", "pooled", "left-out", "few-trials", "far-off", "tail")  # kinds of notes at the foot


def say_lacking(axes: Sequence[Axes], parts: Sequence[xr.Dataset]) -> None:
    """Write at the foot of the figure how many trials it shows, if the run is not complete."""
    if parts and (note := lacking(parts)):
        say_at_foot(axes, f"drawn: {note}", "lacking", ha="right")


def say_pooled(axes: Sequence[Axes], parts: Sequence[xr.Dataset], by: Sequence[str]) -> None:
    """Write at the foot of the figure, and in the log, which coordinates are pooled.

    `parts` are the panels, and `by` the coordinates that a panel distinguishes.
    """
    if what := pooled(parts, by):
        say_at_foot(axes, f"pooled over {what}", "pooled")
        if page().height is None or page().high is not None:  # else the figure is drawn again
            LOG.info("settings that are drawn as one are pooled over %s", what)


def say_few(axes: Sequence[Axes], why: str) -> None:
    """Write at the foot of the figure what its trials are too few for, if anything."""
    if why:
        say_at_foot(axes, why, "few-trials")


def say_far_off(axes: Sequence[Axes], parts: Sequence[xr.Dataset]) -> None:
    """Write at the foot of a figure of K in which settings it misleads, if in any."""
    found = [number for part in parts for number in part["setting"].values[settled_far_off(part)].tolist()]
    if found:
        named = ", ".join(map(str, found[:MOST_NAMED])) + ", ..." * (len(found) > MOST_NAMED)
        what = "settled early, but far from each other or from f"
        say_at_foot(axes, f"K misleads in setting{'s' * (len(found) > 1)} {named}: {what}", "far-off")


def say_tail(axes: Sequence[Axes], results: xr.Dataset, drawn: Sequence[str], option: str) -> None:
    """Write at the foot of the figure that its median errors hide a tail, and which option draws it."""
    if HIDING.intersection(drawn) and TAIL not in drawn and shows_tail(results):
        say_at_foot(axes, f"the worst tenth of the robots may err much more: {option} = {TAIL} draws it", "tail")


def with_numbers(ax: Own, captions: Sequence[str], has: Sequence[bool]) -> list[int]:
    """The panels to draw: those that have numbers. On the caller's axes, or if none has any, these are all."""
    kept = [k for k, there in enumerate(has) if there]
    return kept if kept and ax is None else list(range(len(captions)))


def say_left_out(axes: Sequence[Axes], captions: Sequence[str], kept: Sequence[int], why: str) -> None:
    """Write at the foot of the figure which panels are left out, and why."""
    left_out = [caption for k, caption in enumerate(captions) if k not in kept]
    if left_out:
        say_at_foot(axes, f"left out, {why}: {'; '.join(left_out)}", "left-out")


def say_at_foot(axes: Sequence[Axes], note: str, kind: str, ha: Literal["left", "right"] = "left") -> None:
    """Write a note at the foot of the figure, in a free place next to or under earlier notes."""
    figure: Any = axes[0].figure.canvas.figure
    width, row = 72 * figure.get_figwidth() - 12, 10 / 72 * scale()
    lines = wrapped(note, width, letters(), 4)
    before = [text for text in figure.texts if text.get_gid() in NOTES]
    last = [text for text in before if text.get_position()[1] * figure.get_figheight() < row]
    used = sum(width_of(text.get_text().split("\n")[-1], letters()) + 12 for text in last)
    fits = (
        bool(last)
        and len(lines) == 1
        and used + width_of(note, letters()) <= width
        and all(t.get_ha() != ha for t in last)
    )
    ours = figure.get_gid() in (SHEET, KEY_BELOW)
    if ours:
        free = not before and figure.get_gid() == SHEET and not any("\n" in ax.get_xlabel() for ax in figure.axes)
        make_room(figure, row * (len(lines) - (fits or free)))
    up = 0 if ours else sum(text.get_gid() == kind for text in before)  # by earlier calls on the caller's figure
    x, colour = 6 / (72 * figure.get_figwidth()), WARM_ON_DARK if on_dark() else WARM
    figure.text(
        x if ha == "left" else 1 - x, 4 / (72 * figure.get_figheight()) + up * row / figure.get_figheight(),
        "\n".join(lines), ha=ha, va="bottom", fontsize=letters(), color=colour, gid=kind,
        parse_math=False,
    )  # fmt: skip
