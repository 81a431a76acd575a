"""Quality against cost in each world, with the Pareto front: the brains that no other brain beats on both."""

from __future__ import annotations

from collections import Counter, defaultdict
from collections.abc import Sequence
from typing import Unpack

import numpy as np
import xarray as xr
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from numpy.typing import NDArray

from swarmcensus.analysis import Standings, column_head, compare
from swarmcensus.figures.axes import measured_axis, number_axis
from swarmcensus.figures.captions import NEVER, captioned, unlearnt, with_numbers
from swarmcensus.figures.coordinates import Names, worlds_apart
from swarmcensus.figures.page import PageOptions, on_page
from swarmcensus.figures.sheets import add_key, name_axes, sheet
from swarmcensus.figures.styles import (
    Look,
    add_dots,
    add_endless,
    endless_high,
    endless_mark,
    key_mark,
    looks_of_contenders,
    outlined_dot,
)
from swarmcensus.support.errors import InputError
from swarmcensus.support.hints import did_you_mean
from swarmcensus.support.intervals import Floats
from swarmcensus.support.options import wrong_option
from swarmcensus.support.quantities import QUANTITIES

LARGE, SMALL = 8.0, 5.0  # points: the first dot and the last, so that none hides another at the same place
LEFT = 0.9  # inches: the y axis; its name often needs three lines
RIM = 1.3  # points: the outline of a hollow dot
AGREEING = 3  # digits: costs that agree to these are equal, since means over trials differ by chance
COSTS = {name: QUANTITIES[name].axis for name in ("bytes_sent", "messages_sent", "memory_bytes", "message_bytes")}


@on_page
def pareto(
    results: xr.Dataset,
    *,
    metric: str = "final_error",
    cost: str = "bytes_sent",
    factor: Names = None,
    rows: Names = None,
    cols: Names = None,
    title: str | None = None,
    **more: Unpack[PageOptions],
) -> Figure:
    """Draw a measure of quality against a cost, one panel for each world, with the Pareto front.

    Full dots are on the front: no other brain is both better and cheaper. A stepped line joins them. Vertical lines are
    95 % intervals over trials. A sign at the top is an infinite value. Costs that agree to three digits share one
    x; later brains have smaller dots, so that none hides another.

    - `metric`: a measure, as in `sc.compare`.
    - `cost`: "bytes_sent", "messages_sent", "memory_bytes" or "message_bytes".
    - `factor`: coordinates that are compared, as in `sc.compare`; by default brains.
    - `rows`, `cols`: the coordinates of worlds that are in rows and in columns of panels.
    - `title`: the title of the figure.
    - `width`, `height`, `font_size`, `labels`: the page, and names of brains (see `PageOptions`).

    Raises InputError as `sc.compare` does, for an unknown cost and for more than 120 worlds.
    """
    return draw_pareto(compare(results, metric, factor=factor or ()), cost, title, [results], rows, cols)


def front(cost: Floats, value: Floats, low: bool) -> NDArray[np.bool_]:
    """Which contenders are on the front, (contender,); low values are better if `low`. NaN is never on it.

    A contender is on the front if no other is at least as cheap and as good, and cheaper or better. Costs that agree to
    three digits count as equal, since means over trials differ by chance.
    """
    cost = _rounded(cost)
    worse = value if low else -value
    cheaper = cost[:, np.newaxis] <= cost
    better = worse[:, np.newaxis] <= worse
    strictly = (cost[:, np.newaxis] < cost) | (worse[:, np.newaxis] < worse)
    beaten = (cheaper & better & strictly).any(axis=0)
    return np.asarray(~beaten & ~np.isnan(cost) & ~np.isnan(value))


def _rounded(costs: Floats) -> Floats:
    """Costs rounded to the digits in which equal costs agree."""
    return np.array([float(f"{each:.{AGREEING}g}") for each in costs.ravel().tolist()]).reshape(costs.shape)


