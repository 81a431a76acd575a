"""By how much contenders differ from a reference in each world."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from swarmcensus.analysis.comparing.pair_tests import ends_of_pairs
from swarmcensus.analysis.comparing.standings import Standings
from swarmcensus.summaries import Measure
from swarmcensus.support.intervals import Floats


class Effect(NamedTuple):
    """The differences of a measure between contenders and the reference, (world, contender).

    `low` and `high` are the ends of 95 % intervals over trials. NaN is a missing contender, or interval.
    """

    measure: Measure
    value: Floats
    low: Floats
    high: Floats
    apart: NDArray[np.bool_]


def effects(standings: Standings, reference: int) -> list[Effect]:
    """The effect of each measure: the differences of `Comparison.pairs`, all minus the reference."""
    found = []
    first, second = ends_of_pairs(len(standings.contenders))
    for measure, contest in zip(standings.measures, standings.contests, strict=True):
        value, low, high = np.full((3, *contest.values.shape), np.nan)
        apart = np.zeros(contest.values.shape, np.bool_)
        for k in np.flatnonzero((first == reference) | (second == reference)):
            contender, sign = (first[k], 1.0) if second[k] == reference else (second[k], -1.0)
            # + 0.0, as a difference of none should not be -0.0
            value[:, contender] = sign * contest.difference[:, k] + 0.0
            ends = np.stack([sign * end[:, k] for end in contest.difference_ends])
            low[:, contender], high[:, contender] = np.sort(ends, axis=0)
            apart[:, contender] = contest.apart[:, k]
        found.append(Effect(measure, value, low, high, apart))
    return found
