"""Simulates missions: the share of right robots at many times of one run, with its interval over trials."""

import warnings
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from swarmcensus.brains import Adversary, Brain
from swarmcensus.runs import Hardware, Progress, run
from swarmcensus.search.planning.mission import Mission
from swarmcensus.simulation import NO_ESTIMATE, sampling
from swarmcensus.studies import Setting, Study
from swarmcensus.summaries import failed_trials
from swarmcensus.support.errors import InputError
from swarmcensus.support.intervals import LEVEL, Estimate, Floats, estimate, expected_share

STEPS, FEWEST_STEPS = 100, 30  # times at which shares are computed
LARGE_SWARM = 200  # robots from which on there are fewer times, to save memory
Show = Callable[[Progress], None]


class Case(NamedTuple):
    """A fill ratio, and what liars do; None if nobody lies."""

    fill_ratio: float
    lie: Adversary | None = None


@dataclass(frozen=True)
class Curve:
    """The shares of right robots, (time, trial), with one brain in one case."""

    brain: str
    case: Case
    rounds: list[int]
    shares: Floats

    def at(self, k: int, level: float = LEVEL) -> Estimate:
        """The share at the k-th time, with its interval of this level."""
        return estimate(self.shares[k][:, np.newaxis], "mean", share=True, level=level)

    def expected(self, k: int) -> float:
        """The share to expect in other trials at the k-th time, if these trials were used to choose the time."""
        return expected_share(self.shares[k])


def study_of(
    mission: Mission, robots: int, brains: Sequence[Brain], cases: Sequence[Case], times: Sequence[int], trials: int,
    seed: int,
) -> Study:  # fmt: skip
    """The study that measures the share of right robots at these times, in every case. Raises InputError."""
    fill_ratios, lies = (list(dict.fromkeys(each)) for each in zip(*cases, strict=True))
    values = {
        "swarm.robots": robots, "swarm.brain": list(brains), "swarm.accuracy": mission.accuracy,
        "world.fill_ratio": fill_ratios, "measure.estimates": True, "measure.checkpoints": list(times),
        "schedule.ticks" if mission.moves else "schedule.rounds": times[-1], "seed": seed, "trials": trials,
    }  # fmt: skip
    tables = dict(mission.tables)
    if mission.study.members:
        several = [dict(table) for table in tables["members"]]
        if mission.liars is not None:
            several[mission.liars]["brain"] = lies
        counts = [member.count(robots) for member in mission.setting.members]
        tables["members"] = [table for table, count in zip(several, counts, strict=True) if count]  # of few, none is
    del tables["wanted"]
    context = {"base": mission.base or Path(), "kept": True}  # a short run may end before a fault
    return Study.changed(tables, values, where=mission.study.name, context=context)


def curves(mission: Mission, study: Study, hardware: Hardware, show: Show) -> list[Curve]:
    """Run a study: a curve for each brain and case. Raises InputError.

    If robots lie, numbers may diverge to infinity; in such a trial nobody is right.
    """
    data, measured = _data_of(study, mission.has_liars, hardware, show), []
    for number, setting in enumerate(study.settings()):
        if data is None:
            right = np.zeros((len(study.checkpoints), study.trials, setting.honest), np.bool_)
        else:
            truths = np.full(study.trials, setting.fill_ratio)
            if mission.on_floor:
                truths = data["true_fill_ratio"].values[number]
            right = mission.goal.right(data["estimates"].values[number], truths)
        only_working = setting.faults and mission.wanted.who == "working"
        shares = _of_working(setting, study.seed, right) if only_working else np.asarray(right.mean(axis=2))
        lie = next((member.brain for member in setting.members if isinstance(member.brain, Adversary)), None)
        for each in mission.lies if lie is None and mission.lies else [lie]:  # among few robots nobody lies
            measured.append(Curve(setting.brain.label, Case(setting.fill_ratio, each), study.checkpoints, shares))
    return measured


def _data_of(study: Study, has_liars: bool, hardware: Hardware, show: Show) -> xr.Dataset | None:
    """Run a study in which numbers may diverge among liars; such trials are missing. None if all are such."""
    with warnings.catch_warnings():
        warnings.filterwarnings("ignore", ".*failed", UserWarning)
        try:
            data = run(study, progress=show, cautions=False, **vars(hardware))
        except InputError as error:
            if has_liars and NO_ESTIMATE in str(error):
                return None
            raise
    for failure in failed_trials(data):
        if not has_liars or NO_ESTIMATE not in failure["why"]:
            raise InputError(f"some trials of the plan failed: {failure['why'][:200]}")
    return data


def _of_working(setting: Setting, seed: int, right: NDArray[np.bool_]) -> Floats:
    """The share of right robots among honest ones that still observe, (time, trial)."""
    works = np.array([sampling.working(setting, seed, trial) for trial in range(right.shape[1])])
    return np.asarray((right & works).sum(axis=2) / np.maximum(works.sum(axis=1), 1))  # where none works, none is right


def times_until(first: float, last: int, robots: int) -> list[int]:
    """Rounds at equal ratios from `first` to `last`, fewer in large swarms."""
    begin, steps = min(max(first, 1.0), last), min(STEPS, max(FEWEST_STEPS, STEPS * LARGE_SWARM // robots))
    return [*np.unique(np.geomspace(begin, last, steps).round().astype(int)).tolist()]
