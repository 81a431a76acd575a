"""Warnings about settings with results that are easily misread."""

from __future__ import annotations

import warnings

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from swarmcensus.worlds import read_change

LEAST = 0.05  # share of a setting's robots from which a warning is given
MOST_NAMED = 8  # settings


def settled_at_start(data: xr.Dataset) -> NDArray[np.float64]:
    """The share of robots with convergence 0 over all trials, (setting,); NaN without a trial.

    The estimates of such a robot never left its first belief by delta or more. Often this is because the fill ratio is
    0.5, where brains begin.
    """
    when = data["convergence_round"].transpose("setting", "trial", "robot").values
    known = (when >= 0).sum(axis=(1, 2))
    share: NDArray[np.float64] = np.where(known, (when == 0).sum(axis=(1, 2)) / np.maximum(known, 1), np.nan)
    return share


def warn_of(data: xr.Dataset) -> None:
    """Give all warnings about these results, for the line that called the caller."""
    warn_of_start(data, stacklevel=4)
    warn_of_edges(data, stacklevel=4)


def warn_of_start(data: xr.Dataset, stacklevel: int = 2) -> None:
    """Warn about settings in which 5 % of the robots or more converged before their first observation."""
    shares = settled_at_start(data)
    found = np.flatnonzero(shares >= LEAST)
    if not found.size:
        return
    numbers = data["setting"].values[found]
    named = ", ".join(map(str, numbers[:MOST_NAMED])) + (", ..." if found.size > MOST_NAMED else "")
    highest = f"{'up to ' if found.size > 1 else ''}{100 * shares[found].max():.0f} %"
    delta = f" = {data.attrs['delta']:g}" if "delta" in data.attrs else ""
    warnings.warn(
        f"setting{'s' if found.size > 1 else ''} {named}: {highest} of the robots have K = 0: their estimates never "
        f"left what they believed before any observation by delta{delta} or more. There, K does not "
        "tell how fast robots learn: choose another fill ratio, or a smaller delta under [measure]",
        stacklevel=stacklevel,
    )


def warn_of_edges(data: xr.Dataset, stacklevel: int = 2) -> None:
    """Warn about fill ratios on the edge between two bins: estimates just below it count as wrong."""
    if data.attrs["truth"] != "nominal":  # each trial has its own true fill ratio
        return
    bins = int(data.attrs["bins"])
    changes = map(read_change, np.unique(data["fill_ratio_change"].values)) if "fill_ratio_change" in data else ()
    values = np.unique([*data["fill_ratio"].values, *(one.first for one in changes if one)])
    found = [f"{value:g}" for value in values[np.isin(values, np.arange(1, bins) / bins)]]
    if not found:
        return
    named = ", ".join(found[:MOST_NAMED]) + (", ..." if len(found) > MOST_NAMED else "")
    warnings.warn(
        f"fill ratio {named} {'lies' if len(found) == 1 else 'lie'} on the edge between two of the {bins} bins: about "
        "half of good estimates are in the wrong one. Choose another number of bins under [measure], or another fill "
        "ratio",
        stacklevel=stacklevel,
    )
