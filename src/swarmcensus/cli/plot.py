"""The command `plot`: its options are checked, results are drawn, files written. Imports wait until needed."""

import argparse
import contextlib
import logging
import os
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

from swarmcensus.basics.errors import InputError
from swarmcensus.basics.formatting import counted
from swarmcensus.cli.options import from_zero, name_list, positive, round_or_time
from swarmcensus.cli.output import LOG, wrote
from swarmcensus.cli.source import add_source_options, read

HANDED_ON = (
    *("x", "y", "color", "panels", "local", "setting", "trial", "brain", "tick", "robot", "first", "last", "every"),
    *("fps", "theory"),
)  # flags of `plot` that are options of kinds, by the names of these
ASKED_ANEW = {"bins": ("decisions", "lines"), "delta": ("scatter", "heatmap", "lines")}  # kinds of ours that draw it


def add_plot_options(sub: argparse.ArgumentParser) -> None:
    """Of `plot`."""
    add_source_options(sub)
    sub.add_argument(
        "--kind",
        default="scatter",
        help="what to draw: lines, decisions, heatmap, curves, arena, ... (docs/plotting.md; default: %(default)s)",
    )
    sub.add_argument("--x", metavar="NAME", help="the coordinate along the x axis (lines, heatmap)")
    sub.add_argument("--y", metavar="NAME", help="the variable of lines, or the other coordinate of a heatmap")
    sub.add_argument("--color", metavar="NAME", help="the coordinate that colours tell apart (default: accuracy)")
    sub.add_argument(
        "--panels", type=name_list, metavar="NAMES", help="coordinates with a panel for each value, as topology,robots"
    )
    sub.add_argument(
        "--set",
        action="append",
        default=[],
        metavar="OPTION=VALUE",
        help="any other option of the kind, as scale=linear",
    )
    sub.add_argument("--local", action="store_true", default=None, help="the local estimate instead (scatter)")
    sub.add_argument(
        "--theory", action="store_true", default=None, help="lay theory's curves over it (scatter, decisions, curves)"
    )
    sub.add_argument("--setting", type=int, help="the setting of curves, arena or film (default: the first)")
    sub.add_argument("--trial", type=int, help="the trial of curves, arena or film (default: 0)")
    sub.add_argument("--brain", metavar="FILE", help="the brain file, where the brain is one of your own")
    sub.add_argument(
        "--tick", type=round_or_time, help="when the arena is drawn, a tick or a time as '1 min' (default: the last)"
    )
    sub.add_argument("--robot", type=from_zero, help="whose radio range the arena shows (default: 0)")
    sub.add_argument("--first", type=round_or_time, help="the tick, or time, that a film begins at (default: 1)")
    sub.add_argument("--last", type=round_or_time, help="the tick, or time, that it ends at (default: 600 ticks)")
    sub.add_argument("--every", type=positive, help="ticks from frame to frame (default: 2)")
    sub.add_argument("--fps", type=positive, help="frames a second (default: 20)")
    sub.add_argument(
        "--out", type=Path, metavar="FILE", help="default: RESULTS-KIND.png and .svg (also .pdf), or .mp4 (also .gif)"
    )


def plot(options: argparse.Namespace) -> int:
    """Draw a results file."""
    from swarmcensus.figures.kinds import find
    from swarmcensus.results.partial import say_partial

    draw = find(options.kind)
    given = _given(options, draw)
    suffix = Path(given.get("out") or "").suffix
    out = options.out or Path(f"{options.results.stem}-{options.kind}{suffix}")
    if "out" in given:  # it writes its file itself
        given["out"] = out
    else:
        figure_files(out)
    every, data = read(options)
    say_partial(every, options.results)
    if options.setting in every["setting"].values and options.setting not in data["setting"].values:
        raise InputError(f"setting {options.setting} is not one of those that --where {options.where!r} selects")
    with _failures(options.kind), _telling(given, data):
        drawn = draw(data, **given)
    if "out" in given:
        wrote(f"{out}: {counted(drawn, 'frame')}" if isinstance(drawn, int) else out)
    else:
        save_figure(_as_figure(drawn, options.kind), out)
    return 0


