"""The margins of an arena: colour bar, scale, key and titles."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.colors import FuncNorm, LinearSegmentedColormap, ListedColormap, Normalize, to_hex
from matplotlib.lines import Line2D
from matplotlib.markers import MarkerStyle
from matplotlib.patches import Patch
from matplotlib.text import Text

from swarmcensus.figures.page import (
    ink,
    letters,
    page,
    scale,
    title_letters,
    width_of,
    wrapped,
)
from swarmcensus.figures.styles import AWAY, halo, key_mark, shifted
from swarmcensus.support.errors import InputError

SIZE = 6.75, 6.25  # inches: at 128 and 80 dots per inch both are even numbers of dots, as films need
LEFT, BOTTOM, ARENA = 0.25, 0.5, 5.1  # inches
WHITE_TILE, BLACK_TILE = 0.9, 0.12  # grey levels
# As on the live page: blue is too low, orange too high, and the truth is pale.
OFF = ("#003c78", "#0072b2", "#78b4dc", "#e8e8e4", "#f0aa5a", "#d55e00", "#823200")
ESTIMATES = LinearSegmentedColormap.from_list("estimates", OFF)
LINEAR = 0.1  # colours differ most for estimates within this distance of the truth, the width of one of ten bins
OPINIONS = ListedColormap(["#ffffff", "#000000"])
LINK, RANGE = "#007a59", "#000000"
STROKES = {"moving": 0.0, "sensing": 45.0, "talking": 135.0}  # degrees: all strokes of a robot make a star
LINES, MORE_LINES = 2, 6  # of the title: those that always have room, and the most
LINE = 0.13  # inches: a line of the title
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


def arena_on_page(title: str) -> tuple[tuple[float, float], tuple[float, float], ArenaSize]:
    """The size of an arena's figure, the place of the arena's lower left corner, and its size, in inches.

    A figure of given width is no higher than a page or a slide. Raises InputError for a page that is too narrow or too
    low.
    """
    times, (width, height, *_), highest = scale(), page(), page().highest
    aside, around = (SIZE[0] - LEFT - ARENA) * times, SIZE[1] - ARENA
    if width is None:
        width = SIZE[0] * times if height is None else height - around * times + LEFT * times + aside
    elif height is None:
        height = highest if width - LEFT * times - aside + around * times > highest else None
    more = LINE * max(0, len(_lines(title, width - LEFT * times - 0.1)) - LINES)  # inches
    around += more
    side = width - LEFT * times - aside
    own, apart = side < WIDE_ENOUGH * times, False
    over_key = width - (LEFT + TIGHT) * times  # the side of an arena with its key under it
    if height is not None:
        over_key = min(over_key, height - (KEY_UNDER + OVER + more) * times)
    if height is not None and not own:
        side = min(side, height - around * times)
        low, left_of_key = side < WIDE_ENOUGH * times, min(side, width - (LEFT + TIGHT + COLUMN) * times)
        apart = low and left_of_key >= over_key
        own, side = low and not apart, left_of_key if apart else side
    under, top = (KEY_UNDER, OVER + more) if own else (BOTTOM, around - BOTTOM)
    side = over_key if own else side
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


def _lines(title: str, room: float) -> list[str]:
    """The title in lines of at most `room` inches."""
    return wrapped(title, 72 * room, letters(), MORE_LINES)


def _bar(arena: Axes, size: ArenaSize) -> tuple[Axes, float]:
    """The axes of the colour bar right of the arena, and its height in inches."""
    times = scale()
    foot, tall = (2.15, 2.5) if not (size.own or size.apart) else (0.0, 0.27)  # room for the key under it
    foot, tall = foot * times, size.side - tall * times
    place = (1 + 0.2 * times / size.side, foot / size.side, 0.16 * times / size.side, tall / size.side)
    axes = arena.inset_axes(place)
    axes.yaxis.tick_right()
    axes.set_xticks([])
    return axes, tall


def draw_opinions(arena: Axes, size: ArenaSize) -> tuple[ScalarMappable, Axes]:
    """Draw the colours of opinions right of the arena. Returns what `draw_colours` does."""
    colours = ScalarMappable(Normalize(0.0, 1.0), OPINIONS.with_extremes(bad=AWAY))
    axes, _ = _bar(arena, size)
    axes.imshow([[0.0], [1.0]], cmap=OPINIONS, origin="lower", aspect="auto", extent=(0.0, 1.0, 0.0, 1.0))
    axes.set_yticks([0.25, 0.75], ["white", "black"], fontsize=letters())
    axes.set_title("opinions", loc="left", fontsize=letters(), pad=max(6.0, 0.8 * letters()))
    return colours, axes


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
    colours = ScalarMappable(norm, ESTIMATES.with_extremes(bad=AWAY))
    axes, tall = _bar(arena, size)
    low, truth, high = (float(norm(x)) for x in (0.0, true_fill_ratio, 1.0))
    edges = np.linspace(low, high, 257)
    strip = colours.to_rgba(norm.inverse((edges[1:] + edges[:-1]) / 2.0))
    axes.imshow(strip[:, np.newaxis], origin="lower", aspect="auto", extent=(0.0, 1.0, low, high))
    ticks = {float(norm(x)): f"{x:g}" for x in (0.0, 0.2, 0.4, 0.6, 0.8, 1.0)}
    near = max(0.07, 1.4 * letters() / 72 / tall)
    ticks = {y: text for y, text in ticks.items() if abs(y - truth) > near * (high - low)}  # room for the truth's label
    axes.set_yticks(list(ticks), list(ticks.values()), fontsize=letters())
    axes.axhline(truth, color="black", linewidth=1.2)
    axes.annotate(
        f"true f = {true_fill_ratio:.4g}", (1.0, truth), (5, 0), textcoords="offset points", va="center",
        fontsize=letters(), fontweight="bold", annotation_clip=False,
    )  # fmt: skip
    axes.set_title("estimates\n(not linear)", loc="left", fontsize=letters(), pad=max(6.0, 0.8 * letters()))
    return colours, axes


def write_titles(arena: Axes, size: ArenaSize, title: str, counted: str, longest: str) -> tuple[Text, Text]:
    """Write the title over the arena. Returns the two texts of the headline that change.

    The second one is behind the word `counted`, and at most as long as `longest`.
    """
    large = title_letters() if size.side > WIDE_ENOUGH * scale() else letters()
    times = scale()
    lines = _lines(title, size.side + size.aside)
    y = times * (0.19 + LINE * len(lines))
    two = not size.apart and size.side <= NARROW * times  # lines of the headline

    def write(x: float, right: float, up: float, text: str, points: float = large, **more: Any) -> Text:
        # Names of studies are plain text, even with dollar signs.
        place: dict[str, Any] = {"transform": shifted(arena.transAxes, arena, 72 * right, 72 * up), "va": "baseline"}
        return arena.text(x, 1.0, text, fontsize=points, parse_math=False, **place | more)

    write(0.0, 0.0, 0.12 * times, "\n".join(lines), letters(), va="bottom")
    when = write(0.0, 0.0, y + 0.15 * times * two, "")
    if two:
        write(0.0, 0.0, y, counted)
        return when, write(0.0, (width_of(counted, large) + 0.4 * large) / 72, y, "")
    # Text is the slowest part of a film, so the text that stays is not drawn again in each frame.
    start = -0.08 * times * len(longest) * large / title_letters()
    start += (TIGHT + COLUMN) * times if size.apart else 0.0
    write(1.0, start - 0.05, y, counted, ha="right")
    return when, write(1.0, start, y, "")


def draw_scale(axes: Axes, size: ArenaSize, half: float, note: str, *, to_scale: bool) -> None:
    """Write a note under the arena, and if it is `to_scale` draw a bar of a round length; `half` is half its side."""
    length = max(m * 10.0**e for m in (1, 2, 5) for e in range(-3, 6) if m * 10.0**e <= 0.6 * half)
    y = -half * (1.0 + 2.0 * 0.14 * scale() / size.side)
    axes.text(half, y, note, ha="right", va="center", fontsize=letters())
    if not to_scale:
        return
    x = -half, -half + length
    axes.plot(x, [y, y], "|-", color=ink(), linewidth=1.2, markersize=6, clip_on=False)
    text = f"{length:g} m" if length >= 0.01 else f"{1000 * length:g} mm"
    axes.text(x[1] + 0.03 * half, y, text, va="center", fontsize=letters())


def draw_key(
    arena: Axes, size: ArenaSize, robot: int | None, stops: list[str], *, to_scale: bool, tiles: bool, liars: bool
) -> None:
    """Draw the key. The radio range of `robot` is drawn, if they move, and `stops` are the parts that fail."""
    disc = key_mark("o", 7, to_hex(ESTIMATES(0.5)), mec="black")
    reach = Line2D([], [], color=RANGE, linestyle="--", linewidth=1.6, path_effects=halo(3.2))
    heading = "" if robot is None else ", heading" + ("" if to_scale else "\n(not to scale)")
    entries: dict[str, Any] = {f"robot{heading}": disc, "radio link": Line2D([], [], color=LINK, linewidth=1.3)}
    entries |= {} if robot is None else {f"radio range of\nrobot {robot}": reach}
    if liars:
        entries["not honest"] = disc, key_mark("x", 6, "black", mew=1.6)
    for part in stops:
        mark = MarkerStyle("_").rotated(deg=STROKES[part])
        entries[f"stopped {part}"] = key_mark(mark, 13, "black", mew=1.6), disc
    for name, grey in (("black tile", BLACK_TILE), ("white tile", WHITE_TILE)) if tiles else ():
        entries[name] = Patch(facecolor=str(grey), edgecolor="0.5", linewidth=0.5)
    place: dict[str, Any] = {"loc": "lower left", "bbox_to_anchor": (1.0, 0.0), "labelspacing": 0.7}
    place["bbox_transform"] = shifted(arena.transAxes, arena, 72 * (TIGHT if size.apart else 0.14) * scale())
    if size.own:
        place |= {"loc": "upper left", "bbox_to_anchor": (0.0, 0.0), "columnspacing": 1.0}
        place["bbox_transform"] = shifted(arena.transAxes, arena, 0.0, -18.0 * scale())
        place["ncols"] = max(1, int((size.side + size.aside) / COLUMN / scale()))
    place |= {"frameon": False, "fontsize": letters(), "borderaxespad": 0, "handlelength": 1.5}
    arena.legend([*entries.values()], [*entries], **place)
