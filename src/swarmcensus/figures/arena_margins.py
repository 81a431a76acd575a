"""The margins of an arena: colour bar, scale, key and titles."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.colors import FuncNorm, LinearSegmentedColormap
from matplotlib.lines import Line2D
from matplotlib.markers import MarkerStyle
from matplotlib.patches import Patch
from matplotlib.text import Text
from matplotlib.transforms import ScaledTranslation, Transform

from swarmcensus.figures.lettering import wrapped
from swarmcensus.figures.looks import LIES
from swarmcensus.figures.page import ink, letters, page, scale, title_letters
from swarmcensus.support.errors import InputError

SIZE = 6.75, 6.25  # inches: at 128 and 80 dots per inch both are even numbers of dots, as films need
LEFT, BOTTOM, ARENA = 0.25, 0.5, 5.1  # inches
WHITE_TILE, BLACK_TILE = 0.9, 0.12  # grey levels
# As on the live page: blue is too low, orange too high, and the truth is pale.
OFF = ("#003c78", "#0072b2", "#78b4dc", "#e8e8e4", "#f0aa5a", "#d55e00", "#823200")
ESTIMATES = LinearSegmentedColormap.from_list("estimates", OFF)
LINEAR = 0.1  # colours differ most for estimates within this distance of the truth, the width of one of ten bins
LINK, RANGE = "#007a59", "#d40000"
STROKES = {"moving": 0.0, "sensing": 45.0, "talking": 135.0}  # degrees: all strokes of a robot make a star
LINES = 2  # of the title
WIDE_ENOUGH = 4.0  # inches: the headline of a narrower arena has smaller letters
NARROW = 2.8  # inches: the headline of a narrower arena takes two lines
COLUMN = 1.25  # inches: a column of the key under an arena


KEY_UNDER = 1.0  # inches: scale and key under an arena, if the key is there
NARROWEST = 1.2  # inches: the smallest arena
TIGHT = 1.25  # inches: the colour bar next to an arena with its key under it
OVER = 0.85  # inches: the titles over an arena


class ArenaSize(NamedTuple):
    """The side of an arena in inches, and whether its key is under it: in the caller's axes and on narrow pages.

    `aside` are the inches to its right that titles and key may take. On low pages the key is `apart`, right of the
    colour bar and not under it.
    """

    side: float = ARENA
    own: bool = False
    aside: float = 0.0
    apart: bool = False


def arena_on_page() -> tuple[tuple[float, float], tuple[float, float], ArenaSize]:
    """The size of an arena's figure, the place of the arena's lower left corner, and its size, in inches.

    Raises InputError for a page that is too narrow or too low.
    """
    times, (width, height, *_) = scale(), page()
    aside, around = (SIZE[0] - LEFT - ARENA) * times, SIZE[1] - ARENA
    if width is None:
        width = SIZE[0] * times if height is None else height - around * times + LEFT * times + aside
    side = width - LEFT * times - aside
    own, apart = side < WIDE_ENOUGH * times, False
    if height is not None and not own:
        side = min(side, height - around * times)
        low = side < WIDE_ENOUGH * times
        apart = low and width - LEFT * times - side >= (TIGHT + COLUMN) * times
        own = low and not apart
    under, top = (KEY_UNDER, OVER) if own else (BOTTOM, around - BOTTOM)
    if own:
        side = width - (LEFT + TIGHT) * times
        side = side if height is None else min(side, height - (under + top) * times)
    if side < NARROWEST * times:
        wide, high = ((NARROWEST + more) * times for more in (LEFT + TIGHT, under + top))
        least = f"{wide:.1f} inches of width at least, and {high:.1f} of height"
        raise InputError(f"an arena with its key needs {least}", key="width" if height is None else "height")
    high = side + (under + top) * times
    return (
        (width, high if height is None else height),
        (LEFT * times, high - top * times - side),
        ArenaSize(side, own, width - LEFT * times - side - 0.1, apart),
    )


def size_in(axes: Axes) -> ArenaSize:
    """The size of an arena in the caller's axes, which are square."""
    axes.apply_aspect()
    return ArenaSize(axes.bbox.width / axes.figure.dpi, own=True)


def _moved(axes: Axes, right: float, up: float) -> Transform:
    """Coordinates of the axes, moved by inches. They stay right if the axes change their size before drawing."""
    moved: Transform = axes.transAxes + ScaledTranslation(right, up, axes.figure.dpi_scale_trans)
    return moved


def draw_colours(arena: Axes, size: ArenaSize, true_fill_ratio: float) -> tuple[ScalarMappable, Axes]:
    """Draw the colour bar right of the arena. Returns the mapping from estimates to colours, and the bar's axes."""
    far = max(true_fill_ratio, 1.0 - true_fill_ratio)
    most = np.arcsinh(far / LINEAR)
    # Symmetric about the truth: equal errors above and below it are equally far from its colour.
    norm = FuncNorm(
        (
            lambda x: np.arcsinh((np.asarray(x) - true_fill_ratio) / LINEAR) / most,
            lambda y: true_fill_ratio + LINEAR * np.sinh(np.asarray(y) * most),
        ),
        vmin=true_fill_ratio - far,
        vmax=true_fill_ratio + far,
    )
    colours = ScalarMappable(norm, ESTIMATES.with_extremes(bad=LIES))
    times = scale()
    foot, tall = (2.15, 2.5) if not (size.own or size.apart) else (0.0, 0.27)  # room for the key under it
    foot, tall = foot * times, size.side - tall * times
    axes = arena.inset_axes((1 + 0.2 * times / size.side, foot / size.side, 0.16 * times / size.side, tall / size.side))
    low, truth, high = (float(norm(x)) for x in (0.0, true_fill_ratio, 1.0))
    edges = np.linspace(low, high, 257)
    strip = colours.to_rgba(norm.inverse((edges[1:] + edges[:-1]) / 2.0))
    axes.imshow(strip[:, np.newaxis], origin="lower", aspect="auto", extent=(0.0, 1.0, low, high))
    ticks = {float(norm(x)): f"{x:g}" for x in (0.0, 0.2, 0.4, 0.6, 0.8, 1.0)}
    near = max(0.07, 1.4 * letters() / 72 / tall)
    ticks = {
        y: text for y, text in ticks.items() if abs(y - truth) > near * (high - low)
    }  # room for the label of the truth
    axes.yaxis.tick_right()
    axes.set_xticks([])
    axes.set_yticks(list(ticks), list(ticks.values()), fontsize=letters())
    axes.axhline(truth, color="black", linewidth=1.2)
    axes.annotate(
        f"true f = {true_fill_ratio:.4g}", (1.0, truth), (5, 0), textcoords="offset points", va="center",
        fontsize=letters(), fontweight="bold", annotation_clip=False,
    )  # fmt: skip
    axes.set_title("estimates\n(not linear)", loc="left", fontsize=letters(), pad=max(6.0, 0.8 * letters()))
    return colours, axes


