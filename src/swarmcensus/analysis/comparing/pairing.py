"""Which contenders are compared trial by trial: those with trials that share random numbers."""

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from swarmcensus.analysis.comparing.contenders import NONE, Grid
from swarmcensus.analysis.comparing.pair_tests import pairs_of
from swarmcensus.results import origins_of
from swarmcensus.studies import addresses
from swarmcensus.support.errors import InputError

BRAINS_SHARE = "paired by trial: trials of one number share readings, networks and all else that chance decides"
UNKNOWN = "not paired: these results do not say which random numbers their trials share"


def pairing_of(data: xr.Dataset, grid: Grid) -> tuple[NDArray[np.bool_], list[str]]:
    """Which pairs are compared trial by trial in which worlds, (world, pair), and why, a sentence each.

    Brains meet the same random numbers. Settings that differ in something else share those with equal addresses.
    """
    pairs = pairs_of(len(grid.contenders))
    if grid.factor in ((), ("brain",)):
        return np.ones((len(grid.worlds), len(pairs)), np.bool_), [BRAINS_SHARE]
    streams = _streams(data, grid)
    paired = np.zeros((len(grid.worlds), len(pairs)), np.bool_)
    if streams is None:
        return paired, [UNKNOWN]
    shared: dict[str, None] = {}
    there = np.zeros_like(paired)
    for k, (first, second) in enumerate(pairs):
        for world, row in enumerate(grid.place):
            if NONE in (row[first], row[second]):
                continue
            there[world, k] = True
            one, other = streams[row[first]], streams[row[second]]
            common = [what for what, address in one.items() if other.get(what) == address]
            paired[world, k] = bool(common)
            shared |= dict.fromkeys(common)
    reasons = []
    if paired.any():
        some = "" if paired[there].all() else "some pairs are "
        *most, last = shared
        names = f"{', '.join(most)} and {last}" if most else last
        reasons.append(f"{some}paired by trial: trials of one number share {names}")
    if not paired[there].all():
        some = "the others are " if paired.any() else ""
        names = " and ".join(grid.factor)
        reasons.append(f"{some}not paired: their random numbers depend on {names}, so trials share none of them")
    return paired, reasons


def _streams(data: xr.Dataset, grid: Grid) -> dict[int, dict[str, object]] | None:
    """The addresses of the random numbers of each place; None if the results do not tell their studies."""
    if not {"study", "merged"} & data.attrs.keys() or "fingerprint" not in data:
        return None
    places = np.unique(grid.place[grid.place != NONE]).tolist()
    numbers = data["setting"].values[places].tolist()
    try:
        origins = origins_of(data, numbers)
    except InputError:
        return None
    found = {}
    for place, number in zip(places, numbers, strict=True):
        study, setting = origins[number]
        found[place] = addresses.streams(setting, study.seed)
    return found
