"""Axes for counts, errors, and the values of any coordinate or variable: logarithmic, linear, or a row of names."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Sequence
from typing import Any, Literal

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.ticker import (
    FixedLocator,
    Formatter,
    FuncFormatter,
    LogLocator,
    MaxNLocator,
    NullFormatter,
    NullLocator,
)

from swarmcensus.figures.groups import unit_of
from swarmcensus.figures.page import SPACING, letters, width_of, wrapped
from swarmcensus.figures.sheets import Scale
from swarmcensus.figures.styles import NUMBER, OFF, Look, number_of
from swarmcensus.results import metric_of, metrics_in
from swarmcensus.studies import OF_FIGURES
from swarmcensus.support.errors import InputError
from swarmcensus.support.intervals import Floats
from swarmcensus.support.quantities import QUANTITIES, SEARCHED

COUNTS = {name for name, coordinate in OF_FIGURES.items() if coordinate.counts}  # which often span decades
DECADES = 8.0  # ratio from which a coordinate that counts has a logarithmic axis
HALF_A_DECADE = 10**0.5
WIDE = 30.0  # the same for measured values
LONGEST = 130.0  # points: length of a slanted or upright name under an axis
SLANTS = {40: "top", 90: "center"}  # degrees of names under an axis, and where they are held, from the easiest to read
NARROW = 0.9  # ratio of the ends of values whose axis need not begin at 0
LATE = 0.75  # share of a linear axis: if all data lie beyond, it begins where they do
APART = 0.3  # from the numbers of an axis to its names, as a share of their range


class Ticks(FixedLocator):
    """Ticks at those of these numbers that are on an axis and have room for their texts, the first ones first."""

    def __init__(self, wanted: Sequence[float], text: Callable[[float], str]) -> None:
        """`text` is what is written at a number."""
        super().__init__(list(wanted))
        self.wanted, self.text, self.letters = [*wanted], text, letters()

    def __call__(self) -> Any:
        """The numbers, computed when the axis has its size."""
        axis: Any = self.axis
        axes, side = axis.axes, int(axis.axis_name == "y")
        low, high = sorted(axis.get_view_interval())
        kept: dict[float, tuple[float, float]] = {}  # its place and half of its room, in points
        for value in self.wanted:
            at = float(axes.transData.transform((value, value))[side]) * 72 / axes.figure.dpi
            widths = [width_of(line, self.letters) for line in self.text(value).split("\n")]
            half = 0.55 * self.letters if side else max(widths) / 2 + 2
            if low <= value <= high and all(abs(at - other) >= half + more for other, more in kept.values()):
                kept[value] = at, half
        return np.array(sorted(kept))


def tick(axes: Axes, which: Literal["x", "y"], wanted: Sequence[float], text: Callable[[float], str]) -> None:
    """Put ticks at those of these numbers that are on an axis and have room, the first ones first."""
    axis = axes.xaxis if which == "x" else axes.yaxis
    axis.set_major_locator(Ticks(wanted, text))
    axis.set_minor_locator(NullLocator())
    axis.set_minor_formatter(NullFormatter())


def count_axis(axes: Axes, low: float, high: float, scale: Scale, early: float | None = None) -> None:
    """Give `axes` an x axis for counts from `low` to `high`.

    "log" is linear up to 1 and logarithmic above, and begins at `low`. It is linear throughout if `early` to `high` is
    less than half a decade. A linear axis begins at 0, unless all counts lie in its last quarter. `early` is a count
    that few lie below, by default `low`.
    """
    early = low if early is None else early
    if scale != "log" and early < LATE * high:
        axes.set_xlim(-0.01 * high, 1.02 * high)
        axes.xaxis.set_major_locator(MaxNLocator(5))
    elif scale != "log" or high < HALF_A_DECADE * early:
        span = max(high - low, 0.01 * high)
        axes.set_xlim(low - 0.05 * span, high + 0.05 * span)
        axes.xaxis.set_major_locator(MaxNLocator(4, integer=True))
    else:
        # asinh has no kink, unlike symlog. 0 is on the axis: an estimate may converge before the first observation.
        axes.set_xscale("asinh", linear_width=1.0)
        begin = -0.1
        if low >= 10:
            decade = 10.0 ** np.floor(np.log10(low))
            begin = decade * max(step for step in (1, 2, 5) if step * decade <= low)
        axes.set_xlim(begin, 1.15 * high)
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
    axes.set_ylim(-below, top)
    if scale == "linear" or top < 0.02:
        axes.yaxis.set_major_locator(MaxNLocator(5))
    else:
        tick(axes, "y", [0.0, 0.01, 0.1, 1.0, 0.02, 0.05, 0.2, 0.5, 0.005], "{:g}".format)
    axes.yaxis.set_major_formatter(Numbers())


def places_of(values: Iterable[str], *, mixed: bool = False) -> tuple[dict[str, float], bool]:
    """The position of each value of a coordinate on its axis, and whether the values are numbers (else names).

    With `mixed`, names stand to the right of numbers.
    """
    texts = list(dict.fromkeys(values))
    numbers = {text: number_of(text) for text in texts if re.fullmatch(NUMBER, text)}
    if len(numbers) == len(texts) and len({text.startswith(OFF) for text in texts}) == 1:
        return numbers, True
    if not mixed:
        return {text: float(k) for k, text in enumerate(texts)}, False
    least, most = min(numbers.values(), default=0.0), max(numbers.values(), default=0.0)
    names = [text for text in texts if text not in numbers]
    step = APART * max(most - least, 0.05)
    return numbers | {text: most + step * (k + 1) for k, text in enumerate(names)}, True


def coordinate_axis(axes: Sequence[Axes], name: str, looks: dict[str, Look], aside: float = 0.0) -> None:
    """Give all axes an x axis for these values, with as many labelled ticks as fit.

    `aside` is how many points from its position a value may be drawn.
    """
    places, numbers = places_of(looks, mixed=name == "belief")
    texts = [look.name.removeprefix(OFF) for look in looks.values()]
    x, width = np.array(list(places.values())), axes[0].bbox.width * 72 / axes[0].figure.dpi
    log = numbers and name in COUNTS and x.min() > 0 and x.max() >= DECADES * x.min()
    scaled = np.log(x) if log else x
    margin = (0.04 + 2 * aside / width) * float(np.ptp(scaled)) or 0.5
    low, high = scaled.min() - margin, scaled.max() + margin
    named, ends = dict(zip(x.tolist(), texts, strict=True)), (x.min(), x.max())
    wanted = sorted(named, key=lambda value: (value not in ends, value))
    for ax in axes:
        if not numbers:
            ax.set_xlim(-0.5, x.size - 0.5)
            name_columns(ax, name, texts)
            continue
        if log:
            ax.set_xscale("log")
        ax.set_xlim(*(np.exp([low, high]) if log else (low, high)))
        tick(ax, "x", wanted, named.__getitem__)
        ax.xaxis.set_major_formatter(FuncFormatter(lambda value, _: named.get(float(value), "")))


def name_columns(axes: Axes, name: str, texts: Sequence[str]) -> None:
    """Write all names under an axis: horizontal in up to two lines, unless a word is too long, else slanted or upright.

    Raises InputError if there is no room for the names of the coordinate `name`.
    """
    width = axes.bbox.width * 72 / axes.figure.dpi
    room, style = width / len(texts), dict[str, Any]()
    fits = all(width_of(word, letters()) <= room - 4 for text in texts for word in text.split())
    lines = ["\n".join(wrapped(text, room - 4, letters(), 2)) for text in texts if fits]
    if not fits or any("…" in text for text in lines):
        angles = [angle for angle in SLANTS if SPACING * letters() <= room * np.sin(np.radians(angle))]
        if not angles:
            why = f"a panel has no room for all names of {name}: they have more room in a wider figure"
            raise InputError(f"{why}, or as rows of a heatmap, y={name}", key="x", value=name)
        most = LONGEST if angles[0] == 90 else min(LONGEST, width / 2)
        lines = ["".join(wrapped(text, most, letters(), 1)) for text in texts]
        style = {"rotation": angles[0], "va": SLANTS[angles[0]], "ha": "right", "rotation_mode": "anchor"}
    axes.set_xticks(range(len(texts)), lines, parse_math=False, **style)
    axes.tick_params(axis="x", length=0)


def measured_axis(
    axes: Sequence[Axes], values: Sequence[float], ends: Sequence[float], *, more: float = 0.12, linear: bool = False
) -> None:
    """Give all axes the same y axis for these values and the ends of their intervals; infinite ones are left out.

    It begins at 0 unless all values are far from it, or at 1, 2 or 5 times a power of ten if it is logarithmic, which a
    `linear` one never is. There is room at the top for the marks of infinite values, `more` of the height.
    """
    finite = np.array([value for value in values if np.isfinite(value)])
    reach = np.concatenate([finite, [end for end in ends if np.isfinite(end)]])
    more = more if np.isposinf(values).any() else 0.0
    for ax in axes:
        if not finite.size:
            ax.set_ylim(0.0, 1.0)
            ax.yaxis.set_major_locator(NullLocator())
            continue
        low, high = float(reach.min()), float(reach.max())
        if not linear and finite.min() > 0 and finite.max() >= WIDE * finite.min():
            ax.set_yscale("log")
            positive = reach[reach > 0.3 * finite.min()]  # an interval may reach down to 0
            bound = 0.9 * float(positive.min())  # some room for the lowest mark
            decade = float(10.0 ** np.floor(np.log10(bound)))
            least = max(step * decade for step in (1.0, 2.0, 5.0) if step * decade <= bound)
            ax.set_ylim(least, 1.25 * high * (high / least) ** more)
            few = high < 300 * positive.min()
            ax.yaxis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0) if few else (1.0,)))
            ax.yaxis.set_minor_formatter(NullFormatter())
        else:
            if 0 <= low < NARROW * high:
                low = 0.0
            room = 0.06 * (high - low) or 0.1 * abs(high) or 0.5
            ax.set_ylim(low - (0.2 * room if low == 0 else room), high + room + more * (high - low))
            ax.yaxis.set_major_locator(MaxNLocator(6, steps=[1, 2, 5, 10]))
        ax.yaxis.set_major_formatter(Numbers())


def number_axis(axes: Axes, values: Floats, log: bool | None = None) -> None:
    """Give the axes an x axis for these numbers, logarithmic with `log`, by default if they differ much."""
    least, most = float(values.min()), float(values.max())
    if least > 0 and (most >= DECADES * least if log is None else log):
        axes.set_xscale("log")
        axes.set_xlim(least / (most / least) ** 0.08, most * (most / least) ** 0.08)
        axes.xaxis.set_major_locator(LogLocator(subs=(1.0,) if most > 100 * least else (1.0, 2.0, 5.0)))
        axes.xaxis.set_minor_formatter(NullFormatter())
    else:
        room = 0.08 * (most - least) or 0.1 * most or 1.0
        axes.set_xlim(least - room, most + room)
        room = axes.bbox.width * 72 / axes.figure.dpi / (width_of(f"{most:,.4g}", letters()) + 2 * letters())
        axes.xaxis.set_major_locator(MaxNLocator(int(np.clip(room, 1, 5))))
    axes.xaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:,.6g}"))


class Numbers(Formatter):
    """All numbers of an axis in one format."""

    def __call__(self, value: float, pos: int | None = None) -> str:
        """The number as it is written."""
        return short(value, self.locs)


def short(value: float, among: Iterable[float] = ()) -> str:
    """A number in about five characters, in a format for all those `among` which it is."""
    sizes = [abs(each) for each in (value, *among) if each]
    for least, unit, letter in ((1e6, 1e6, "M"), (1e4, 1e3, "k")):
        if value and (abs(value) >= least or (max(sizes) >= least and min(sizes) >= unit)):
            return f"{value / unit:,.6g}{letter}"
    if value and min(sizes) < 1e-4:
        digits, exponent = f"{value:e}".split("e")
        return f"{float(digits):g}e{int(exponent)}"
    return f"{value:,.6g}"


def name_of(results: xr.Dataset, variable: str, statistic: str) -> str:
    """The name of a variable's y axis with its unit."""
    quantity = QUANTITIES.get(variable)
    unit = str(results[variable].attrs.get("units", "")) if variable in results else quantity.unit if quantity else ""
    unit = unit_of(results) if unit == "rounds" and "topology" in results.coords else unit
    label = metric_of(results, variable).label if variable in metrics_in(results) else ""
    name = (quantity.axis if quantity else "") or (label or variable.replace("_", " ")).replace("$", r"\$")
    statistic = f", {statistic}" * (SEARCHED not in results.attrs)  # a candidate has one number
    return f"{name}{statistic}" + (f" ({unit})" if unit not in ("", "1") else "")
