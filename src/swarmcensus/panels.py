"""What figures share: panels on a sheet, a look for each accuracy, axes from 0, labels and keys that hide nothing."""

from __future__ import annotations

import re
import string
from collections.abc import Iterable, Sequence
from typing import Any, Literal, NamedTuple

import matplotlib as mpl
import numpy as np
import xarray as xr
from matplotlib import patheffects
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.colors import to_hex
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.ticker import FixedLocator, FuncFormatter, MaxNLocator, NullFormatter, NullLocator
from numpy.typing import NDArray

from swarmcensus.errors import InputError

Scale = Literal["log", "linear"]

SMALL = 7.5  # points: ticks and keys; axis labels and captions are a step larger
MOST_PANELS = 24
CAPTIONS = {  # how a caption names the coordinates that vary
    "topology": "{}",
    "brain": "{}",
    "robots": "N = {:,.0f}",
    "density": "D = {:g}",
    "fill_ratio": "f = {:g}",
    "rounds": "C = {:,.0f}",
    "observations_per_round": "R = {:,.0f}",
}


class Panel(NamedTuple):
    """One panel of a grid: its caption, its results and, for a scatter, two options."""

    caption: str
    results: xr.Dataset
    local: bool = False
    error_limit: float | None = None


def panels_of(results: xr.Dataset) -> list[Panel]:
    """Split a study's results into panels: one for each combination of all coordinates but the accuracy.

    Panels come in the order of the settings. Captions name only what varies, e.g. "ring, N = 100, f = 0.55".

    Raises InputError if `results` has no settings.
    """
    require(results, "accuracy")
    varying = varies(results, {"accuracy"})
    combinations = list(zip(*varying.values(), strict=True)) or [()] * results.sizes["setting"]
    panels = []
    for combination in dict.fromkeys(combinations):
        mine = [i for i, other in enumerate(combinations) if other == combination]
        named = zip(varying, combination, strict=True)
        parts = [CAPTIONS.get(name, name + " = {}").format(value) for name, value in named if value is not None]
        panels.append(Panel(", ".join(parts), results.isel(setting=mine)))
    return panels


def varies(results: xr.Dataset, apart_from: set[str]) -> dict[str, list[Any]]:
    """Return the values of every coordinate of `setting` that has more than one; None stands for NaN."""
    order = [*CAPTIONS, *sorted(str(name) for name in results.coords if name not in CAPTIONS)]
    found = {}
    for name in order:
        if name in results.coords and results[name].dims == ("setting",) and name not in {"setting", *apart_from}:
            values = [None if value != value else value for value in results[name].values.tolist()]
            if len(set(values)) > 1:
                found[name] = values
    return found


def require(data: xr.Dataset, *names: str, dimension: str = "setting") -> None:
    """Raise InputError unless `data` has the dimension, with a length, and the variables `names`."""
    if not data.sizes.get(dimension):
        raise InputError(f"this dataset has nothing along the dimension {dimension!r}: select with a list or mask")
    missing = [name for name in names if name not in data.variables]
    if missing:
        raise InputError(
            f"this dataset has no {missing[0]!r}"
            + (": set local = true under [measure] and run again" if missing[0].startswith("local_") else "")
        )


class Look(NamedTuple):
    """How one sensor accuracy appears: its name in the key, a short one beside dots, colour and marker."""

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


def looks(accuracies: Iterable[str], marker: str) -> dict[str, Look]:
    """Return the look of every distinct accuracy, in drawing order: numbers upwards, then all others.

    Numbers share `marker` and get colours by rank, darkest where sensors are worst. All others (spread over
    the swarm, or different for black and white) are black, as in the paper, and told apart by shape.
    """
    distinct = set(accuracies)
    numbers = sorted(filter(_is_number, distinct), key=float)
    others = sorted(distinct.difference(numbers))
    result = {
        text: Look(text, text.removeprefix("0"), colour, marker)
        for text, colour in zip(numbers, palette(len(numbers)), strict=True)
    }
    for i, text in enumerate(others):
        name = re.sub(r",\s*", ", ", text.replace("black=", "b = ").replace(" white=", ", w = "))
        result[text] = Look(name, name.split("(")[0], "#000000", f"{marker}s^vPXph"[i % 8])
    return result


def _is_number(text: str) -> bool:
    return re.fullmatch(r"\d*\.?\d+", text) is not None


def dot(look: Look, size: float, edge: float = 0.8) -> Line2D:
    """Return a solid marker of this look with a black outline, without data: for keys and medians."""
    return Line2D(
        [], [], linestyle="", marker=look.marker, markersize=size, markerfacecolor=look.colour,
        markeredgecolor="black", markeredgewidth=edge,
    )  # fmt: skip


