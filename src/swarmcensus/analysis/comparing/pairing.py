"""Which contenders are compared trial by trial: those with trials that share random numbers."""

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from swarmcensus.analysis.comparing.contenders import NONE, Grid
from swarmcensus.analysis.comparing.pair_tests import pairs_of
from swarmcensus.results import Origins
from swarmcensus.studies import addresses

BRAINS_SHARE = "paired by trial: trials of one number share readings, networks and all else that chance decides"
UNKNOWN = "not paired: these results do not say which random numbers their trials share"


def pairing_of(data: xr.Dataset, grid: Grid, origins: Origins) -> tuple[NDArray[np.bool_], list[str]]:
    """Which pairs are compared trial by trial in which worlds, (world, pair), and why, a sentence each.

    Brains meet the same random numbers. Settings that differ in something else share those with equal addresses.
    """
    pairs = pairs_of(len(grid.contenders))
    if grid.factor in ((), ("brain",)):
        return np.ones((len(grid.worlds), len(pairs)), np.bool_), [BRAINS_SHARE]
    numbers = dict(enumerate(data["setting"].values.tolist()))
    streams = {
        place: addresses.streams(origins[number][1], origins[number][0].seed)
        for place, number in numbers.items()
        if number in origins
    }
    paired = np.zeros((len(grid.worlds), len(pairs)), np.bool_)
    if not streams:
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
