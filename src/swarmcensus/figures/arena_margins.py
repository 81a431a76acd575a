"""What stands around an arena: colour bar, scale, headline, and the entries of its key."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.colors import FuncNorm, LinearSegmentedColormap, ListedColormap, Normalize, to_hex
from matplotlib.lines import Line2D
from matplotlib.markers import MarkerStyle
from matplotlib.patches import Patch
from matplotlib.text import Text
from matplotlib.ticker import FuncFormatter

from swarmcensus.figures.axes import tick
from swarmcensus.figures.page import caption_letters, ink, letters, scale, width_of
from swarmcensus.figures.styles import AWAY, halo, key_mark, shifted

WHITE_TILE, BLACK_TILE = 0.9, 0.12  # grey levels
# As on the live page: blue is too low, orange too high, and the truth is pale.
OFF = ("#003c78", "#0072b2", "#78b4dc", "#e8e8e4", "#f0aa5a", "#d55e00", "#823200")
ESTIMATES = LinearSegmentedColormap.from_list("estimates", OFF)
LINEAR = 0.1  # colours differ most for estimates within this distance of the truth, the width of one of ten bins
OPINIONS = ListedColormap(["#ffffff", "#000000"])
LINK, RANGE = "#007a59", "#000000"
STROKES = {"moving": 0.0, "sensing": 45.0, "talking": 135.0}  # degrees: all strokes of a robot make a star
BAR = (1.04, 0.0, 0.03, 1.0)  # place of the colour bar, as shares of the arena's side
UNDER = 10.0  # points: the scale, under the arena


def _bar(arena: Axes, name: str, colours: Any, low: float, high: float) -> Axes:
    """The axes of a colour bar right of the arena, with these colours from the lowest to the highest."""
    axes = arena.inset_axes(BAR)
    axes.yaxis.tick_right()
    axes.set_xticks([])
    axes.imshow(colours[:, np.newaxis], origin="lower", aspect="auto", extent=(0.0, 1.0, low, high))
    axes.set_xlabel(name, loc="left", fontsize=letters(), labelpad=letters())
    axes.tick_params(labelsize=letters())
    return axes


def draw_opinions(arena: Axes) -> tuple[ScalarMappable, Axes]:
    """Draw the colours of opinions right of the arena. Returns what `draw_colours` does."""
    colours = ScalarMappable(Normalize(0.0, 1.0), OPINIONS.with_extremes(bad=AWAY))
    axes = _bar(arena, "opinions", colours.to_rgba(np.array([0.0, 1.0])), 0.0, 1.0)
    axes.set_yticks([0.25, 0.75], ["white", "black"])
    return colours, axes


def draw_colours(arena: Axes, true_fill_ratio: float) -> tuple[ScalarMappable, Axes]:
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
    low, truth, high = (float(norm(x)) for x in (0.0, true_fill_ratio, 1.0))
    edges = np.linspace(low, high, 257)
    strip = colours.to_rgba(norm.inverse((edges[1:] + edges[:-1]) / 2.0))
    axes = _bar(arena, "estimates\n(not linear)", strip, low, high)
    names = {truth: f"true f = {true_fill_ratio:.4g}"}
    names = names | {float(norm(x)): f"{x:g}" for x in (0.0, 1.0, 0.2, 0.4, 0.6, 0.8)} | names
    tick(axes, "y", [*names], names.__getitem__)
    axes.yaxis.set_major_formatter(FuncFormatter(lambda value, _: names.get(float(value), "")))
    axes.axhline(truth, color="black", linewidth=1.2)
    return colours, axes


def write_headline(arena: Axes, counted: str, longest: str) -> tuple[Text, Text]:
    """Write two lines over the arena. Returns their texts that change.

    The second one is behind the word `counted`, and at most as long as `longest`.
    """
    size = caption_letters()

    def write(right: float, up: float, text: str) -> Text:
        place = shifted(arena.transAxes, arena, right, up)
        return arena.text(0.0, 1.0, text, transform=place, va="baseline", fontsize=size, parse_math=False)

    # text is the slowest part of a film, so the text that stays is not drawn again in each frame
    write(0.0, 0.5 * size, counted)
    return write(0.0, 1.8 * size, "tick"), write(width_of(counted, size) + 0.8 * size, 0.5 * size, longest)


def draw_scale(axes: Axes, half: float) -> None:
    """Draw a bar of a round length under the arena; `half` is half its side."""
    length = max(m * 10.0**e for m in (1, 2, 5) for e in range(-3, 6) if m * 10.0**e <= 0.6 * half)
    under = shifted(axes.get_xaxis_transform(), axes, 0.0, -UNDER * scale())
    x = -half, -half + length
    axes.plot(x, [0, 0], "|-", color=ink(), linewidth=1.2, markersize=6, clip_on=False, transform=under)
    text = f"{length:g} m" if length >= 0.01 else f"{1000 * length:g} mm"
    axes.text(x[1] + 0.03 * half, 0, text, transform=under, va="center", fontsize=letters())


def key_entries(robot: int | None, stops: list[str], *, to_scale: bool, tiles: bool, liars: bool) -> dict[str, Any]:
    """The entries of the key: with `robot`, its radio range; `stops` are the parts that fail."""
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
    return entries
