"""When a curve of shares reaches the confidence, with the interval of that time."""

from typing import NamedTuple

import numpy as np

from swarmcensus.planning.trying import Curve, Share


class Reached(NamedTuple):
    """The first looked-at round from which on enough robots are right; `low` and `high` are the ends of its interval.

    The interval is of the rounds at which the 95 % interval of the share holds the confidence: the true round, at which
    the true share is just that, is among them in 95 of 100 cases. `high` is None where the share is never surely
    above.
    """

    rounds: int
    low: int
    high: int | None
    share: Share


def reached(curve: Curve, confidence: float) -> Reached | None:
    """When the confidence is reached and kept to the end; None where it is not."""
    k = _from(curve.shares.mean(axis=1) >= confidence)
    if k is None:
        return None
    ends = [curve.at(i) for i in range(len(curve.rounds))]
    first = next(i for i, one in enumerate(ends) if one.high >= confidence)
    high = next((n for n, one in zip(curve.rounds[k:], ends[k:], strict=True) if one.low >= confidence), None)
    return Reached(curve.rounds[k], curve.rounds[min(first, k)], high, ends[k])


def _from(holds: np.ndarray) -> int | None:
    """The first place from which on something holds to the end."""
    lacking = np.flatnonzero(~holds)
    first = int(lacking[-1]) + 1 if lacking.size else 0
    return first if first < holds.size else None
