"""Picture of the leaderboard: one row per contender, one column per kind of world; darker is worse."""

from collections.abc import Collection, Sequence

import numpy as np
from matplotlib.colors import LogNorm
from matplotlib.figure import Figure
from matplotlib.ticker import NullFormatter
from numpy.typing import NDArray

from swarmcensus.figures.lettering import write_numbers

LEAST = 1e-3  # smaller errors have the same colour
SIZE = 7.0  # points: the numbers


def draw_board(
    names: Sequence[str], columns: Sequence[str], values: NDArray[np.float64], marked: Collection[str] = ()
) -> Figure:
    """Draw errors (contender, column), the best contender first. The names in `marked` are bold."""
    rows, count = values.shape
    figure = Figure(figsize=(2.6 + 0.72 * count, 1.5 + 0.215 * rows), layout="constrained")
    axes = figure.add_subplot()
    known = values[np.isfinite(values)]
    norm = LogNorm(max(LEAST, known.min(initial=1.0)), max(known.max(initial=LEAST), 2 * LEAST), clip=True)
    image = axes.imshow(values, cmap="cividis_r", norm=norm, aspect="auto")
    write_numbers(axes, image, values, "{:.3f}".format, SIZE)
    axes.set_xticks(range(count), columns, size=SIZE + 1, rotation=35, ha="left", rotation_mode="anchor")
    axes.set_yticks(range(rows), names, size=SIZE + 1)
    for label, name in zip(axes.get_yticklabels(), names, strict=True):
        label.set_fontweight("bold" if name in marked else "normal")
    axes.tick_params(length=0, labeltop=True, labelbottom=False, top=False)
    axes.spines[:].set_visible(False)
    bar = figure.colorbar(image, ax=axes, pad=0.01, fraction=0.03)
    bar.set_label("error of the last estimate", size=SIZE + 1)
    bar.ax.tick_params(which="both", labelsize=SIZE)
    bar.ax.yaxis.set_major_formatter("{x:g}")
    bar.ax.yaxis.set_minor_formatter(NullFormatter())
    return figure
