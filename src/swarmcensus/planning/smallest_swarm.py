"""Finds the smallest swarm that is enough for a time: by growing or shrinking sizes, then by bisection."""

from dataclasses import replace

from swarmcensus.brains import Brain
from swarmcensus.planning.mission import FEWEST_TRIALS
from swarmcensus.planning.plans import Answer, Row, row_of, with_case
from swarmcensus.planning.search import Search, TooLong, cases_to_confirm
from swarmcensus.planning.simulating import LEVEL, Share

RATIOS = (1.1, 1.2, 1.4, 1.7, 2.0)  # to the found size, of sizes tried for the ends of its interval
STEP = 1.5  # from one size to the next, until one is enough and one is not
SURE = 0.99  # the level at which few trials decide: higher than 95 %, as they decide many times
NEAR = 0.05  # precision of the found size, as a share of it


def enough(search: Search, brain: Brain, robots: int, minutes: float) -> Row:
    """The share of right robots after so many minutes, in a swarm of this size."""
    search.check_reach(robots)
    try:
        if search.inner:
            _row(search, brain, robots, minutes, few=True)
        return _row(search, brain, robots, minutes)
    except TooLong:
        return _of_theory(search, brain, robots, minutes)


def smallest(search: Search, brain: Brain, minutes: float) -> Row:
    """The smallest swarm that is enough for so many minutes.

    Sizes are tried from the predicted one on. Few trials decide if the confidence is outside of their interval; else
    all trials do.
    """
    low, high = search.sizes
    search.check_reach(high)
    rows: dict[int, Row] = {}

    def holds(robots: int) -> bool:
        if robots not in rows:
            rows[robots] = _decide(search, brain, robots, minutes)
        return rows[robots].answer == "reached"

    try:
        size = _theory_size(search, minutes)
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
        while True:  # all trials confirm what few trials decided
            row = _row(search, brain, size, minutes, chosen=True)
            if row.answer == "reached":
                row = _check_fresh(search, brain, row)
            if row.answer == "reached":
                break
            if size == high:
                return row
            size = min(high, max(size + 1, int(size * (1.0 + NEAR))))
    except TooLong:
        return _of_theory(search, brain, size, minutes)
    lowest, highest = _ends(search, brain, row)
    return replace(row, robots_low=lowest, robots_high=highest)


def _ends(search: Search, brain: Brain, chosen: Row) -> tuple[int, int | None]:
    """The interval of a size: above the next smaller size that is surely too few, up to the first surely enough."""
    wanted, size, (low, high) = search.mission.wanted.confidence, chosen.robots, search.sizes

    def share(robots: int) -> Share:
        row = chosen if robots == size else _row(search, brain, robots, chosen.minutes)
        assert row.share is not None
        return row.share

    smaller = sorted({max(low, min(size - 1, int(size / ratio))) for ratio in RATIOS} - {size}, reverse=True)
    larger = sorted({size} | {min(high, max(size + 1, round(size * ratio))) for ratio in RATIOS})
    lowest = next((n + 1 for n in smaller if n < size and share(n).high < wanted), low)
    return lowest, next((n for n in larger if share(n).low >= wanted), None)


def _theory_size(search: Search, minutes: float) -> int:
    """The least allowed size for which the predicted time is short enough."""
    rounds, (low, high) = search.mission.rounds(minutes), search.sizes
    while low < high:
        middle = (low + high) // 2
        low, high = (low, middle) if search.predict(middle).mixed <= rounds else (middle + 1, high)
    return low


def _decide(search: Search, brain: Brain, robots: int, minutes: float) -> Row:
    """Whether a size is enough, from few trials if they decide, else from all trials."""
    row = _row(search, brain, robots, minutes, few=True)
    assert row.share is not None
    if row.share.low >= search.mission.wanted.confidence or row.share.high < search.mission.wanted.confidence:
        return row
    return _row(search, brain, robots, minutes, chosen=True)


def _check_fresh(search: Search, brain: Brain, row: Row) -> Row:
    """The row with the share in fresh trials: "reached" unless that is surely below the confidence.

    The share in the trials that chose the size is too high on average, as they may have chosen it by chance.
    """
    mission, [case, *_] = search.mission, search.worst[brain.label]
    [curve] = search.run(row.robots, [brain], [case], [mission.rounds(row.minutes)], mission.trials, fresh=True)
    share = curve.at(0)
    return replace(row, share=share, answer="reached" if share.high >= mission.wanted.confidence else "not reached")


def _row(search: Search, brain: Brain, robots: int, minutes: float, few: bool = False, chosen: bool = False) -> Row:
    """A size's row: from all trials at the worst cases, or from few trials at all possible worst cases.

    Cases that surely are not the worst drop out. Few trials have an interval of level `SURE`. If the answer chooses a
    size, it uses the share to expect in other trials.
    """
    mission, before = search.mission, search.worst.get(brain.label, search.cases)
    cases, trials = (before, FEWEST_TRIALS) if few else (cases_to_confirm(before), mission.trials)
    curves = search.run(robots, [brain], cases, [mission.rounds(minutes)], trials)
    curves.sort(key=lambda curve: float(curve.shares.mean()))  # ties keep the order found at earlier sizes
    worst = curves[0]
    left = [curve.case for curve in curves if curve.at(0).low <= worst.at(0).high]
    search.worst[brain.label] = left + [case for case in before if case not in cases]
    share = worst.at(0, SURE if few else LEVEL)
    if chosen:
        share = share._replace(value=worst.expected(0))
    answer: Answer = "reached" if share.value >= mission.wanted.confidence else "not reached"
    return replace(with_case(_of_theory(search, brain, robots, minutes), worst), answer=answer, share=share)


def _of_theory(search: Search, brain: Brain, robots: int, minutes: float) -> Row:
    theory = search.predict(robots).minutes(search.mission)
    return row_of(search.mission, brain.label, robots, minutes, theory)