def draw_pareto(
    standings: Standings, cost: str = "bytes_sent", title: str | None = None,
    results: Sequence[xr.Dataset] = (), rows: Names = None, cols: Names = None,
) -> Figure:  # fmt: skip
    """Draw the first measure of a comparison against a cost; see `pareto`.

    The caption says how many trials `results` lack. Raises InputError for an unknown cost and for more than 120 worlds.
    """
    known = {name: values for name, values in standings.costs.items() if name in COSTS}
    cost = next((name for name in known if cost in (name, QUANTITIES[name].title)), cost)
    if cost not in known:
        there = f"{did_you_mean(cost, known)}there are {', '.join(known) or 'none'}"
        raise wrong_option("cost", cost, f"these results have no such cost; {there}")
    captions, labels = worlds_apart(standings.grid.worlds, rows, cols)
    measure, contest = standings.measures[0], standings.contests[0]
    times = 100.0 if measure.share else 1.0
    values, low, high = (times * part for part in (contest.values, *contest.value_ends))
    costs = _rounded(known[cost])
    if not (np.isfinite(values) & np.isfinite(costs)).any():
        raise InputError(f"there is nothing to draw: no contender has both {measure.name} and {cost}", key="cost")
    looks = list(looks_of_contenders(standings.contenders, standings.grid.factor, results).values())
    has = [bool(there.any()) for there in ~np.isnan(values) & np.isfinite(costs)]
    why = f"no contender has both {measure.name} and {cost}"
    numberless, kept, captions = with_numbers(captions, has, why, range(len(captions)), captions)
    axes = sheet(captions, title, rows=[labels[k] for k in kept if labels], left=LEFT)
    ends = [*low.ravel().tolist(), *high.ravel().tolist()]
    endless = Counter((k, costs[k, i]) for k, i in np.argwhere(np.isposinf(values)).tolist())  # signs at a cost
    more = endless_high(max(endless.values(), default=0), axes[0])
    measured_axis(axes, values.ravel().tolist(), ends, more=more)
    on_front = np.array([front(*each, contest.low) for each in zip(costs, values, strict=True)])
    for k, place in zip(kept, axes, strict=True):
        number_axis(place, costs[np.isfinite(costs)])
        _draw(place, costs[k], values[k], low[k], high[k], on_front[k], looks)
        better = "lower" if contest.low else "higher"
        name_axes(place, COSTS[cost], f"{column_head(measure)} ({better} is better)")
    entries: dict[str, Artist] = {look.name: outlined_dot(look, size, 0.6) for look, size in _sizes(looks)}
    if np.isfinite(low).any():
        entries["95 % interval"] = key_mark("|")
    if np.isinf(values).any():
        entries["infinite"] = endless_mark()
    shown = np.isfinite(values) & np.isfinite(costs)
    if any(len({*costs[k][on_front[k] & shown[k]]}) > 1 for k in kept):
        entries["front: none is both better and cheaper"] = Line2D([], [], color="0.4", linewidth=1)
    if (shown & ~on_front).any():
        entries["hollow: not on the front"] = outlined_dot(Look("", "", "0.4", "o"), LARGE, 0.6, hollow=RIM)
    add_key(axes, "", entries)
    return captioned(axes, pareto, results, [numberless, unlearnt(results, [measure.name], NEVER)])


def _sizes(looks: list[Look]) -> list[tuple[Look, float]]:
    """Each look with the size of its dots."""
    return list(zip(looks, np.linspace(LARGE, SMALL, len(looks)).tolist(), strict=True))


def _draw(
    axes: Axes, cost: Floats, value: Floats, low: Floats, high: Floats, on_front: NDArray[np.bool_], looks: list[Look]
) -> None:
    """Draw the contenders of one world and the line of the front."""
    bottom, top = axes.get_ylim()
    joined = np.flatnonzero(on_front & np.isfinite(value))
    order = joined[np.argsort(cost[joined], kind="stable")]
    axes.step(cost[order], value[order], where="post", color="0.4", linewidth=1, zorder=2)
    signs = defaultdict[float, list[Look]](list)
    for k in np.flatnonzero(~np.isnan(cost + value)).tolist():
        look, size = _sizes(looks)[k]
        if np.isinf(value[k]):
            signs[cost[k]].append(look)
            continue
        axes.vlines(cost[k], max(low[k], bottom), min(high[k], top), colors=look.colour, linewidths=0.9, zorder=3)
        dot = outlined_dot(look, size, 0.6, hollow=0.0 if on_front[k] else RIM)
        add_dots(axes, dot, [cost[k]], [value[k]], zorder=4, clip_on=False)
    add_endless(axes, signs)
