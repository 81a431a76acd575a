"""Runs the search: evaluates each generation on its own trials, logs it, and resets parameters without effect."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from swarmcensus.runs import Progress
from swarmcensus.search.tuning.logs import Evaluation, Log, hint
from swarmcensus.search.tuning.optimiser import Search
from swarmcensus.search.tuning.plans import TuningPlan
from swarmcensus.search.tuning.training import Training, loss, scales_of
from swarmcensus.support.bootstrap import centres
from swarmcensus.support.errors import InputError
from swarmcensus.support.options import wrong_option
from swarmcensus.support.seeds import seed_for

Floats = NDArray[np.float64]
Values = tuple[float, ...]


@dataclass(frozen=True)
class SearchResult:
    """The result of a search: the values found, and all evaluations."""

    values: Values
    evaluations: list[Evaluation]
    generations: int
    narrowed: bool  # whether the search converged before its budget was spent
    flat: bool  # whether no generation had candidates that differ in the metric; then `values` are the start's


class _SearchRun:
    """A running search; candidates in the log are not evaluated again."""

    def __init__(self, plan: TuningPlan, log: Log, training: Training, show: Callable[[Progress], None]) -> None:
        self.plan, self.log, self.training, self.show = plan, log, training, show
        self.done = 0  # evaluations of the log that the optimiser has received
        self.usual: Floats | None = None  # the scales of the worlds by each measure, from the program as it was

    def evaluate(self, generation: int, candidates: Sequence[Values]) -> list[Values]:
        """The losses of a generation, from the log if that has them all."""
        end = self.done + len(candidates)
        logged = self.log.evaluations[self.done : end]
        for k, (evaluation, values) in enumerate(zip(logged, candidates, strict=False), start=self.done):
            if evaluation.values != values or evaluation.generation != generation:
                raise InputError.of(
                    self.log.path,
                    f"evaluation {k} has the values {evaluation.values} there and {values} here, "
                    f"because the machine or versions of libraries differ. {hint()}",
                )
        if len(logged) < len(candidates):
            del self.log.evaluations[self.done :]
            self.log.add(self._evaluations(generation, candidates))
        self.done = end
        return [evaluation.losses for evaluation in self.log.evaluations[end - len(candidates) : end]]

    def _evaluations(self, generation: int, candidates: Sequence[Values]) -> list[Evaluation]:
        measures = self.plan.measures
        if self.usual is None:
            self.training.compile(self.show)
            first, failures = self._numbers(0, [self.plan.start])
            if np.isnan(first[0, 0]).all():
                no = "no trial has a number of it: the measure means nothing for this brain"
                raise wrong_option("metric", self.plan.metric, failures[0] if failures else no)
            with_least = zip(first[0], measures, self.plan.least, strict=True)
            self.usual = np.array([scales_of(one, self.plan.worlds, m, least) for one, m, least in with_least])
        numbers_of = first if generation == 0 else self._numbers(generation, candidates)[0]
        found = []
        for values, numbers in zip(candidates, numbers_of, strict=True):
            losses = tuple(map(loss, numbers, measures, self.usual))
            every = (centres(one.ravel(), m.statistic) for one, m in zip(numbers, measures, strict=True))
            failed = int(np.isnan(numbers[0]).sum())
            found.append(Evaluation(generation, values, losses, tuple(map(float, every)), failed))
        return found

    def _numbers(self, generation: int, candidates: Sequence[Values]) -> tuple[Floats, list[str]]:
        """The numbers of a generation on its own trials, and why trials failed."""
        programs = [*map(self.plan.candidate, candidates)]
        seed = seed_for(self.plan.study.seed, "training", generation)
        stage = f"generation {generation}, {self.done:,} of at most {self.plan.budget:,} evaluations done"
        return self.training.run(
            programs, seed, lambda now: self.show(replace(now, stage=stage, part="this generation"))
        )


def new_search(plan: TuningPlan) -> Search:
    """A search before its first generation. Raises InputError if the budget is too small for one generation."""
    search = Search(plan.ranges, plan.start, seed_for(plan.study.seed, "search"))
    least = 1 + search.size
    if not (isinstance(plan.budget, int) and plan.budget >= least):
        why = f"should be a number of evaluations: the {plan.before.kind} as it is and one generation take {least}"
        raise wrong_option("budget", plan.budget, why)
    return search


def run_search(
    plan: TuningPlan, search: Search, log: Log, training: Training, show: Callable[[Progress], None]
) -> SearchResult:
    """Search, or resume from the log, until the budget is spent or the search has converged.

    Raises InputError if the original program fails in all trials.
    """
    course = _SearchRun(plan, log, training, show)
    course.evaluate(0, [plan.start])
    generation = 0
    while not search.ended and course.done + search.size <= plan.budget:
        generation += 1
        search.tell(course.evaluate(generation, search.ask()))
    done = log.evaluations[: course.done]
    flat = len({(evaluation.generation, evaluation.loss) for evaluation in done}) == generation + 1
    values = plan.start if flat else search.favourite
    return SearchResult(values, done, generation, search.ended, flat)


def reset_idle(
    plan: TuningPlan, values: Values, training: Training, show: Callable[[Progress], None]
) -> tuple[Values, list[str]]:
    """Reset values that change no number of any trial to what they were, and name their parameters.

    Each changed value is reset by itself, then all that have no effect together. If that changes a number, because one
    of them can stand for another, only the first is.
    """
    changed = [k for k, (value, was) in enumerate(zip(values, plan.start, strict=True)) if value != was]
    if not changed or len(values) == 1:  # if a search finds anything, its only parameter has an effect
        return values, []

    def reset(*places: int) -> Values:
        return tuple(plan.start[k] if k in places else value for k, value in enumerate(values))

    def numbers_of(*resets: Sequence[int]) -> list[Floats]:
        """The numbers (measure, world, trial) for each choice of places to reset, all on the same training trials."""
        programs = [plan.candidate(reset(*places)) for places in resets]
        return [*training.run(programs, seed_for(plan.study.seed, "influence"), show)[0]]

    def is_same(numbers: Floats) -> bool:
        return np.array_equal(original, numbers, equal_nan=True)

    original, *alone = numbers_of([], *([k] for k in changed))
    idle = [k for k, numbers in zip(changed, alone, strict=True) if is_same(numbers)]
    if len(idle) > 1 and not is_same(*numbers_of(idle)):
        idle = idle[:1]
    return reset(*idle), [plan.ranges[k].label for k in idle]
