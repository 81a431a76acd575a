"""A comparison as text, cell by cell, so that terminal and LaTeX tables show the same digits."""

from collections.abc import Iterable

import numpy as np
from numpy.typing import NDArray

from swarmcensus.summaries import Measure
from swarmcensus.support.formatting import decimals_for, fixed, rounded
from swarmcensus.support.intervals import FEWEST, Floats
from swarmcensus.support.printed_tables import NEVER

MOST_DECIMALS = 6
ALWAYS = "always"
TESTS = {
    "signed-rank": "Wilcoxon's signed-rank test of paired trials, together with a one-sided sign test",
    "rank-sum": "the two-sided rank-sum test, or Brunner and Munzel's if its p is larger",
}
LEAST_P = 0.001  # smaller p-values are shown as "< 0.001"


def column_head(measure: Measure) -> str:
    """The head of a measure's column."""
    return f"{measure.label} %" if measure.share else measure.label


def numbers(
    with_ends: Iterable[Floats], trials: NDArray[np.int64], measure: Measure, differences: bool = False
) -> list[tuple[str, str]]:
    """Values and their intervals as text, with two digits of the median interval (one digit for rounds).

    `with_ends` are values, and the low and high ends of their intervals. Infinite numbers are "never", of `differences`
    "inf"; those that are the same in all trials have "always" for an interval. A share of 1 has a lower end only, as in
    `swarmcensus show`.
    """
    values, low, high = with_ends
    times, endless = 100.0 if measure.share else 1.0, "inf" if differences else NEVER
    largest = times if measure.share and not differences else np.inf
    ends = [times * part for part in (values, low, high)]
    with np.errstate(invalid="ignore"):  # both ends may be infinite
        every_width = times * (high - low)
    widths, known = every_width[np.isfinite(every_width)], ends[0][np.isfinite(values)]
    counts = measure.unit in ("rounds", "observations")
    if widths.size:
        finest = decimals_for(float(np.median(widths)), digits=1 if counts else 2)
        decimals = min(max(finest, int(measure.share)), MOST_DECIMALS)
    elif (known == np.rint(known)).all():
        decimals = int(measure.share)
    else:
        decimals = 1 if counts or measure.share else 4
    out = []
    for *three, width, count in zip(*ends, every_width, trials.tolist(), strict=True):
        places = decimals
        if differences and 0.0 < width < np.inf:  # one is seen, however small it is next to those of other worlds
            places = max(decimals, min(decimals_for(width), MOST_DECIMALS))
        if places:  # else `rounded` does it, which keeps halves
            three = [float(np.round(part, places)) + 0.0 for part in three]  # + 0.0 avoids -0.00
        value, least, most = three
        text, interval = (part.replace("inf", endless) for part in rounded(value, least, most, places, largest))
        if value == least == np.inf:
            interval = ""  # it never comes, in nearly all trials
        elif np.isnan(least):
            same = differences and count >= FEWEST and not np.isnan(value)
            interval = (ALWAYS if same else "-") * bool(widths.size or count >= FEWEST)
        out.append(("-" if np.isnan(value) else text, interval))
    return out


def amount(value: float) -> str:
    """A cost as text: whole numbers from 100 on, else three digits."""
    return "-" if np.isnan(value) else fixed(value) if value >= 100 else f"{value:.3g}"


def range_text(values: Floats) -> str:
    """A contender's values over all worlds: one number, or the least and the largest; empty if none is known."""
    known = values[np.isfinite(values)]
    if not known.size:
        return ""
    low, high = amount(known.min()), amount(known.max())
    return low if low == high else f"{low} to {high}"


def p_value(p: float) -> str:
    """A p-value with three decimals, or "< 0.001"."""
    return f"< {LEAST_P}" if p < LEAST_P else f"{p:.3f}"


def p_equals(p: float) -> str:
    """A p-value as it follows "p" in a sentence: "= 0.034", or "< 0.001"."""
    return text if (text := p_value(p)).startswith("<") else f"= {text}"


def probability(value: float, low: float, high: float) -> tuple[str, str]:
    """A probability and its interval as text."""
    return f"{value:.2f}", "" if np.isnan(low) else f"[{low:.2f}, {high:.2f}]"


def margin_text(margin: float, measure: Measure) -> str:
    """A margin in the unit in which the measure is shown."""
    return f"{100 * margin:g} %" if measure.share else f"{margin:g}"
