"""Robots that move, as a film."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import xarray as xr

from swarmcensus.basics.errors import InputError
from swarmcensus.basics.files import check_writable
from swarmcensus.figures import films, scenes
from swarmcensus.figures.sheets import Own


def film(
    results: xr.Dataset,
    *,
    out: str | Path = "film.mp4",
    setting: int | None = None,
    trial: int = 0,
    brain: str | Path | None = None,
    first: int | str = 1,
    last: int | str | None = None,
    every: int = 2,
    fps: int = 20,
    robot: int = 0,
    title: str | None = None,
    progress: Callable[[int, int], None] | None = None,
    ax: Own = None,
) -> Any:
    """Write a film of ticks first, first + every, ... up to `last` (default: 600 ticks, or all there are).

    `out` ends in .mp4 (H.264, 864 x 800; needs imageio-ffmpeg) or .gif (540 x 500, few colours; at most 1,000 frames).
    `first` and `last` may be times, as "5 min"; `fps` are frames a second, which a GIF counts in hundredths of a
    second. All else is as in `arena`. `progress` is called with the frames done and their number after each. The file
    appears whole or not at all, in place of an older one. Returns the number of frames.

    With axes of your own, `ax`, no file is written: the film is returned as a matplotlib `FuncAnimation` of their
    figure, which a notebook shows by `HTML(film.to_jshtml())`; keep it as long as it should run.

    Raises InputError as `arena` does, for a stretch or speed that cannot be, another suffix, a missing imageio-ffmpeg,
    and where the file cannot be written: all before a trial is run again.
    """
    if ax is not None and out != "film.mp4":
        raise InputError(f"film: with ax no file is written: leave out={out} out, or ax")
    films.suffix_of(out)
    clock = scenes.clock_of(results, setting, trial, brain, robot)
    begin, end = clock.tick(first, "first"), None if last is None else clock.tick(last, "last")
    films.stretch(out, (clock.first, clock.last), first=begin, last=end, every=every, fps=fps)
    if ax is None:
        check_writable(Path(out))
        films.ffmpeg_for(out)
    trace, floor = scenes.drawn_of(results, setting, trial, brain)
    if ax is not None:
        return films.animation(
            trace, floor, ax, first=begin, last=end, every=every, fps=fps, robot=robot, title=title, progress=progress
        )
    return films.film(
        trace, floor, out, first=begin, last=end, every=every, fps=fps, robot=robot, title=title, progress=progress
    )
