"""The shortest time of a swarm: all times of one run at once, first in few trials, then in as many as were asked."""

import math
from collections.abc import Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from swarmcensus.planning.mission import FEWEST_TRIALS, Mission
from swarmcensus.planning.plans import Row, of_case, row_of
from swarmcensus.planning.predictions import Start
from swarmcensus.planning.search import Search, TooLong, confirmed
from swarmcensus.planning.simulating import Case, Curve, Floats, Share, times_until
from swarmcensus.studies.fields import LARGEST
from swarmcensus.worlds.patterns import Floor

LONGER = 1.6  # than the few trials say it takes: so that the interval of the time ends within the run
SLOWER = 2.0  # than theory's time: how long the first look is
GIVE_UP = 4.0  # times what theory says of a robot alone, where no longest time is given
GIVE_UP_LATE = 30.0  # the same on floors of which theory knows less: there readings tell of their neighbours too
LEAST = 10  # rounds of a run
SURE = 0.99  # the level at which few trials say that a goal is never reached


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


class Look(NamedTuple):
    """What few trials say of a brain: cases of which any may be the worst, these first, and when the goal is reached.

    `never` is a curve that surely does not reach it.
    """

    cases: tuple[Case, ...]
    rounds: int
    never: Curve | None = None


def shortest(search: Search, robots: int) -> list[Row]:
    """A row for each brain."""
    search.check_reach(robots)
    mission, start = search.mission, search.start(robots)
    minutes = mission.free.minutes
    times = GIVE_UP_LATE if mission.area.floor and mission.area.floor[0] != Floor() else GIVE_UP
    most = mission.rounds(minutes[1]) if minutes else int(min(max(times * start.alone, LEAST), LARGEST))
    try:
        return _confirmed(search, robots, start, _first_look(search, robots, start, most), most)
    except TooLong:
        told = start.minutes(mission)
        return [row_of(mission, brain.label, robots, told.mixed, told) for brain in mission.brains]


def _first_look(search: Search, robots: int, start: Start, most: int) -> dict[str, Look]:
    """What few trials say of each brain, run longer and longer until all reach the goal, or the longest time."""
    last = min(most, max(LEAST, int(SLOWER * start.mixed)))
    left, cases = list(search.mission.brains), search.cases
    found: dict[str, Look] = {}
    while left:
        every = search.run(robots, left, cases, times_until(start.pooled / 2, last, robots), FEWEST_TRIALS)
        for brain in list(left):
            look = _look(search, [curve for curve in every if curve.brain == brain.label], last)
            if look.rounds <= last or last == most:
                found[brain.label] = look
                left.remove(brain)
        slow = {case for brain in left for case in _longer(search, [c for c in every if c.brain == brain.label])}
        cases, last = [case for case in cases if case in slow], min(most, 2 * last)
    return found


def _longer(search: Search, curves: Sequence[Curve]) -> list[Case]:
    """Cases of a brain that are looked at for longer: of the inner fill ratios those that may be the worst so far."""
    most = min((curve.at(-1) for curve in curves), key=lambda share: share.value).high
    return [one.case for one in curves if one.case.fill_ratio not in search.inner or one.at(-1).low <= most]


def _look(search: Search, curves: Sequence[Curve], last: int) -> Look:
    """Of one brain: a case may be the worst unless it is surely reached before that which takes longest."""
    confidence = search.mission.wanted.confidence
    when = {curve.case: reached(curve, confidence) for curve in curves}
    slowest = max((one.rounds if one else last + 1) for one in when.values())
    surely = max(
        (one.low if one else last + 1) for one in when.values() if (one.rounds if one else last + 1) == slowest
    )
    by_share = sorted(curves, key=lambda one: float(one.shares[-1].mean()))
    by_time = sorted(by_share, key=lambda one: -(found.rounds if (found := when[one.case]) else last + 1))
    in_turn = ((one.case, when[one.case]) for one in by_time)
    kept = [case for case, one in in_turn if one is None or one.high is None or one.high >= surely]
    lowest = by_share[0]
    hopeless = slowest > last and lowest.at(-1, SURE).high < confidence
    return Look(tuple(confirmed(kept)), slowest, lowest if hopeless else None)


def _confirmed(search: Search, robots: int, start: Start, looked: dict[str, Look], most: int) -> list[Row]:
    """A row for each brain, from as many trials as were asked, run long enough for the intervals of their times."""
    mission, told = search.mission, start.minutes(search.mission)
    rows = {name: _row(mission, look.never, None, robots, told) for name, look in looked.items() if look.never}
    brains = [brain for brain in mission.brains if brain.label not in rows]
    if not brains:
        return list(rows.values())
    hopeful = [looked[brain.label] for brain in brains]
    cases = [case for case in search.cases if any(case in look.cases for look in hopeful)]
    soon: float = min(look.rounds for look in hopeful)
    last = min(most, max(LEAST, int(LONGER * max(look.rounds for look in hopeful))))
    while True:
        times = times_until(soon / 2.0, last, robots)
        every = search.run(robots, brains, cases, times, mission.trials)
        mine = {brain.label: [curve for curve in every if curve.brain == brain.label] for brain in brains}
        found = {name: _slowest(curves, mission.wanted.confidence) for name, curves in mine.items()}
        early = any(one is not None and 1 < one.rounds == times[0] for _, one in found.values())
        late = last < most and any(one is None or one.high is None for _, one in found.values())
        if not early and not late:
            break
        soon, last = (soon / 2 if early else soon), (min(most, int(LONGER * last)) if late else last)
    rows |= {name: _row(mission, *one, robots, told) for name, one in found.items()}
    return [rows[brain.label] for brain in mission.brains]


def _slowest(curves: Sequence[Curve], confidence: float) -> tuple[Curve, Reached | None]:
    """The curve that reaches the confidence last, or never; of several of these the lowest."""
    found = [(curve, reached(curve, confidence)) for curve in curves]
    return max(found, key=lambda one: (one[1].rounds if one[1] else math.inf, -float(one[0].shares[-1].mean())))


def _row(mission: Mission, curve: Curve, found: Reached | None, robots: int, theory: Start) -> Row:
    minute = mission.round_minutes
    row = of_case(row_of(mission, curve.brain, robots, curve.rounds[-1] * minute, theory), curve)
    if found is None:
        share = curve.at(-1)
        return replace(row, answer="not reached", share=share._replace(value=min(share.value, curve.expected(-1))))
    least = mission.free.minutes[0] if mission.free.minutes else 0.0
    return replace(
        row,
        answer="reached",
        minutes=max(found.rounds * minute, least),
        minutes_low=found.low * minute,
        minutes_high=None if found.high is None else found.high * minute,
        share=found.share,
    )


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
