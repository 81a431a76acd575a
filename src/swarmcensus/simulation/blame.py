"""Whose fault a failure is: which brain fails, in which trial, at which robot and round.

`rerunning.py` finds the line of its file.
"""

import contextlib
from collections.abc import Iterator, Sequence

import numpy as np

from swarmcensus.brains import INTERVAL, Brain
from swarmcensus.engine import Inputs, Intervals, compiler
from swarmcensus.engine.constants import WRONG, WRONG_IN
from swarmcensus.studies import Setting
from swarmcensus.support.errors import BrainError
from swarmcensus.support.options import command

NO_ESTIMATE = "a number in [0, 1] is right"


class BrainFails(BrainError):
    """A brain fails in a trial, or gives what the contract does not allow."""


def failure(setting: Setting, blamed: Sequence[Brain], first: int, trials: int, what: str) -> BrainFails:
    """The error that names the brains that may have failed, and in which trials."""
    which = f"trials {first} to {first + trials - 1}" if trials > 1 else f"trial {first}"
    names = " or ".join(repr(brain.name) for brain in blamed)
    return BrainFails(f"brain {names} fails in {which} of {setting}: {what}", key="brain", value=blamed[0].name)


@contextlib.contextmanager
def blaming(setting: Setting, first: int, trials: int = 1) -> Iterator[None]:
    """Turn any error of a brain in here into a BrainFails that names it."""
    try:
        yield
    except BrainFails:
        raise
    except compiler.NotCompiled as error:
        check = command("swarmcensus", "brains", "--check", error.brain.path)
        what = f"it cannot be compiled: {check} says why"
        raise failure(setting, [error.brain], first, trials, what) from error
    except Exception as error:
        said = str(error).strip().partition("\n")[0]
        raise failure(setting, setting.brains, first, trials, f"{type(error).__name__}: {said}") from error


def check_answers(
    setting: Setting, given: Inputs, estimates: np.ndarray, verdicts: np.ndarray, intervals: Intervals,
    local: bool = False,
) -> None:  # fmt: skip
    """Raise BrainFails if a robot gave an invalid estimate, decision or interval.

    The first wrong `estimates` (trial, 3) are those of `Measures`. With `local`, they count single observations.
    """
    for trial in np.flatnonzero(estimates[:, 0] >= 0.0)[:1]:
        robot, tick, estimate = estimates[trial]
        raise _wrong(setting, given, trial, robot, tick, f"estimate gives {estimate:.9g}: {NO_ESTIMATE}", local)
    for trial, robot in np.argwhere(verdicts[..., WRONG] != -1.0)[:1] if verdicts.size else ():
        choice, tick = verdicts[trial, robot, [WRONG, WRONG_IN]]
        options = next(brain.options for brain in setting.brains if brain.decides)  # of all the same
        right = f"-1 (undecided) or an option from 0 to {options - 1} is right"
        raise _wrong(setting, given, trial, robot, tick, f"decide gives {choice:g}: {right}")
    for trial in np.flatnonzero(intervals.wrong[:, 0] >= 0.0)[:1]:
        robot, tick, low, high = intervals.wrong[trial]
        raise _wrong(setting, given, trial, robot, tick, f"interval gives ({low:g}, {high:g}): {INTERVAL}")


def check_commands(setting: Setting, given: Inputs, commands: np.ndarray) -> None:
    """Raise BrainFails if a robot steered by what is no number; `commands` (3, robot) are as the engine left them."""
    for robot in np.flatnonzero(~(np.abs(commands[1:]) < 1e300).all(axis=0))[:1]:
        tick, speed, turn = commands[:, robot]
        right = "two finite numbers, a speed and a turn, or None are right"
        raise _wrong(setting, given, 0, robot, tick, f"steer gives ({speed:g}, {turn:g}): {right}")


def _wrong(
    setting: Setting, given: Inputs, trial: int, robot: float, tick: float, what: str, local: bool = False
) -> BrainFails:
    """The error that names the brain of a robot in the `trial`-th trial of a batch, and after which round it was."""
    i = int(robot)
    brain = setting.brains[given.group[trial, i]] if given.group.size else setting.brain
    when = f"after {'observation' if local else 'tick' if setting.body else 'round'} {tick:.0f}"
    return failure(setting, [brain], given.first + int(trial), 1, f"robot {i}, {when}: {what}")
