"""Critical-difference diagram: average ranks of brains, with bars over brains that do not differ significantly."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, Unpack

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from swarmcensus.analysis import Standings, compare, in_worlds_too_few, overall_too_few, p_equals
from swarmcensus.figures.captions import NEVER, captioned, left_out, on_edges, unlearnt
from swarmcensus.figures.coordinates import Names
from swarmcensus.figures.page import PageOptions, ink, letters, on_page, page, scale, wrapped
from swarmcensus.figures.sheets import EDGE, add_key, sheet
from swarmcensus.figures.styles import looks_of_contenders
from swarmcensus.support.errors import InputError
from swarmcensus.support.formatting import counted
from swarmcensus.support.options import option
from swarmcensus.support.significance import groups

# Inches, with letters of the usual size:
WIDE = 6.4  # the figure
NAMES = 1.75  # on the right for the names
LEFT = 0.15  # on the left
NUMBER = 0.36  # of these for a rank
MOST_LINES = 2  # of a name
LINE, BAR = 0.12, 0.09  # a line of a name, and from bar to bar
APART = 0.05  # between names; less if a page is too low
UNDER, AROUND = 0.12, 1.25  # under the last name, and about all but bars and names
MOST = 40  # contenders
GREY = "0.35"  # of the lines to the names
KEY = "1 is best. {}Friedman's test is of all together: whether any differ."
BARS = "A bar joins those that tests of pairs (corrected) do not tell apart. "


@on_page
def ranks(
    results: xr.Dataset,
    *,
    metric: Names = None,
    factor: Names = None,
    title: str | None = None,
    **more: Unpack[PageOptions],
) -> Figure:
    """Draw the critical-difference diagram: the average ranks of brains.

    Each measure has a line. The best brain is on the left. Ranks are means over the trials and worlds in which all
    contenders have run. A bar joins contenders that `sc.compare` does not tell apart by its tests of pairs over all
    these worlds. Friedman's test is of all contenders together: it may find that some differ where no pair is told
    apart.

    - `metric`: measures, such as "correct" or ["final_error", "my_metric:low"]; by default the usual ones. Tests are
      corrected for all of them together.
    - `factor`: coordinates that are compared, as in `sc.compare`; by default brains.
    - `title`: the title of the figure.
    - `width`, `height`, `font_size`, `labels`: the page, and names of brains (see `PageOptions`).

    Raises InputError as `sc.compare` does, if there is no world in which all contenders have run, and for more than 40
    contenders.
    """
    return draw_ranks(compare(results, metric or (), factor=factor or ()), title, [results])


def draw_ranks(standings: Standings, title: str | None = None, results: Sequence[xr.Dataset] = ()) -> Figure:
    """Draw a panel for each measure of a comparison; see `ranks`.

    The caption says how many trials `results` lack. Raises InputError if there is no world in which all contenders have
    run, for more than 40 contenders, and for more than a page of given width has lines for.
    """
    drawn = [k for k, contest in enumerate(standings.contests) if len(contest.ranks)]
    if not drawn:
        raise InputError("ranks: there is no world in which all contenders have finished the same trials")
    if len(standings.contenders) > MOST:
        many = f"a line has room for {MOST:,} contenders, not {len(standings.contenders)}"
        raise InputError(f"ranks: {many}: select some settings")
    averages = [standings.contests[k].average_ranks for k in drawn]
    joined = [
        groups(np.argsort(averages[i], kind="stable").tolist(), standings.apart_overall(standings.contests[k]))
        for i, k in enumerate(drawn)
    ]
    times = scale()
    wide = (page().width or WIDE * times) - 2 * EDGE
    called = [look.name for look in looks_of_contenders(standings.contenders, standings.grid.factor, results).values()]
    side = min(NAMES * times, 0.55 * wide)  # for the names
    names = [wrapped(name, 72 * (side - 0.45 * times), letters(), MOST_LINES) for name in called]
    needed = times * (AROUND + BAR * max(map(len, joined)) + LINE * sum(map(len, names)))  # with no gaps, about
    if needed > (high := page().highest) and page().width:
        few = f"select some settings, or take smaller letters, as by {option('font_size', letters() * high // needed)}"
        raise InputError(f"ranks: {len(names)} contenders are too many for a page of {high:g} inches: {few}")
    apart = min(APART * times, max(0.0, high - needed) / len(names))
    tall = [LINE * times * len(lines) + apart for lines in names]  # inches of each name
    captions = [_caption(standings, k) for k in drawn]
    inches = [times * (UNDER + BAR * (len(bars) + 1)) + sum(tall) for bars in joined]  # of a panel
    panels = sheet(
        captions, title, size=(wide, inches), least=None, left=0.0, key=False, fewer="name one metric"
    )  # fmt: skip
    for panel, average, bars, deep in zip(panels, averages, joined, inches, strict=True):
        panel.set_ylim(deep, 0)
        _draw(panel, names, average, bars, tall, side)
    add_key(panels, KEY.format(BARS * any(joined)), {}, below=True)
    every = [measure.label for measure in standings.measures]
    missing = left_out(every, drawn, "no world in which all contenders have numbers")
    few = overall_too_few(standings.contests) or in_worlds_too_few(standings.contests)
    shown = [standings.measures[k].name for k in drawn]
    return captioned(panels, ranks, results, [missing, few, on_edges(results, shown), unlearnt(results, shown, NEVER)])


def _caption(standings: Standings, k: int) -> str:
    """The measure, its trials, and Friedman's test of whether any contenders differ."""
    contest = standings.contests[k]
    worlds = int(contest.met.sum())
    over = counted(len(contest.ranks), "trial") + (f" in {counted(worlds, 'world')}" if worlds > 1 else "")
    caption = f"{standings.measures[k].label}: average rank over {over}"
    p = contest.friedman_corrected
    return caption if np.isnan(p) else f"{caption}; Friedman's test: p {p_equals(p)}"


