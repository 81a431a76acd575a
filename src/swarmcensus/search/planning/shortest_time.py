"""Finds the shortest time of a swarm: one run shows all times, first in few trials, then in all trials."""

import math
from collections.abc import Sequence
from functools import partial
from typing import NamedTuple

import numpy as np

from swarmcensus.search.planning.mission import FEWEST_TRIALS, Mission
from swarmcensus.search.planning.plans import Need, need_of
from swarmcensus.search.planning.predictions import Prediction
from swarmcensus.search.planning.search import Search, cases_to_confirm
from swarmcensus.search.planning.simulating import Case, Curve, times_until
from swarmcensus.studies import LARGEST
from swarmcensus.support.intervals import Estimate, Floats
from swarmcensus.worlds import Floor

CONFIRM_FACTOR = 1.6  # confirming runs last so many times the first look's time, to contain the interval's end
FIRST_LOOK_FACTOR = 2.0  # first looks last so many times the predicted time
GIVE_UP = 4.0  # longest time, in times of a robot alone by theory, if the mission gives none
GIVE_UP_STRUCTURED = 30.0  # the same on other floors than tiles, where readings nearby are correlated
LEAST = 10  # rounds of a run
SURE = 0.99  # the level at which few trials decide that a goal is never reached


class Reached(NamedTuple):
    """The round from which enough robots are right, with its 95 % interval, and the share of right robots then.

    `high` is None if the share is never surely above the confidence.
    """

    rounds: int
    low: int
    high: int | None
    share: Estimate


class FirstLook(NamedTuple):
    """What few trials say about a brain: its possible worst cases, the worst first, and when it reaches the goal.

    `never` is a curve that surely does not reach the goal, if there is one.
    """

    cases: tuple[Case, ...]
    rounds: int
    never: Curve | None = None


def shortest(search: Search, robots: int) -> list[Need]:
    """The shortest time of each brain, a row each."""
    search.check_reach(robots)
    mission, prediction = search.mission, search.predict(robots)
    minutes = mission.minutes
    factor = GIVE_UP_STRUCTURED if mission.setting.floor not in (None, Floor()) else GIVE_UP
    most = mission.rounds(minutes[1]) if minutes else int(min(max(factor * prediction.alone, LEAST), LARGEST))
    return _confirmed(search, robots, prediction, _first_look(search, robots, prediction, most), most)


def _first_look(search: Search, robots: int, prediction: Prediction, most: int) -> dict[str, FirstLook]:
    """A first look at each brain in few trials, run longer and longer until all reach the goal, or the longest time."""
    last = min(most, max(LEAST, int(FIRST_LOOK_FACTOR * prediction.mixed)))
    left, cases = list(search.mission.study.swarm.brain), search.cases
    looks: dict[str, FirstLook] = {}
    while left:
        times, slow = times_until(prediction.pooled / 2, last, robots), set[Case]()
        for name, curves in search.run(robots, left, cases, times, FEWEST_TRIALS).items():
            look = _judge_first_look(search, curves, last)
            if look.rounds <= last or last == most:
                looks[name] = look
                continue
            # longer runs leave out inner fill ratios that cannot be the worst
            lowest = min((curve.at(-1) for curve in curves), key=lambda share: share.value).high
            slow.update(c.case for c in curves if c.case.fill_ratio not in search.inner or c.at(-1).low <= lowest)
        left = [brain for brain in left if brain.label not in looks]
        cases, last = [case for case in cases if case in slow], min(most, 2 * last)
    return looks


def _judge_first_look(search: Search, curves: Sequence[Curve], last: int) -> FirstLook:
    """The first look at one brain; a case may be the worst unless it surely ends before the slowest case."""
    confidence = search.mission.wanted.probability
    when = {curve.case: reached(curve, confidence) for curve in curves}
    rounds = {case: result.rounds if result else last + 1 for case, result in when.items()}
    slowest = max(rounds.values())
    surely = max(result.low if result else last + 1 for case, result in when.items() if rounds[case] == slowest)
    by_share = sorted(curves, key=lambda curve: float(curve.shares[-1].mean()))
    by_time = sorted((curve.case for curve in by_share), key=lambda case: -rounds[case])
    possible = [case for case in by_time if not (at := when[case]) or at.high is None or at.high >= surely]
    lowest = by_share[0]
    hopeless = slowest > last and lowest.at(-1, SURE).high < confidence
    return FirstLook(tuple(cases_to_confirm(possible)), slowest, lowest if hopeless else None)


