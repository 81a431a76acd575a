"""What robots' intervals come to at checkpoints: room for it as the engine's loops take it, and what is wrong in it."""

from typing import NamedTuple, Self

import numpy as np

from swarmcensus.basics.errors import InputError
from swarmcensus.brains.syntax import INTERVAL
from swarmcensus.simulation.inputs import Inputs
from swarmcensus.studies.settings import Setting

ENDS = "interval_low", "interval_high"  # of a trace, beside a brain's own fields


class Asked(NamedTuple):
    """Of some trials, or of one, without the first dimension of `sure` and `wrong`."""

    truths: np.ndarray  # (checkpoint): the fill ratios that intervals should hold
    bounds: np.ndarray  # (end, robot): room for those of a checkpoint; no robots where nobody has any
    sure: np.ndarray  # (trial, what, checkpoint): see `engine.constants`; NaN where nobody honest has any
    wrong: np.ndarray  # (trial, 4): the first that is none: the robot, below 0 for nobody, the round and both ends

    @classmethod
    def of(cls, setting: Setting, truths: np.ndarray, trials: int) -> Self:
        """Room for what a setting's robots say at checkpoints with these `truths`."""
        robots = setting.robots if any(brain.has_interval for brain in setting.crew) else 0
        return cls(truths, np.empty((2, robots)), np.full((trials, 2, truths.size), np.nan), np.full((trials, 4), -1.0))

    @property
    def alone(self) -> Self:
        """That of the first trial."""
        return self._replace(sure=self.sure[0], wrong=self.wrong[0])

    @property
    def found(self) -> np.ndarray:
        """What came of it, (what, checkpoint, trial)."""
        return self.sure.transpose(1, 2, 0)


def nobody(trials: int = 1) -> Asked:
    """Room where nobody is asked."""
    return Asked(np.empty(0), np.empty((2, 0)), np.empty((trials, 2, 0)), np.full((trials, 4), -1.0))


def check_intervals(setting: Setting, given: Inputs, asked: Asked) -> None:
    """Raise InputError where a brain gave what is no interval."""
    for trial in np.flatnonzero(asked.wrong[:, 0] >= 0.0)[:1]:
        robot, tick, low, high = asked.wrong[trial]
        brain = setting.crew[given.group[trial, int(robot)]] if given.group.size else setting.brain
        raise InputError(
            f"brain {brain.name!r} fails in trial {given.first + trial} of {setting}: after "
            f"{'tick' if setting.body else 'round'} {tick:g} interval gives ({low:g}, {high:g}): {INTERVAL}"
        )
