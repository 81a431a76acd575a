"""Runs candidates on training trials, a generation at a time, and computes their losses."""

import copy
from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from swarmcensus.brains import Adversary, Brain
from swarmcensus.results import LOCAL, store
from swarmcensus.runs import Hardware, Progress, placing_of, pools, recompute
from swarmcensus.search.tuning.plans import TuningPlan
from swarmcensus.search.tuning.targets import world_with
from swarmcensus.studies import Setting
from swarmcensus.summaries import Measure, learnt_numbers

Floats = NDArray[np.float64]
FAILED_LOSS = 1.0  # of a trial that failed
MOST_WIDTHS = 500.0  # from the middle, beyond which a logistic function is 0 or 1


class Training:
    """Runs candidates in worlds."""

    def __init__(self, plan: TuningPlan, hardware: Hardware) -> None:
        """Choose where trials run. Raises InputError."""
        self.study, self.worlds, self.measures, self.trials = plan.study, plan.worlds, plan.measures, plan.trials
        self.local = any(measure.name in LOCAL for measure in self.measures)
        self.placing = placing_of(hardware, self.study, self.worlds, plan.budget * self.trials, local=self.local)

    def compile(self, show: Callable[[Progress], None]) -> None:
        """Compile what the worlds need, once: candidates differ in numbers only."""
        on_cpu = self.placing.on_cpu(self.worlds)
        pools.compile_for([(self.study, on_cpu)], lambda note: show(Progress(0, 0, 0.0, 0.0, note)))

    def run(
        self, programs: Sequence[Brain | Adversary], seed: int, show: Callable[[Progress], None]
    ) -> tuple[Floats, list[str]]:
        """The numbers of candidates on the same trials, (candidate, measure, world, trial), and why trials failed.

        NaN is a trial that failed. Raises KeyboardInterrupt after Ctrl-C.
        """
        seeded = copy.copy(self.study)
        seeded.seed = seed
        settings = [world_with(world, program) for program in programs for world in self.worlds]
        wanted = np.ones((len(settings), self.trials), np.bool_)
        placing = replace(self.placing, room=np.tile(self.placing.room, len(programs)))
        values, failures = recompute(seeded, settings, wanted, self.local, placing, show)
        data = store.dataset([seeded], settings, [""] * len(settings), values)
        numbers = np.stack([learnt_numbers(data, measure.name) for measure in self.measures])
        numbers = numbers.reshape(len(self.measures), len(programs), len(self.worlds), self.trials)
        return numbers.swapaxes(0, 1), [failure.why for failure in failures]


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
