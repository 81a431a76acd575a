"""Profiles of times: the share of trials in which something has happened by each round, as in survival analysis.

A run ends for all trials of a contender at once, so the estimate of Kaplan and Meier (1958) is this share. A trial in
which nothing happened stays in it: the profile ends below 1.
"""

from typing import TYPE_CHECKING, Any

import numpy as np

from swarmcensus.analysis.comparing.standings import Standings
from swarmcensus.support.intervals import FEWEST, share_interval
from swarmcensus.support.quantities import QUANTITIES

if TYPE_CHECKING:
    import pandas as pd

COLUMNS = ("measure", "world", "contender", "trials", "round", "share", "share_low", "share_high")


def is_time(name: str) -> bool:
    """Whether a measure is a time that may never come."""
    return name in QUANTITIES and QUANTITIES[name].never


def profiles(standings: Standings) -> "pd.DataFrame":
    """See `Comparison.profiles`."""
    import pandas as pd

    rows: list[tuple[Any, ...]] = []
    for measure, contest in zip(standings.measures, standings.contests, strict=True):
        if not is_time(measure.name):
            continue
        for world, contender in np.argwhere(standings.settings >= 0).tolist():
            times = contest.numbers[world, contender]
            times = times[~np.isnan(times)]
            if not times.size:
                continue
            last = standings.rounds[world, contender]
            for at in np.unique([0.0, *times[np.isfinite(times)], last]).tolist():
                hits = int((times <= at).sum())
                share, low, high = share_interval(hits, times.size)
                if times.size < FEWEST:
                    low = high = np.nan
                rows.append((measure.name, world, standings.contenders[contender], times.size, at, share, low, high))
    return pd.DataFrame(rows, columns=list(COLUMNS))
