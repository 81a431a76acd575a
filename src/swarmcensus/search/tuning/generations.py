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
        self.compiled = False

    def evaluate(self, generation: int, candidates: Sequence[Values]) -> list[Values]:
        """The losses of some candidates, from the log as far as it has them."""
        logged = self.log.evaluations[self.done : self.done + len(candidates)]
        for k, (evaluation, values) in enumerate(zip(logged, candidates, strict=False), start=self.done):
            if evaluation.values != values or evaluation.generation != generation:
                raise InputError.of(
                    self.log.path,
                    f"evaluation {k} has the values {evaluation.values} there and {values} here, "
                    f"because the machine or versions of libraries differ. {hint()}",
                )
        if len(logged) < len(candidates):
            self._try(generation, candidates[len(logged) :])
        self.done += len(candidates)
        return [evaluation.losses for evaluation in self.log.evaluations[self.done - len(candidates) : self.done]]

    def _try(self, generation: int, candidates: Sequence[Values]) -> None:
        if not self.compiled:
            self.training.compile(self.show)
            self.compiled = True
        plan, log = self.plan, self.log

        programs, seed = [*map(plan.candidate, candidates)], seed_for(plan.study.seed, "training", generation)
        found, failures = self.training.run(programs, seed, self._showing(f"generation {generation}"))
        if log.usual is None:  # of the program as it was
            if np.isnan(found[0, 0]).all():
                no = "no trial has a number of it: the measure means nothing for this brain"
                raise wrong_option("metric", plan.metric, failures[0] if failures else no)
            with_least = zip(found[0], plan.measures, plan.least, strict=True)
            log.set_usual(np.array([scales_of(one, plan.worlds, m, least) for one, m, least in with_least]))
        assert log.usual is not None
        for values, numbers in zip(candidates, found, strict=True):
            losses = tuple(map(loss, numbers, plan.measures, log.usual))
            every = (centres(one.ravel(), m.statistic) for one, m in zip(numbers, plan.measures, strict=True))
            failed = int(np.isnan(numbers[0]).sum())
            log.add(Evaluation(generation, values, losses, tuple(map(float, every)), failed))

    def _showing(self, stage: str) -> Callable[[Progress], None]:
        """A callback that shows the progress of one generation as progress of the whole search."""
        each = len(self.plan.worlds) * self.plan.trials
        before, cost = len(self.log.evaluations), self.training.cost()

        def show(progress: Progress) -> None:
            done, total = before * each + progress.done, self.plan.budget * each
            work_done, work_total = before * cost + progress.work_done, self.plan.budget * cost
            whole = replace(progress, done=done, total=total, work_done=work_done, work_total=work_total)
            self.show(replace(whole, stage=stage, part="the search"))

        return show


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
    of them can stand for another, they are reset one by one, as long as nothing changes.
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
        candidates, idle = idle, []
        for k in candidates:
            if is_same(*numbers_of([*idle, k])):
                idle.append(k)
    return reset(*idle), [plan.ranges[k].label for k in idle]
