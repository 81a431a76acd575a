"""The command `plot`: its options are checked, results are drawn, files written. Imports wait until needed."""

import argparse
from pathlib import Path
from typing import Any

from swarmcensus.basics.errors import InputError

ONLY_OF = (
    {"local": ("scatter",), "tick": ("arena",), "robot": ("arena", "film")}
    | dict.fromkeys(("setting", "trial", "brain"), ("curves", "arena", "film"))
    | dict.fromkeys(("first", "last", "every", "fps"), ("film",))
    | {"bins": ("decisions",), "delta": ("scatter", "heatmap")}
)  # options of `plot` that mean something to these kinds


def plot(options: argparse.Namespace) -> int:
    """Draw a results file."""
    from swarmcensus.figures import kinds
    from swarmcensus.figures.beliefs import beliefs
    from swarmcensus.results import replaying
    from swarmcensus.results.cautions import warn_of_edges
    from swarmcensus.results.early import opened, say_partial
    from swarmcensus.results.remeasuring import remeasure
    from swarmcensus.results.selecting import TooMuch, where
    from swarmcensus.runs.progress import compiling

    for name, fitting in ONLY_OF.items():
        given = getattr(options, name)
        if given is not None and given is not False and options.kind not in fitting:  # 0 is given too
            raise InputError(f"--{name} goes with --kind {' or '.join(fitting)}, not with {options.kind}")
    if options.local and options.delta is not None:
        raise InputError("--local does not go with --delta: the local estimate is not kept at checkpoints")
    out = options.out or Path(f"{options.results.stem}-{options.kind}{'.mp4' if options.kind == 'film' else ''}")
    if options.kind != "film":
        figure_files(out)
    every = remeasure(opened(options.results), delta=options.delta, bins=options.bins)
    say_partial(every, options.results)
    data = where(every, options.where)
    if options.setting in every["setting"].values and options.setting not in data["setting"].values:
        raise InputError(f"setting {options.setting} is not one of those that --where {options.where!r} selects")
    if options.kind in ("arena", "film"):
        return _plot_arena(options, data, out)
    try:
        if options.kind == "curves":
            setting = options.setting if options.setting is not None else int(data["setting"].values[0])
            with compiling(brain_of(data, setting)):
                figure = kinds.curves(replaying.replay(data, setting, options.trial or 0, options.brain))
        elif options.kind == "heatmap":
            figure = kinds.heatmap(data)
        elif options.kind == "beliefs":
            figure = beliefs(data)
        elif options.kind == "decisions":
            warn_of_edges(data)
            figure = kinds.decisions_grid(kinds.panels_of(data))
        else:
            figure = kinds.scatter_grid([p._replace(local=options.local) for p in kinds.panels_of(data)])
    except TooMuch as error:
        raise InputError(error.shell) from None
    save_figure(figure, out)
    return 0


def brain_of(data: Any, setting: int) -> str:
    """The name of a setting's brain, for messages; of a setting that is not there, none."""
    return "".join(data["brain"].values[data["setting"].values == setting].tolist())


def _plot_arena(options: argparse.Namespace, data: Any, out: Path) -> int:
    from rich.console import Console
    from rich.progress import Progress

    from swarmcensus.basics.files import check_writable
    from swarmcensus.figures import arena_pictures, films, scenes
    from swarmcensus.runs.progress import compiling

    # What can be told before the trial is run again, and what this machine lacks last.
    setting, found = scenes.find_moving(data, options.setting, options.trial or 0, options.brain)
    assert found.body is not None
    ticks = {n: _in_ticks(getattr(options, n), found.body.tick, f"--{n}") for n in ("tick", "first", "last")}
    given = {"every": options.every, "fps": options.fps} | ticks
    stretch = {n: given[n] for n in ("first", "last", "every", "fps") if given[n] is not None}
    shown = stretch if options.robot is None else stretch | {"robot": options.robot}
    scenes.check_robot(options.robot or 0, found.robots)
    scenes.check_tick(ticks["tick"] or 0, (0, found.rounds))
    if options.kind == "film":
        films.stretch(out, (0, found.rounds), **stretch)
        check_writable(out)
        films.ffmpeg_for(out)
    with compiling(found.brain.name):
        trace, floor = scenes.scene_of(data, setting, options.trial or 0, options.brain)
    if options.kind == "arena":
        tick = int(trace["round"][-1]) if ticks["tick"] is None else ticks["tick"]
        save_figure(arena_pictures.snapshot(trace, tick, floor, **shown), out)
        return 0
    console = Console(stderr=True)
    with Progress(console=console, transient=True, disable=not console.is_terminal) as bar:
        task = bar.add_task("drawing", total=None)
        frames = films.film(
            trace, floor, out, **shown, progress=lambda done, total: bar.update(task, completed=done, total=total)
        )
    print(f"{out}: {frames:,} frames")
    return 0


def _in_ticks(value: Any, tick: float, name: str) -> int | None:
    from swarmcensus.basics.times import in_ticks

    try:
        return None if value is None else in_ticks(value, tick, name)
    except ValueError as error:
        raise InputError(str(error)) from None


def save_figure(figure: Any, out: Path, default: tuple[str, ...] = ("png", "svg")) -> None:
    """Write a figure in the format of its suffix, without one in all of `default`, and print the paths."""
    from swarmcensus.figures import kinds

    for path in kinds.save(figure, *figure_files(out, default)):
        print(path)


def figure_files(out: Path, default: tuple[str, ...] = ("png", "svg"), *inputs: Path) -> tuple[Path, tuple[str, ...]]:
    """The name without its suffix, and the formats; raises InputError where they cannot be written."""
    from swarmcensus.basics.files import check_writable

    if not out.suffix and (out.is_dir() or out.name in ("", "..")):
        raise InputError(f"cannot write {out}: it is a folder")
    suffix = out.suffix.lower().lstrip(".")
    if suffix and suffix not in ("png", "svg", "pdf"):
        raise InputError(f"{out}: figures are written as .png, .svg or .pdf")
    stem, formats = (out.with_suffix(""), (suffix,)) if suffix else (out, default)
    for each in formats:
        check_writable(stem.with_name(f"{stem.name}.{each}"), *inputs)
    return stem, formats
