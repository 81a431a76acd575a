"""When a curve of shares reaches the confidence, with the interval of that time."""

import math
from typing import NamedTuple

import numpy as np

from swarmcensus.planning.trying import Curve, Floats, Share


class Reached(NamedTuple):
    """The round from which on enough robots are right, and the share then; `low` and `high` are its 95 % interval.

    `high` is None where the share is never surely above the confidence.
    """

    rounds: int
    low: int
    high: int | None
    share: Share


def reached(curve: Curve, confidence: float) -> Reached | None:
    """When the confidence is reached and kept; None where it is not.

    More evidence makes more robots right, so that shares and both ends of their intervals are sorted by size: chance
    makes a curve cross the confidence back and forth, and its first crossing would be early, its last one late
    (Chernozhukov, Fernandez-Val and Galichon, 2009, "Improving point and interval estimators of monotone functions by
    rearrangement"). Between two times that were looked at the curve is a line.
    """
    every = [curve.at(k) for k in range(len(curve.rounds))]
    expected = [curve.expected(k) for k in range(len(curve.rounds))]
    begin = _lost([one.low >= confidence for one in every], [one.high < confidence for one in every])
    rounds, shares = curve.rounds[begin:], np.sort(expected[begin:])
    lows, highs = (np.sort([getattr(one, end) for one in every[begin:]]) for end in ("low", "high"))
    at, first, last = (_crossing(rounds, each, confidence) for each in (shares, highs, lows))
    if at is None or first is None:
        return None
    found = math.ceil(at)
    share = Share(*(float(np.interp(found, rounds, each)) for each in (shares, lows, highs)))
    return Reached(found, math.floor(first), None if last is None else math.ceil(last), share)


def _crossing(rounds: list[int], shares: Floats, confidence: float) -> float | None:
    """Where shares that never fall reach the confidence; None where they do not."""
    k = int(np.searchsorted(shares, confidence))
    if k == shares.size:
        return None
    if k == 0:
        return rounds[0]
    part = (confidence - shares[k - 1]) / (shares[k] - shares[k - 1])
    return float(rounds[k - 1] + part * (rounds[k] - rounds[k - 1]))


def _lost(above: list[bool], below: list[bool]) -> int:
    """The first place after which no time surely above the confidence is followed by one that is surely below it."""
    last_below = max(np.flatnonzero(below), default=0)
    return 1 + int(max(np.flatnonzero(above[:last_below]), default=-1))
