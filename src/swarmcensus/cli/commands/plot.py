"""The command `plot`. Imports wait until the command needs them."""

import contextlib
import os
from collections.abc import Callable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Annotated, Any

from cyclopts import Parameter

from swarmcensus.cli.figures_out import figure_files
from swarmcensus.cli.messages import progress_bar
from swarmcensus.cli.parameters import (  # fmt: skip
    ASSIGNMENTS,
    COUNT,
    FILE,
    NAME,
    NUMBER,
    WHEN,
    WHOLE,
    BrainFiles,
    Labels,
    Results,
    Where,
    known,
    once,
    toml_value,
)
from swarmcensus.cli.source import read
from swarmcensus.support.answers import Answer
from swarmcensus.support.errors import BrainError, InputError, OptionError
from swarmcensus.support.formatting import counted
from swarmcensus.support.options import option, option_conflict, wrong_option

OF_KINDS = ("x", "y", "color", "local", "setting", "trial", "tick", "robot", "first", "last", "every", "fps", "theory")
OF_LOGS = ("lines", "scatter")  # of searches
OF_TRACES = ("curves", "arena", "film")


def plot(
    results: Results, /, *,
    kind: Annotated[str, Parameter(metavar="KIND"), known("figures.kinds")] = "scatter",
    where: Where = None,
    x: Annotated[str | None, NAME] = None, y: Annotated[str | None, NAME] = None,
    color: Annotated[str | None, NAME] = None, rows: Annotated[str | None, Parameter(metavar="NAMES")] = None,
    cols: Annotated[str | None, Parameter(metavar="NAMES")] = None,
    option: Annotated[Sequence[tuple[str, str]], ASSIGNMENTS] = (), local: bool = False, theory: bool = False,
    setting: Annotated[int | None, WHOLE] = None, trial: Annotated[int | None, WHOLE] = None,
    brain_file: BrainFiles = (), tick: Annotated[Any, WHEN] = None, robot: Annotated[int | None, WHOLE] = None,
    first: Annotated[Any, WHEN] = None, last: Annotated[Any, WHEN] = None,
    every: Annotated[int | None, COUNT] = None, fps: Annotated[int | None, COUNT] = None,
    width: Annotated[float | str | None, Parameter(metavar="INCHES")] = None,
    height: Annotated[float | None, NUMBER] = None, dpi: Annotated[int | None, COUNT] = None,
    font_size: Annotated[float | None, NUMBER] = None,
    style: Annotated[str | None, Parameter(metavar="NAME_OR_FILE")] = None, label: Labels = (),
    out: Annotated[Path | None, FILE] = None,
) -> Answer:  # fmt: skip
    """Draw a figure of results, or of one trial in robots' logs.

    Args:
        results: a results file, as 'run' writes it; or a folder of robots' logs (curves)
        kind: what to draw: lines, heatmap, compare, curves, arena, ... (docs/plotting.md; default: scatter)
        x: coordinate on the x axis (lines, scatter, heatmap)
        y: variable on the y axis (lines, scatter), or coordinate on that of a heatmap
        color: coordinate shown by colour (default: accuracy)
        rows: coordinates with a row of panels per value, such as topology,robots (default: what varies)
        cols: coordinates with a column of panels per value (as many as fit the width, then further rows)
        option: any other option of the kind, such as scale=linear; may be repeated
        local: draw local instead of informed estimates (scatter)
        theory: add curves of theory (scatter, curves, lines of checkpoints and beliefs)
        setting: number of the setting, as 'show' prints it (curves, arena and film; default: the first)
        trial: number of the trial, from 0 (the same; default: 0)
        tick: tick of the arena, or a time such as '1 min' (default: the last)
        robot: robot whose radio range the arena shows (default: 0)
        first: first tick of a film, or a time (default: 1)
        last: last tick of a film, or a time (default: 600 ticks)
        every: ticks from one frame of a film to the next (default: 2)
        fps: frames per second of a film (default: 20)
        width: width in inches, or column (3.5), double (7.2), slide (10)
        height: height in inches (default: what panels need, on numbered pages of 9 inches)
        dpi: dots per inch of a PNG (default: 150)
        font_size: size of ticks and keys in points (default: 7.5)
        style: a matplotlib style, such as ggplot or my.mplstyle; also in matplotlibrc
        out: file to write (default: RESULTS-KIND.png and .svg, or .mp4, next to RESULTS; also .pdf, .gif)
    """
    asked = dict(locals())
    from matplotlib.figure import Figure

    from swarmcensus.figures import caption_file, save
    from swarmcensus.figures.kinds import find
    from swarmcensus.results import say_partial
    from swarmcensus.runs import log_compilation
    from swarmcensus.support.quantities import SEARCHED

    draw = find(kind)
    of_kind = {
        name: value for name, value in asked.items() if name in OF_KINDS and value is not None and value is not False
    }
    for name, names in (("rows", rows), ("cols", cols)):
        if names is not None:
            of_kind[name] = [one.strip() for one in names.split(",") if one.strip()]
    if brain_file:
        of_kind["brain_file"] = [*map(str, brain_file)]
    given = _options_of_kind(kind, draw, of_kind, once("option", option))
    file = out or results.with_name(f"{results.stem}-{kind}{Path(given.get('out') or '').suffix}")
    if writes_itself := "out" in given:
        given |= {"out": file} | ({} if dpi is None else {"dpi": dpi})
    paths = (file, ()) if writes_itself else figure_files(file, is_stem=out is None)
    if results.is_dir():  # robots' logs
        from swarmcensus.robots import trace_in

        others = {"where": where, "label": label or None, "setting": setting}
        if kind not in OF_TRACES:
            raise option_conflict("kind", kind, f"draws results: of robots' logs, {', '.join(OF_TRACES)} draw a trial")
        for name in (name for name, value in {**others, "trial": trial}.items() if value is not None):
            raise option_conflict(name, None, f"is for results: {results} is a folder of logs, of one trial")
        stored = data = trace_in(results)
    else:
        stored, data = read(results, where, label, logs=True)
        say_partial(stored, results)
    if SEARCHED in stored.attrs and kind not in OF_LOGS:
        raise option_conflict(
            "kind", kind, f"draws trials: of the log of a search, {' and '.join(OF_LOGS)} draw candidates"
        )
    if setting is not None and setting in stored["setting"].values and setting not in data["setting"].values:
        raise option_conflict("setting", setting, f"is not one of those that --where {where!r} selects")
    with contextlib.ExitStack() as stack:
        stack.enter_context(_styled(style))
        stack.enter_context(_failures(kind))
        if "setting" in given and not results.is_dir():
            stack.enter_context(log_compilation(brain_of(data, given["setting"])))
        if "progress" in given:
            given["progress"] = stack.enter_context(progress_bar("drawing"))
        drawn = draw(data, **given, width=width, height=height, font_size=font_size)
        if writes_itself:
            captions = {path: "" for path in [caption_file(file)] if path.is_file()}
            return Answer(files={file: counted(drawn, "frame") if isinstance(drawn, int) else ""} | captions)
        if not isinstance(drawn, Figure):
            what = f"figure {kind!r} returned {type(drawn).__name__}: should be a matplotlib Figure"
            raise BrainError(what, key="figure", value=kind)
        return Answer(files=dict.fromkeys(save(drawn, *paths, dpi=dpi), ""))


