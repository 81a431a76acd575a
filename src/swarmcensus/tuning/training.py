"""Candidates tried: a generation at once, in all worlds, by the threads of this process, and nothing is written."""

import copy
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from typing import Self

import numpy as np
from numpy.typing import NDArray

from swarmcensus.brains import Brain
from swarmcensus.results import store
from swarmcensus.results.measures import OURS, Measure, chosen, inputs_of, lacks, numbers
from swarmcensus.results.values import LOCAL, Values
from swarmcensus.runs import pools
from swarmcensus.runs.collect import Progress, State, run_bundles
from swarmcensus.runs.tasks import bundle_tasks, plan_tasks
from swarmcensus.studies.settings import Setting
from swarmcensus.studies.study import Study

Floats = NDArray[np.float64]
FOR_ALL = ("convergence_round", "final_estimate", "true_fill_ratio", "right_option")  # shapes, and what errors are of
Keep = Callable[[int, Floats], None]  # a candidate's place, its numbers (measure, world, trial): NaN of failed trials


def measures_of(study: Study, worlds: list[Setting], metric: str) -> list[Measure]:
    """The measure of this name, and its companion if it has one here.

    Raises InputError where such worlds have none, or nobody says what is better.
    """
    blank = store.dataset(study, worlds, [""] * len(worlds), Values(study, worlds, 1))
    [measure], _ = chosen(blank, [metric])
    companion = COMPANIONS.get(measure.name, "")
    return [measure, *([OURS[companion]] if companion and not lacks(blank, companion) else [])]


class Training:
    """Worlds in which candidates are tried, with threads that wait for them as long as the block lasts."""

    def __init__(self, study: Study, worlds: list[Setting], measures: list[Measure], trials: int, jobs: int) -> None:
        """Each candidate has so many trials in each world."""
        self.study, self.worlds, self.measures, self.trials, self.jobs = study, worlds, measures, trials, jobs
        self.local = any(one.name in LOCAL for one in measures)

    def __enter__(self) -> Self:
        """Begin the threads."""
        self._executor = ThreadPoolExecutor(self.jobs, thread_name_prefix="swarmcensus")
        return self

    def __exit__(self, *_: object) -> None:
        """End them."""
        self._executor.shutdown(cancel_futures=True)

    def compile(self, show: Callable[[Progress], None]) -> None:
        """Compile what the worlds need: candidates differ in numbers alone, and need nothing else."""
        pools.compile_for(
            [(self.study, self.worlds)], lambda note, steps: show(Progress(0, 0, 0.0, 0.0, note, steps=steps))
        )

    def cost(self) -> float:
        """The predicted seconds of a candidate on one core."""
        every = np.ones((len(self.worlds), self.trials), np.bool_)
        local = every if self.local else None
        return sum(task.cost for task in plan_tasks(self.worlds, every, local, pools.BUNDLE_SECONDS))

    def run(self, brains: Sequence[Brain], seed: int, keep: Keep, show: Callable[[Progress], None]) -> list[str]:
        """Run all candidates on the same trials, and `keep` the numbers of each as soon as it is through, in order.

        What comes back is why trials failed, a text for each. Raises KeyboardInterrupt after Ctrl-C, when those that
        were through are kept.
        """
        seeded = copy.copy(self.study)
        seeded.seed = seed
        settings = [replace(world, brain=brain) for brain in brains for world in self.worlds]
        values = Values(seeded, settings, self.trials, self.local)
        wanted = np.ones((len(settings), self.trials), np.bool_)
        tasks = plan_tasks(settings, wanted, wanted if self.local else None, pools.BUNDLE_SECONDS)
        tasks.sort(key=lambda task: min(task.settings) // len(self.worlds))  # one candidate through, then the next
        kept = 0

        def report(progress: Progress) -> None:
            nonlocal kept
            through = self._through(state)
            while kept < len(brains) and through[kept]:
                several = kept + int(np.argmin(np.append(through[kept:], False)))
                for place, found in enumerate(self._numbers(seeded, settings, values, kept, several), start=kept):
                    keep(place, found)
                    kept = place + 1
            show(progress)

        state = State(seeded, settings, values, report, None, np.zeros(0), slice(None))
        state.total, state.work_total = wanted.size, sum(task.cost for task in tasks)
        pool = pools.Threads(self._executor, self.jobs, seeded, settings)
        try:
            stopped = run_bundles(state, bundle_tasks(tasks, pools.BUNDLE_SECONDS), pool)
        except BaseException:
            pool.halt()
            raise
        report(Progress(state.done, state.total, state.work_done, state.work_total))
        if stopped:
            raise KeyboardInterrupt
        return [failure.why for failure in state.failures]

    def _through(self, state: State) -> NDArray[np.bool_]:
        """Which candidates have no trial left to run, (candidate,)."""
        ended = state.values.finished()
        for failure in state.failures:
            ended[failure.setting, failure.trial] = True
        return np.asarray(ended.reshape(-1, len(self.worlds) * self.trials).all(axis=1))

    def _numbers(self, study: Study, settings: list[Setting], values: Values, first: int, last: int) -> Floats:
        """The numbers of candidates from `first` to before `last`, (candidate, measure, world, trial)."""
        rows = slice(first * len(self.worlds), last * len(self.worlds))
        some = copy.copy(values)
        needed = {*FOR_ALL, *(part for one in self.measures for part in inputs_of(one.name))}
        some.arrays = {name: array[rows] for name, array in values.arrays.items() if name in needed}
        mine = settings[rows]
        data = store.dataset(study, mine, [""] * len(mine), some)
        found = np.stack([numbers(data, one.name) for one in self.measures])
        return found.reshape(len(self.measures), last - first, len(self.worlds), self.trials).swapaxes(0, 1)


WORST = 1.0
COMPANIONS = {  # of measures that are the same in whole regions of values: which one breaks their ties
    "consensus_right": "decided_right", "consensus_round": "decided_right", "decided_right": "final_error",
    "decision_round": "decided", "done_round": "done", "correct": "final_error", "right_side": "final_error",
    "first_right": "final_error", "swarm_right": "final_error", "time_right": "final_error",
}  # fmt: skip
FARTHEST = 500.0  # widths from the middle, beyond which a logistic is 0 or 1


def scales_of(numbers: Floats, worlds: Sequence[Setting], measure: Measure, least: float) -> Floats:
    """What is usual in each world, (world, 2), of the start's trials (world, trial): a middle and a width.

    `least` is the smallest number that the measure can be. Of one that is never negative the middle is the median of
    what is above 0 and finite, and the width 0, for ratios to it count; where there is nothing of the kind it is 1, or
    of times the world's own length.
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
    """How bad a candidate's trials (world, trial) are, in [0, 1], lower being better; a NaN has failed.

    A share counts as it is. Of other measures the number v of a trial counts as v / (v + s), with the usual s of its
    world: 0 is none, 1/2 what is usual, 1 never. One that may be negative counts as the logistic of its distance from
    what is usual, in usual distances.
    """
    middle, width = scales[:, :1], scales[:, 1:]
    if measure.share:
        bad = numbers if measure.low else 1.0 - numbers
    else:
        with np.errstate(invalid="ignore", divide="ignore"):
            ratio = np.where(np.isposinf(numbers), 1.0, numbers / (numbers + middle))
            off = np.clip((numbers - middle) / np.where(width > 0, width, 1.0), -FARTHEST, FARTHEST)
        above = np.where(width > 0, 1.0 / (1.0 + np.exp(-off)), ratio)
        bad = above if measure.low else 1.0 - above
    return float(np.where(np.isnan(numbers), WORST, bad).mean())
