"""The report of a search: a fragment of a study file with what was found, and the evidence as comments."""

import textwrap
from collections.abc import Mapping, Sequence
from pathlib import Path

from swarmcensus.brains import Adversary, Brain
from swarmcensus.search.tuning.evidence import NONE, Evidence
from swarmcensus.search.tuning.generations import SearchResult
from swarmcensus.search.tuning.plans import TuningPlan
from swarmcensus.support.formatting import counted
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
    harms, study = plan.target.harms, plan.study
    aim, use = "tuned for", "its brain is for one's table [swarm]"
    if harms:
        aim = f"with the values found to harm {plan.target.brain.name} most in"
        use = "its table is for one's members"
    head = [
        f"{plan.before.name}, {aim} the study {study.name!r} by swarmcensus {__version__}; this is no study by itself: "
        f"{use}"
    ]
    if not evidence.is_found:
        head += ["There is no evidence that the values below are worth anything: read on"]
    findings = [*evidence.sentences, *notes]
    if compared := evidence.verdict != NONE:
        findings += [
            f"evaluated with seed {study.seed}, the study's own, in {counted(study.trials, 'trial')} a world, none of "
            "which the search has seen; p-values are corrected by Holm's method for this metric alone, so that "
            "swarmcensus compare, which asks for more measures, may tell less apart"
        ]
    start = ", ".join(f"{each.label} = {value:.6g}" for each, value in zip(plan.ranges, plan.start, strict=True))
    searched = f"{', '.join(map(str, plan.ranges))}; from {start}; by {plan.metric}: {plan.measures[0].meaning}"
    provenance = [f"searched{' for the most harm' * harms}: {searched}", course_text(result)]
    if files:
        results = f"; the evaluation's results: {files['.nc'].name}" * compared
        provenance.append(f"every evaluation, with versions and hashes: {files['.csv'].name}{results}")
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


def course_text(result: SearchResult) -> str:
    """How a search went and why it ended: "57 evaluations in 4 generations, as many as the budget allows"."""
    why = "until all candidates of one had the same values" if result.narrowed else "as many as the budget allows"
    return f"{counted(len(result.evaluations), 'evaluation')} in {counted(result.generations, 'generation')}, {why}"


def why_unchanged(plan: TuningPlan, result: SearchResult) -> str:
    """Why a search ended at the original values."""
    if result.flat:
        return f"no candidate differed from another in {plan.metric}"
    return "the search ended at the values there were"


def _comments(lines: Sequence[str]) -> list[str]:
    return [
        f"{'# ' if k == 0 else '#   '}{part}"
        for line in lines
        for k, part in enumerate(textwrap.wrap(line, WIDTH, break_long_words=False, break_on_hyphens=False))
    ]