@contextlib.contextmanager
def _styled(style: str | None) -> Iterator[None]:
    """Draw in a matplotlib style. Raises InputError if there is none of this name, and no such file."""
    import matplotlib.style

    with matplotlib.rc_context():
        try:
            matplotlib.style.use([] if style is None else style)
        except (OSError, ValueError) as error:
            there = f"there are {', '.join(matplotlib.style.available)}"
            raise wrong_option("style", style, f"is neither a style nor a file of one: {there}") from error
        yield


def _options_of_kind(
    kind: str, draw: Callable[..., Any], of_kind: Mapping[str, Any], more: Mapping[str, str]
) -> dict[str, Any]:
    """The options of a kind as given, or by default. Raises InputError for options that it does not have."""
    from swarmcensus.support.plugins import read_keys
    from swarmcensus.support.times import Time

    given = {name: str(value) if isinstance(value, Time) else value for name, value in of_kind.items()}
    for name in given.keys() & more:
        raise OptionError(f"{option(name)} and --option {name}=... set the same option: give one of them", key=name)
    with _failures(kind):
        return dict(read_keys(f"--kind {kind}", draw, given | {name: toml_value(text) for name, text in more.items()}))


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


def brain_of(data: Any, setting: int | None = None) -> str:
    """The name of a setting's brain, or of the only brain, for messages; empty for a setting that does not exist."""
    names = data["brain"].values if setting is None else data["brain"].values[data["setting"].values == setting]
    return "the brain" if len({*names}) > 1 else "".join(names[:1].tolist())
