"""The scene of one trial of robots that move: what arenas and films draw."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from swarmcensus.basics.errors import InputError
from swarmcensus.results.origins import setting_of
from swarmcensus.results.replaying import replay
from swarmcensus.results.store import load
from swarmcensus.studies.settings import Setting
from swarmcensus.worlds.arena import tiles_across
from swarmcensus.worlds.networks import MOVING

MOST_TILES = 4000  # from wall to wall; beyond it a floor is even grey


def scene_of(
    results: xr.Dataset | str | Path, setting: int | None = None, trial: int = 0, brain: str | Path | None = None
) -> tuple[xr.Dataset, NDArray[np.uint8] | None]:
    """Return what `snapshot` and `film` draw of one trial: its trace with links, and its floor.

    Takes what `replay` takes; `setting` is by default the first whose robots move. The floor is None where it
    has too many tiles for a picture. Raises InputError, also if the setting's robots do not move.
    """
    data = results if isinstance(results, xr.Dataset) else load(results)
    setting, found = find_moving(data, setting, trial, brain)
    assert found.body is not None
    trace = replay(data, setting, trial, brain, links=True)
    trace.attrs["tick_seconds"] = found.body.tick
    drawn = tiles_across(trace.attrs["side"], found.body.tile) <= MOST_TILES
    return trace, found.ground(trace.attrs["seed"], trial).all_tiles() if drawn else None


def check_tick(tick: int, known: tuple[int, int]) -> None:
    """Raise InputError for a tick that a trial with those from known[0] to known[1] lacks."""
    if not known[0] <= tick <= known[1]:
        raise InputError(f"tick {tick}: this trial has ticks {known[0]} to {known[1]}")


def check_robot(robot: int, robots: int) -> None:
    """Raise InputError for a robot that is not there."""
    if not 0 <= robot < robots:
        raise InputError(f"robot {robot}: the robots are numbered 0 to {robots - 1}")


def find_moving(
    data: xr.Dataset, setting: int | None, trial: int, brain: str | Path | None = None
) -> tuple[int, Setting]:
    """The number of a setting whose robots move, by default the first, and the setting.

    Raises InputError where it, the trial or its brain is not there, or its robots do not move.
    """
    moving = data["setting"].values[data["topology"].values == MOVING]
    if not moving.size:
        raise InputError('no robots move in these results: arenas and films need topology = "moving"')
    number = int(moving[0]) if setting is None else setting
    if number in data["setting"].values and number not in moving:
        several = ", ".join(map(str, moving[:8])) + (", ..." if moving.size > 8 else "")
        raise InputError(f"setting {number} is a fixed network, without an arena; those of moving robots: {several}")
    _, found = setting_of(data, number, brain)
    trials = data["trial"].values
    if trial not in trials:
        raise InputError(f"trial {trial}: these results hold trial {trials.min()} to {trials.max()}")
    return number, found
