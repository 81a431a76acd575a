"""One trial for figures: its trace, given or replayed, with the floor of moving robots or the places on a network."""

from __future__ import annotations

from pathlib import Path
from typing import NamedTuple

import numpy as np
import xarray as xr

from swarmcensus.figures.network_places import MOST_LAID_OUT, edges_drawn, in_a_row, places_of_robots
from swarmcensus.results import Brains, as_dataset, check_held, setting_of
from swarmcensus.simulation import sampling
from swarmcensus.studies import Setting
from swarmcensus.summaries import replaying, require
from swarmcensus.support.errors import InputError
from swarmcensus.support.options import wrong_option
from swarmcensus.support.times import in_ticks, parse_time
from swarmcensus.worlds import MOVING, tiles_across

MOST_TILES = 4000  # from wall to wall; a finer floor is drawn as plain grey
FLOOR, TURNS = "arena floor", "arena turns"  # variables of a trace; no field of a brain has a space in its name


class Clock(NamedTuple):
    """The first and last tick of a trial, and the seconds of a tick if known."""

    first: int
    last: int
    seconds: float | None

    def tick(self, value: int | str, name: str) -> int:
        """Convert a tick, or a time such as "5 min", to a tick. Raises InputError, also for one outside the trial."""
        try:
            time = parse_time(value) if isinstance(value, str) else value
        except ValueError as error:
            raise InputError(f"{name} = {value!r}: {error}", key=name, value=value) from None
        try:
            tick = in_ticks(time, self.seconds, name)
        except ValueError as error:
            raise InputError(str(error), key=name, value=value) from None
        if not self.first <= tick <= self.last:
            raise wrong_option("tick", tick, f"this trial has ticks {self.first:,} to {self.last:,}")
        return tick


def is_trace(data: xr.Dataset) -> bool:
    """Whether a dataset is a trace of one trial, not results of a study."""
    return "round" in data.dims


def trace_of(results: xr.Dataset, setting: int | None = None, trial: int = 0, brain_file: Brains = ()) -> xr.Dataset:
    """Replay the estimates of a trial; `setting` is by default the first. Raises InputError as `replay` does."""
    require(results, dimensions=("setting", "trial"))
    number = int(results["setting"].values[0]) if setting is None else setting
    return replaying.estimates(results, number, trial, brain_file)


def scene_of(
    results: xr.Dataset | str | Path, setting: int | None = None, trial: int = 0, brain_file: Brains = ()
) -> xr.Dataset:
    """Return what `arena` and `film` draw of one trial: its trace with links, and its floor as two more variables.

    `FLOOR` (row, column) holds the tiles at tick 1, 1 for black, in squares of the attribute `tile_side` in metres, the
    lowest row first, centred on the arena. `TURNS` (row, column) is the tick from which a tile of a floor that changes
    has the other colour. A floor that has too many tiles for a picture is left out. Arguments are those of `replay`;
    `setting` is by default the first with moving robots, or else the first. Robots of a fixed network stand where the
    live page shows them, in a square of side 1, and all `link` are of round 0. Raises InputError.
    """
    data = as_dataset(results)
    setting, chosen = find_shown(data, setting, trial, brain_file)
    if chosen.body is None:
        trace = replaying.estimates(data, setting, trial, brain_file)
        links = sampling.links(chosen, trace.attrs["seed"], trial, 1)
        places = (places_of_robots(chosen, links) - 0.5) * (1.0, -1.0)
        trace["position"] = ("round", "robot", "axis"), np.broadcast_to(places, (*trace["estimate"].shape, 2))
        trace["link"] = ("link", "end"), np.insert(edges_drawn(links, chosen.robots), 0, 0, axis=1)
        across = 1.2 * in_a_row(chosen.robots) if chosen.robots > MOST_LAID_OUT else max(22.0, chosen.robots / 2.3)
        trace.attrs |= {"side": 1.0, "radius": 0.5 / across}
        return trace
    trace = replaying.replay(data, setting, trial, brain_file, links=True)
    trace.attrs["tick_seconds"] = chosen.body.tick
    if tiles_across(trace.attrs["side"], chosen.body.tile) <= MOST_TILES:
        ground = sampling.ground(chosen, trace.attrs["seed"], trial)
        trace[FLOOR] = ("row", "column"), ground.all_tiles()
        if chosen.change:
            trace[TURNS] = ("row", "column"), ground.turns()
    return trace


def drawn_of(results: xr.Dataset, setting: int | None, trial: int, brain_file: Brains) -> xr.Dataset:
    """A trace as it is, or the scene of results. Raises InputError as `scene_of` does."""
    return results if is_trace(results) else scene_of(results, setting, trial, brain_file)


def clock_of(results: xr.Dataset, setting: int | None, trial: int, brain_file: Brains, robot: int) -> Clock:
    """The clock of a trial, without running it again.

    Raises InputError if the setting, trial, brain or robot does not exist.
    """
    if is_trace(results):
        require(results, dimensions=("round", "robot"))
        ticks, robots = results["round"].values, results.sizes["robot"]
        clock = Clock(int(ticks[0]), int(ticks[-1]), results.attrs.get("tick_seconds"))
    else:
        _, chosen = find_shown(results, setting, trial, brain_file)
        robots, clock = chosen.robots, Clock(0, chosen.rounds, chosen.body.tick if chosen.body else None)
    check_robot(robot, robots)
    return clock


def check_robot(robot: int, robots: int) -> None:
    """Raise InputError for a robot number that does not exist."""
    if not 0 <= robot < robots:
        raise wrong_option("robot", robot, f"the robots are numbered 0 to {robots - 1}")


def find_shown(data: xr.Dataset, setting: int | None, trial: int, brain_file: Brains = ()) -> tuple[int, Setting]:
    """The number of a setting, by default the first with moving robots or else the first, and the setting.

    Raises InputError if the setting, the trial or its brain does not exist.
    """
    number = int(data["setting"].values[np.argmax(data["topology"].values == MOVING)]) if setting is None else setting
    _, chosen = setting_of(data, number, brain_file)
    check_held(data, trial=trial)
    return number, chosen