def write_titles(arena: Axes, size: ArenaSize, title: str, robots: int) -> tuple[Text, Text]:
    """Write the title over the arena, in at most two lines. Returns the two texts of the headline that change."""
    large = title_letters() if size.side > WIDE_ENOUGH * scale() else letters()
    times = scale()
    lines = wrapped(title, 72 * (size.side + size.aside), letters(), LINES)
    y = times * (0.19 + 0.13 * len(lines))
    over = y if size.apart or size.side > NARROW * times else y + 0.15 * times  # the headline takes two lines

    def write(x: float, right: float, up: float, text: str, points: float = large, **more: Any) -> Text:
        # Names of studies are plain text, even with dollar signs.
        place: dict[str, Any] = {"transform": _moved(arena, right, up), "va": "baseline"}
        return arena.text(x, 1.0, text, fontsize=points, parse_math=False, **place | more)

    write(0.0, 0.0, 0.12 * times, "\n".join(lines), letters(), va="bottom")
    when = write(0.0, 0.0, over, "")
    # Text is the slowest part of a film, so the text that stays is not drawn again in each frame.
    start = -0.08 * times * len(f"{robots:,} of {robots:,}") * large / title_letters()
    start += (TIGHT + COLUMN) * times if size.apart else 0.0
    write(1.0, start - 0.05, y, "robots in the right bin:", ha="right")
    return when, write(1.0, start, y, "")


def draw_scale(axes: Axes, size: ArenaSize, half: float, note: str) -> None:
    """Draw a scale bar of a round length and write a note under the arena; `half` is half its side in metres."""
    length = max(m * 10.0**e for m in (1, 2, 5) for e in range(-3, 6) if m * 10.0**e <= 0.6 * half)
    y = -half * (1.0 + 2.0 * 0.14 * scale() / size.side)
    x = -half, -half + length
    axes.plot(x, [y, y], "|-", color=ink(), linewidth=1.2, markersize=6, clip_on=False)
    axes.text(
        x[1] + 0.03 * half, y, f"{length:g} m" if length >= 0.01 else f"{1000 * length:g} mm", va="center",
        fontsize=letters(),
    )  # fmt: skip
    axes.text(half, y, note, ha="right", va="center", fontsize=letters())


def draw_key(
    arena: Axes, size: ArenaSize, robot: int, stops: list[str], *, to_scale: bool, tiles: bool, liars: bool
) -> None:
    """Draw the key. The radio range of `robot` is drawn, and `stops` are the parts that fail."""
    disc = Line2D([], [], linestyle="", marker="o", markersize=7, color=ESTIMATES(0.5), markeredgecolor="black")
    entries: dict[str, Any] = {
        "robot, heading" + ("" if to_scale else "\n(not to scale)"): disc,
        "radio link": Line2D([], [], color=LINK, linewidth=1.3),
        f"radio range of\nrobot {robot}": Line2D([], [], color=RANGE, linestyle="--", linewidth=1.6),
    }
    if liars:
        entries["not honest"] = Line2D(
            [], [], linestyle="", marker="o", markersize=7, color=ESTIMATES(0.5), markeredgecolor=LIES,
            markeredgewidth=2,
        )  # fmt: skip
    for part in stops:
        mark = MarkerStyle("_").rotated(deg=STROKES[part])
        stroke = Line2D([], [], linestyle="", marker=mark, markersize=13, markeredgewidth=1.6, color="black")
        entries[f"stopped {part}"] = stroke, disc
    if tiles:
        entries["black tile"] = Patch(facecolor=str(BLACK_TILE), edgecolor="0.5", linewidth=0.5)
        entries["white tile"] = Patch(facecolor=str(WHITE_TILE), edgecolor="0.5", linewidth=0.5)
    place: dict[str, Any] = {"loc": "lower left", "bbox_to_anchor": (1.0, 0.0), "labelspacing": 0.7}
    place["bbox_transform"] = _moved(arena, (TIGHT if size.apart else 0.14) * scale(), 0.0)
    if size.own:
        place |= {
            "loc": "upper left",
            "bbox_to_anchor": (0.0, 0.0),
            "bbox_transform": _moved(arena, 0.0, -0.25 * scale()),
        }
        place |= {"ncols": max(1, int((size.side + size.aside) / COLUMN / scale())), "columnspacing": 1.0}
    arena.legend(
        list(entries.values()),
        list(entries),
        frameon=False,
        fontsize=letters(),
        borderaxespad=0,
        handlelength=1.5,
        **place,
    )
