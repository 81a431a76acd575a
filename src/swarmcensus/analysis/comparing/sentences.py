"""Sentences for a paper: each difference with its values, intervals and test, in words that need no table."""

import numpy as np

from swarmcensus.analysis.comparing.cells import ALWAYS, numbers, p_equals, probability
from swarmcensus.analysis.comparing.pair_tests import Contest, pairs_of, test_count
from swarmcensus.analysis.comparing.standings import Standings
from swarmcensus.results import Measure, is_idle
from swarmcensus.support.formatting import counted, grouped


def sentences(standings: Standings) -> list[str]:
    """A sentence for each measure, world and tested pair."""
    out = []
    for measure, contest in zip(standings.measures, standings.contests, strict=True):
        for world, pair in np.argwhere(~np.isnan(contest.corrected)).tolist():
            out.append(_sentence(standings, measure, contest, world, pair))
    return out


def _sentence(standings: Standings, measure: Measure, contest: Contest, world: int, pair: int) -> str:
    first, second = pairs_of(len(standings.contenders))[pair]
    one, other = standings.contenders[first], standings.contenders[second]
    own, others = contest.pair_trials[:, world, pair].tolist()
    paired = bool(contest.paired[world, pair])
    trials = f"{counted(own, 'trial')} each" if own == others else f"{own:,} and {counted(others, 'trial')}"
    values = [_with_interval(contest, measure, world, who) for who in (first, second)]
    at, low, high = (part[[world], [pair]] for part in (contest.difference, *contest.difference_ends))
    [(difference, between)] = numbers(at, low, high, np.array([min(own, others)]), measure, differences=True)
    between = {"": "", ALWAYS: " in every trial"}.get(between, f" {between}")
    ends = (end[world, pair] for end in contest.better_ends)
    chance = " ".join(probability(contest.better[world, pair], *ends)).strip()
    test = "Wilcoxon's signed-rank test, paired by trial" if paired else "Mann and Whitney's rank-sum test"
    tests = test_count(standings.contests)
    p, corrected = (p_equals(float(part[world, pair])) for part in (contest.tests.p, contest.corrected))
    holm = f"; p {corrected} after Holm's correction for {tests:,} tests" if tests > 1 else ""
    margin = standings.margins.get(measure.name)
    equal = f"; equal for practical purposes, within {margin:g}" if contest.within(margin)[world, pair] else ""
    unit = " %" if measure.share else f" {measure.unit}" if measure.unit != "1" else ""
    where = ", ".join(f"{name} {grouped(v)}" for name, v in standings.grid.worlds[world].items() if not is_idle(v))
    kind = "mean" if measure.statistic == "mean" else "median"
    return (
        f"{measure.label}{f' ({where})' if where else ''}: {one} {values[0]}{unit}, {other} {values[1]}{unit} "
        f"({kind}, {trials}); difference {difference}{between}, probability that {one} is better {chance}; "
        f"{test}, two-sided p {p}{holm}{equal}. Brackets are 95 % intervals over trials."
    )


def _with_interval(contest: Contest, measure: Measure, world: int, who: int) -> str:
    value, low, high = (part[[world], [who]] for part in (contest.values, *contest.value_ends))
    [(text, interval)] = numbers(value, low, high, contest.trials[[world], [who]], measure)
    return f"{text} {interval}".strip() if interval != ALWAYS else text
