"""Searches for good parameters of a brain, or the worst of an adversary, and evaluates them: `sc.tune`."""

import contextlib
import json
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from swarmcensus.brains import Adversary, Brain, Value
from swarmcensus.results import folder_of, store
from swarmcensus.runs import Device, Hardware, Report, run, showing
from swarmcensus.search.tuning.evidence import Evidence, evidence_of
from swarmcensus.search.tuning.generations import new_search, reset_idle, run_search
from swarmcensus.search.tuning.logs import Evaluation, Log
from swarmcensus.search.tuning.plans import TuningPlan, plan_of
from swarmcensus.search.tuning.reports import course_text, notes_of, report, why_unchanged
from swarmcensus.search.tuning.training import Training
from swarmcensus.simulation import warn_of_connections
from swarmcensus.studies import Study, warn_of_needs
from swarmcensus.support.answers import Answer, Row
from swarmcensus.support.errors import InputError
from swarmcensus.support.files import atomic_write, check_output, check_writable
from swarmcensus.support.formatting import counted
from swarmcensus.support.options import option
from swarmcensus.support.printed_tables import Table
from swarmcensus.support.toml_text import read_toml

MARK = "tuned: "  # titles of evaluations begin with it: an evaluation replaces no other results


@dataclass(repr=False)
class Tuned(Answer):
    """The result of a search: the brain or adversary with the values found, all evaluations, and the evidence."""

    brain: Brain  # with the values found; where an adversary was searched, the brain that it harms
    adversary: Adversary | None  # with the values found, if one was searched
    before: Brain | Adversary  # what was searched, as it was
    values: dict[str, float]  # the values found, by parameter or item, such as "prior" or "weights[0]"
    evaluations: list[Evaluation]
    evidence: Evidence
    course: str  # how the search went and why it ended, in a sentence
    notes: list[str]  # further sentences on these values
    text: str  # a fragment of a study file, with the evidence as comments

    @property
    def parameters(self) -> dict[str, Value]:
        """All parameters of the brain or adversary that was searched."""
        return (self.adversary or self.brain).parameters

    @property
    def verdict(self) -> str:
        """Whether the tuned brain is "better" than it was, "worse", "not told apart", or "not compared".

        Where an adversary was searched, it is how the swarm fares: "worse" if it does more harm.
        """
        return self.evidence.verdict

    @property
    def sentences(self) -> list[str]:  # type: ignore[override]
        """The evidence and the notes."""
        return [*self.evidence.sentences, *self.notes]

    @property
    def rows(self) -> Sequence[Row]:  # type: ignore[override]
        """A row for each world: what was found compared with the original."""
        return self.evidence.comparison.rows if self.evidence.comparison else []

    def tables(self, limit: int) -> list[Table]:
        """The comparison world by world."""
        return self.evidence.comparison.tables(limit)[:1] if self.evidence.comparison else []

    @property
    def fields(self) -> dict[str, Any]:  # type: ignore[override]
        """Values before and after, and the verdict."""
        return {
            "brain": self.brain.name, "adversary": self.adversary and self.adversary.name, "values": self.values,
            "parameters": self.parameters, "parameters_before": self.before.parameters,
            "evaluations": len(self.evaluations), "course": self.course, "verdict": self.verdict,
        }  # fmt: skip


