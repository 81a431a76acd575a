"""Whether a swarm is large enough for a time, and the smallest that is: by steps of a half, then by halves."""

from dataclasses import replace

from swarmcensus.brains import Brain
from swarmcensus.planning.mission import FEWEST_TRIALS
from swarmcensus.planning.plans import Answer, Row, of_case, row_of
from swarmcensus.planning.search import Search, TooLong, confirmed
from swarmcensus.planning.simulating import LEVEL, Share

RATIOS = (1.1, 1.2, 1.4, 1.7, 2.0)  # by which sizes are tried that are surely too few, or enough
STEP = 1.5  # from a size to the next, until one is enough and one is not
SURE = 0.99  # the level at which few trials decide: they are asked again and again
NEAR = 0.05  # of the size: as exactly as it is found


def enough(search: Search, brain: Brain, robots: int, minutes: float) -> Row:
    """The share of so many robots that are right at that time."""
    search.check_reach(robots)
    try:
        if search.inner:
            _row(search, brain, robots, minutes, few=True)
        return _row(search, brain, robots, minutes)
    except TooLong:
        return _of_theory(search, brain, robots, minutes)


def smallest(search: Search, brain: Brain, minutes: float) -> Row:
    """The smallest swarm that is enough for so many minutes.

    Sizes are tried from theory's on. Few trials decide where the confidence is outside of their interval, else as many
    as the mission asks for do.
    """
    low, high = search.sizes
    search.check_reach(high)
    rows: dict[int, Row] = {}

    def holds(robots: int) -> bool:
        if robots not in rows:
            rows[robots] = _judged(search, brain, robots, minutes)
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
        while True:  # what few trials decided is held to all
            found = _row(search, brain, size, minutes, chosen=True)
            if found.answer == "reached":
                found = _fresh(search, brain, found)
            if found.answer == "reached":
                break
            if size == high:
                return found
            size = min(high, max(size + 1, int(size * (1.0 + NEAR))))
    except TooLong:
        return _of_theory(search, brain, size, minutes)
    few, many = _ends(search, brain, found)
    return replace(found, robots_low=few, robots_high=many)


def _ends(search: Search, brain: Brain, found: Row) -> tuple[int, int | None]:
    """The interval of a size: from above the first smaller one that is surely too few to the first surely enough."""
    wanted, size, (low, high) = search.mission.wanted.confidence, found.robots, search.sizes

    def share(robots: int) -> Share:
        row = found if robots == size else _row(search, brain, robots, found.minutes)
        assert row.share is not None
        return row.share

    smaller = sorted({max(low, min(size - 1, int(size / ratio))) for ratio in RATIOS} - {size}, reverse=True)
    larger = sorted({size} | {min(high, max(size + 1, round(size * ratio))) for ratio in RATIOS})
    few = next((n + 1 for n in smaller if n < size and share(n).high < wanted), low)
    return few, next((n for n in larger if share(n).low >= wanted), None)


def _theory_size(search: Search, minutes: float) -> int:
    """The least size for which theory's time is short enough, within the sizes that there are."""
    rounds, (low, high) = search.mission.rounds(minutes), search.sizes
    while low < high:
        middle = (low + high) // 2
        low, high = (low, middle) if search.start(middle).mixed <= rounds else (middle + 1, high)
    return low


def _judged(search: Search, brain: Brain, robots: int, minutes: float) -> Row:
    """Whether a size is enough, from few trials where these decide."""
    row = _row(search, brain, robots, minutes, few=True)
    assert row.share is not None
    if row.share.low >= search.mission.wanted.confidence or row.share.high < search.mission.wanted.confidence:
        return row
    return _row(search, brain, robots, minutes, chosen=True)


def _fresh(search: Search, brain: Brain, row: Row) -> Row:
    """The row with the share in trials that had no part in choosing its size: reached, unless they surely say no.

    Trials in which a size looked good enough by chance are among those that choose it, so that their share is too high.
    """
    mission, [case, *_] = search.mission, search.worst[brain.label]
    [curve] = search.run(row.robots, [brain], [case], [mission.rounds(row.minutes)], mission.trials, fresh=True)
    share = curve.at(0)
    return replace(row, share=share, answer="reached" if share.high >= mission.wanted.confidence else "not reached")


def _row(search: Search, brain: Brain, robots: int, minutes: float, few: bool = False, chosen: bool = False) -> Row:
    """What all trials say at the worst cases, or few trials at all that may be it; those that surely are not drop out.

    Few trials have an interval of a level at which they decide. Where the answer chooses a size, it goes by the share
    to expect in other trials.
    """
    mission, before = search.mission, search.worst.get(brain.label, search.cases)
    cases, trials = (before, FEWEST_TRIALS) if few else (confirmed(before), mission.trials)
    every = search.run(robots, [brain], cases, [mission.rounds(minutes)], trials)
    every.sort(key=lambda one: float(one.shares.mean()))  # ties stay in the order of sizes before
    curve = every[0]
    left = [one.case for one in every if one.at(0).low <= curve.at(0).high]
    search.worst[brain.label] = left + [case for case in before if case not in cases]
    share = curve.at(0, SURE if few else LEVEL)
    if chosen:
        share = share._replace(value=curve.expected(0))
    answer: Answer = "reached" if share.value >= mission.wanted.confidence else "not reached"
    return replace(of_case(_of_theory(search, brain, robots, minutes), curve), answer=answer, share=share)


def _of_theory(search: Search, brain: Brain, robots: int, minutes: float) -> Row:
    theory = search.start(robots).minutes(search.mission)
    return row_of(search.mission, brain.label, robots, minutes, theory)
