"""How a search and its evaluation are told, in the comments of the fragment."""

from collections.abc import Mapping, Sequence
from pathlib import Path

from swarmcensus.basics.seeds import seed_for
from swarmcensus.basics.version import __version__
from swarmcensus.brains import Brain
from swarmcensus.tuning.evidence import BETTER, Evidence
from swarmcensus.tuning.fragments import fragment
from swarmcensus.tuning.plans import Plan
from swarmcensus.tuning.rounds import Ended
from swarmcensus.tuning.searching import library


def notes_of(plan: Plan, idle: Sequence[str]) -> list[str]:
    """What should be known of the values found: which change nothing, and which the search could not begin at."""
    starts = dict(zip((one.place for one in plan.ranges), plan.start, strict=True))
    notes = [f"{place} changes nothing in {plan.metric}, and stays at {starts[place]:.6g}" for place in idle]
    return notes + [
        f"{one.place} was {value:.6g}, which is not in {one}: the search began at the nearest end"
        for one, value in zip(plan.ranges, plan.start, strict=True)
        if not one.low <= value <= one.high
    ]


def report(
    plan: Plan, tuned: Brain, ended: Ended, evidence: Evidence, notes: Sequence[str], files: Mapping[str, Path]
) -> str:
    """The fragment's text."""
    worlds, seed = len(plan.worlds), plan.study.seed
    head = [
        f"{plan.before.name}, tuned for the study {plan.study.name!r} by swarmcensus {__version__}; this is no study "
        "by itself: its brain is for one's table [swarm]"
    ]
    if evidence.verdict != BETTER:
        head += ["There is no evidence that the line below is worth anything: read on"]
    said = [
        *evidence.sentences,
        *notes,
        f"evaluated in {_several(worlds, 'world')} with seed {seed}, the study's own, and {plan.study.trials} trials "
        "in each, none of which the search has seen; p-values are corrected by Holm's method for this metric alone, so "
        "that swarmcensus compare, which asks for more measures, may tell less apart",
    ]
    names = [f"every evaluation: {files['.csv'].name}; the evaluation's results: {files['.nc'].name}"] if files else []
    why = (
        "no candidate was better or worse than another"
        if ended.flat
        else "until it had narrowed down"
        if ended.narrowed
        else "as many as the budget allows"
    )
    told = [
        f"searched: {', '.join(map(str, plan.ranges))}; from {_told(plan, plan.start)}",
        f"by {plan.metric}: {plan.measure.meaning}",
        f"with CMA-ES (cma {library().__version__}): {len(ended.evaluations)} evaluations in {ended.generations} "
        f"generations, {plan.trials} trials in each world; {why} ({plan.budget.text})",
        f"training seeds {seed_for(seed, 'training')} (the brain as it was) and those that follow from {seed}, one a "
        f"generation; the search's own {seed_for(seed, 'search')}",
        f"the brain's source has SHA-256 {tuned.sha256}",
        *names,
    ]
    return fragment(tuned, head, said, told)


def _told(plan: Plan, values: tuple[float, ...]) -> str:
    return ", ".join(f"{one.place} = {value:.6g}" for one, value in zip(plan.ranges, values, strict=True))


def _several(count: int, what: str) -> str:
    return f"{count:,} {what}{'s' * (count != 1)}"
