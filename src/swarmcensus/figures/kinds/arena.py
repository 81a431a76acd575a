"""Where robots that move are at one tick, what they estimate, and who hears whom."""

from __future__ import annotations

from pathlib import Path

import xarray as xr

from swarmcensus.figures import scenes
from swarmcensus.figures.arena_pictures import snapshot
from swarmcensus.figures.sheets import Drawn, Own


def arena(
    results: xr.Dataset,
    *,
    setting: int | None = None,
    trial: int = 0,
    brain: str | Path | None = None,
    tick: int | str | None = None,
    robot: int = 0,
    title: str | None = None,
    ax: Own = None,
) -> Drawn:
    """Draw the arena at the end of a tick, or at a time as "5 min": by default the last. The paper's Fig. 1.

    `results` are a study's: then `setting` (by default the first whose robots move) and `trial` are replayed, with the
    file `brain` where the brain is one of your own. Or it is a trace of `sc.replay` with links: then the floor is the
    even grey of the fill ratio. Robots are discs to scale, coloured by what they estimate; lines join those that hear
    each other, a dotted circle is the radio range of `robot`, and strokes across a robot say what it no longer does.
    Axes of your own, `ax`, become square; the key stands under them.

    Raises InputError if there is no such setting, trial, tick or robot, or robots do not move.
    """
    clock = scenes.clock_of(results, setting, trial, brain, robot)
    at = clock.last if tick is None else clock.tick(tick, "tick")
    scenes.check_tick(at, (clock.first, clock.last))
    trace, floor = scenes.drawn_of(results, setting, trial, brain)
    return snapshot(trace, at, floor, robot=robot, title=title, ax=ax)
