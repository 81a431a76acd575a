"""The tables of `compare`: of worlds, of pairs or of groups of worlds, with a legend and the verdict."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from swarmcensus.basics.formatting import counted, grouped
from swarmcensus.basics.terminal import FIRST_OUT, INTERVAL, Column, console, fits, fitted, left_out
from swarmcensus.comparing.cells import MARKS, PAIR_HEADS, legend, pair_rows
from swarmcensus.comparing.comparison import Comparison
from swarmcensus.comparing.groups import gap_name
from swarmcensus.comparing.standings import AGAINST, RANKED
from swarmcensus.comparing.table_text import fitting, print_verdict, print_worlds


def show(comparison: Comparison, title: str, again: str, limit: int, with_pairs: bool) -> None:
    """Print the worlds of a comparison: as many as fit into `limit` rows, at least one (0: all), then the verdict.

    `again` is the shell line of the command. On a narrow terminal each measure has its own table.
    """
    out = console()
    out.print(title)
    print_worlds(comparison, out, limit, "--json has all", f"show all: {again} --limit 0")
    if with_pairs:
        out.print()
        page, lacking = fitted(_pairs(comparison, fitting(comparison, limit)), out)
        out.print(page)
        for line in [*left_out(lacking, out), *PAIRS]:
            out.print(line, style="dim")
    print_verdict(comparison, out)
    if not with_pairs:
        count = sum(int((~np.isnan(contest.corrected)).sum()) for contest in comparison.contests)
        out.print(
            f"to show all {count:,} differences with effects and p-values: {again} --pairs, or --csv FILE"
            if count > 1
            else f"to show the difference with its effect and p-value: {again} --pairs, or --csv FILE",
            soft_wrap=True,
        )


PAIRS = (
    "one - other: median over trials of the difference (mean for shares and for messages and bytes); [95 %]: bootstrap "
    "over trials, for each pair separately",
    "effect: matched rank-biserial correlation, from -1 to 1, above 0 if the first is better",
    "p: paired signed-rank test, exact up to 64 trials; corrected: by Holm's method over all tests in single worlds",
)


def _pairs(comparison: Comparison, worlds: int) -> list[Column]:
    texts = ("measure", "one", "other", INTERVAL, "one is better in", "told apart")
    rows: Sequence[tuple[str, ...]] = pair_rows(comparison, worlds)
    spare = {INTERVAL: FIRST_OUT} | {name: k for k, name in enumerate(("p", "effect", "one is better in"), start=1)}
    return [
        Column(name, [row[k] for row in rows], name not in texts, spare.get(name, 0))
        for k, name in enumerate(PAIR_HEADS)
        if name != "world" or comparison.grid.worlds[0]
    ]


def show_groups(comparison: Comparison, title: str, again: str, axes: Sequence[str], limit: int) -> None:
    """Print one row per combination of values and contender, at most `limit` (0: all), then the verdict.

    `again` is the shell line of the command. On a narrow terminal each measure has its own table.
    """
    out = console()
    everything = comparison.by(*axes)
    rows = everything.head(limit or len(everything))
    left = [Column(name, _once(rows, axes[: k + 1]), number=False) for k, name in enumerate(axes)]
    left += [Column(name, rows[name].map(str).tolist(), name == "worlds") for name in ("contender", "worlds")]
    parts = [_columns(comparison, k, rows) for k in range(len(comparison.measures))]
    together, _ = fitted([*left, *(column for part in parts for column in part)], out)
    pages = [together] if fits(together, out) else [fitted([*left, *part], out)[0] for part in parts]
    out.print(title)
    for page in pages:
        out.print(page)
    out.print(f"number of worlds: {legend(comparison)}", style="dim")
    if comparison.against is not None:
        reference = comparison.contenders[comparison.against]
        out.print(
            f"ratio: its value divided by that of {reference}, median over worlds, and the worst "
            "(for shares: difference in percentage points)",
            style="dim",
        )
    if len(rows) < len(everything):
        out.print(f"{len(rows):,} of {counted(len(everything), 'row')}; show all: {again} --limit 0", soft_wrap=True)
    print_verdict(comparison, out)


def _once(rows: Any, axes: Sequence[str]) -> list[str]:
    """The values of the last of these axes, shown only in the first of several rows that agree in all of them."""
    keys = rows[list(axes)].map(grouped).agg(" ".join, axis=1)
    return list(rows[axes[-1]].map(grouped).where(keys != keys.shift(), ""))


def _columns(comparison: Comparison, k: int, rows: Any) -> list[Column]:
    measure = comparison.measures[k]
    ways = RANKED if comparison.against is None else AGAINST
    heads = [f"{measure.label} " * (way == ways[0]) + MARKS.get(way, way) for way in ways]
    out: list[Column] = [
        Column(head, rows[f"{measure.name}_{way}"].map(grouped).tolist()) for head, way in zip(heads, ways, strict=True)
    ]
    if comparison.against is not None:
        for name in (gap_name(measure.share), "worst"):
            out.append(Column(name, [_gap(value, measure.share) for value in rows[f"{measure.name}_{name}"]]))
    return out


def _gap(value: float, share: bool) -> str:
    return "-" if np.isnan(value) else f"{100 * value:+.1f}" if share else f"x {value:.2f}"
