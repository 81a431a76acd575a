"""The sheet that figures are drawn on: its panels, axes, looks and key, and how it is saved."""

from __future__ import annotations

import re
import string
import threading
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Literal, NamedTuple

import matplotlib as mpl
import numpy as np
from matplotlib import patheffects
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.collections import LineCollection
from matplotlib.colors import to_hex
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.ticker import FixedLocator, FuncFormatter, MaxNLocator, NullFormatter, NullLocator

from swarmcensus.errors import InputError
from swarmcensus.files import whole

Scale = Literal["log", "log-y", "linear"]  # both axes logarithmic, the y axis alone, none

SMALL = 7.5  # points: ticks and keys; axis labels and captions are a step larger
MOST_PANELS = 24

# matplotlib's settings belong to the whole process: threads that save at the same time take turns.
_settings = threading.Lock()


class Look(NamedTuple):
    """How one sensor accuracy appears: its name in the key, a short one for labels, colour and marker."""

    name: str
    short: str
    colour: str
    marker: str


def palette(count: int) -> list[str]:
    """Return `count` colours for ordered values, dark to light, as #rrggbb.

    Perceptually uniform with rising luminance: the order survives colour blindness and grey print. Both ends
    are cut off, for black has a meaning of its own and the palest end is lost on white paper.
    """
    return [to_hex(colour) for colour in mpl.colormaps["viridis"](np.linspace(0.06, 0.9, count))]


def looks_of(accuracies: Iterable[str], marker: str) -> dict[str, Look]:
    """Return the look of every distinct accuracy, in drawing order: numbers upwards, then all others.

    Numbers share `marker` and get colours by rank, darkest where sensors are worst. All others (spread over
    the swarm, or different for black and white) are black, as in the paper, and told apart by shape.
    """
    distinct = set(accuracies)
    numbers = sorted((text for text in distinct if re.fullmatch(r"\d*\.?\d+", text)), key=float)
    looks = {
        text: Look(text, text.removeprefix("0"), colour, marker)
        for text, colour in zip(numbers, palette(len(numbers)), strict=True)
    }
    for i, text in enumerate(sorted(distinct.difference(numbers))):
        name = re.sub(r",\s*", ", ", text.replace("black=", "b = ").replace(" white=", ", w = "))
        short = "b≠w" if "w = " in name else name.split("(")[0]
        looks[text] = Look(name, short, "#000000", f"{marker}s^vPXph"[i % 8])
    return looks


def solid_dot(look: Look, size: float, edge: float) -> Line2D:
    """Return a solid, outlined marker of this look, still without data: for keys and medians."""
    return Line2D(
        [], [], linestyle="", marker=look.marker, markersize=size, markerfacecolor=look.colour,
        markeredgecolor="black", markeredgewidth=edge,
    )  # fmt: skip


def halo(width: float) -> list[patheffects.AbstractPathEffect]:
    """Return a white rim of `width` points, which keeps what it surrounds legible upon dense dots."""
    return [patheffects.withStroke(linewidth=width, foreground="white")]


