"""Numbers in the cells of an image, in black or white, whichever reads better."""

from collections.abc import Callable

import numpy as np
from matplotlib.axes import Axes
from matplotlib.image import AxesImage
from numpy.typing import NDArray


def write_numbers(
    axes: Axes, image: AxesImage, values: NDArray[np.float64], told: Callable[[float], str], size: float
) -> None:
    """Write each finite value (row, column) into its cell."""
    red, green, blue, _ = np.moveaxis(image.to_rgba(values), -1, 0)
    bright = 0.2126 * red**2.2 + 0.7152 * green**2.2 + 0.0722 * blue**2.2 > 0.18  # WCAG: black reads better
    for row, column in np.argwhere(np.isfinite(values)):
        axes.text(
            column, row, told(values[row, column]), ha="center", va="center",
            fontsize=size, color="black" if bright[row, column] else "white",
        )  # fmt: skip