def _given(options: argparse.Namespace, draw: Callable[..., Any]) -> dict[str, Any]:
    """The options of a kind as they are given, or by default. Raises InputError for those that it has not."""
    from swarmcensus.basics.plugins import keys_of, read_keys
    from swarmcensus.basics.times import Time
    from swarmcensus.figures.kinds import DOOR, find

    with _failures(options.kind):
        has = keys_of(draw).model_fields
    given = {name: value for name in HANDED_ON if (value := getattr(options, name)) is not None}
    fitting = {
        name: [k for k in DOOR.shipped if name in keys_of(find(k)).model_fields] for name in given if name not in has
    }
    if options.kind in DOOR.shipped:
        asked = [name for name in ASKED_ANEW if getattr(options, name) is not None]
        fitting |= {name: [*ASKED_ANEW[name]] for name in asked if options.kind not in ASKED_ANEW[name]}
    for name, kinds in fitting.items():
        raise InputError(f"--{name} goes with --kind {' or '.join(kinds)}, not with {options.kind}")
    if options.local and options.delta is not None:
        raise InputError("--local does not go with --delta: the local estimate is not kept at checkpoints")
    given = {name: str(value) if isinstance(value, Time) else value for name, value in given.items()}
    more = dict(map(_set, options.set))
    if len(more) < len(options.set):
        raise InputError("--set gives an option twice")
    for name in given.keys() & more:
        raise InputError(f"--{name} and --set {name}=... say the same: give one of them")
    try:
        return dict(read_keys(f"--kind {options.kind}", draw, given | more))
    except ValueError as error:
        raise InputError(str(error)) from None


def _set(text: str) -> tuple[str, Any]:
    """The option and the value of `--set`: what TOML reads as a value, else the text itself."""
    import tomllib

    name, equals, value = text.partition("=")
    if not equals:
        raise InputError(f"--set {text!r}: should be such as scale=linear")
    try:
        return name.strip(), tomllib.loads(f"value = {value}")["value"]
    except tomllib.TOMLDecodeError:
        return name.strip(), value.strip()


@contextlib.contextmanager
def _failures(kind: str) -> Iterator[None]:
    """What goes wrong in drawing, in one line: of another package's kind, whose it is."""
    from swarmcensus.figures.kinds import DOOR

    try:
        yield
    except (InputError, OSError, MemoryError):
        raise
    except Exception as error:
        if kind in DOOR.shipped or os.environ.get("SWARMCENSUS_DEBUG"):
            raise
        where = DOOR.outside[kind].value
        raise InputError(f"figure {kind!r}, {where}: {type(error).__name__}: {error}") from error


@contextlib.contextmanager
def _telling(given: dict[str, Any], data: Any) -> Iterator[None]:
    """Say what a kind that draws one trial waits for: the compiler, and frame after frame."""
    from rich.console import Console
    from rich.progress import Progress

    from swarmcensus.runs.progress import compiling

    with contextlib.ExitStack() as stack:
        if "setting" in given:
            stack.enter_context(compiling(brain_of(data, given["setting"])))
        if "progress" in given:
            console = Console(stderr=True)
            bar = stack.enter_context(
                Progress(
                    console=console,
                    transient=True,
                    disable=not (console.is_terminal and LOG.isEnabledFor(logging.INFO)),
                )
            )
            task = bar.add_task("drawing", total=None)
            given["progress"] = lambda done, total: bar.update(task, completed=done, total=total)
        yield


def _as_figure(drawn: Any, kind: str) -> Any:
    from matplotlib.figure import Figure

    if not isinstance(drawn, Figure):
        raise InputError(f"figure {kind!r} returned {type(drawn).__name__}: should be a matplotlib Figure")
    return drawn


def brain_of(data: Any, setting: int | None = None) -> str:
    """The name of a setting's brain, or of the only one, for messages; of a setting that is not there, none."""
    every = data["brain"].values if setting is None else data["brain"].values[data["setting"].values == setting]
    return "the brain" if len({*every}) > 1 else "".join(every[:1].tolist())


def save_figure(figure: Any, out: Path, default: tuple[str, ...] = ("png", "svg")) -> None:
    """Write a figure in the format of its suffix, without one in all of `default`, and print the paths."""
    from swarmcensus.figures.files import save

    for path in save(figure, *figure_files(out, default)):
        wrote(path)


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