def sheet(
    count: int,
    title: str | None = None,
    *,
    size: tuple[float, float] | None = None,
    left: float = 0.65,
    right: float = 1.5,
    above: float = 0.0,
) -> tuple[Figure, list[Axes]]:
    """Return a figure with `count` equal panels in at most 4 columns, and room for a key on the right.

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
        figure.suptitle(title, x=left / width, y=1 - 0.1 / height, ha="left", va="top", fontsize=SMALL + 3)
    return figure, [figure.add_subplot(grid[divmod(i, columns)]) for i in range(count)]


def caption_panels(axes: Sequence[Axes], captions: Sequence[str], above: float = 0.0) -> None:
    """Write (a), (b), ... and the captions `above` inches over the panels; a single one gets no letter."""
    for letter, ax, caption in zip(string.ascii_lowercase, axes, captions, strict=False):
        if caption or len(axes) > 1:
            text = caption if len(axes) == 1 else f"({letter}) {caption}"
            ax.set_title(text, loc="left", fontsize=SMALL + 1.5, pad=6 + 72 * above)


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


def key(axes: Sequence[Axes], title: str, entries: dict[str, Artist]) -> None:
    """Put one key for all panels right of the first row, where it can hide no data."""
    specs = [ax.get_subplotspec() for ax in axes]
    corner = next((ax for ax, s in zip(axes, specs, strict=True) if s and s.is_last_col()), axes[-1])
    room = axes[0].figure.bbox.height * 72 / axes[0].figure.dpi - 60
    corner.legend(
        list(entries.values()), list(entries), title=title, loc="upper left", bbox_to_anchor=(1.02, 1.03),
        borderaxespad=0, frameon=False, title_fontsize=SMALL, alignment="left", handlelength=1.2,
        fontsize=float(np.clip(room / len(entries) / 1.55, 3.0, SMALL)),
    )  # fmt: skip


def count_axis(axes: Axes, low: float, high: float, scale: Scale) -> None:
    """Give `axes` an x axis for counts from `low` to `high`: "log" is linear up to 1, logarithmic above."""
    if scale == "linear":
        axes.set_xlim(-0.01 * high, 1.02 * high)
        axes.xaxis.set_major_locator(MaxNLocator(5))
    else:
        # Rather asinh than symlog: it has no kink. 0 is on the axis, for an estimate may have settled
        # before the first observation.
        axes.set_xscale("asinh", linear_width=1.0)
        axes.set_xlim(-0.1 if low < 10 else 10.0 ** np.floor(np.log10(low)), high * 1.15)
        decades = 10.0 ** np.arange(np.ceil(np.log10(max(high, 1.0))) + 1)
        axes.xaxis.set_major_locator(FixedLocator([0.0, *decades]))
        axes.xaxis.set_minor_locator(FixedLocator(np.outer(decades, np.arange(2, 10)).ravel().tolist()))
        axes.xaxis.set_minor_formatter(NullFormatter())
    axes.xaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:,.0f}"))


def error_axis(axes: Axes, top: float, scale: Scale) -> None:
    """Give `axes` a y axis for errors from 0 to `top`: "log" is linear up to 0.01, logarithmic above."""
    if scale == "log":
        axes.set_yscale("asinh", linear_width=0.01)
        axes.yaxis.set_minor_locator(NullLocator())
    if scale == "linear" or top < 0.02:
        axes.yaxis.set_major_locator(MaxNLocator(5))
    else:
        axes.yaxis.set_major_locator(FixedLocator([0, 0.005, 0.01, 0.02, 0.05, 0.1, 0.2, 0.5, 1.0]))
    axes.yaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
    axes.set_ylim(-0.0005 if scale == "log" else -0.01 * top, top)  # below 0: no dot is cut in half


def label_dots(axes: Axes, dots: Sequence[tuple[float, float]], texts: Sequence[str]) -> None:
    """Write texts[i] above the axes, upright, with a thin line down to dots[i] (data coordinates).

    There they cover no data, and stand in the order of the dots, as straight above them as their size allows.
    The axes must have their final limits and size.
    """
    size = SMALL - 1.5
    to_points = 72 / axes.figure.dpi
    x = (axes.transData.transform(dots)[:, 0] - axes.bbox.x0) * to_points
    order = np.argsort(x, kind="stable")
    # Neighbours at least a line apart: pushing all to the right does it, so does pushing all to the left,
    # and so does the mean of both.
    steps = np.arange(x.size) * 1.2 * size
    wanted = x[order] - steps
    right, left = np.maximum.accumulate(wanted), np.minimum.accumulate(wanted[::-1])[::-1]
    width, height = axes.bbox.size * to_points
    places = np.clip((right + left) / 2, 0, max(0, width - steps[-1])) + steps
    for i, place in zip(order, places, strict=True):
        axes.annotate(
            texts[i], dots[i], xytext=(place, height + 2), textcoords="axes points", rotation=90, ha="center",
            va="bottom", fontsize=size, zorder=3, annotation_clip=False,
            arrowprops=dict(arrowstyle="-", linewidth=0.35, color="0.3", shrinkA=0, shrinkB=0, relpos=(0.5, 0)),
        )  # fmt: skip


def halo(width: float) -> list[patheffects.AbstractPathEffect]:
    """Return a white rim of `width` points, which keeps what it surrounds legible upon dense dots."""
    return [patheffects.withStroke(linewidth=width, foreground="white")]