def new_sheet(
    count: int,
    title: str | None = None,
    *,
    size: tuple[float, float] | None = None,
    left: float = 0.65,
    right: float = 1.6,
    above: float = 0.0,
) -> list[Axes]:
    """Return `count` equal panels on a new figure, in at most 4 columns, with room for a key on the right.

    `size` is a panel's width and height (by default, small multiples are smaller), `left` and `right` are
    margins and `above` is room over each panel: all in inches.

    Raises InputError if there are none or more than 24.
    """
    if not 1 <= count <= MOST_PANELS:
        raise InputError(
            f"a figure holds 1 to {MOST_PANELS} panels, not {count}: select some of the settings, "
            "e.g. results.isel(setting=(results.topology == 'ring').values)"
        )
    columns = count if count <= 3 else {4: 2, 5: 3, 6: 3, 9: 3}.get(count, 4)
    rows = -(-count // columns)
    wide, high = size or ((4.4, 3.2) if count == 1 else (3.1, 2.4) if columns <= 3 else (2.5, 1.9))
    # Margins and gaps in inches: the room that text needs does not depend on the number of panels.
    top, bottom, gap_x, gap_y = above + (0.6 if title else 0.35), 0.55, 0.42, 0.72 + above
    width = left + columns * wide + (columns - 1) * gap_x + right
    height = bottom + rows * high + (rows - 1) * gap_y + top
    figure = Figure(figsize=(width, height))
    FigureCanvasAgg(figure)
    grid = figure.add_gridspec(
        rows, columns, left=left / width, right=1 - right / width, bottom=bottom / height,
        top=1 - top / height, wspace=gap_x / wide, hspace=gap_y / high,
    )  # fmt: skip
    if title:
        figure.suptitle(
            title, x=left / width, y=1 - 0.1 / height, ha="left", va="top", fontsize=SMALL + 3, parse_math=False
        )
    return [figure.add_subplot(grid[divmod(i, columns)]) for i in range(count)]


def caption_panels(axes: Sequence[Axes], captions: Sequence[str], above: float = 0.0) -> None:
    """Write (a), (b), ... and the captions `above` inches over the panels; a single one gets no letter."""
    for letter, ax, caption in zip(string.ascii_lowercase, axes, captions, strict=False):
        if caption or len(axes) > 1:
            text = caption if len(axes) == 1 else f"({letter}) {caption}"
            ax.set_title(text, loc="left", fontsize=SMALL + 1.5, pad=6 + 72 * above, parse_math=False)


def name_axes(axes: Axes, x: str, y: str) -> None:
    """Write the axis labels, `y` in the leftmost column only, and take away what carries no data."""
    place = axes.get_subplotspec()
    axes.set_xlabel(x, fontsize=SMALL + 1)
    if place is None or place.is_first_col():
        axes.set_ylabel(y, fontsize=SMALL + 1)
    axes.tick_params(labelsize=SMALL)
    axes.spines[["top", "right"]].set_visible(False)


def say_empty(axes: Axes) -> None:
    """Say in an empty panel that it is empty because nothing has been run."""
    axes.text(0.5, 0.5, "no trial has been run", ha="center", transform=axes.transAxes, fontsize=SMALL + 1)
    axes.set_axis_off()


def add_key(axes: Sequence[Axes], title: str, entries: dict[str, Artist]) -> None:
    """Put one key for all panels right of the first row, where it can hide no data."""
    places = [ax.get_subplotspec() for ax in axes]
    last = [ax for ax, place in zip(axes, places, strict=True) if place and place.is_last_col()]
    corner = last[0] if last else axes[-1]
    room = corner.bbox.y1 * 72 / corner.figure.dpi - 15  # points from the panel's top to the paper's end
    lines = sum(1 + name.count("\n") for name in entries)
    corner.legend(
        list(entries.values()), list(entries), title=title, loc="upper left", bbox_to_anchor=(1.02, 1.01),
        borderaxespad=0, frameon=False, title_fontsize=SMALL, alignment="left", handlelength=1.2,
        fontsize=float(np.clip(room / lines / 1.6, 3.0, SMALL)),
    )  # fmt: skip


def count_axis(axes: Axes, low: float, high: float, scale: Scale) -> None:
    """Give `axes` an x axis for counts from `low` to `high`: "log" is linear up to 1, logarithmic above."""
    if scale != "log":
        axes.set_xlim(-0.01 * high, 1.02 * high)
        axes.xaxis.set_major_locator(MaxNLocator(5))
    else:
        # Rather asinh than symlog: it has no kink. 0 is on the axis, for an estimate may have settled
        # before the first observation.
        axes.set_xscale("asinh", linear_width=1.0)
        axes.set_xlim(-0.1 if low < 10 else 10.0 ** np.floor(np.log10(low)), 1.15 * high)
        decades = 10.0 ** np.arange(np.ceil(np.log10(max(high, 1.0))) + 1)
        axes.xaxis.set_major_locator(FixedLocator([0.0, *decades]))
        axes.xaxis.set_minor_locator(FixedLocator(np.outer(decades, np.arange(2, 10)).ravel().tolist()))
        axes.xaxis.set_minor_formatter(NullFormatter())
    axes.xaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:,.0f}"))


