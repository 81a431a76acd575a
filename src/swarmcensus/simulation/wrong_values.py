"""Answers that the contract does not allow: each is an error that names the brain, the robot and the round."""

import numpy as np

from swarmcensus.brains import INTERVAL
from swarmcensus.engine import Inputs, Intervals
from swarmcensus.engine.constants import WRONG, WRONG_IN
from swarmcensus.studies import Setting
from swarmcensus.support.errors import InputError

NO_ESTIMATE = "a number in [0, 1] is right"


class WrongAnswer(InputError):
    """A brain gives what the contract does not allow."""


def refuse(
    setting: Setting, given: Inputs, trial: int, robot: float, tick: float, what: str, local: bool = False
) -> WrongAnswer:
    """The error that names the brain of a robot in the `trial`-th trial of a batch, and after which round it was."""
    i = int(robot)
    brain = setting.brains[given.group[trial, i]] if given.group.size else setting.brain
    when = f"after {'observation' if local else 'tick' if setting.body else 'round'} {tick:.0f}"
    return WrongAnswer(
        f"brain {brain.name!r} fails in trial {given.first + trial} of {setting}: robot {i}, {when}: {what}"
    )


def check_estimates(setting: Setting, given: Inputs, wrong: np.ndarray, local: bool = False) -> None:
    """Raise WrongAnswer if a robot estimated what is no fill ratio; `wrong` (trial, 3) is that of `Measures`.

    With `local`, it counts single observations.
    """
    for trial in np.flatnonzero(wrong[:, 0] >= 0.0)[:1]:
        robot, tick, estimate = wrong[trial]
        raise refuse(setting, given, trial, robot, tick, f"estimate gives {estimate:.9g}: {NO_ESTIMATE}", local)


def check_verdicts(setting: Setting, given: Inputs, verdicts: np.ndarray) -> None:
    """Raise WrongAnswer if a robot decided for an option that does not exist."""
    wrong = np.argwhere(verdicts[..., WRONG] != -1.0) if verdicts.size else ()
    for trial, robot in wrong[:1]:
        choice, tick = verdicts[trial, robot, [WRONG, WRONG_IN]]
        options = next(brain.options for brain in setting.brains if brain.decides)  # of all the same
        right = f"-1 (undecided) or an option from 0 to {options - 1} is right"
        raise refuse(setting, given, trial, robot, tick, f"decide gives {choice:g}: {right}")


def check_intervals(setting: Setting, given: Inputs, intervals: Intervals) -> None:
    """Raise WrongAnswer if a robot returned an invalid interval."""
    for trial in np.flatnonzero(intervals.wrong[:, 0] >= 0.0)[:1]:
        robot, tick, low, high = intervals.wrong[trial]
        raise refuse(setting, given, trial, robot, tick, f"interval gives ({low:g}, {high:g}): {INTERVAL}")


def check_commands(setting: Setting, given: Inputs, commands: np.ndarray) -> None:
    """Raise WrongAnswer if a robot steered by what is no number; `commands` (3, robot) are as the engine left them."""
    for robot in np.flatnonzero(~(np.abs(commands[1:]) < 1e300).all(axis=0))[:1]:
        tick, speed, turn = commands[:, robot]
        right = "two finite numbers, a speed and a turn, or None are right"
        raise refuse(setting, given, 0, robot, tick, f"steer gives ({speed:g}, {turn:g}): {right}")
