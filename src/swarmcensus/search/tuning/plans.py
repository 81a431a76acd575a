"""The plan of a search: what is searched, worlds, ranges, measure and budget."""

import hashlib
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

from swarmcensus.brains import Adversary, Brain, Value
from swarmcensus.results import Values, store
from swarmcensus.search.tuning.optimiser import library
from swarmcensus.search.tuning.ranges import Range, ranges_of, start_of, with_values
from swarmcensus.search.tuning.targets import Target, target_of
from swarmcensus.studies import Setting, Study, addresses
from swarmcensus.summaries import MEASURES, Measure, choose_measures, missing_inputs
from swarmcensus.support.options import wrong_option
from swarmcensus.support.version import __version__

COMPANIONS = {  # for measures that are often equal for different values: the measure that breaks their ties
    "consensus_right": "decided_right", "right_consensus_round": "decided_right", "decided_right": "final_error",
    "decision_round": "decided", "done_round": "done", "correct": "final_error", "right_side": "final_error",
    "first_right": "final_error", "swarm_right": "final_error", "time_right": "final_error",
    "agreement_round": "final_disagreement",
}  # fmt: skip
MOST_TRIALS = 100_000  # in each world, for a candidate


@dataclass(frozen=True)
class TuningPlan:
    """All that defines a search."""

    study: Study
    target: Target
    worlds: list[Setting]
    ranges: list[Range]
    metric: str  # the name that was given
    measures: list[Measure]  # of that name, and the one that breaks its ties, if any; for harm both are turned round
    least: list[float]  # the smallest possible number of each measure
    budget: int  # evaluations
    trials: int

    @property
    def before(self) -> Brain | Adversary:
        """What is searched, with the parameters that the study gives first; worlds have the number formats."""
        return self.target.program

    @property
    def start(self) -> tuple[float, ...]:
        """The present values, one for each range."""
        return start_of(self.ranges, self.before)

    @property
    def searched(self) -> list[str]:
        """The names of the searched parameters; a vector appears once."""
        return list(dict.fromkeys(each.name for each in self.ranges))

    def label(self, program: Brain | Adversary) -> str:
        """A program's name, its searched parameters, and other parameters that differ from its file."""
        values = {name: program.parameters[name] for name in self.searched} | dict(program.overrides)
        return " ".join([program.name, *(f"{name}={_value_text(value)}" for name, value in values.items())])

    @property
    def losses(self) -> list[str]:
        """The columns of the log for a candidate's loss by each measure."""
        return ["loss", *(f"{each.name}_loss" for each in self.measures[1:])]

    def candidate(self, values: Sequence[float]) -> Brain | Adversary:
        """The program with these values of the searched parameters."""
        return with_values(self.before, self.ranges, values)

    @property
    def identity(self) -> dict[str, Any]:
        """What determines a search: with an equal identity and equal losses it proposes the same candidates."""
        worlds = "".join(addresses.fingerprint(world, self.study.seed) for world in self.worlds)
        measure = self.study.measure
        measured = (worlds, measure.delta, measure.bins, measure.truth, self.study.checkpoints)
        files = [metric.sha256 for metric in measure.metrics]
        harm = {"adversary": self.before.label} if self.target.harms else {}
        return {
            "brain": self.target.brain.name if self.target.harms else self.before.label,
            **harm, "source": self.before.sha256[:16], "parameters": " ".join(map(str, self.ranges)),
            "metric": self.metric, "better": "low" if self.measures[0].low else "high", "seed": self.study.seed,
            "trials": self.trials,
            "worlds": hashlib.blake2b(repr((measured, files)).encode(), digest_size=8).hexdigest(),
            "version": __version__, "cma": str(library().__version__),
        }  # fmt: skip


def _value_text(value: Value) -> str:
    return f"[{', '.join(map(_value_text, value))}]" if isinstance(value, tuple) else f"{value:.15g}"


def measures_of(study: Study, worlds: list[Setting], metric: str) -> list[Measure]:
    """The measure of this name, and the measure that breaks its ties, if these worlds have it.

    Raises InputError if these worlds do not have the measure, or if it does not say whether low or high is better.
    """
    blank = store.dataset([study], worlds, [""] * len(worlds), Values([study], worlds, 1))
    [measure], _ = choose_measures(blank, [metric])
    companion = COMPANIONS.get(measure.name, "")
    return [measure, *([MEASURES[companion]] if companion and not missing_inputs(blank, companion) else [])]


def plan_of(
    study: Study, parameters: Sequence[str] | str, brain: str | None, metric: str, budget: int, trials: int,
    adversary: str | None = None,
) -> TuningPlan:  # fmt: skip
    """Check the request against the study. Raises InputError, naming what the study lacks and what it has."""
    if not 1 <= trials <= MOST_TRIALS:
        raise wrong_option("trials", trials, f"a candidate has 1 to {MOST_TRIALS:,} trials in each world")
    target = target_of(study, brain, adversary)
    ranges = ranges_of(parameters, target.program)
    worlds = target.worlds(study)
    measures = measures_of(study, worlds, metric)
    lows = {m.variable: m.bounds[0] for m in study.measure.metrics}
    least = [lows.get(each.name, 0.0) for each in measures]
    if target.harms:
        measures = [replace(measure, low=not measure.low) for measure in measures]
    return TuningPlan(study, target, worlds, ranges, metric, measures, least, budget, trials)
