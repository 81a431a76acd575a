"""The layout that all figures share: panels, captions, axes and key."""

from __future__ import annotations

import re
import string
from collections.abc import Callable, Iterable, Sequence
from typing import Any, Literal, NamedTuple

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.legend import Legend
from matplotlib.ticker import FixedLocator, FuncFormatter, MaxNLocator, NullFormatter, NullLocator
from matplotlib.transforms import ScaledTranslation

from swarmcensus.figures.lettering import SPACING, width_of, wrapped
from swarmcensus.figures.page import KEY_BELOW, RENDERING, SHEET, caption_letters, letters, page, scale, title_letters
from swarmcensus.figures.panels import MOST_PANELS
from swarmcensus.support.errors import InputError
from swarmcensus.support.options import wrong_option

Scale = Literal["log", "log-y", "linear"]  # both axes are logarithmic, only the y axis, neither
Own = Axes | Sequence[Axes] | None  # the caller's axes, one per panel; None: a new figure

HALF_A_DECADE = 10**0.5
# Inches, with letters of the usual size:
LEFT = 0.65  # the room for the y axis and its name
KEY = 1.6  # the room for a key on the right
EDGE = 0.15  # the room on the right if the key is below
GAP = 0.42  # from panel to panel
SMALL = 0.7  # share of the usual size of letters that a key on the right has at least
LEAST = 1.75  # the width of a panel that a page of given width may have
NARROWEST = 0.8  # the same if there is a single column
INNER = "inner"  # label of a panel with a left neighbour, which has the name of the y axis
POOLED = "select some of the settings, draw all into one with panels=[]"  # advice on how to get fewer panels
UNRUN = "no trial has been run"
NOTHING = "nothing to draw: no trial of these settings has been run"


class Layout(NamedTuple):
    """Columns and rows of panels, the size of a panel and margins in inches, and whether the key is below."""

    columns: int
    rows: int
    wide: float
    high: float
    left: float
    right: float
    key_below: bool


