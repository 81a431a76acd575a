"""The report of a search: a fragment of a study file with what was found, and the evidence as comments."""

import textwrap
from collections.abc import Mapping, Sequence
from pathlib import Path

from swarmcensus.brains import Adversary, Brain
from swarmcensus.search.tuning.evidence import NONE, Evidence
from swarmcensus.search.tuning.generations import SearchResult
from swarmcensus.search.tuning.optimiser import library
from swarmcensus.search.tuning.plans import TuningPlan
from swarmcensus.support.formatting import counted
from swarmcensus.support.seeds import seed_for
from swarmcensus.support.toml_text import read_toml, to_toml_value
from swarmcensus.support.version import __version__

WIDTH = 110  # characters of a comment line


def notes_of(plan: TuningPlan, idle: Sequence[str]) -> list[str]:
    """Notes on the values found: which change nothing, and which original values lie outside their ranges."""
    starts = dict(zip((parameter.label for parameter in plan.ranges), plan.start, strict=True))
    notes = [f"{place} changes nothing in {plan.metric}, and stays at {starts[place]:.6g}" for place in idle]
    return notes + [
        f"{parameter.label} was {value:.6g}, which is not in {parameter}: the search began at the nearest end"
        for parameter, value in zip(plan.ranges, plan.start, strict=True)
        if not parameter.low <= value <= parameter.high
    ]


def report(
    plan: TuningPlan, tuned: Brain | Adversary, result: SearchResult, evidence: Evidence, notes: Sequence[str],
    files: Mapping[str, Path],
) -> str:  # fmt: skip
    """The text of the fragment."""
    worlds, seed = len(plan.worlds), plan.study.seed
    kind, harms = plan.before.kind, plan.target.harms
    aim, use = "tuned for", "its brain is for one's table [swarm]"
    if harms:
        aim = f"with the values found to harm {plan.target.brain.name} most in"
        use = "its table is for one's members"
    head = [
        f"{plan.before.name}, {aim} the study {plan.study.name!r} by swarmcensus {__version__}; this is no study by "
        f"itself: {use}"
    ]
    compared = evidence.verdict != NONE
    if not compared:
        head += ["The values below are as they were before the search, and nothing was compared"]
    elif not evidence.is_found and harms:
        head += ["There is no evidence that the values below do more harm than those before: read on"]
    elif not evidence.is_found:
        head += ["There is no evidence that the line below is worth anything: read on"]
    findings = [*evidence.sentences, *notes]
    if compared:
        findings += [
            f"evaluated in {counted(worlds, 'world')} with seed {seed}, the study's own, and "
            f"{counted(plan.study.trials, 'trial')} in each, none of which the search has seen; "
            "p-values are corrected by Holm's method for this metric alone, so "
            "that swarmcensus compare, which asks for more measures, may tell less apart"
        ]
    start = ", ".join(f"{each.label} = {value:.6g}" for each, value in zip(plan.ranges, plan.start, strict=True))
    ties = "".join(
        f"; where that is the same, by {parameter.name}: {parameter.meaning}" for parameter in plan.measures[1:]
    )
    provenance = [
        f"searched{' for the most harm' * harms}: {', '.join(map(str, plan.ranges))}; from {start}",
        f"by {plan.metric}: {plan.measures[0].meaning}{ties}",
        f"with CMA-ES (cma {library().__version__}), {counted(plan.trials, 'trial')} in each world: "
        f"{course_text(plan, result)}",
        f"training seeds {seed_for(seed, 'training')} (the {kind} as it was) and those that follow from {seed}, one a "
        f"generation; the search's own {seed_for(seed, 'search')}",
        f"the {kind}'s source has SHA-256 {tuned.sha256}",
    ]
    if harms:
        provenance.append(f"that of the brain {plan.target.brain.name} has {plan.target.brain.sha256}")
    if files:
        results = f"; the evaluation's results: {files['.nc'].name}" * compared
        provenance.append(f"every evaluation: {files['.csv'].name}{results}")
    table = _table_lines(plan, tuned)
    lines = [*_comments(head), "#", *_comments(findings), "", *table, "", *_comments(provenance)]
    return "\n".join(lines) + "\n"


def _table_lines(plan: TuningPlan, tuned: Brain | Adversary) -> list[str]:
    """The lines to paste, which name all searched parameters, also those with the value of the file."""
    named = {name: tuned.parameters[name] for name in plan.searched} | dict(tuned.overrides)
    program = to_toml_value({"file": tuned.name, **named})
    if plan.target.table is None:
        return ["[swarm]", f"brain = [{program}]"]
    given = read_toml(plan.study.text, "study")["members"][plan.target.table]
    return [
        "[[members]]",
        *(f"{key} = {f'[{program}]' if key == 'brain' else to_toml_value(value)}" for key, value in given.items()),
    ]


def course_text(plan: TuningPlan, result: SearchResult) -> str:
    """How a search went and why it ended: "57 evaluations in 4 generations, as many as the budget allows (...)"."""
    why = "until all candidates of one had the same values" if result.narrowed else "as many as the budget allows"
    text = f"{counted(len(result.evaluations), 'evaluation')} in {counted(result.generations, 'generation')}, {why}"
    return f"{text} ({plan.budget.text}){_drawn(result)}"


def why_unchanged(plan: TuningPlan, result: SearchResult) -> str:
    """Why a search ended at the original values."""
    if not result.flat:
        return "the search ended at the values there were"
    spent = f"{counted(len(result.evaluations), 'evaluation')}, as many as the budget allows{_drawn(result)}"
    return f"no candidate differed from another in {plan.metric}, and the budget is spent ({spent})"


def _drawn(result: SearchResult) -> str:
    if not result.drawn:
        return ""
    drawn = f"{counted(result.drawn, 'generation')} {'was' if result.drawn == 1 else 'were'} drawn"
    return f"; {drawn} from the whole of the ranges, as no candidate had differed before"


def _comments(lines: Sequence[str]) -> list[str]:
    return [
        f"{'# ' if k == 0 else '#   '}{part}"
        for line in lines
        for k, part in enumerate(textwrap.wrap(line, WIDTH, break_long_words=False, break_on_hyphens=False))
    ]
