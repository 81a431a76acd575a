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
    head = [f"{_found_text(plan)} by swarmcensus {__version__}; this is no study by itself: {_use_text(plan)}"]
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
    names = [f"every evaluation: {files['.csv'].name}"] if files else []
    if files and compared:
        names = [f"{names[0]}; the evaluation's results: {files['.nc'].name}"]
    ties = "".join(
        f"; where that is the same, by {parameter.name}: {parameter.meaning}" for parameter in plan.measures[1:]
    )
    provenance = [
        f"searched{' for the most harm' * harms}: {', '.join(map(str, plan.ranges))}; from "
        f"{_values_text(plan, plan.start)}",
        f"by {plan.metric}: {plan.measures[0].meaning}{ties}",
        f"with CMA-ES (cma {library().__version__}), {counted(plan.trials, 'trial')} in each world: "
        f"{course_text(plan, result)}",
        f"training seeds {seed_for(seed, 'training')} (the {kind} as it was) and those that follow from {seed}, one a "
        f"generation; the search's own {seed_for(seed, 'search')}",
        f"the {kind}'s source has SHA-256 {tuned.sha256}",
        *([f"that of the brain {plan.target.brain.name} has {plan.target.brain.sha256}"] if harms else []),
        *names,
    ]
    return fragment(_table_lines(plan, tuned), head, findings, provenance)


def _found_text(plan: TuningPlan) -> str:
    study = f"the study {plan.study.name!r}"
    if not plan.target.harms:
        return f"{plan.before.name}, tuned for {study}"
    return f"{plan.before.name}, with the values found to harm {plan.target.brain.name} most in {study}"


def _use_text(plan: TuningPlan) -> str:
    return "its table is for one's members" if plan.target.harms else "its brain is for one's table [swarm]"


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


def _values_text(plan: TuningPlan, values: tuple[float, ...]) -> str:
    return ", ".join(f"{parameter.label} = {value:.6g}" for parameter, value in zip(plan.ranges, values, strict=True))


def fragment(table: Sequence[str], head: Sequence[str], evidence: Sequence[str], provenance: Sequence[str]) -> str:
    """TOML text: the evidence as comments, the lines to paste, and comments on how the values were found."""
    lines = [*_comments(head), "#", *_comments(evidence), "", *table, "", *_comments(provenance)]
    return "\n".join(lines) + "\n"


def _comments(lines: Sequence[str]) -> list[str]:
    return [
        f"{'# ' if k == 0 else '#   '}{part}"
        for line in lines
        for k, part in enumerate(textwrap.wrap(line, WIDTH, break_long_words=False, break_on_hyphens=False))
    ]
