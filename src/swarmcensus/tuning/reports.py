"""How a search and its evaluation are told, in the comments of the fragment."""

import textwrap
from collections.abc import Mapping, Sequence
from pathlib import Path

from swarmcensus.basics.formatting import counted
from swarmcensus.basics.seeds import seed_for
from swarmcensus.basics.version import __version__
from swarmcensus.brains import Brain
from swarmcensus.studies.toml_text import to_toml_value
from swarmcensus.tuning.evidence import BETTER, NONE, Evidence
from swarmcensus.tuning.generations import Ended
from swarmcensus.tuning.optimiser import library
from swarmcensus.tuning.plans import Plan


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
    compared = evidence.verdict != NONE
    if not compared:
        head += ["The values below are as they were before the search, and nothing was compared"]
    elif evidence.verdict != BETTER:
        head += ["There is no evidence that the line below is worth anything: read on"]
    said = [*evidence.sentences, *notes]
    if compared:
        said += [
            f"evaluated in {counted(worlds, 'world')} with seed {seed}, the study's own, and "
            f"{counted(plan.study.trials, 'trial')} in each, none of which the search has seen; "
            "p-values are corrected by Holm's method for this metric alone, so "
            "that swarmcensus compare, which asks for more measures, may tell less apart"
        ]
    names = [f"every evaluation: {files['.csv'].name}"] if files else []
    if files and compared:
        names = [f"{names[0]}; the evaluation's results: {files['.nc'].name}"]
    ties = "".join(f"; where that is the same, by {one.name}: {one.meaning}" for one in plan.measures[1:])
    told = [
        f"searched: {', '.join(map(str, plan.ranges))}; from {_told(plan, plan.start)}",
        f"by {plan.metric}: {plan.measures[0].meaning}{ties}",
        f"with CMA-ES (cma {library().__version__}), {counted(plan.trials, 'trial')} in each world: "
        f"{course_of(plan, ended)}",
        f"training seeds {seed_for(seed, 'training')} (the brain as it was) and those that follow from {seed}, one a "
        f"generation; the search's own {seed_for(seed, 'search')}",
        f"the brain's source has SHA-256 {tuned.sha256}",
        *names,
    ]
    return fragment(tuned, plan.searched, head, said, told)


def course_of(plan: Plan, ended: Ended) -> str:
    """How a search went and why it ended, such as "57 evaluations in 4 generations, as many as the budget allows"."""
    why = "until all candidates of one had the same values" if ended.narrowed else "as many as the budget allows"
    text = f"{counted(len(ended.evaluations), 'evaluation')} in {counted(ended.generations, 'generation')}, {why}"
    return f"{text} ({plan.budget.text}){_drawn(ended)}"


def why_unchanged(plan: Plan, ended: Ended) -> str:
    """Why a search ended at the values there were."""
    if not ended.flat:
        return "the search ended at the values there were"
    spent = f"{counted(len(ended.evaluations), 'evaluation')}, as many as the budget allows{_drawn(ended)}"
    return f"no candidate differed from another in {plan.metric}, and the budget is spent ({spent})"


def _drawn(ended: Ended) -> str:
    if not ended.drawn:
        return ""
    drawn = f"{counted(ended.drawn, 'generation')} {'was' if ended.drawn == 1 else 'were'} drawn"
    return f"; {drawn} from the whole of the ranges, as no candidate had differed before"


def _told(plan: Plan, values: tuple[float, ...]) -> str:
    return ", ".join(f"{one.place} = {value:.6g}" for one, value in zip(plan.ranges, values, strict=True))


WIDTH = 110


def fragment(
    brain: Brain, searched: Sequence[str], head: Sequence[str], evidence: Sequence[str], told: Sequence[str]
) -> str:
    """TOML text: comments of what came of it, the line to paste, and comments of how it came to be.

    The line names all parameters that were searched, those too that are as the brain's file says.
    """
    table = {"file": brain.name, **{name: brain.parameters[name] for name in searched}, **dict(brain.given)}
    lines = [*_comments(head), "#", *_comments(evidence)]
    lines += ["", "[swarm]", f"brain = [{to_toml_value(table)}]", "", *_comments(told)]
    return "\n".join(lines) + "\n"


def _comments(lines: Sequence[str]) -> list[str]:
    return [
        f"{'# ' if k == 0 else '#   '}{part}"
        for line in lines
        for k, part in enumerate(textwrap.wrap(line, WIDTH, break_long_words=False, break_on_hyphens=False))
    ]