def layout(
    count: int, *, size: tuple[float, float] | None = None, left: float | None = None, key: bool = True
) -> Layout:
    """The layout of equal panels. All lengths are in inches.

    `size` is a panel's width and height (the default depends on the number of panels), `left` the margin there, and
    `key` tells whether there is one.
    On a page of given width, panels have the width that is left for them: there are fewer columns, and the key is
    below, if they would be too narrow. Raises InputError for no panel, for more than 24, and for a page too narrow.
    """
    if not 1 <= count <= MOST_PANELS:
        raise InputError(f"a figure holds 1 to {MOST_PANELS} panels, not {count}")
    columns = count if count <= 3 else {4: 2, 5: 3, 6: 3, 9: 3}.get(count, 4)
    usual = (4.4, 3.2) if count == 1 else (3.1, 2.4) if columns <= 3 else (2.5, 1.9)
    times, width = scale(), page().width
    wide, high = (size or usual) if size else (times * usual[0], times * usual[1])
    left, right = times * LEFT if left is None else left, times * (KEY if key else EDGE)
    below = False
    if width is not None:
        fits = [
            (columns, (width - left - margin - (columns - 1) * times * GAP) / columns, margin)
            for columns in range(columns, 0, -1)
            for margin in ((right, times * EDGE) if key else (right,))
        ]
        columns, wide, right = next((fit for fit in fits if fit[1] >= times * LEAST), fits[-1])
        if wide < times * NARROWEST:
            needed = width + times * NARROWEST - wide
            raise wrong_option("width", width, f"this figure needs {needed + 0.05:.1f} inches at least")
        below = key and right < times * KEY
        high = size[1] if size else wide * usual[1] / usual[0]
    return Layout(columns, -(-count // columns), wide, page().high or high, left, right, below)


def sheet(
    ax: Own,
    captions: Sequence[str],
    title: str | None,
    *,
    size: tuple[float, float] | None = None,
    left: float | None = None,
    key: bool = True,
    above: float = 0.0,
    below: float = 0.0,
    fewer: str = "select some of the settings",
) -> list[Axes]:
    """Return equal panels with these captions: the caller's own axes, or a new figure with room for a key.

    Lengths are those of `layout`. `above` and `below` are extra inches over and under each panel. Captions take as many
    lines as they need. A title is the caption of the caller's single axes, and stands over the figure of several.
    Raises InputError as `layout` does, and if there are not as many axes as panels; the message says how to get `fewer`
    panels.
    """
    if ax is not None:
        own = own_axes(ax, len(captions), fewer)
        if title and len(own) > 1:
            own[0].figure.suptitle(title, fontsize=title_letters(), parse_math=False)
        caption_panels(own, [title] if title and len(own) == 1 else captions, above)
        return own
    columns, rows, wide, high, left, right, key_below = layout(len(captions), size=size, left=left, key=key)
    count, times = len(captions), scale()
    # Margins and gaps are in inches, as text takes the same room for any number of panels.
    gap_x, line = times * GAP, SPACING / 72
    room = wide + (gap_x - 0.06 if columns > 1 else right - 0.1)
    lines = [max(1, len(text.splitlines())) for text in _lettered(captions, room)]
    over = [above + line * caption_letters() * (max(lines[k : k + columns]) - 1) for k in range(0, count, columns)]
    width = left + columns * wide + (columns - 1) * gap_x + right
    titles = wrapped(title or "", 72 * (width - left - 0.1), title_letters(), 3)
    captioned = any(captions[:columns]) or above > 0  # captions of heatmaps come later, above
    top = (0.35 if captioned or titles else 0.12) * times + over[0] + line * title_letters() * len(titles)
    top += 0.1 if titles else 0.0
    bottom, gaps = 0.55 * times + below, [0.72 * times + below + more for more in over[1:]]
    height = bottom + rows * high + sum(gaps) + top
    figure = Figure(figsize=(width, height))
    FigureCanvasAgg(figure)
    figure.set_gid(KEY_BELOW if key_below else SHEET)
    grid = figure.add_gridspec(  # every second row is a gap
        2 * rows - 1, columns, left=left / width, right=1 - right / width, bottom=bottom / height,
        top=1 - top / height, wspace=gap_x / wide, hspace=0.0,
        height_ratios=[high, *(each for gap in gaps for each in (gap, high))],
    )  # fmt: skip
    if titles:
        figure.suptitle(
            "\n".join(titles), x=left / width, y=1 - 0.1 / height, ha="left", va="top", fontsize=title_letters(),
            parse_math=False,
        )  # fmt: skip
    axes = [
        figure.add_subplot(grid[2 * (i // columns), i % columns], label=INNER if i % columns else "")
        for i in range(count)
    ]
    caption_panels(axes, captions, above, room)
    return axes


def own_axes(ax: Axes | Sequence[Axes], panels: int, fewer: str) -> list[Axes]:
    """The caller's axes as a list. Raises InputError if there is not one for each panel."""
    own: list[Axes] = np.ravel(np.asarray(ax, object)).tolist()
    if strange := next((type(each).__name__ for each in own if not hasattr(each, "get_figure")), None):
        raise InputError.at("ax", strange, "should be matplotlib Axes, or a list of them")
    if len(own) != panels and panels == 1:
        raise InputError(f"ax has {len(own)} axes, but this is one panel: give one of them", key="ax")
    if len(own) != panels:
        holds = "ax holds one panel" if len(own) == 1 else f"ax has {len(own)} axes"
        raise InputError(f"{holds}, not {panels}: {fewer}, or give a list of {panels} axes", key="ax")
    return own


def figure_of(axes: Sequence[Axes]) -> Figure:
    """The figure that these axes are on, which a kind of figure returns: a new one, or the caller's."""
    return axes[0].figure.canvas.figure


def show_range(axes: Axes, which: Literal["x", "y"], low: float, high: float) -> None:
    """Set the limits of an axis, no narrower than other axes that share it need."""
    shared = axes.get_shared_x_axes() if which == "x" else axes.get_shared_y_axes()
    if any(sibling is not axes and sibling.has_data() for sibling in shared.get_siblings(axes)):
        least, most = axes.get_xlim() if which == "x" else axes.get_ylim()
        low, high = min(low, least), max(high, most)
    axes.set(**{f"{which}lim": (low, high)})


def caption_panels(
    axes: Sequence[Axes], captions: Sequence[str], above: float = 0.0, room: float | None = None, *, math: bool = False
) -> None:
    """Write (a), (b), ... and the captions over the panels; a single panel gets no letter.

    Captions begin `above` inches over the panels and are at most `room` inches wide, by default as wide as a panel.
    With `math`, text between dollar signs is a formula.
    """
    if room is None:
        room = axes[0].bbox.width / axes[0].figure.dpi
    for ax, text in zip(axes, _lettered(captions, np.inf if math else room), strict=True):
        ax.set_title(text, loc="left", fontsize=caption_letters(), pad=6 + 72 * above, parse_math=math)


def _lettered(captions: Sequence[str], room: float) -> list[str]:
    letters = [""] if len(captions) == 1 else [f"({letter}) " for letter in string.ascii_lowercase]
    pairs = zip(letters, captions, strict=False)
    return ["\n".join(wrapped(letter + caption, 72 * room, caption_letters())) for letter, caption in pairs]


def name_axes(axes: Axes, x: str, y: str) -> None:
    """Write the axis labels, and hide the top and right spines.

    `y` is written in the leftmost column only. Names of axes that panels share are written once.
    """
    place = axes.get_subplotspec()
    shares_axis = place and not place.is_first_col() and axes.get_shared_y_axes().get_siblings(axes)[1:]
    above = place and not place.is_last_row() and axes.get_shared_x_axes().get_siblings(axes)[1:]
    if not above:
        wide = axes.bbox.width / axes.figure.dpi
        axes.set_xlabel(name_in_lines(x, wide) if figure_is_ours(axes) else x, fontsize=letters() + 1)
    if axes.get_label() != INNER and not shares_axis:
        axes.set_ylabel(y, fontsize=letters() + 1)
    axes.tick_params(labelsize=letters())
    axes.spines[["top", "right"]].set_visible(False)


def figure_is_ours(axes: Axes) -> bool:
    """Whether axes are on a sheet that was made here, and not on the caller's figure."""
    return axes.figure.canvas.figure.get_gid() in (SHEET, KEY_BELOW)


def name_in_lines(name: str, wide: float) -> str:
    """The name of an x axis under a panel of `wide` inches, with its unit on a second line if it is wider."""
    plain = re.sub(r"[$\\{},]", "", name)  # a formula is no wider than its letters
    too_wide = "\n" not in plain and width_of(plain, letters() + 1) > 72 * wide + 20
    return name.replace(" (", "\n(", 1) if too_wide else name


def second_line(names: Iterable[str], wide: float) -> float:
    """The inches that a second line of these names takes under panels of `wide` inches; 0 if there is none."""
    return SPACING * (letters() + 1) / 72 * any("\n" in name_in_lines(name, wide) for name in names)


def say_empty(axes: Axes, why: str = UNRUN) -> None:
    """Write into an empty panel of the caller why it is empty."""
    axes.text(0.5, 0.5, why, ha="center", transform=axes.transAxes, fontsize=letters() + 1)
    axes.set_axis_off()


def add_key(axes: Sequence[Axes], title: str, entries: dict[str, Artist], *, below: bool = False) -> None:
    """Put one key for all panels to the right of the first row, or `below` all panels, where it hides no data.

    Long names are wrapped. On the right, letters get a little smaller if many lines are to fit; a longer key is below.
    """
    figure: Any = axes[0].figure.canvas.figure
    if figure_is_ours(axes[0]) and any("\n" in ax.get_xlabel() for ax in axes):
        make_room(figure, max(0.0, 0.03 - _lowest(axes)))
    if not entries:
        return
    if below or figure.get_gid() == KEY_BELOW:
        _key_below(axes, title, entries)
        return
    places = [ax.get_subplotspec() for ax in axes]
    last = [ax for ax, place in zip(axes, places, strict=True) if place and place.is_last_col()]
    corner = last[0] if last else axes[-1]
    points = 72 / corner.figure.dpi
    wide = (corner.figure.bbox.width - corner.bbox.x0 - 1.02 * corner.bbox.width) * points - 3 * letters()
    names, heading = _wrapped_names(entries, max(wide, 60.0)), title
    title = _wrapped_title(title, max(wide, 60.0) + 2 * letters())
    lines = sum(1 + name.count("\n") for name in (title, *names))
    room = corner.bbox.y1 * points - 15  # from the panel's top to the paper's end
    if room / lines / 1.6 < SMALL * letters() and figure_is_ours(corner):
        grid = corner.get_gridspec()
        if grid is not None and grid.ncols == 1:  # the margin for the key stays empty
            grid.update(right=1 - scale() * EDGE / figure.get_figwidth())
        _key_below(axes, heading, entries)
        return
    legend = corner.legend(
        list(entries.values()), names, title=title, loc="upper left", bbox_to_anchor=(1.02, 1.01),
        borderaxespad=0, frameon=False, title_fontsize=letters(), alignment="left", handlelength=1.2,
        fontsize=float(np.clip(room / lines / 1.6, 3.0, letters())),
    )  # fmt: skip
    for text in legend.get_texts():
        text.set_parse_math(False)


def _wrapped_names(entries: Iterable[str], wide: float) -> list[str]:
    return ["\n".join("\n".join(wrapped(line, wide, letters())) for line in name.split("\n")) for name in entries]


def _wrapped_title(title: str, wide: float) -> str:
    """The title of a key in lines, as it is if it holds a formula."""
    return title if "$" in title.replace(r"\$", "") else _wrapped_names([title], wide)[0]


def _key_below(axes: Sequence[Axes], title: str, entries: dict[str, Artist]) -> None:
    """Put the key under the lowest panels, short names side by side, and make the figure higher by as much."""
    figure: Any = axes[0].figure.canvas.figure
    lowest, width, handle = axes[-1], 72 * figure.get_figwidth() - 12, 3.0 * letters()
    shown = {name.replace("\n", " "): artist for name, artist in entries.items()}
    short = {name for name in shown if width_of(name, letters()) + handle <= (width - letters()) / 2}
    heading = _wrapped_title(title.replace("\n", " "), width)
    across = 6 / 72 - lowest.bbox.x0 / figure.dpi
    foot = _lowest(axes)
    down = foot - 0.08 * scale() - lowest.bbox.y0 / figure.dpi  # from the panel, past the names of axes
    added = 0.0
    for group in ([name for name in shown if name in short], [name for name in shown if name not in short]):
        if not group:
            continue
        names = _wrapped_names(group, width - handle)
        widest = max(width_of(line, letters()) for name in names for line in name.split("\n"))
        place = lowest.transAxes + ScaledTranslation(across, down - added, figure.dpi_scale_trans)
        columns = max(1, min(len(names), int((width + letters()) / (widest + handle + letters()))))
        legend = Legend(
            lowest, [shown[name] for name in group], names, title=heading or None, loc="upper left",
            bbox_to_anchor=(0, 0), bbox_transform=place, borderaxespad=0, frameon=False, title_fontsize=letters(),
            alignment="left", handlelength=1.2, fontsize=letters(), columnspacing=1.0, ncols=columns,
        )  # fmt: skip
        lowest.add_artist(legend)
        legend.set_clip_on(False)  # a tight figure, as in a notebook, leaves out what its axes clip
        for text in legend.get_texts():
            text.set_parse_math(False)
        with RENDERING:
            added += legend.get_window_extent(figure.canvas.get_renderer()).height / figure.dpi
        heading = ""
    make_room(figure, added + 0.13 * scale() - foot)


def _lowest(axes: Sequence[Axes]) -> float:
    """How many inches above the foot of the figure the names of axes end."""
    figure: Any = axes[0].figure.canvas.figure
    with RENDERING:
        boxes = [ax.get_tightbbox(figure.canvas.get_renderer(), for_layout_only=True) for ax in axes if ax.axison]
    return float(min(box.y0 for box in boxes if box is not None) / figure.dpi)


def make_room(figure: Any, inches: float) -> None:
    """Make a sheet higher by this many inches at its foot, without changing its contents."""
    width, height = figure.get_size_inches()
    new = height + inches
    figure.set_size_inches(width, new)
    grids = {id(place.get_gridspec()): place.get_gridspec() for ax in figure.axes if (place := ax.get_subplotspec())}
    for grid in grids.values():
        grid.bottom, grid.top = (grid.bottom * height + inches) / new, (grid.top * height + inches) / new
    for ax in figure.axes:
        if place := ax.get_subplotspec():
            ax.set_subplotspec(place)
        else:
            x, y, wide, high = ax.get_position().bounds
            ax.set_position((x, (y * height + inches) / new, wide, high * height / new))
    for text in figure.texts:
        text.set_y((text.get_position()[1] * height + inches) / new)


def count_axis(axes: Axes, low: float, high: float, scale: Scale, early: float | None = None) -> None:
    """Give `axes` an x axis for counts from `low` to `high`.

    "log" is linear up to 1 and logarithmic above, and begins at `low`. It is linear throughout if `early` to `high` is
    less than half a decade. `early` is a count that few lie below, by default `low`.
    """
    if scale != "log":
        show_range(axes, "x", -0.01 * high, 1.02 * high)
        axes.xaxis.set_major_locator(MaxNLocator(5))
    elif high < HALF_A_DECADE * (low if early is None else early):
        span = max(high - low, 0.01 * high)
        show_range(axes, "x", low - 0.05 * span, high + 0.05 * span)
        axes.xaxis.set_major_locator(MaxNLocator(4, integer=True))
    else:
        # asinh has no kink, unlike symlog. 0 is on the axis: an estimate may converge before the first observation.
        axes.set_xscale("asinh", linear_width=1.0)
        begin = -0.1
        if low >= 10:
            decade = 10.0 ** np.floor(np.log10(low))
            begin = decade * max(step for step in (1, 2, 5) if step * decade <= low)
        show_range(axes, "x", begin, 1.15 * high)
        decades = 10.0 ** np.arange(np.ceil(np.log10(max(high, 1.0))) + 1)
        few = high < 20 * max(begin, 1.0)  # decades alone would give one or two labels
        named = np.outer(decades, [1, 2, 5] if few else [1]).ravel()
        if begin > 0 and high >= 20 * begin:
            named = np.append(named, begin)
        axes.xaxis.set_major_locator(FixedLocator([0.0, *named]))
        axes.xaxis.set_minor_locator(FixedLocator(np.outer(decades, np.arange(2, 10)).ravel().tolist()))
        axes.xaxis.set_minor_formatter(NullFormatter())
    axes.xaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:,.0f}"))


def error_axis(axes: Axes, top: float, scale: Scale) -> None:
    """Give `axes` a y axis for errors from 0 to `top`: linear up to 0.01 and logarithmic above, unless "linear"."""
    below = 0.01 * top  # so that dots at 0 are whole
    if scale != "linear":
        axes.set_yscale("asinh", linear_width=0.01)
        axes.yaxis.set_minor_locator(NullLocator())
        below = min(0.0005, below)
    show_range(axes, "y", -below, top)
    if scale == "linear" or top < 0.02:
        axes.yaxis.set_major_locator(MaxNLocator(5))
    else:
        tick(axes, "y", [0.0, 0.01, 0.1, 1.0, 0.02, 0.05, 0.2, 0.5, 0.005], "{:g}".format)
    axes.yaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))


def tick(axes: Axes, which: Literal["x", "y"], wanted: Sequence[float], text: Callable[[float], str]) -> None:
    """Put ticks at those of these numbers that are on an axis and have room for their texts, the first ones first."""
    axis, place = (axes.xaxis, 0) if which == "x" else (axes.yaxis, 1)
    low, high = axis.get_view_interval()
    kept: dict[float, tuple[float, float]] = {}  # its place and half of its room, in points
    for value in wanted:
        at = float(axes.transData.transform((value, value))[place]) * 72 / axes.figure.dpi
        half = width_of(text(value), letters()) / 2 + 2 if which == "x" else 0.55 * letters()
        if low <= value <= high and all(abs(at - other) >= half + more for other, more in kept.values()):
            kept[value] = at, half
    axis.set_major_locator(FixedLocator(sorted(kept)))
    axis.set_minor_locator(NullLocator())
    axis.set_minor_formatter(NullFormatter())
