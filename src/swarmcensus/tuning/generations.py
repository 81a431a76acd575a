"""The search, generation by generation: asked for, tried on trials of its own, told, and all of it in the log."""

import logging
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from swarmcensus.basics.errors import InputError
from swarmcensus.basics.formatting import counted
from swarmcensus.basics.options import option
from swarmcensus.basics.seeds import seed_for
from swarmcensus.runs.collect import Progress
from swarmcensus.tuning.logs import Evaluation, Log, hint
from swarmcensus.tuning.optimiser import Search
from swarmcensus.tuning.plans import Plan
from swarmcensus.tuning.training import Training, loss, scales_of

LOG = logging.getLogger(__name__)
Floats = NDArray[np.float64]


@dataclass(frozen=True)
class Ended:
    """Where a search ended: the values that it would go on from, and all evaluations up to there."""

    values: tuple[float, ...]
    evaluations: list[Evaluation]
    generations: int
    drawn: int  # of which from the whole of the ranges, as no candidate had differed before
    narrowed: bool  # whether it ended by itself, and not with its budget
    flat: bool  # whether no candidate of any generation differed in the metric: the values are the start's


class _Course:
    """A search under way: what is in the log is not tried again."""

    def __init__(self, plan: Plan, log: Log, training: Training, show: Callable[[Progress], None]) -> None:
        self.plan, self.log, self.training, self.show = plan, log, training, show
        self.done = 0  # evaluations of the log that the search has been told of
        self.compiled = False
        self.before = log.evaluations[-1].seconds if log.evaluations else 0.0
        self.begun = time.monotonic()

    @property
    def seconds(self) -> float:
        """How long the search has been going on, pauses left out."""
        return self.before + time.monotonic() - self.begun

    def evaluate(self, generation: int, asked: Sequence[tuple[float, ...]]) -> list[tuple[float, ...]]:
        """How bad some candidates are, those of the log as it says."""
        found = self.log.evaluations[self.done : self.done + len(asked)]
        for k, (one, values) in enumerate(zip(found, asked, strict=False), start=self.done):
            if one.values != values or one.generation != generation:
                raise InputError(
                    f"{self.log.path}: evaluation {k} is of {one.values} there, and would be of {values} here, on "
                    f"another machine or with other versions of libraries. {hint()}"
                )
        if len(found) < len(asked):
            self._try(generation, asked[len(found) :])
        self.done += len(asked)
        return [one.losses for one in self.log.evaluations[self.done - len(asked) : self.done]]

    def _try(self, generation: int, asked: Sequence[tuple[float, ...]]) -> None:
        if not self.compiled:
            self.training.compile(self.show)
            self.compiled = True
            self.begun = time.monotonic()  # to compile is no part of the search
        plan, log = self.plan, self.log

        def keep(place: int, numbers: Floats) -> None:
            if log.usual is None:
                if np.isnan(numbers[0]).all():
                    return  # told of below
                each = zip(numbers, plan.measures, plan.least, strict=True)
                log.set_usual(np.array([scales_of(some, plan.worlds, one, least) for some, one, least in each]))
            assert log.usual is not None
            by = zip(numbers, plan.measures, log.usual, strict=True)
            lost = tuple(loss(some, one, usual) for some, one, usual in by)
            told = ", ".join(f"{r.place} = {v:.6g}" for r, v in zip(plan.ranges, asked[place], strict=True))
            LOG.debug("generation %s: %s: loss %s", generation, told, ", ".join(f"{one:.6g}" for one in lost))
            seconds = round(self.seconds, 3)  # as the log will say: by it a budget of time ends, now and from the log
            log.add(Evaluation(generation, asked[place], lost, int(np.isnan(numbers[0]).sum()), seconds))

        failures = self.training.run(
            [plan.brain_of(values) for values in asked],
            seed_for(plan.study.seed, "training", generation),
            keep,
            self._showing(f"generation {generation}"),
        )
        if log.usual is None:
            why = failures[0] if failures else "no trial has a number of it: the measure means nothing for this brain"
            raise InputError(f"{option('metric', plan.metric)}: {why}")

    def _showing(self, stage: str) -> Callable[[Progress], None]:
        """Progress of some candidates as that of the whole search."""
        each = len(self.plan.worlds) * self.plan.trials
        budget, before = self.plan.budget, len(self.log.evaluations) * each
        total, cost = (budget.evaluations or 0) * each, self.training.cost()

        def show(progress: Progress) -> None:
            done = before + progress.done
            if budget.seconds is not None:
                work = min(self.seconds, budget.seconds), budget.seconds
            else:
                work = before / each * cost + progress.work_done, total / each * cost
            self.show(
                replace(progress, done=done, total=total or done, work_done=work[0], work_total=work[1], stage=stage)
            )

        return show


def search_of(plan: Plan) -> Search:
    """The search that is asked for, before its first generation. Raises InputError where the budget is too small."""
    search = Search(plan.ranges, plan.start, seed_for(plan.study.seed, "search"))
    if plan.budget.evaluations is not None and plan.budget.evaluations < 1 + search.size:
        raise InputError(
            f"{option('budget', plan.budget.evaluations)}: the brain as it is and one generation take "
            f"{counted(1 + search.size, 'evaluation')}"
        )
    return search


def search_on(plan: Plan, search: Search, log: Log, training: Training, show: Callable[[Progress], None]) -> Ended:
    """Search, or go on, until the budget is spent or the search has come to its end.

    Raises InputError where the brain as it is fails in all trials.
    """
    course = _Course(plan, log, training, show)
    course.evaluate(0, [plan.start])
    generation = 0
    while generation == 0 or (
        not search.ended and plan.budget.allows(course.done, search.size, log.evaluations[course.done - 1].seconds)
    ):
        generation += 1
        search.tell(course.evaluate(generation, search.ask()))
    done = log.evaluations[: course.done]
    flat = len({(one.generation, one.loss) for one in done}) == generation + 1
    values = plan.start if flat else search.favourite
    return Ended(values, done, generation, search.drawn, search.ended, flat)
