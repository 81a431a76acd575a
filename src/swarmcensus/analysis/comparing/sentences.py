"""Sentences for a paper: each difference with its values, intervals and test, in words that need no table."""

from typing import Any

import numpy as np

from swarmcensus.analysis.comparing.cells import ALWAYS, TESTS, margin_text, numbers, p_equals, probability
from swarmcensus.analysis.comparing.pair_tests import Contest, number_of_tests
from swarmcensus.analysis.comparing.tables import Frames
from swarmcensus.summaries import Measure, world_text
from swarmcensus.support.formatting import counted
from swarmcensus.support.printed_tables import NEVER


def sentences(frames: Frames) -> list[str]:
    """A sentence for each measure, world and tested pair."""
    by_name = {one.name: (one, contest) for one, contest in zip(frames.measures, frames.contests, strict=True)}
    return [_sentence(frames, *by_name[row["measure"]], row) for row in frames.pairs.to_dict("records")]


def _sentence(frames: Frames, measure: Measure, contest: Contest, row: dict[str, Any]) -> str:
    one, other, world, paired = row["one"], row["other"], row["world"], row["test"] == "signed-rank"
    places = [frames.contenders.index(name) for name in (one, other)]
    own, others = contest.trials[world, places].tolist()
    common, kind = min(row["trials"], row["other_trials"]), "mean" if measure.statistic == "mean" else "median"
    trials = f"{counted(own, 'trial')} each" if own == others else f"{own:,} and {counted(others, 'trial')}"
    texts = [_with_interval(contest, measure, world, who) for who in places]
    ends = (np.array([row[f"difference{end}"]]) for end in ("", "_low", "_high"))
    [(difference, between)] = numbers(ends, np.array([common]), measure, differences=True)
    between = {"": "", ALWAYS: " in every trial"}.get(between, f" {between}")
    both = f" in {counted(common, 'trial')}" * (paired and common < max(own, others))
    of = f"{kind} of paired differences{both}" if paired else f"difference of {kind}s over all trials of each"
    chance = " ".join(probability(row["superiority"], row["superiority_low"], row["superiority_high"])).strip()
    tests = number_of_tests(frames.contests)
    holm = f"; p {p_equals(row['p_holm'])} after Holm's correction for {tests:,} tests" if tests > 1 else ""
    margin = margin_text(frames.margins.get(measure.name, 0.0), measure)
    equal = f"; equal for practical purposes, within {margin}" * row["equal_in_practice"]
    unit = " %" if measure.share else f" {measure.unit}" if measure.unit != "1" else ""
    units = ["" if text.startswith(NEVER) else unit for text in texts]
    ended = [int(np.isfinite(contest.numbers[world, who]).sum()) for who in places]
    reached = f"; reached in {ended[0]} of {own} and {ended[1]} of {others} trials" if sum(ended) < own + others else ""
    where = world_text(frames.grid.worlds[world])
    values = f"{one} {texts[0]}{units[0]}, {other} {texts[1]}{units[1]} ({kind}, {trials}{reached})"
    differs = f"{of}, {one} - {other}, {difference}{between}; probability that {one} is better {chance}"
    tested = f"{TESTS[row['test']]}, p {p_equals(row['p'])}{holm}{equal}"
    label = f"{measure.label}{f' ({where})' if where else ''}"
    return f"{label}: {values}; {differs}; {tested}. Brackets are 95 % intervals over trials."


def _with_interval(contest: Contest, measure: Measure, world: int, who: int) -> str:
    with_ends = (part[[world], [who]] for part in (contest.values, *contest.value_ends))
    [(text, interval)] = numbers(with_ends, contest.trials[[world], [who]], measure)
    return f"{text} {interval}".strip() if interval != ALWAYS else text