def _confirmed(
    search: Search, robots: int, prediction: Prediction, looks: dict[str, FirstLook], most: int
) -> list[Need]:
    """A row for each brain from all trials, run long enough to contain the intervals of the times."""
    mission = search.mission
    rows = {name: _row(mission, look.never, None, robots, prediction) for name, look in looks.items() if look.never}
    brains = [brain for brain in mission.study.swarm.brain if brain.label not in rows]
    if not brains:
        return list(rows.values())
    hopeful = [looks[brain.label] for brain in brains]
    cases = [case for case in search.cases if any(case in look.cases for look in hopeful)]
    earliest: float = min(look.rounds for look in hopeful)
    last = min(most, max(LEAST, int(CONFIRM_FACTOR * max(look.rounds for look in hopeful))))
    while True:
        times = times_until(earliest / 2.0, last, robots)
        by_brain = search.run(robots, brains, cases, times, mission.study.trials)
        slowest = {name: _slowest(curves, mission.wanted.probability) for name, curves in by_brain.items()}
        early = any(result is not None and 1 < result.rounds == times[0] for _, result in slowest.values())
        late = last < most and any(result is None or result.high is None for _, result in slowest.values())
        if not early and not late:
            break
        earliest = earliest / 2 if early else earliest
        last = min(most, int(CONFIRM_FACTOR * last)) if late else last
    rows |= {name: _row(mission, *result, robots, prediction) for name, result in slowest.items()}
    return [rows[brain.label] for brain in mission.study.swarm.brain]


def _slowest(curves: Sequence[Curve], confidence: float) -> tuple[Curve, Reached | None]:
    """The curve that reaches the confidence last, or never; the lowest of several such curves."""
    with_times = [(curve, reached(curve, confidence)) for curve in curves]

    def slowness(pair: tuple[Curve, Reached | None]) -> tuple[float, float]:
        curve, result = pair
        return result.rounds if result else math.inf, -float(curve.shares[-1].mean())

    return max(with_times, key=slowness)


def _row(mission: Mission, curve: Curve, reached_at: Reached | None, robots: int, theory: Prediction) -> Need:
    minute, needs = mission.round_minutes, partial(need_of, mission, curve.brain, robots)
    if reached_at is None:
        share = curve.at(-1)
        share = share._replace(value=min(share.value, curve.expected(-1)))
        return needs(curve.rounds[-1] * minute, theory, curve, answer="not reached", share=share)
    low, high = (None if end is None else end * minute for end in (reached_at.low, reached_at.high))
    ends = {"minutes_low": low, "minutes_high": high}
    return needs(reached_at.rounds * minute, theory, curve, answer="reached", share=reached_at.share, **ends)


def reached(curve: Curve, confidence: float) -> Reached | None:
    """When the confidence is reached and kept; None if it is not.

    More evidence makes more robots right, so shares and both ends of their intervals are sorted by size. By chance a
    curve crosses the confidence several times; its first crossing would be too early, its last one too late
    (Chernozhukov, Fernandez-Val and Galichon, 2009, "Improving point and interval estimators of monotone functions by
    rearrangement"). Between two times the curve is interpolated linearly.
    """
    measured = [curve.at(k) for k in range(len(curve.rounds))]
    expected = [curve.expected(k) for k in range(len(curve.rounds))]
    begin = _first_place(
        [share.low >= confidence for share in measured], [share.high < confidence for share in measured]
    )
    rounds, shares = curve.rounds[begin:], np.sort(expected[begin:])
    lows = np.sort([share.low for share in measured[begin:]])
    highs = np.sort([share.high for share in measured[begin:]])
    at, first, last = (_crossing(rounds, each, confidence) for each in (shares, highs, lows))
    if at is None or first is None:
        return None
    rounds_reached = math.ceil(at)
    share_then = Estimate(*(float(np.interp(rounds_reached, rounds, each)) for each in (shares, lows, highs)))
    return Reached(rounds_reached, math.floor(first), None if last is None else math.ceil(last), share_then)


def _crossing(rounds: list[int], shares: Floats, confidence: float) -> float | None:
    """The time at which sorted shares reach the confidence; None if they do not."""
    k = int(np.searchsorted(shares, confidence))
    if k == shares.size:
        return None
    if k == 0:
        return rounds[0]
    part = (confidence - shares[k - 1]) / (shares[k] - shares[k - 1])
    return float(rounds[k - 1] + part * (rounds[k] - rounds[k - 1]))


def _first_place(above: list[bool], below: list[bool]) -> int:
    """The first place from which no time that is surely above the confidence precedes one that is surely below it."""
    last_below = max(np.flatnonzero(below), default=0)
    return 1 + int(max(np.flatnonzero(above[:last_below]), default=-1))
