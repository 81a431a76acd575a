"""Sentences for a paper: each difference with its values, intervals and test, in words that need no table."""

import numpy as np

from swarmcensus.analysis.comparing.cells import ALWAYS, NEVER, RANK_SUM, margin_text, numbers, p_equals, probability
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
    own, others = contest.trials[world, [first, second]].tolist()
    common, paired = int(contest.pair_trials[:, world, pair].min()), bool(contest.paired[world, pair])
    trials = f"{counted(own, 'trial')} each" if own == others else f"{own:,} and {counted(others, 'trial')}"
    kind = "mean" if measure.statistic == "mean" else "median"
    texts = [_with_interval(contest, measure, world, who) for who in (first, second)]
    at, low, high = (part[[world], [pair]] for part in (contest.difference, *contest.difference_ends))
    [(difference, between)] = numbers(at, low, high, np.array([common]), measure, differences=True)
    between = {"": "", ALWAYS: " in every trial"}.get(between, f" {between}")
    both = f" in {counted(common, 'trial')}" * (paired and common < max(own, others))
    of = f"{kind} of paired differences{both}" if paired else f"difference of {kind}s over trials"
    ends = (end[world, pair] for end in contest.better_ends)
    chance = " ".join(probability(contest.better[world, pair], *ends)).strip()
    test = "Wilcoxon's signed-rank test, paired by trial" if paired else RANK_SUM
    tests = test_count(standings.contests)
    p, corrected = (p_equals(float(part[world, pair])) for part in (contest.tests.p, contest.corrected))
    holm = f"; p {corrected} after Holm's correction for {tests:,} tests" if tests > 1 else ""
    margin = standings.margins.get(measure.name)
    within = margin is not None and contest.within(margin)[world, pair]
    equal = f"; equal for practical purposes, within {margin_text(margin, measure)}" if within and margin else ""
    unit = " %" if measure.share else f" {measure.unit}" if measure.unit != "1" else ""
    units = ["" if text.startswith(NEVER) else unit for text in texts]
    ended = [int(np.isfinite(contest.numbers[world, who]).sum()) for who in (first, second)]
    reached = f"; reached in {ended[0]} of {own} and {ended[1]} of {others} trials" if sum(ended) < own + others else ""
    where = ", ".join(f"{name} {grouped(v)}" for name, v in standings.grid.worlds[world].items() if not is_idle(v))
    values = f"{one} {texts[0]}{units[0]}, {other} {texts[1]}{units[1]} ({kind}, {trials}{reached})"
    differs = f"{of}, {one} - {other}, {difference}{between}; probability that {one} is better {chance}"
    return (
        f"{measure.label}{f' ({where})' if where else ''}: {values}; {differs}; {test}, two-sided p {p}{holm}{equal}. "
        "Brackets are 95 % intervals over trials."
    )


def _with_interval(contest: Contest, measure: Measure, world: int, who: int) -> str:
    value, low, high = (part[[world], [who]] for part in (contest.values, *contest.value_ends))
    [(text, interval)] = numbers(value, low, high, contest.trials[[world], [who]], measure)
    return f"{text} {interval}".strip() if interval != ALWAYS else text