def _draw(
    axes: Axes, names: list[list[str]], ranks: np.ndarray, bars: list[list[int]], tall: list[float], side: float
) -> None:
    """Draw one panel: x are ranks, y inches below the line of ranks.

    `tall` is the height of each name, given as lines, and `side` the width for names on the right.
    """
    count, times = len(names), scale()
    bar_step = BAR * times
    wide = (axes.bbox.width / axes.figure.dpi - LEFT - side) / max(count - 1, 1)  # inches from rank to rank
    axes.set_xlim(1 - LEFT / wide, count + side / wide)
    axes.set_axis_off()
    axes.plot([1, count], [0, 0], color=ink(), linewidth=1, clip_on=False)
    apart = max(1, count // 12, int(np.ceil(1.6 * letters() / 72 / wide)))
    for rank in [*range(1, count + 1 - apart, apart), count]:
        axes.plot([rank, rank], [0, -0.05], color=ink(), linewidth=1, clip_on=False)
        axes.text(rank, -0.07, str(rank), ha="center", va="bottom", fontsize=letters())
    for level, bar in enumerate(bars):
        y, ends = bar_step * (level + 0.9), ranks[bar]
        across = [ends.min() - 0.04 / wide, ends.max() + 0.04 / wide]
        axes.plot(across, [y, y], color=ink(), linewidth=3, solid_capstyle="butt")
    end = count + 0.05 / wide
    style: dict[str, Any] = {"ha": "left", "va": "center", "fontsize": letters(), "parse_math": False}
    foot = bar_step * (len(bars) + 1)
    for contender in np.argsort(ranks, kind="stable").tolist()[::-1]:
        y, foot = foot + tall[contender] / 2, foot + tall[contender]
        axes.plot([ranks[contender], ranks[contender], end], [0, y, y], color=GREY, linewidth=0.7)
        axes.text(end + 0.04 / wide, y, f"{ranks[contender]:.2f}", **style)
        axes.text(end + (0.04 + NUMBER * times) / wide, y, "\n".join(names[contender]), linespacing=0.95, **style)
