"""The command `plot`, and how figures are written. Imports wait until the command needs them."""

import argparse
import contextlib
import logging
import os
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

from swarmcensus.cli.options import (  # fmt: skip
    Command,
    Group,
    add_shared,
    assignment,
    from_zero,
    name_list,
    once,
    positive,
    round_or_time,
    width,
)

from swarmcensus.cli.output import LOG, wrote
from swarmcensus.cli.source import add_source_options, read
from swarmcensus.support.errors import BrainError, InputError, OptionError
from swarmcensus.support.formatting import counted
from swarmcensus.support.options import misplaced, option, wrong_option
from swarmcensus.support.texts import read_text

KIND_OPTIONS = (
    *("x", "y", "color", "panels", "local", "setting", "trial", "brain_file", "tick", "robot", "first", "last"),
    *("every", "fps", "theory"),
)  # options of `plot` that are passed on to the function of a kind, by the same name
DRAWN_BY = {"bins": ("decisions", "lines"), "delta": ("scatter", "heatmap", "lines")}  # shipped kinds affected by these


def add_plot_options(sub: argparse.ArgumentParser) -> None:
    """Add the options of `plot`."""
    add_source_options(sub)
    sub.add_argument(
        "--kind",
        default="scatter",
        help="what to draw: lines, decisions, heatmap, curves, arena, ... (docs/plotting.md; default: %(default)s)",
    )
    sub.add_argument("--x", metavar="NAME", help="coordinate on the x axis (lines, heatmap)")
    sub.add_argument("--y", metavar="NAME", help="variable on the y axis of lines, or coordinate on that of a heatmap")
    sub.add_argument("--color", metavar="NAME", help="coordinate shown by colour (default: accuracy)")
    sub.add_argument(
        "--panels",
        type=name_list,
        metavar="NAMES",
        help="coordinates with one panel per value, such as topology,robots",
    )
    sub.add_argument(
        "--set",
        type=assignment,
        action="append",
        default=[],
        metavar="OPTION=VALUE",
        help="any other option of the kind, such as scale=linear; may be repeated",
    )
    sub.add_argument(
        "--local", action="store_true", default=None, help="draw local instead of informed estimates (scatter)"
    )
    sub.add_argument(
        "--theory", action="store_true", default=None, help="add curves of theory (scatter, decisions, curves)"
    )
    add_shared(sub, setting="curves, arena and film; default: the first", trial="the same; default: 0")
    add_shared(sub, brain_file="the same")
    sub.add_argument(
        "--tick", type=round_or_time, help="tick of the arena, or a time such as '1 min' (default: the last)"
    )
    sub.add_argument("--robot", type=from_zero, help="robot whose radio range the arena shows (default: 0)")
    sub.add_argument("--first", type=round_or_time, help="first tick of a film, or a time (default: 1)")
    sub.add_argument("--last", type=round_or_time, help="last tick of a film, or a time (default: 600 ticks)")
    sub.add_argument("--every", type=positive, help="ticks from one frame of a film to the next (default: 2)")
    sub.add_argument("--fps", type=positive, help="frames per second of a film (default: 20)")
    page = sub.add_argument_group("page")
    page.add_argument(
        "--width", type=width, metavar="INCHES", help="width in inches, or column (3.5), double (7.2), slide (10)"
    )
    page.add_argument("--height", type=float, metavar="INCHES", help="height in inches (default: what panels need)")
    page.add_argument("--dpi", type=int, metavar="DOTS", help="dots per inch of a PNG (default: 150)")
    page.add_argument("--font-size", type=float, metavar="POINTS", help="size of ticks and keys (default: 7.5)")
    page.add_argument(
        "--style",
        metavar="NAME_OR_FILE",
        help="a matplotlib style, such as ggplot or my.mplstyle; also in matplotlibrc",
    )
    add_shared(page, "label")
    page.add_argument(
        "--out",
        type=Path,
        metavar="FILE",
        help="file to write (default: RESULTS-KIND.png and .svg, or .mp4, next to RESULTS; also .pdf, .gif)",
    )


def plot(options: argparse.Namespace) -> int:
    """Draw a figure of a results file."""
    from swarmcensus.figures.kinds import find
    from swarmcensus.results import say_partial

    draw = find(options.kind)
    given = _given(options, draw)
    suffix = Path(given.get("out") or "").suffix
    out = options.out or options.results.with_name(f"{options.results.stem}-{options.kind}{suffix}")
    if "out" in given:  # this kind writes its file itself
        given["out"] = out
    else:
        figure_files(out, is_stem=options.out is None)
    stored, data = read(options)
    say_partial(stored, options.results)
    if options.setting in stored["setting"].values and options.setting not in data["setting"].values:
        raise misplaced("setting", options.setting, f"is not one of those that --where {options.where!r} selects")
    page = {name: getattr(options, name) for name in ("width", "height", "font_size")}
    if "out" in given and options.dpi is not None:
        given["dpi"] = options.dpi
    with _styled(options.style), _failures(options.kind), _showing_progress(given, data):
        drawn = draw(data, **given, **page)
        if "out" in given:
            wrote(f"{out}: {counted(drawn, 'frame')}" if isinstance(drawn, int) else out)
        else:
            save_figure(_as_figure(drawn, options.kind), out, dpi=options.dpi, is_stem=options.out is None)
    return 0


