"""A figure of given width that would be higher than a page is refused, with what fits."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import xarray as xr
from matplotlib.figure import Figure

from swarmcensus.figures.coordinates import brains_first_of_own, varies
from swarmcensus.summaries import TooMuch
from swarmcensus.support.errors import InputError
from swarmcensus.support.options import option

HIGHEST = 9.0  # inches: what a page of a journal has room for
MEASURE = "final_error"  # that every comparison can have
TURNS = 5  # coordinates of which values are chosen


def check_height(
    figure: Figure, results: xr.Dataset, draw: Callable[..., Figure], options: dict[str, Any], *, measures: bool
) -> None:
    """Raise InputError if a figure that `draw` made of results is too high; it says what to draw instead.

    With `measures` the kind draws several of them.
    """
    high = float(figure.get_figheight())
    if high <= HIGHEST:
        return
    what = f"at this width the figure is {high:.1f} inches high, and a page has {HIGHEST:g}"

    def height(part: xr.Dataset, **more: Any) -> float:
        try:
            return float(draw(part, **options | more).get_figheight())
        except InputError:  # such as one brain alone
            return np.inf

    if measures and height(results, metric=MEASURE) <= HIGHEST:
        raise InputError(f"{what}: draw one measure, as {option('metric', MEASURE)}", key="width")
    if chosen := _fitting(results, high, height):
        raise TooMuch(what, chosen)
    raise InputError(f"{what}: choose settings, or {option('height', HIGHEST)}", key="width")


def _fitting(results: xr.Dataset, high: float, height: Callable[[xr.Dataset], float]) -> dict[str, Any]:
    """Values of coordinates by name: a figure of the settings that have them fits. Empty if there are none."""
    chosen: dict[str, Any] = {}
    for _ in range(TURNS):
        heights: dict[str, float] = {}
        varying = {name: brains_first_of_own(values) for name, values in varies(results).items()}
        for name, values in sorted(varying.items(), key=lambda item: -len(item[1])):
            least = 1
            heights[name] = height(_with(results, name, values[:1]))
            if np.isinf(heights[name]) and len(values) > 2:  # such as one brain alone, which is no comparison
                least, heights[name] = 2, height(_with(results, name, values[:2]))
            if heights[name] > HIGHEST:
                continue
            fit = least + int((HIGHEST - heights[name]) / (high - heights[name]) * (len(values) - least))
            while fit > least and height(_with(results, name, values[:fit])) > HIGHEST:
                fit -= 1
            return chosen | {name: values[:fit] if fit > 1 else values[0]}
        best = min(heights, key=lambda name: heights[name], default="")
        if not best or np.isinf(heights[best]):
            break
        high, chosen[best] = heights[best], varying[best][0]
        results = _with(results, best, varying[best][:1])
    return {}


def _with(results: xr.Dataset, name: str, values: list[Any]) -> xr.Dataset:
    return results.isel(setting=np.isin(results[name].values, values))
