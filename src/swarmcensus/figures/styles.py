"""The look of each value of a coordinate: name, colour and marker, the same in every figure."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import Any, NamedTuple

import matplotlib as mpl
import numpy as np
import xarray as xr
from matplotlib import patheffects
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.colors import to_hex
from matplotlib.legend import Legend
from matplotlib.legend_handler import HandlerBase
from matplotlib.lines import Line2D
from matplotlib.patches import Rectangle
from matplotlib.transforms import ScaledTranslation, Transform
from numpy.typing import ArrayLike, NDArray

from swarmcensus.brains.library import TITLES
from swarmcensus.figures.brain_colours import LINES, MARKERS, NAMED, marks_of_brains
from swarmcensus.figures.page import letters, scale
from swarmcensus.studies import title_of
from swarmcensus.summaries import labels_in, renamed_contender, titles_in
from swarmcensus.support.formatting import distinct_texts
from swarmcensus.support.intervals import Floats

AWAY = "#cc79a7"  # colour of robots without an estimate
SPREAD = ("#000000", "#d55e00", "#cc79a7")  # colours of spread accuracies; none is in the palette
MOST_KEYED = 5  # numbers with dots in a key
LINE = 1.15  # from line to line of a text, as a multiple of the font size
OFF = "error="  # prefix of assumed accuracies that are wrong by a number
NUMBER = rf"({OFF})?[-+]?(\d+(\.\d+)?|\.\d+)(e[-+]?\d+)?"
TWO_SIDED: Any = "-"  # the line of an interval
ONE_SIDED: Any = (0, (5, 1.5, 1, 1.5))  # the line of an interval with a lower end only: of a share of all trials
SIGN, STACKED = 9.0, 3  # the height of a sign of infinity, and the most of one x upon each other
ONE_END = "so a lower end only, which counts trials, not robots"  # its text in a key


class Look(NamedTuple):
    """The look of one value: its name in the key, a short name for labels of numbers, colour, marker and line.

    `spread` is an accuracy that differs between robots, or between black and white.
    """

    name: str
    short: str
    colour: str
    marker: Any  # of matplotlib
    line: Any = "-"  # of matplotlib
    spread: bool = False


def palette(count: int) -> list[str]:
    """Return `count` colours for ordered values, dark to light, as #rrggbb.

    The palette is perceptually uniform with rising luminance, so the order survives colour blindness and grey print.
    Both ends are cut off: black marks the first spread accuracy, and the palest colours are lost on white paper.
    """
    return [to_hex(colour) for colour in mpl.colormaps["viridis"](np.linspace(0.06, 0.9, count))]


def looks_of(
    values: Iterable[str], marker: str, of: str = "accuracy", titles: Mapping[str, str] = TITLES
) -> dict[str, Look]:
    """Return the look of every distinct value of a coordinate, in drawing order: numbers from the lowest, then others.

    Numbers share `marker` and have colours by rank, the lowest darkest. The first accuracy that is not a number (spread
    over the swarm, or different for black and white) is black, as in the paper; further ones differ in colour and
    shape. Names of topologies and the like differ in colour and shape too, in the order in which they come; those of
    brains are of `marks_of_brains`. `titles` are names of brains, with or without parameters
    behind them.
    """
    distinct = list(dict.fromkeys(values))
    numbers = sorted((text for text in distinct if re.fullmatch(NUMBER, text)), key=number_of)
    others = [text for text in distinct if text not in numbers]
    if of.endswith("accuracy"):
        others.sort()
    names = dict(zip([*numbers, *others], map(_grouped, distinct_texts([*numbers, *others])), strict=True))
    if of == "brain":
        names = {text: renamed_contender(name, titles) for text, name in names.items()}
    looks = {
        text: Look(names[text], names[text].removeprefix(OFF).removeprefix("0") or "0", colour, marker)
        for text, colour in zip(numbers, palette(len(numbers)), strict=True)
    }
    if of == "brain":
        marks = marks_of_brains(others)
        return looks | {text: Look(names[text], "", *marks[text]) for text in others}
    for i, text in enumerate(others):
        shape = f"{marker}{MARKERS}"[i % 8]
        if not of.endswith("accuracy"):
            looks[text] = Look(names[text], "", NAMED[i % len(NAMED)], shape, LINES[i // len(NAMED) % len(LINES)])
            continue
        name = re.sub(r",\s*", ", ", names[text].replace("black=", "b = ").replace(" white=", ", w = "))
        short = "b≠w" if "w = " in name else "drifts" if " drift=" in name else name.split("(")[0]
        name = re.sub(r" drift=(\S+) (least|most)=", r", \1 a round to ", name)
        looks[text] = Look(name, short, SPREAD[i % 3], shape, spread=True)
    return looks


def looks_of_contenders(
    contenders: Sequence[str], factor: Sequence[str], results: Sequence[xr.Dataset]
) -> dict[str, Look]:
    """The look of every level of a factor in results, by its name there, in which labels stand for brains."""
    brains = {label: name for each in results for name, label in labels_in(each).items()}
    names = {contender: renamed_contender(contender, brains) for contender in contenders}
    of = "brain" if "brain" in factor or not factor else factor[0]
    looks = looks_of(names.values(), "o", of, titles_in(*results))
    return {contender: looks[name] for contender, name in names.items()}


def number_of(text: str) -> float:
    """A value of a coordinate that matches NUMBER."""
    return float(text.removeprefix(OFF))


def _grouped(text: str) -> str:
    return f"{int(text):,}" if text.isdigit() else text


class Strip(Line2D):
    """Colours from top to bottom in a key, as high as the lines of its label."""

    def __init__(self, colours: Sequence[str], lines: Sequence[str]) -> None:
        """The first line is at the middle of the first colour, and the last line at that of the last one."""
        super().__init__([], [], label="\n".join(lines))
        self.colours, self.lines, self.longest = colours, len(lines), max(lines, key=len)


class StripHandler(HandlerBase):
    """Draws a strip in a legend."""

    def create_artists(self, legend: Any, orig_handle: Any, *place: Any) -> list[Artist]:  # type: ignore[override]
        """A rectangle for each colour."""
        xdescent, ydescent, width, height, fontsize, trans = place
        high, count = LINE * fontsize * (orig_handle.lines - 1), len(orig_handle.colours)
        each = high / (count - 1)
        top = (height - ydescent + high + each) / 2
        style: dict[str, Any] = {"transform": trans, "linewidth": 0, "antialiased": False}
        return [
            Rectangle((-xdescent, top - (k + 1) * each), width, each, facecolor=colour, **style)
            for k, colour in enumerate(orig_handle.colours)
        ]


Legend.update_default_handler_map({Strip: StripHandler()})


def key_of(
    looks: Mapping[str, Look], of: str, dot: Callable[[Look], Artist], *, named: bool = False
) -> tuple[str, dict[str, Artist]]:
    """A key's title and entries: dots, and a strip of colours for more than 5 numbers.

    If numbers are `named` in the figure, the key leaves them out.
    """
    numbers = [look for text, look in looks.items() if re.fullmatch(NUMBER, text)][::-1]
    strip: dict[str, Artist] = {}
    if len(numbers) > MOST_KEYED and not named:
        last = max((3, 4, 5), key=lambda n: sum(k * (len(numbers) - 1) % n == 0 for k in range(n)))
        places = [divmod(k * (len(numbers) - 1), last) for k in range(last + 1)]
        lines = ["" if between else numbers[place].name for place, between in places]
        strip = {max(lines, key=len): Strip([look.colour for look in numbers], lines)}
    dots = {look.name: dot(look) for look in looks.values() if look not in numbers or not (named or strip)}
    entries = strip | dots
    return title_of(of) * bool(entries), entries


def key_mark(marker: Any, size: float = 10.0, colour: str = "0.3", **style: Any) -> Line2D:
    """Return a marker without data, for keys."""
    return Line2D([], [], linestyle="", marker=marker, markersize=size, color=colour, **style)


def outlined_dot(look: Look, size: float, edge: float, *, hollow: float = 0.0, inside: str = "white") -> Line2D:
    """Return a marker of this look without data, with a black outline of `edge` points.

    A hollow one shows its colour as an outline only, of `hollow` points, around what is `inside`.
    """
    face, outline = (inside, look.colour) if hollow else (look.colour, "black")
    return key_mark(look.marker, size, mfc=face, mec=outline, mew=hollow or edge)


def median_dot(look: Look, size: float, edge: float) -> Line2D:
    """Return the marker of a median among many dots: a ring for a spread accuracy, so that it hides no others."""
    return outlined_dot(look, size, edge, hollow=2 * edge * look.spread, inside="none")


def add_dots(axes: Axes, dot: Line2D, x: ArrayLike, y: ArrayLike, **style: Any) -> None:
    """Draw such a marker at these places."""
    dot.set(xdata=x, ydata=y, **style)
    dot.set_in_layout(bool(np.size(x)))  # layouts must skip an artist without data
    axes.add_line(dot)


def draw_intervals(
    axes: Axes, x: Floats, low: Floats, high: Floats, whole: NDArray[np.bool_], name: str, **style: Any
) -> None:
    """Draw intervals as vertical lines, with `name` in their labels; those of `whole` shares have a lower end only."""
    for those, dashes, kind in ((~whole, TWO_SIDED, "interval"), (whole, ONE_SIDED, "one-sided")):
        if those.any():
            axes.vlines(x[those], low[those], high[those], linestyles=dashes, label=f"{kind} {name}", **style)


def shifted(base: Transform, axes: Axes, right: float, up: float = 0.0) -> Transform:
    """Coordinates that are moved by points."""
    moved: Transform = base + ScaledTranslation(right / 72, up / 72, axes.figure.dpi_scale_trans)
    return moved


def endless_mark(colour: str = "0.3", **style: Any) -> Line2D:
    """The sign of an infinite value."""
    return key_mark(r"$\infty$", 8.0, colour, mew=0.4, **style)


def add_endless(axes: Axes, signs: Mapping[float, Sequence[Look]]) -> None:
    """Draw the signs of infinite values at the top, in columns around their x.

    Those that do not fit there, or that share a colour, are one sign under their number.
    """
    top, points = axes.get_xaxis_transform(), 72 / axes.figure.dpi
    places = {x: points * (top.transform((x, 1.0))[0] - axes.bbox.x0) for x in signs}
    for x, looks in signs.items():
        columns, place = -(-len(looks) // STACKED), places[x]
        apart = (abs(place - other) for at, other in places.items() if at != x)
        wide = min(2 * place, 2 * (points * axes.bbox.width - place), *apart)
        counted = (columns > 1 and scale() * SIGN * columns > wide) or len({one.colour for one in looks}) < len(looks)
        for k, look in enumerate([Look(f"{len(looks)}", "", "0.3", "")] if counted else looks):
            aside, down = (0.0, 1) if counted else (k // STACKED - (columns - 1) / 2, k % STACKED)
            edge = shifted(top, axes, scale() * SIGN * aside, -scale() * (5.0 + SIGN * down))
            sign = endless_mark(look.colour, transform=edge, clip_on=False)
            add_dots(axes, sign, [x], [1.0], label=f"infinite {look.name}", zorder=4)
        if counted:
            above: dict[str, Any] = {"transform": shifted(top, axes, 0.0, -5.0 * scale()), "fontsize": letters()}
            axes.text(x, 1.0, f"{len(looks)} ×", ha="center", va="center", path_effects=halo(1.5), zorder=4, **above)


def endless_high(most: int, axes: Axes) -> float:
    """The share of a panel's height that so many signs of infinite values at one x need."""
    return 0.06 + scale() * SIGN * min(most, STACKED) * axes.figure.dpi / 72 / axes.bbox.height


def halo(width: float) -> list[patheffects.AbstractPathEffect]:
    """Return a white rim of `width` points, which keeps text legible on top of dense dots."""
    return [patheffects.withStroke(linewidth=width, foreground="white")]
