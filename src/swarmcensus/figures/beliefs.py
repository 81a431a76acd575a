"""Lines of the cost of wrong beliefs: the errors of settings by what robots believe of their sensors, and theory."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import xarray as xr
from matplotlib.axes import Axes

from swarmcensus.analysis import Cost, accuracy_of, costs, costs_of, goes_to
from swarmcensus.figures.coordinates import Panel
from swarmcensus.figures.styles import OFF, Look
from swarmcensus.support.errors import InputError
from swarmcensus.support.intervals import Floats
from swarmcensus.worlds import Accuracy

X_NAME = "belief: assumed minus true accuracy"
PREDICTED: dict[str, Any] = {"linestyle": (0, (4, 2)), "linewidth": 0.9}
FINE = 401  # points of a predicted line
SIZES = 6.5, 3.5  # points: the first dot and the last, so that none hides another


def with_beliefs(results: xr.Dataset) -> xr.Dataset:
    """Results with the coordinate "belief": by how much the assumed accuracy is off, or what is believed at random.

    Raises InputError as `costs` does.
    """
    texts = [_text(cost) for cost in costs(results)]
    return results.assign_coords(belief=("setting", np.array(texts, object)))


def _text(cost: Cost) -> str:
    if cost.error is not None:
        return f"{OFF}{cost.error:.12g}"
    text = cost.belief.removeprefix(OFF).replace(".0,", ",").replace(",", ", ")
    return f"{text}\nrandom\nerror" if cost.belief.startswith(OFF) else f"all\nbelieve\n{text}"


def costs_in(results: xr.Dataset, panels: Sequence[Panel]) -> list[list[Cost]]:
    """The costs of the settings of each panel. Raises InputError if a panel does not tell two settings apart."""
    numbers, found = results["setting"].values.tolist(), []
    for panel in panels:
        rows = [numbers.index(number) for number in panel.results["setting"].values.tolist()]
        found.append(costs_of(results.isel(setting=rows)))
        if len({(cost.accuracy, cost.belief) for cost in found[-1]}) < len(rows):
            raise InputError("lines: of beliefs, a panel should hold one setting for each accuracy", key="cols")
    return found


def series_of(costs: Sequence[Cost]) -> dict[str, dict[str, Floats]]:
    """The median, its interval, and 0, by accuracy and belief."""
    series: dict[str, dict[str, Floats]] = {}
    for cost in costs:
        series.setdefault(cost.accuracy, {})[_text(cost)] = np.array([cost.median, cost.low, cost.high, 0.0])
    return series


def draw_predicted(axes: Axes, costs: Sequence[Cost], looks: Mapping[str, Look]) -> None:
    """Draw the errors that theory predicts for each accuracy after endless observation, by the error of the belief."""
    for text, look in looks.items():
        found = [cost for cost in costs if cost.accuracy == text and np.isfinite(cost.predicted)]
        if found:
            true, f = accuracy_of(text), found[0].fill_ratio
            assert isinstance(true, Accuracy)
            errors = [cost.error for cost in found if cost.error is not None]
            fine = np.linspace(min(errors), max(errors), FINE)
            off = np.abs(goes_to(true, fine, f) - f)
            axes.plot(fine, off, **PREDICTED, color=look.colour, label=f"predicted {text}", zorder=1.7)