def tune(
    study: Study | str | Path, parameters: Sequence[str] | str, brain: str | None = None, metric: str = "final_error",
    *, budget: int = 200, trials: int = 10, jobs: int | None = None, out: str | Path | None = None,
    fresh: bool = False, progress: Report | bool = True, say: Callable[[str], None] | None = None,
    adversary: str | None = None, device: Device = "cpu",
) -> Tuned:  # fmt: skip
    """Search for good values of a brain's parameters in a study's worlds, and compare the result with the original.

    With `adversary`, the name of one in the study's members, its parameters are searched for those with which the
    swarm is worst by the metric; `brain` is then the one that hears it, and needed if several do.

    `parameters` are ranges, such as ["prior=1:100:log", "weights[0]=0:1"]. `brain` is needed if several of the study's
    brains have parameters. `budget` is a number of evaluations. Each evaluation runs `trials` trials in each world,
    with seeds that the study does not use. With `out`, a .toml file, a fragment of a study file is written there; next
    to it are the log (.csv), from which the same call continues unless `fresh`, and the results of the evaluation
    (.nc), if there is one. `progress`, `say` and `device` are as for `run`. Raises InputError, and KeyboardInterrupt
    after Ctrl-C, when finished evaluations are in the log.
    """
    study = study if isinstance(study, Study) else Study.load(study)
    plan = plan_of(study, parameters, brain, metric, budget, trials, adversary)
    warn_of_needs(plan.worlds, study.measure.bins)
    warn_of_connections(plan.worlds, study.seed, trials)
    files = files_of(out)
    if files:
        check_replaceable(files[".nc"])
    hardware, search = Hardware(jobs, device), new_search(plan)
    training = Training(plan, hardware)
    log = Log(files.get(".csv"), plan, fresh)
    with showing(progress, f"tuning {plan.target.program.name}") as show, log:
        if log.evaluations and say:
            say(f"{log.path}: found {counted(len(log.evaluations), 'evaluation')}")
        result = run_search(plan, search, log, training, show)
        values, idle = reset_idle(plan, result.values, training, show)
        tuned = plan.candidate(values)
        if tuned == plan.before:
            names, why = (plan.label(tuned), plan.label(plan.before)), why_unchanged(plan, result)
            evidence = Evidence(*names, None, None, why, plan.target.harms)
        else:
            again, kept = evaluation_of(plan, tuned), files.get(".nc")  # finished trials are kept, and not run again
            other = kept is not None and any(title != again.name for title in _titles(kept)[-1:])  # of other values
            data = run(again, progress=show, out=kept, fresh=fresh or other, say=say, cautions=False, **vars(hardware))
            evidence = evidence_of(data, again.settings(), plan, tuned)
        notes = notes_of(plan, idle)
        text = report(plan, tuned, result, evidence, notes)
        if files:
            with atomic_write(files[".toml"]) as temporary:
                temporary.write_text(text, encoding="utf-8")
    of, liar = (plan.target.brain, tuned) if isinstance(tuned, Adversary) else (tuned, None)
    by_label, course = dict(zip(log.places, values, strict=True)), course_text(result)
    return Tuned(of, liar, plan.before, by_label, result.evaluations, evidence, course, notes, text)


def files_of(out: str | Path | None, *inputs: Path) -> dict[str, Path]:
    """The files of a search by suffix. Raises InputError if they cannot be written, or are inputs."""
    if out is None:
        return {}
    check_output("out", out, (".toml",))
    files = {suffix: Path(out).with_suffix(suffix) for suffix in (".toml", ".csv", ".nc")}
    for path in files.values():
        check_writable(path, *inputs)
    return files


def evaluation_of(plan: TuningPlan, tuned: Brain | Adversary) -> Study:
    """The study with what was found added wherever the original appears, and with the largest number of trials.

    Its label becomes part of the study's name.
    """
    study = plan.study
    tables = read_toml(study.text, "study")
    changes: dict[str, Any] = {"name": f"{MARK}{plan.label(tuned)}, {study.name}", "trials": study.trials}
    if isinstance(tuned, Adversary):
        assert plan.target.table is not None
        keys: list[tuple[Any, Any]] = [(tables["members"][plan.target.table], study.members[plan.target.table])]
    else:
        keys = [(tables.get("swarm", {}), study.swarm), *zip(tables.get("case", []), study.case, strict=True)]
    # the tables of the file are changed, since a checked study no longer tells what its author left out
    for table, checked in keys:
        programs = checked.brain or []
        if tuned not in programs and tuned.as_written in [program.as_written for program in programs]:
            table["brain"] = [*programs, tuned]
    return study.with_(**changes, **{key: tables[key] for key in ("members", "swarm", "case") if key in tables})


def check_replaceable(out: Path) -> None:
    """Raise InputError if `out`, or an unfinished run that writes it, holds results other than an evaluation."""
    for title in _titles(out):
        if not title.startswith(MARK):
            why = f"holds results that no evaluation of a search made: write elsewhere with {option('out')}"
            raise InputError(f"{out} {why}", file=out)


def _titles(out: Path) -> list[str]:
    """The names of the study with results in `out`, and of the study of an unfinished run, as far as they exist."""
    titles = []
    if out.exists():
        titles.append(str(store.load(out).attrs.get("title", "")))
    with contextlib.suppress(OSError, ValueError, KeyError, TypeError):
        titles.append(str(json.loads((folder_of(out) / "run.json").read_text(encoding="utf-8"))["study"]))
    return titles
