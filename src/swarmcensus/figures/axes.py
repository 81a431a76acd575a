"""Axes for the values of any coordinate or variable: logarithmic, linear, or a row of names."""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence
from typing import Any, NamedTuple

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.ticker import FuncFormatter, LogLocator, MaxNLocator, NullFormatter, NullLocator

from swarmcensus.figures.groups import unit_of
from swarmcensus.figures.lettering import SPACING, shortened_apart, width_of, wrapped
from swarmcensus.figures.page import letters
from swarmcensus.figures.sheets import INNER, show_range, tick
from swarmcensus.figures.styles import NUMBER, OFF, Look, number_of
from swarmcensus.results import metric_of, metrics_in
from swarmcensus.studies import OF_FIGURES
from swarmcensus.support.intervals import Floats
from swarmcensus.support.quantities import QUANTITIES, SEARCHED

COUNTS = {name for name, coordinate in OF_FIGURES.items() if coordinate.counts}  # which often span decades
DECADES = 8.0  # ratio from which a coordinate that counts has a logarithmic axis
WIDE = 30.0  # the same for measured values
HUGE = 1000.0  # the same from which values nearly are 0
SPREAD = 8.0  # largest to typical value from which an axis may bend
LONGEST = 130.0  # points: length of a slanted name under an axis
SLANT = 40.0  # degrees
NARROW = 0.9  # ratio of the ends of values whose axis need not begin at 0


def places_of(values: Iterable[str]) -> tuple[dict[str, float], bool]:
    """The position of each value of a coordinate on its axis, and whether the values are numbers (else names)."""
    texts = list(values)
    if all(re.fullmatch(NUMBER, text) for text in texts) and len({text.startswith(OFF) for text in texts}) == 1:
        return {text: number_of(text) for text in texts}, True
    return {text: float(k) for k, text in enumerate(texts)}, False


class Lettering(NamedTuple):
    """Labels under an axis: texts, whether they slant, and the extra room in inches compared to a line of numbers."""

    texts: list[str]
    slanted: bool
    room: float

    @property
    def style(self) -> dict[str, Any]:
        """Keyword arguments of `set_xticks`."""
        return {"rotation": SLANT, "ha": "right", "rotation_mode": "anchor"} if self.slanted else {}


def names_of(looks: dict[str, Look], width: float, left: float = np.inf) -> Lettering:
    """The labels under an axis of `width` points: horizontal in up to two lines, or slanted if a word is too long.

    `left` is how many points there are from the axis to the paper's left edge.
    """
    texts, room = [look.name.removeprefix(OFF) for look in looks.values()], width / len(looks) - 4
    if places_of(looks)[1]:
        return Lettering(texts, False, 0.0)
    if all(width_of(word, letters()) <= room for text in texts for word in text.split()):
        lines = ["\n".join(wrapped(text, room, letters(), 2)) for text in texts]
        if not any("…" in text for text in lines):
            return Lettering(lines, False, max(text.count("\n") for text in lines) * SPACING * letters() / 72)
    slope = np.radians(SLANT)
    ticks = width / len(looks) * (np.arange(len(looks)) + 0.5)  # from the axis
    to_edge = (left + ticks - letters()) / np.cos(slope)  # from a tick to the paper's left edge
    texts = shortened_apart(texts, np.minimum(LONGEST, to_edge).tolist(), letters())
    return Lettering(texts, True, (np.sin(slope) * max(width_of(text, letters()) for text in texts) + 2) / 72)


def coordinate_axis(axes: Axes, name: str, looks: dict[str, Look], names: Lettering, aside: float) -> None:
    """Give `axes` an x axis for these values, with as many labelled ticks as fit.

    `aside` is how many points from its position a value may be drawn.
    """
    places, numbers = places_of(looks)
    x = np.array(list(places.values()))
    width = axes.bbox.width * 72 / axes.figure.dpi
    if not numbers:
        show_range(axes, "x", -0.5, x.size - 0.5)
        needed = SPACING * letters() / np.sin(np.radians(SLANT)) if names.slanted else 0.0
        kept = range(0, x.size, max(1, int(np.ceil(needed * x.size / width))))
        axes.set_xticks(x[kept], [names.texts[k] for k in kept], parse_math=False, **names.style)
        axes.tick_params(axis="x", length=0)
        return
    log = name in COUNTS and x.min() > 0 and x.max() >= DECADES * x.min()
    if log:
        axes.set_xscale("log")
    scaled = np.log(x) if log else x
    span = float(np.ptp(scaled))
    margin = (0.04 + 2 * aside / width) * span or 0.5
    low, high = scaled.min() - margin, scaled.max() + margin
    show_range(axes, "x", *(np.exp([low, high]) if log else (low, high)))
    named = dict(zip(x.tolist(), names.texts, strict=True))
    ends = x.min(), x.max()
    tick(axes, "x", sorted(named, key=lambda value: (value not in ends, value)), named.__getitem__)
    axes.xaxis.set_major_formatter(FuncFormatter(lambda value, _: named.get(float(value), "")))


