"""A comparison as text, cell by cell, so that terminal and LaTeX tables show the same digits."""

import numpy as np
from numpy.typing import NDArray

from swarmcensus.analysis.comparing.pair_tests import pairs_of
from swarmcensus.analysis.comparing.standings import Standings
from swarmcensus.results import OURS, Measure
from swarmcensus.support.formatting import decimals_for, fixed, rounded
from swarmcensus.support.intervals import FEWEST
from swarmcensus.support.printed_tables import INTERVAL, Column
from swarmcensus.support.quantities import QUANTITIES

MOST_DECIMALS = 6
NEVER = "never"
ALWAYS = "always"
RANK_SUM = "the rank-sum test, or Brunner and Munzel's if its p is larger"
LEAST_P = 0.001  # smaller p-values are shown as "< 0.001"
MARKS = {"best": "*", "better": "+", "worse": "-", "level": "="}
COSTS = {name: QUANTITIES[name].title for name in ("messages_sent", "bytes_sent", "memory_bytes")}  # column heads
PAIR_HEADS = (
    *("measure", "world", "one", "other", "one - other", INTERVAL, "P(one better)", INTERVAL),
    *("effect", "p", "p, corrected", "told apart"),
)
Floats = NDArray[np.float64]


def column_head(measure: Measure) -> str:
    """The head of a measure's column."""
    return f"{measure.label} %" if measure.share else measure.label


def rows_of(standings: Standings, worlds: int) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
    """The rows of a table of the first `worlds` worlds: the world and the contender of each row."""
    world, contender = np.nonzero(standings.settings[:worlds] >= 0)
    return world, contender


def columns(standings: Standings, worlds: int) -> list[Column]:
    """The columns of measures, with a cell for each row of `rows_of`; the best, or better, values are strong."""
    at, found = rows_of(standings, worlds), []
    for measure, contest in zip(standings.measures, standings.contests, strict=True):
        low, high = (ends[at] for ends in contest.value_ends)
        texts = numbers(contest.values[at], low, high, contest.trials[at], measure)
        ways = standings.standing(contest)[at].tolist()
        found.append(Column(
            column_head(measure), [value for value, _ in texts], intervals=[interval for _, interval in texts],
            marks=[MARKS.get(way, "") for way in ways], strong=[way in ("best", "better") for way in ways],
        ))  # fmt: skip
        if measure.name == "final_error":
            found += [_tail_column(name, [part[at] for part in of], contest.trials[at])
                      for name, of in standings.tails.items()]  # fmt: skip
    return found


def _tail_column(name: str, of: list[Floats], trials: NDArray[np.int64]) -> Column:
    """The column of a tail, which has neither marks nor intervals: it is not tested."""
    value, low, high = of
    texts = numbers(value, low, high, trials, OURS[name])
    return Column(OURS[name].label, [value for value, _ in texts])


def cost_columns(standings: Standings, worlds: int) -> list[Column]:
    """The columns of costs that are no measures of the comparison, with a cell for each row of `rows_of`."""
    at, measured = rows_of(standings, worlds), [measure.name for measure in standings.measures]
    return [
        Column(COSTS[name], [amount(value) for value in values[at]])
        for name, values in (standings.costs | standings.sizes).items()
        if name in COSTS and name not in measured
    ]


def numbers(
    values: Floats, low: Floats, high: Floats, trials: NDArray[np.int64], measure: Measure, differences: bool = False
) -> list[tuple[str, str]]:
    """Values and their intervals as text, with two digits of the median interval (one digit for rounds).

    Infinite numbers are "never", of `differences` "inf"; those that are the same in all trials have "always" for an
    interval. A share of 1 has a lower end only, as in `swarmcensus show`.
    """
    times, endless = 100.0 if measure.share else 1.0, "inf" if differences else NEVER
    largest = times if measure.share and not differences else np.inf
    ends = [times * part for part in (values, low, high)]
    with np.errstate(invalid="ignore"):  # both ends may be infinite
        widths = times * (high - low)
    widths = widths[np.isfinite(widths)]
    counts = measure.unit in ("rounds", "observations")
    digits = 1 if counts else 2
    decimals = 1 if counts or measure.share else 4
    if widths.size:
        decimals = min(max(decimals_for(float(np.median(widths)), digits), int(measure.share)), MOST_DECIMALS)
    known = values[np.isfinite(values)]
    if not widths.size and (times * known == np.rint(times * known)).all():
        decimals = int(measure.share)
    out = []
    if decimals:  # else `rounded` does it, which keeps halves
        ends = [np.round(part, decimals) + 0.0 for part in ends]  # + 0.0 avoids -0.00
    for value, least, most, count in zip(*ends, trials.tolist(), strict=True):
        text, interval = (part.replace("inf", endless) for part in rounded(value, least, most, decimals, largest))
        if value == least == np.inf:
            interval = ""  # it never comes, in nearly all trials
        elif np.isnan(least):
            interval = (ALWAYS if differences and count >= FEWEST and not np.isnan(value) else "-") * bool(
                widths.size or count >= FEWEST
            )
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


def legend(standings: Standings) -> str:
    """The meaning of the marks."""
    if standings.against is None:
        return "* best in its world, told apart from all others; = first, or not told apart from the first"
    return f"+ better, - worse than {standings.contenders[standings.against]}, and told apart from it; = not told apart"


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


def pair_rows(standings: Standings, worlds: int) -> list[tuple[str, ...]]:
    """A row of texts for each measure, world and pair, with the columns `PAIR_HEADS`."""
    rows: list[tuple[str, ...]] = []
    for measure, contest in zip(standings.measures, standings.contests, strict=True):
        trials = contest.pair_trials.min(axis=0)
        world, pair = at = np.nonzero(~np.isnan(contest.corrected[:worlds]))
        equal = contest.within(standings.margins.get(measure.name))
        low, high = (ends[at] for ends in contest.difference_ends)
        texts = numbers(contest.difference[at], low, high, trials[at], measure, differences=True)
        for k, (w, p) in enumerate(zip(world.tolist(), pair.tolist(), strict=True)):
            first, second = (standings.contenders[c] for c in pairs_of(len(standings.contenders))[p])
            apart = "yes" if contest.apart[w, p] else "no"
            rows.append(
                (
                    *(column_head(measure), str(w), first, second, *texts[k]),
                    *probability(contest.better[w, p], *(end[w, p] for end in contest.better_ends)),
                    f"{(-1 if contest.low else 1) * contest.tests.balance[w, p] + 0.0:.2f}",
                    p_value(contest.tests.p[w, p]),
                    p_value(contest.corrected[w, p]),
                    f"{apart}, equal in practice" if equal[w, p] else apart,
                )
            )
    return rows
