"""Names of dots over a panel, where they cover no data, with thin lines down to the dots."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.backend_bases import RendererBase
from matplotlib.collections import LineCollection
from numpy.typing import NDArray

from swarmcensus.figures.sheets import SMALL

MOST_NAMED = 24  # dots of a panel
NAMES = SMALL - 1.5  # points: names of dots over a panel


class _Leaders(LineCollection):
    """Lines from names over the axes down to dots, wherever these are when they are drawn."""

    def __init__(self, axes: Axes, starts: NDArray[np.float64], dots: NDArray[np.float64]) -> None:
        super().__init__([], linewidths=0.35, colors="0.3", zorder=3, transform=axes.transAxes, clip_on=False)
        self.starts, self.dots = starts, dots
        self.lead(axes)

    def lead(self, axes: Axes) -> None:
        self.set_segments(list(np.stack([self.starts, _ends_of(axes, self.dots)], axis=1)))

    def draw(self, renderer: RendererBase) -> None:
        # Limits that are shared, or zoomed, may be others than they were.
        assert isinstance(self.axes, Axes)
        self.lead(self.axes)
        super().draw(renderer)


def _ends_of(axes: Axes, dots: Sequence[tuple[float, float]] | NDArray[np.float64]) -> NDArray[np.float64]:
    """Where dots are upon the axes, those beyond at their edge."""
    ends = axes.transAxes.inverted().transform(axes.transData.transform(dots))
    return np.asarray(np.clip(ends, 0, 1), np.float64)


def label_dots(axes: Axes, dots: Sequence[tuple[float, float]], texts: Sequence[str]) -> bool:
    """Write texts[i] above the axes, upright, with a thin line down to dots[i] (data coordinates).

    There they cover no data, and stand in the order of the dots, as straight above them as their size allows.
    Of more than fit some are named, evenly chosen, and far apart: their lines would hide what is below. The axes must
    have their final limits and size. Returns whether all are named.
    """
    size = NAMES
    width, height = np.array([axes.bbox.width, axes.bbox.height]) * 72 / axes.figure.dpi
    ends = _ends_of(axes, dots)
    order = np.argsort(ends[:, 0], kind="stable")
    if len(order) > min(MOST_NAMED, 1 + width / (1.2 * size)):
        few = int(1 + width / (4 * size))
        order = order[np.linspace(0, len(order) - 1, few).round().astype(int)]
    ends, texts = ends[order], [texts[i] for i in order]
    # Neighbours stand at least a line apart: pushing all to the right does it, so does pushing all to the
    # left, and so does the mean of both.
    steps = np.arange(len(ends)) * 1.2 * size / width
    wanted = ends[:, 0] - steps
    right, left = np.maximum.accumulate(wanted), np.minimum.accumulate(wanted[::-1])[::-1]
    places = np.clip((right + left) / 2, 0, max(0, 1 - steps[-1])) + steps
    starts = np.stack([places, np.full(len(ends), 1 + 2 / height)], axis=1)
    axes.add_collection(_Leaders(axes, starts, np.array(dots)[order]), autolim=False)
    for place, text in zip(places, texts, strict=True):
        axes.text(
            place, 1 + 3 / height, text, rotation=90, ha="center", va="bottom", fontsize=size,
            transform=axes.transAxes,
        )  # fmt: skip
    return len(order) == len(dots)
