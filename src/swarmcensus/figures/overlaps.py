"""Lines that lie upon one another: where several do, those above are dashed, and each shows in the gaps of the next."""

import itertools
from collections.abc import Callable, Mapping
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

Piece = tuple[float, float, float, float]  # x and y of one point, and of the next
SOLID = "-"
DASH = 6.0  # points


class Stretch(NamedTuple):
    """A part of a line, from point to point, and matplotlib's style of it."""

    x: NDArray[np.float64]
    y: NDArray[np.float64]
    style: Any


def stretches(
    lines: Mapping[str, tuple[NDArray[np.float64], NDArray[np.float64]]], hides: Callable[[Piece], bool]
) -> dict[str, list[Stretch]]:
    """Cut lines, x and y of their points from left to right, where they come to lie upon others or leave them.

    `hides` says of a piece, from one point to the next, whether a line there would hide another. The first of those
    that share a stretch is solid. A line that shares none is one stretch.
    """
    here: dict[Piece, list[str]] = {}
    pieces = {name: list(zip(x, y, x[1:], y[1:], strict=False)) for name, (x, y) in lines.items()}
    for name, some in pieces.items():
        for piece in some:
            here.setdefault(piece, []).append(name)
    found = {}
    for name, (x, y) in lines.items():
        shared = [here[piece] if hides(piece) else [name] for piece in pieces[name]]
        styles = [_style(several.index(name), len(several)) for several in shared]
        ends = [0, *(k for k in range(1, len(styles)) if styles[k] != styles[k - 1]), len(styles)]
        found[name] = (
            [
                Stretch(x[first : last + 1], y[first : last + 1], styles[first])
                for first, last in itertools.pairwise(ends)
            ]
            if any(style != SOLID for style in styles)
            else [Stretch(x, y, SOLID)]
        )
    return found


def _style(place: int, several: int) -> Any:
    return SOLID if place == 0 else (place * DASH, (DASH, (several - 1) * DASH))
