"""The report of a search: a fragment of a study file with what was found, and the evidence as comments."""

import textwrap
from collections.abc import Sequence

from swarmcensus.brains import Adversary, Brain
from swarmcensus.search.tuning.evidence import Evidence
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
    plan: TuningPlan, tuned: Brain | Adversary, result: SearchResult, evidence: Evidence, notes: Sequence[str]
) -> str:
    """The text of the fragment: what it is for, what was found and how, and the table to paste."""
    study, aim = plan.study, f"to harm {plan.target.brain.name} most" if plan.target.harms else "to do best"
    pairs = [] if evidence.comparison is None else evidence.comparison.pair_sentences
    lines = [
        f"{plan.before.name}, {aim} in the study {study.name!r} by {plan.metric}: paste the table below into it",
        *["There is no evidence that its values are worth anything"] * (not evidence.is_found),
        *evidence.sentences, *pairs, *notes,
        f"The comparison is on seed {study.seed}, the study's own, in {counted(study.trials, 'trial')} a world: none "
        "that the search has seen",
        f"Searched: {', '.join(map(str, plan.ranges))}; {course_text(result)}; swarmcensus {__version__}",
    ]  # fmt: skip
    return "\n".join([*_comments(lines), *_table_lines(plan, tuned)]) + "\n"


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
    wrap = textwrap.TextWrapper(
        WIDTH, initial_indent="# ", subsequent_indent="#   ", break_long_words=False, break_on_hyphens=False
    )
    return [part for line in lines for part in wrap.wrap(line)]
