"""Finds the smallest swarm that is enough for a time: a search near the size, then a curve through sizes around it."""

from bisect import bisect_left
from typing import Any

from swarmcensus.brains import Brain
from swarmcensus.search.planning.mission import FEWEST_TRIALS
from swarmcensus.search.planning.plans import Need, need_of
from swarmcensus.search.planning.search import Search, cases_to_confirm
from swarmcensus.search.planning.simulating import Case, Curve
from swarmcensus.support.intervals import LEVEL, Estimate
from swarmcensus.support.share_fits import ShareFit, fit_shares

STEP = 1.5  # from one size to the next, until one is enough and one is not
SURE = 0.99  # the level at which few trials decide: higher than 95 %, as they decide many times
NEAR = 0.1  # precision of the search, as a share of the size
RATIO = 1.2  # from one size to the next of those around the size that the search ends with
AROUND, FARTHEST = 2, 4  # how many such steps there are on either side at first, and at most


def smallest(search: Search, brain: Brain, minutes: float) -> Need:
    """The smallest swarm that is enough for so many minutes; if only one size is allowed, whether it is enough.

    The search begins at the predicted size. Few trials decide if the confidence is outside of their interval; else all
    trials do.
    """
    low, high = search.mission.sizes
    search.check_reach(high)
    rows: dict[int, Need] = {}

    def holds(robots: int) -> bool:
        if robots not in rows:
            row = _row(search, brain, robots, minutes, few=True)
            # the interval of few trials may contain the confidence: then they cannot decide
            if row.share and row.share.low < search.mission.wanted.probability <= row.share.high:
                row = _row(search, brain, robots, minutes, chosen=True)
            rows[robots] = row
        return rows[robots].answer == "reached"

    if low == high:
        if search.inner:
            _row(search, brain, low, minutes, few=True)  # finds out which cases may be the worst
        return _row(search, brain, low, minutes)
    size = theory_size(search, minutes)
    if holds(size):
        while size > low and holds(smaller := max(low, min(size - 1, int(size / STEP)))):
            size = smaller
        too_few = max((n for n, row in rows.items() if row.answer != "reached" and n < size), default=low - 1)
    else:
        too_few = size
        while not holds(size):
            if size == high:
                return rows[high]
            too_few, size = size, min(high, max(size + 1, int(size * STEP)))
    while size - too_few > max(1, NEAR * size):
        middle = (size + too_few) // 2
        size, too_few = (middle, too_few) if holds(middle) else (size, middle)
    return _fitted(search, brain, size, minutes)


def _fitted(search: Search, brain: Brain, near: int, minutes: float) -> Need:
    """The smallest swarm, with its interval, by a curve through fresh trials of sizes around `near`.

    More sizes are tried until the curve is surely too low at the first and surely enough at the last, or `FARTHEST`.
    """
    wanted, (low, high) = search.mission.wanted.probability, search.mission.sizes
    cases = cases_to_confirm(search.worst[brain.label])
    curves: dict[int, dict[Case, Curve]] = {}
    fits: dict[Case, ShareFit] = {}

    def share(robots: int) -> Estimate:
        return min((fit.at(robots) for fit in fits.values()), key=lambda share: share.value)

    least, most = -AROUND, AROUND
    while True:
        for robots in _sizes(near, least, most, low, high):
            if robots not in curves:
                rounds = [search.mission.rounds(minutes)]
                run = search.run(robots, [brain], cases, rounds, search.mission.study.trials, fresh=True)
                curves[robots] = {curve.case: curve for curve in run[brain.label]}
        tried = sorted(curves)
        fits |= {case: fit_shares(tried, [curves[robots][case].shares[0] for robots in tried]) for case in cases}
        smallest_share, largest_share = share(min(curves)), share(max(curves))
        enough_below = smallest_share.value >= wanted or (smallest_share.high >= wanted and least > -FARTHEST)
        too_few_above = largest_share.value < wanted or (largest_share.low < wanted and most < FARTHEST)
        fewer, more = enough_below and min(curves) > low, too_few_above and max(curves) < high
        if not fewer and not more:
            break
        least, most = least - fewer, most + more
    sizes = range(min(curves), max(curves) + 1)

    def first(end: str) -> int | None:
        k = bisect_left(sizes, True, key=lambda robots: getattr(share(robots), end) >= wanted)
        return sizes[k] if k < len(sizes) else None

    size, lowest = first("value"), first("high")
    robots = size or sizes[-1]
    worst = min(cases, key=lambda case: fits[case].at(robots).value)
    ends = {"robots_low": low if lowest == sizes[0] else lowest, "robots_high": first("low")} if size else {}
    answer = "reached" if size else "not reached"
    return _need(search, brain, robots, minutes, curves[sizes[0]][worst], answer=answer, share=share(robots), **ends)


def _sizes(near: int, least: int, most: int, low: int, high: int) -> list[int]:
    """Sizes from `least` to `most` steps by `RATIO` about `near`, at least one robot apart, in the allowed range."""
    steps = {k: round(near * RATIO**k) - near for k in range(least, most + 1)}
    apart = [max(k, step) if k > 0 else min(k, step) for k, step in steps.items()]
    return sorted({min(high, max(low, near + step)) for step in apart})


def theory_size(search: Search, minutes: float) -> int:
    """The least allowed size for which the predicted time is short enough."""
    rounds, (low, high) = search.mission.rounds(minutes), search.mission.sizes
    return low + bisect_left(range(low, high), True, key=lambda robots: search.predict(robots).mixed <= rounds)


def _row(search: Search, brain: Brain, robots: int, minutes: float, few: bool = False, chosen: bool = False) -> Need:
    """A size's row: from all trials at the worst cases, or from few trials at all possible worst cases.

    Cases that surely are not the worst drop out. Few trials have an interval of level `SURE`. If the answer chooses a
    size, it uses the share to expect in other trials.
    """
    mission, before = search.mission, search.worst.get(brain.label, search.cases)
    cases, trials = (before, FEWEST_TRIALS) if few else (cases_to_confirm(before), mission.study.trials)
    curves = search.run(robots, [brain], cases, [mission.rounds(minutes)], trials)[brain.label]
    curves.sort(key=lambda curve: float(curve.shares.mean()))  # ties keep the order found at earlier sizes
    worst = curves[0]
    left = [curve.case for curve in curves if curve.at(0).low <= worst.at(0).high]
    search.worst[brain.label] = left + [case for case in before if case not in cases]
    share = worst.at(0, SURE if few else LEVEL)
    if chosen:
        share = share._replace(value=worst.expected(0))
    answer = "reached" if share.value >= mission.wanted.probability else "not reached"
    return _need(search, brain, robots, minutes, worst, answer=answer, share=share)


def _need(search: Search, brain: Brain, robots: int, minutes: float, curve: Curve, **results: Any) -> Need:
    return need_of(search.mission, brain.label, robots, minutes, search.predict(robots), curve, **results)
