"""Sentences for a paper: each difference with its values, intervals and test, in words that need no table."""

from typing import Any

import numpy as np

from swarmcensus.analysis.comparing.cells import (
    TESTS,
    column_head,
    margin_text,
    numbers,
    p_equals,
    probability,
)
from swarmcensus.analysis.comparing.pair_tests import Contest, number_of_tests
from swarmcensus.analysis.comparing.tables import Frames
from swarmcensus.summaries import Measure, world_text


def sentences(frames: Frames) -> list[str]:
    """A sentence for each measure, world and tested pair."""
    by_name = {one.name: (one, contest) for one, contest in zip(frames.measures, frames.contests, strict=True)}
    return [_sentence(frames, *by_name[row["measure"]], row) for row in frames.pairs.to_dict("records")]


def _sentence(frames: Frames, measure: Measure, contest: Contest, row: dict[str, Any]) -> str:
    one, other, world, paired = row["one"], row["other"], row["world"], row["test"] == "signed-rank"
    values = (_with_interval(contest, measure, world, frames.contenders.index(name), name) for name in (one, other))
    trials, tests = (row["trials"], row["other_trials"]), f"{number_of_tests(frames.contests):,}"
    ends = (np.array([row[f"difference{end}"]]) for end in ("", "_low", "_high"))
    [(difference, between)] = numbers(ends, np.array([min(trials)]), measure, differences=True)
    of = f"{measure.statistic} of paired differences" if paired else f"difference of {measure.statistic}s"
    chance = " ".join(probability(row["superiority"], row["superiority_low"], row["superiority_high"])).strip()
    equal = f"; equal for practical purposes, within {margin_text(frames.margins.get(measure.name, 0.0), measure)}"
    unit = f" ({measure.unit})" * (measure.unit != "1" and not measure.share)
    where = world_text(frames.grid.worlds[world])
    return (
        f"{column_head(measure)}{unit}{f' ({where})' if where else ''}: {' and '.join(values)} ({measure.statistic}s "
        f"over robots and trials); {of} of trials' {measure.statistic}s over robots, {one} - {other}, {difference} "
        f"{between} ({trials[0]:,} and {trials[1]:,} trials); probability that {one} is better {chance}; "
        f"{TESTS[row['test']]}, p {p_equals(row['p'])}; p {p_equals(row['p_holm'])} after Holm's correction for "
        f"{tests} tests{equal * row['equal_in_practice']}. Brackets are 95 % intervals over trials."
    )


def _with_interval(contest: Contest, measure: Measure, world: int, who: int, name: str) -> str:
    with_ends = (part[[world], [who]] for part in (contest.values, *contest.value_ends))
    [(text, interval)] = numbers(with_ends, contest.trials[[world], [who]], measure)
    return f"{name} {text} {interval}".strip()
