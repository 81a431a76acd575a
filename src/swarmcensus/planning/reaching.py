"""When a curve of shares reaches the confidence, with the interval of that time."""

from typing import NamedTuple

import numpy as np

from swarmcensus.planning.trying import Curve, Share


class Reached(NamedTuple):
    """The first looked-at round from which on enough robots are right; `low` and `high` are the ends of its interval.

    The interval reaches from the last round before which the whole 95 % interval of the share lies below the confidence
    to the first whose interval lies above it. The true round, at which the true share is the confidence, is within it
    in 95 of 100 cases: at that round the share's interval holds it. `high` is None where the share is
    never surely above.
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
    return Reached(curve.rounds[k], curve.rounds[max(min(first, k) - 1, 0)], high, ends[k])


def _from(holds: np.ndarray) -> int | None:
    """The first place from which on something holds to the end."""
    lacking = np.flatnonzero(~holds)
    first = int(lacking[-1]) + 1 if lacking.size else 0
    return first if first < holds.size else None