@contextlib.contextmanager
def _styled(style: str | None) -> Iterator[None]:
    """Draw in a matplotlib style. Raises InputError if there is none of this name, and no such file."""
    if style is None:
        yield
        return
    import matplotlib.style

    from swarmcensus.support.hints import did_you_mean

    with contextlib.ExitStack() as stack:
        try:
            stack.enter_context(matplotlib.style.context(style))
        except (OSError, ValueError) as error:
            if Path(style).is_file():
                read_text(style, option("style", style), code=True)
            known = [name for name in matplotlib.style.available if not name.startswith("_")]
            what = "cannot be read" if Path(style).is_file() else "is neither a style nor a file"
            hint = did_you_mean(style, known) or f"there are {', '.join(known)}"
            raise wrong_option("style", style, f"{what}: {hint.strip()}") from error
        yield


def _given(options: argparse.Namespace, draw: Callable[..., Any]) -> dict[str, Any]:
    """The options of a kind as given, or by default. Raises InputError for options that it does not have."""
    from swarmcensus.figures.kinds import PLUGINS, find
    from swarmcensus.support.plugins import keys_of, read_keys
    from swarmcensus.support.times import Time

    with _failures(options.kind):
        known = keys_of(draw).model_fields
    given = {name: value for name in KIND_OPTIONS if (value := getattr(options, name)) not in (None, [])}
    unknown = [name for name in given if name not in known]
    fitting = {name: [k for k in PLUGINS.shipped if name in keys_of(find(k)).model_fields] for name in unknown}
    if options.kind in PLUGINS.shipped:
        remeasured = [name for name in DRAWN_BY if getattr(options, name) is not None]
        fitting |= {name: [*DRAWN_BY[name]] for name in remeasured if options.kind not in DRAWN_BY[name]}
    for name, kinds in fitting.items():
        raise OptionError(f"{option(name)} goes with --kind {' or '.join(kinds)}, not with {options.kind}", key=name)
    if options.local and options.delta is not None:
        raise misplaced("local", None, "does not go with --delta: the local estimate is not kept at checkpoints")
    given = {name: str(value) if isinstance(value, Time) else value for name, value in given.items()}
    if "brain_file" in given:  # kinds take what a study file can hold
        given["brain_file"] = [str(path) for path in given["brain_file"]]
    more = {name: _value(text) for name, text in once("set", options.set).items()}
    for name in given.keys() & more:
        raise OptionError(f"{option(name)} and --set {name}=... set the same option: give one of them", key=name)
    return dict(read_keys(f"--kind {options.kind}", draw, given | more))


def _value(text: str) -> Any:
    """A value of `--set` as TOML reads it, or else the text itself."""
    from swarmcensus.studies import read_toml

    try:
        return read_toml(f"value = {text}", "")["value"]
    except InputError:
        return text


@contextlib.contextmanager
def _failures(kind: str) -> Iterator[None]:
    """Report an error of another package's kind as one line that names the package."""
    from swarmcensus.figures.kinds import PLUGINS

    try:
        yield
    except (InputError, OSError, MemoryError):
        raise
    except Exception as error:
        if kind in PLUGINS.shipped or os.environ.get("SWARMCENSUS_DEBUG"):
            raise
        raise PLUGINS.error(kind, f"{type(error).__name__}: {error}") from error


@contextlib.contextmanager
def _showing_progress(given: dict[str, Any], data: Any) -> Iterator[None]:
    """Show what a kind that draws one trial waits for: the compiler, and the frames of a film."""
    from rich.progress import Progress

    from swarmcensus.runs import log_compilation
    from swarmcensus.support.terminal import console

    with contextlib.ExitStack() as stack:
        if "setting" in given:
            stack.enter_context(log_compilation(brain_of(data, given["setting"])))
        if "progress" in given:
            out = console(stderr=True)
            bar = stack.enter_context(
                Progress(
                    console=out,
                    transient=True,
                    disable=not (out.is_terminal and LOG.isEnabledFor(logging.INFO)),
                )
            )
            task = bar.add_task("drawing", total=None)
            given["progress"] = lambda done, total: bar.update(task, completed=done, total=total)
        yield


def _as_figure(drawn: Any, kind: str) -> Any:
    from matplotlib.figure import Figure

    if not isinstance(drawn, Figure):
        what = f"figure {kind!r} returned {type(drawn).__name__}: should be a matplotlib Figure"
        raise BrainError(what, key="figure", value=kind)
    return drawn


def brain_of(data: Any, setting: int | None = None) -> str:
    """The name of a setting's brain, or of the only brain, for messages; empty for a setting that does not exist."""
    names = data["brain"].values if setting is None else data["brain"].values[data["setting"].values == setting]
    return "the brain" if len({*names}) > 1 else "".join(names[:1].tolist())


COMMANDS = (
    Command(
        "plot", "Draw a figure of results.",
        Group.STUDIES, 7, plot, add_plot_options, json=False,
    ),
)  # fmt: skip