def measured_axis(
    axes: Sequence[Axes], values: Sequence[float], ends: Sequence[float], *, bends: bool = False
) -> float:
    """Give all axes the same y axis for these values and the ends of their intervals; infinite ones are left out.

    It begins at 0 unless all values are far from it, or at 1, 2 or 5 times a power of ten if it is logarithmic. There
    is room at the top for the marks of infinite values. If it may bend, some values are 0 or nearly so, and few are
    large, it is linear up to the typical value, which is returned, and logarithmic above; else infinity is returned.
    """
    finite = np.array([value for value in values if np.isfinite(value)])
    reach = np.concatenate([finite, [end for end in ends if np.isfinite(end)]])
    more = 0.12 if np.isposinf(values).any() else 0.0  # of the height
    typical = float(f"{np.median(finite[finite > 0]):.0e}") if (finite > 0).any() else np.inf
    if not bends or finite.min() * HUGE > finite.max() or finite.min() < 0 or finite.max() < SPREAD * typical:
        typical = np.inf
    for ax in axes:
        if not finite.size:
            show_range(ax, "y", 0.0, 1.0)
            ax.yaxis.set_major_locator(NullLocator())
            continue
        low, high = float(reach.min()), float(reach.max())
        if np.isfinite(typical):
            ax.set_yscale("asinh", linear_width=typical)
            show_range(ax, "y", -0.3 * typical, 1.3 * high * (high / typical) ** more)
            decades = 10.0 ** np.arange(np.floor(np.log10(typical)), np.log10(high) + 1)
            tick(ax, "y", [0.0, *np.outer([1.0, 5.0, 2.0], decades[::-1]).ravel().tolist()], short)
        elif finite.min() > 0 and finite.max() >= WIDE * finite.min():
            ax.set_yscale("log")
            positive = reach[reach > 0.3 * finite.min()]  # an interval may reach down to 0
            bound = 0.9 * float(positive.min())  # some room for the lowest mark
            decade = float(10.0 ** np.floor(np.log10(bound)))
            least = max(step * decade for step in (1.0, 2.0, 5.0) if step * decade <= bound)
            show_range(ax, "y", least, 1.25 * high * (high / least) ** more)
            few = high < 300 * positive.min()
            ax.yaxis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0) if few else (1.0,)))
            ax.yaxis.set_minor_formatter(NullFormatter())
        else:
            if 0 <= low < NARROW * high:
                low = 0.0
            room = 0.06 * (high - low) or 0.1 * abs(high) or 0.5
            show_range(ax, "y", low - (0.2 * room if low == 0 else room), high + room + more * (high - low))
            ax.yaxis.set_major_locator(MaxNLocator(6, steps=[1, 2, 5, 10]))
        ax.yaxis.set_major_formatter(FuncFormatter(lambda value, _: short(value)))
        ax.tick_params(axis="y", labelleft=ax.get_label() != INNER)  # its left neighbour has the same axis
    return typical


def number_axis(axes: Axes, values: Floats, log: bool | None = None) -> None:
    """Give the axes an x axis for these numbers, logarithmic with `log`, by default if they differ much."""
    least, most = float(values.min()), float(values.max())
    if least > 0 and (most >= DECADES * least if log is None else log):
        axes.set_xscale("log")
        show_range(axes, "x", least / (most / least) ** 0.08, most * (most / least) ** 0.08)
        axes.xaxis.set_major_locator(LogLocator(subs=(1.0,) if most > 100 * least else (1.0, 2.0, 5.0)))
        axes.xaxis.set_minor_formatter(NullFormatter())
    else:
        room = 0.08 * (most - least) or 0.1 * most or 1.0
        show_range(axes, "x", least - room, most + room)
        axes.xaxis.set_major_locator(MaxNLocator(5))
    axes.xaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:,.6g}"))


def short(value: float) -> str:
    """A number in about five characters."""
    for least, unit, letter in ((1e6, 1e6, "M"), (1e4, 1e3, "k")):
        if abs(value) >= least:
            return f"{value / unit:,.6g}{letter}"
    if 0 < abs(value) < 1e-3:
        digits, exponent = f"{value:e}".split("e")
        return f"{float(digits):g}e{int(exponent)}"
    return f"{value:,.6g}"


def name_of(results: xr.Dataset, variable: str, statistic: str, room: float) -> str:
    """The label of a variable's axis with its unit, in lines of at most `room` points."""
    quantity = QUANTITIES.get(variable)
    unit = str(results[variable].attrs.get("units", "")) if variable in results else quantity.unit if quantity else ""
    unit = unit_of(results) if unit == "rounds" and "topology" in results.coords else unit
    known = quantity.axis if quantity else ""
    label = metric_of(results, variable).label if variable in metrics_in(results) else ""
    name = known or (label or variable.replace("_", " ")).replace("$", r"\$")
    statistic = f", {statistic}" * (SEARCHED not in results.attrs)  # a candidate has one number
    text = f"{name}{statistic}" + (f" ({unit})" if unit not in ("", "1") else "")
    if known:  # a formula is no wider than its letters
        return text.replace(" (", "\n(") if width_of(re.sub(r"[$\\{},]", "", text), letters() + 1) > room else text
    return "\n".join(wrapped(text, room, letters() + 1, 2))
