"""Runs candidates on training trials, a generation at a time, in threads, and computes their losses."""

import copy
from collections.abc import Callable, Sequence
from typing import Self

import numpy as np
from numpy.typing import NDArray

from swarmcensus.brains import Adversary, Brain
from swarmcensus.engine import LeavableThreads
from swarmcensus.results import LOCAL, Values, store
from swarmcensus.runs import (
    Device,
    Progress,
    State,
    WhereToRun,
    bundle_tasks,
    placing_of,
    plan_tasks,
    pools,
    run_bundles,
    seconds_for,
)
from swarmcensus.search.tuning.plans import TuningPlan
from swarmcensus.search.tuning.targets import world_with
from swarmcensus.studies import Setting, Study
from swarmcensus.summaries import Measure, learnt_numbers, measures

Floats = NDArray[np.float64]
ALWAYS_NEEDED = (  # variables for shapes, and for the truth that errors refer to
    "convergence_round", "final_estimate", "true_fill_ratio", "right_option",
)  # fmt: skip
MANY = 1000  # evaluations, where a time limits them: they are worth a card
FAILED_LOSS = 1.0  # of a trial that failed
MOST_WIDTHS = 500.0  # from the middle, beyond which a logistic function is 0 or 1
Keep = Callable[[int, Floats], None]  # takes a candidate's place and numbers (measure, world, trial); NaN has failed


