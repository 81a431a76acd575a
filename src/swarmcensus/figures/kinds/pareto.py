"""Quality against what it costs, in each world, and the front of brains that none is both better and cheaper than."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.lines import Line2D
from matplotlib.ticker import FuncFormatter, LogLocator, MaxNLocator, NullFormatter
from matplotlib.transforms import ScaledTranslation
from numpy.typing import NDArray

from swarmcensus.basics.errors import InputError
from swarmcensus.basics.hints import did_you_mean
from swarmcensus.comparing.cells import column_head
from swarmcensus.comparing.comparison import compare
from swarmcensus.comparing.standings import Standings
from swarmcensus.figures.axes import measured_axis
from swarmcensus.figures.coordinates import caption_of
from swarmcensus.figures.looks import Look, looks_of, solid_dot
from swarmcensus.figures.panels import MOST_PANELS
from swarmcensus.figures.sheets import Drawn, Own, add_key, drawn_on, name_axes, say_lacking, sheet, show_range
from swarmcensus.vocabulary.quantities import QUANTITIES


def pareto(
    results: xr.Dataset,
    *,
    metric: str = "final_error",
    cost: str = "bytes_sent",
    title: str | None = None,
    ax: Own = None,
) -> Drawn:
    """Draw a measure of `sc.compare` against a cost, a panel for each world, with its Pareto front.

    `cost` is "bytes_sent", "messages_sent", "memory_bytes" or "message_bytes". Upright lines are 95 % intervals over
    trials. Raises InputError as `sc.compare` does, for a cost that is not there and for more than 24 worlds.
    """
    return draw_pareto(compare(results, metric), cost, title, ax, [results])


SIZE = 6.0  # points: a dot
NEAR, BESIDE = 0.01, 5.0  # what counts as one cost, of an axis' length, and how far dots are drawn apart, in points
SPREAD = 8.0  # from there on the axis of costs is logarithmic
COSTS = {name: QUANTITIES[name].axis for name in ("bytes_sent", "messages_sent", "memory_bytes", "message_bytes")}
Floats = NDArray[np.float64]


def front(cost: Floats, value: Floats, low: bool) -> NDArray[np.bool_]:
    """Which of (contender,) are on the front: no other is as cheap and as good, and cheaper or better. NaN never is.

    Costs that agree to three digits are the same: means over trials differ by chance.
    """
    cost = np.array([float(f"{one:.3g}") for one in cost.tolist()])
    worse = value if low else -value
    cheaper = cost[:, np.newaxis] <= cost
    better = worse[:, np.newaxis] <= worse
    strictly = (cost[:, np.newaxis] < cost) | (worse[:, np.newaxis] < worse)
    beaten = (cheaper & better & strictly).any(axis=0)
    return np.asarray(~beaten & ~np.isnan(cost) & ~np.isnan(value))


def draw_pareto(
    found: Standings,
    cost: str = "bytes_sent",
    title: str | None = None,
    ax: Own = None,
    results: Sequence[xr.Dataset] = (),
) -> Drawn:
    """Draw a comparison's first measure against what contenders cost, a panel for each world.

    Full dots are on the front, which a line of steps joins; upright lines are 95 % intervals over trials. What never
    came is an arrow at the edge. The foot says what `results` lack.

    Raises InputError for a cost that is not there and for more than 24 worlds.
    """
    known = found.costs | found.sizes
    if cost not in known:
        told = f"these results have no such cost; {did_you_mean(cost, known)}there are {', '.join(known) or 'none'}"
        raise InputError(f"cost {cost!r}: {told}")
    if len(found.field.worlds) > MOST_PANELS:
        raise InputError(
            f"a figure holds 1 to {MOST_PANELS:,} worlds, not {len(found.field.worlds)}: select some settings"
        )
    measure, contest = found.measures[0], found.contests[0]
    times = 100.0 if measure.share else 1.0
    values, low, high = (times * part for part in (contest.values, *contest.value_ends))
    costs = known[cost]
    if not (np.isfinite(values) & np.isfinite(costs)).any():
        raise InputError(f"there is nothing to draw: no contender has both {measure.name} and {cost}")
    looks = looks_of(found.contenders, "o", "brain")
    captions = [caption_of(world) for world in found.field.worlds]
    axes = sheet(ax, captions, title)
    measured_axis(axes, values.ravel().tolist(), [*low.ravel().tolist(), *high.ravel().tolist()])
    for k, place in enumerate(axes):
        _cost_axis(place, costs[np.isfinite(costs)])
        _draw(
            place, costs[k], values[k], low[k], high[k], front(costs[k], values[k], contest.low), list(looks.values())
        )
        better = "lower" if contest.low else "higher"
        name_axes(place, COSTS[cost], f"{column_head(measure)} ({better} is better)")
    entries: dict[str, Any] = {look.name: solid_dot(look, SIZE, 0.6) for look in looks.values()}
    entries["front: none is both better and cheaper"] = Line2D([], [], color="0.4", linewidth=1)
    entries["hollow: not on the front"] = _dot(Look("", "", "white", "o"), False)
    if any(_beside(place, cost).any() for place, cost in zip(axes, costs, strict=True)):
        entries["side by side: at the same cost"] = Line2D([], [], linestyle="")
    add_key(axes, "", entries)
    say_lacking(axes, results)
    return drawn_on(axes, ax)


def _dot(look: Look, on_front: bool) -> Line2D:
    dot = solid_dot(look, SIZE, 0.6)
    if not on_front:
        dot.set(markerfacecolor="white", markeredgecolor=look.colour if look.name else "0.4", markeredgewidth=1.3)
    return dot


def _cost_axis(axes: Axes, costs: Floats) -> None:
    least, most = float(costs.min()), float(costs.max())
    if least > 0 and most >= SPREAD * least:
        axes.set_xscale("log")
        show_range(axes, "x", least / (most / least) ** 0.08, most * (most / least) ** 0.08)
        axes.xaxis.set_major_locator(LogLocator(subs=(1.0,) if most > 100 * least else (1.0, 2.0, 5.0)))
        axes.xaxis.set_minor_formatter(NullFormatter())
    else:
        room = 0.08 * (most - least) or 0.1 * most or 1.0
        show_range(axes, "x", least - room, most + room)
        axes.xaxis.set_major_locator(MaxNLocator(5))
    axes.xaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:,.6g}"))


def _beside(axes: Axes, cost: Floats) -> Floats:
    """How far, in points, contenders are drawn beside their cost, that those at one cost do not hide one another."""
    across = axes.transAxes.inverted().transform(axes.transData.transform(np.column_stack([cost, 0.0 * cost + 1.0])))
    out, order = np.zeros(len(cost)), np.argsort(across[:, 0], kind="stable")
    order = order[np.isfinite(across[order, 0])]
    for group in np.split(order, np.flatnonzero(np.diff(across[order, 0]) > NEAR) + 1):
        out[np.sort(group)] = BESIDE * (np.arange(len(group)) - (len(group) - 1) / 2.0)
    return out


def _draw(
    axes: Axes, cost: Floats, value: Floats, low: Floats, high: Floats, first: NDArray[np.bool_], looks: list[Look]
) -> None:
    bottom, top = axes.get_ylim()
    order = np.flatnonzero(first & np.isfinite(value))[np.argsort(cost[first & np.isfinite(value)], kind="stable")]
    axes.step(cost[order], value[order], where="post", color="0.4", linewidth=1, zorder=2)
    points = axes.figure.dpi_scale_trans
    for k, (look, beside) in enumerate(zip(looks, _beside(axes, cost), strict=True)):
        shifted = axes.transData + ScaledTranslation(beside / 72.0, 0.0, points)
        if np.isnan(cost[k]) or np.isnan(value[k]):
            continue
        if np.isinf(value[k]):
            axes.annotate("", (cost[k], top), (cost[k], top - 0.1 * (top - bottom)), xycoords=shifted,
                          textcoords=shifted, arrowprops={"arrowstyle": "->", "color": look.colour})  # fmt: skip
            continue
        if not np.isnan(low[k]):
            axes.plot(
                [cost[k]] * 2, [max(low[k], bottom), min(high[k], top)], color=look.colour, linewidth=0.9, zorder=3,
                transform=shifted,
            )  # fmt: skip
        dot = _dot(look, bool(first[k]))
        dot.set_data([cost[k]], [value[k]])
        dot.set_zorder(4)
        axes.add_line(dot)
        dot.set_transform(shifted)