def error_axis(axes: Axes, top: float, scale: Scale) -> None:
    """Give `axes` a y axis for errors from 0 to `top`: unless "linear", linear up to 0.01, logarithmic above."""
    if scale != "linear":
        axes.set_yscale("asinh", linear_width=0.01)
        axes.yaxis.set_minor_locator(NullLocator())
    if scale == "linear" or top < 0.02:
        axes.yaxis.set_major_locator(MaxNLocator(5))
    else:
        axes.yaxis.set_major_locator(FixedLocator([0, 0.005, 0.01, 0.02, 0.05, 0.1, 0.2, 0.5, 1.0]))
    axes.yaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
    axes.set_ylim(-min(0.0005, 0.01 * top) if scale != "linear" else -0.01 * top, top)  # cuts no dot in half


def label_dots(axes: Axes, dots: Sequence[tuple[float, float]], texts: Sequence[str]) -> None:
    """Write texts[i] above the axes, upright, with a thin line down to dots[i] (data coordinates).

    There they cover no data, and stand in the order of the dots, as straight above them as their size allows.
    The axes must have their final limits and size.
    """
    size = SMALL - 1.5
    width, height = np.array([axes.bbox.width, axes.bbox.height]) * 72 / axes.figure.dpi
    ends = np.clip(axes.transAxes.inverted().transform(axes.transData.transform(dots)), 0, 1)
    order = np.argsort(ends[:, 0], kind="stable")
    # Neighbours stand at least a line apart: pushing all to the right does it, so does pushing all to the
    # left, and so does the mean of both.
    steps = np.arange(len(ends)) * 1.2 * size / width
    wanted = ends[order, 0] - steps
    right, left = np.maximum.accumulate(wanted), np.minimum.accumulate(wanted[::-1])[::-1]
    places = np.clip((right + left) / 2, 0, max(0, 1 - steps[-1])) + steps
    starts = np.stack([places, np.full(len(ends), 1 + 2 / height)], axis=1)
    lines = np.stack([starts, ends[order]], axis=1)
    axes.add_collection(
        LineCollection(list(lines), linewidths=0.35, colors="0.3", zorder=3, transform=axes.transAxes, clip_on=False),
        autolim=False,
    )
    for i, place in zip(order, places, strict=True):
        axes.text(
            place, 1 + 3 / height, texts[i], rotation=90, ha="center", va="bottom", fontsize=size,
            transform=axes.transAxes,
        )  # fmt: skip


def save(figure: Figure, stem: Path, formats: Sequence[str] = ("png", "svg")) -> list[Path]:
    """Write a figure to `stem`.png, `stem`.svg, ... and return these paths.

    Each file appears whole or not at all, in place of an older one. PNGs have 150 dots an inch, and so have
    the layers of single dots inside an SVG or PDF; all else there is lines and text. The same figure gives
    the same bytes.

    Raises InputError for a format that matplotlib cannot write and a place that cannot be written.
    """
    known = figure.canvas.get_supported_filetypes()
    for suffix in formats:
        if suffix not in known:
            raise InputError(f"cannot write {suffix!r} files, only {', '.join(sorted(known))}")
    paths = [stem.with_name(f"{stem.name}.{suffix}") for suffix in formats]
    for suffix, path in zip(formats, paths, strict=True):
        undated = {"svg": {"Date": None}, "pdf": {"CreationDate": None}}.get(suffix)
        with whole(path) as beside, _settings, mpl.rc_context({"svg.hashsalt": "swarmcensus"}):
            figure.savefig(beside, format=suffix, dpi=150, metadata=undated)
    return paths
