"""Which contenders are compared trial by trial: those with trials that share random numbers."""

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from swarmcensus.analysis.comparing.contenders import NONE, Grid
from swarmcensus.analysis.comparing.pair_tests import ends_of_pairs
from swarmcensus.studies import addresses
from swarmcensus.summaries import Origins

BRAINS_SHARE = "paired by trial: trials of one number share readings, networks and all else that chance decides"
UNKNOWN = "not paired: these results do not say which random numbers their trials share"


def pairing_of(data: xr.Dataset, grid: Grid, origins: Origins) -> tuple[NDArray[np.bool_], list[str]]:
    """Which pairs are compared trial by trial in which worlds, (world, pair), and why, a sentence each.

    Brains meet the same random numbers. Settings that differ in something else share those with equal addresses.
    """
    ends = grid.place[:, ends_of_pairs(len(grid.contenders))]
    there = (ends != NONE).all(axis=1)
    if grid.factor in ((), ("brain",)):
        return np.ones(there.shape, np.bool_), [BRAINS_SHARE]
    # random numbers follow from addresses: equal addresses in both settings give equal numbers
    known = [(place, origins[n]) for place, n in enumerate(data["setting"].values.tolist()) if n in origins]
    streams = {place: addresses.streams(setting, study.seed) for place, (study, setting) in known}
    paired = np.zeros(there.shape, np.bool_)
    if not streams:
        return paired, [UNKNOWN]
    shared: dict[str, None] = {}
    for k, world in np.argwhere(there.T).tolist():
        one, other = (streams[place] for place in ends[world, :, k])
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
        some, names = "the others are " * bool(paired.any()), " and ".join(grid.factor)
        reasons.append(f"{some}not paired: their random numbers depend on {names}, so trials share none of them")
    return paired, reasons