class Training:
    """Runs candidates in worlds; the threads live as long as the `with` block."""

    def __init__(self, plan: TuningPlan, jobs: int, device: Device = "cpu") -> None:
        """Choose where trials run. Raises InputError."""
        self.study, self.worlds, self.measures, self.trials = plan.study, plan.worlds, plan.measures, plan.trials
        self.jobs, self.device = jobs, device
        self.local = any(measure.name in LOCAL for measure in self.measures)
        trials = np.full(len(self.worlds), (plan.budget.evaluations or MANY) * self.trials)
        self.placing = placing_of(self.study, self.worlds, trials, device, local=self.local)

    def __enter__(self) -> Self:
        """Create the threads."""
        self._executor = LeavableThreads(self.jobs)
        self._feeder = LeavableThreads(1 if self.placing.card else 0)
        return self

    def __exit__(self, *_: object) -> None:
        """End them."""
        self._executor.shutdown()
        self._feeder.shutdown()

    def compile(self, show: Callable[[Progress], None]) -> None:
        """Compile what the worlds need, once: candidates differ in numbers only."""
        pools.compile_for(
            [(self.study, self.placing.on_cpu(self.worlds))],
            lambda note, steps: show(Progress(0, 0, 0.0, 0.0, note, steps=steps)),
        )

    def candidate_seconds(self) -> float:
        """The seconds that a candidate takes in these threads, measured once brains are compiled."""
        return seconds_for(self.study, self.worlds, self.trials, self.jobs, self.local, self.placing)

    def cost(self) -> float:
        """The predicted seconds of a candidate on one core."""
        every = np.ones((len(self.worlds), self.trials), np.bool_)
        local = every if self.local else None
        tasks = plan_tasks(self.worlds, every, local, pools.BUNDLE_SECONDS, self.placing.room)
        return sum(task.cost for task in tasks)

    def run(
        self, programs: Sequence[Brain | Adversary], seed: int, keep: Keep, show: Callable[[Progress], None]
    ) -> list[str]:
        """Run all candidates on the same trials; `keep` is called for each in order, as soon as it is finished.

        Returns why trials failed, a text for each. Raises KeyboardInterrupt after Ctrl-C; finished candidates are kept.
        """
        seeded = copy.copy(self.study)
        seeded.seed = seed
        settings = [world_with(world, program) for program in programs for world in self.worlds]
        values = Values(seeded, settings, self.trials, self.local)
        wanted = np.ones((len(settings), self.trials), np.bool_)
        placing = WhereToRun(self.placing.card, np.tile(self.placing.room, len(programs)))
        tasks = plan_tasks(settings, wanted, wanted if self.local else None, pools.BUNDLE_SECONDS, placing.room)
        tasks.sort(key=lambda task: min(task.settings) // len(self.worlds))  # one candidate after the other
        kept = 0

        def report(progress: Progress) -> None:
            nonlocal kept
            ended = state.values.finished()
            for failure in state.failures:
                ended[failure.setting, failure.trial] = True
            finished = np.asarray(ended.reshape(len(programs), -1).all(axis=1))
            while kept < len(programs) and finished[kept]:
                end = kept + int(np.argmin(np.append(finished[kept:], False)))
                for candidate_numbers in self._numbers(seeded, settings, values, kept, end):
                    keep(kept, candidate_numbers)
                    kept += 1
            show(progress)

        state = State(seeded, settings, values, report, None, np.zeros(0), slice(None), placing)
        state.total, state.work_total = wanted.size, sum(task.cost for task in tasks)
        pool = pools.Threads(self._executor, self.jobs, seeded, settings, placing.card, self._feeder)
        try:
            stopped = run_bundles(state, bundle_tasks(tasks, pools.BUNDLE_SECONDS), pool)
        except BaseException:
            pool.halt()
            raise
        report(Progress(state.done, state.total, state.work_done, state.work_total))
        if stopped:
            raise KeyboardInterrupt
        return [failure.why for failure in state.failures]

    def _numbers(self, study: Study, settings: list[Setting], values: Values, first: int, last: int) -> Floats:
        """The numbers of candidates `first` to `last` - 1, (candidate, measure, world, trial)."""
        rows = slice(first * len(self.worlds), last * len(self.worlds))
        part = copy.copy(values)
        needed = {*ALWAYS_NEEDED, *(name for measure in self.measures for name in measures.inputs_of(measure.name))}
        part.arrays = {name: array[rows] for name, array in values.arrays.items() if name in needed}
        part_settings = settings[rows]
        data = store.dataset(study, part_settings, [""] * len(part_settings), part)
        stacked = np.stack([learnt_numbers(data, measure.name) for measure in self.measures])
        return stacked.reshape(len(self.measures), last - first, len(self.worlds), self.trials).swapaxes(0, 1)


def scales_of(numbers: Floats, worlds: Sequence[Setting], measure: Measure, least: float) -> Floats:
    """The scale of each world (world, 2), a middle and a width, from the first candidate's trials (world, trial).

    `least` is the smallest possible number of the measure. If it is not negative, the middle is the median of finite
    numbers above 0, and the width is 0, because ratios to the middle count; without such numbers it is 1, or the
    world's number of rounds if the measure is a time. Otherwise they are the median and the mean distance from it.
    """
    scales = np.zeros((len(worlds), 2))
    for k, (row, world) in enumerate(zip(numbers, worlds, strict=True)):
        finite = row[np.isfinite(row)]
        if least >= 0:
            above = finite[finite > 0]
            alone = float(world.rounds) if measure.unit == "rounds" else 1.0
            scales[k] = (np.median(above) if above.size else alone), 0.0
        else:
            middle = float(np.median(finite)) if finite.size else 0.0
            width = float(np.abs(finite - middle).mean()) if finite.size else 0.0
            scales[k] = middle, width or 1.0
    return scales


def loss(numbers: Floats, measure: Measure, scales: Floats) -> float:
    """The loss of a candidate's trials (world, trial), in [0, 1], where lower is better; a NaN is a failed trial.

    A share counts as it is. For other measures a trial's number v counts as v / (v + m), with the middle m of its
    world's scale: 0 stays 0, the middle is 1/2, infinity ("never") is 1. If a measure may be negative, v counts as the
    logistic function of its distance from the middle, in widths.
    """
    middle, width = scales[:, :1], scales[:, 1:]
    if measure.share:
        bad = numbers if measure.low else 1.0 - numbers
    else:
        with np.errstate(invalid="ignore", divide="ignore"):
            ratio = np.where(np.isposinf(numbers), 1.0, numbers / (numbers + middle))
            distance = np.clip((numbers - middle) / np.where(width > 0, width, 1.0), -MOST_WIDTHS, MOST_WIDTHS)
        above = np.where(width > 0, 1.0 / (1.0 + np.exp(-distance)), ratio)
        bad = above if measure.low else 1.0 - above
    return float(np.where(np.isnan(numbers), FAILED_LOSS, bad).mean())
