"""The tables of `compare`: of worlds, of pairs or of groups of worlds, with a legend and the verdict."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from swarmcensus.analysis import (
    AGAINST,
    MARKS,
    RANKED,
    Comparison,
    fitting,
    gap_name,
    legend,
    pairs_table,
    print_verdict,
    test_count,
    worlds_table,
)
from swarmcensus.support import terminal
from swarmcensus.support.formatting import counted, grouped
from swarmcensus.support.printed_tables import Column, Table


def show(
    comparison: Comparison, title: str, again: str, limit: int, with_pairs: bool, with_sentences: bool = False
) -> None:
    """Print the worlds of a comparison: as many as fit into `limit` rows, at least one (0: all), then the verdict.

    A table of pairs and sentences on them follow if wanted. `again` is the shell line of the command. On a narrow
    terminal each measure has its own table.
    """
    out = terminal.console()
    terminal.show(worlds_table(comparison, limit, f"show all: {again} --limit 0", title), out)
    if with_pairs:
        out.print()
        terminal.show(pairs_table(comparison, fitting(comparison, limit)), out)
    print_verdict(comparison, out)
    if with_sentences:
        out.print()
        for sentence in comparison.sentences:
            out.print(sentence, soft_wrap=True)
    if not with_pairs:
        count = test_count(comparison.contests)
        out.print(
            f"to show all {count:,} differences with effects and p-values: {again} --pairs, or --csv FILE"
            if count > 1
            else f"to show the difference with its effect and p-value: {again} --pairs, or --csv FILE",
            soft_wrap=True,
        )


def show_groups(comparison: Comparison, title: str, again: str, axes: Sequence[str], limit: int) -> None:
    """Print one row per combination of values and contender, at most `limit` (0: all), then the verdict.

    `again` is the shell line of the command. On a narrow terminal each measure has its own table.
    """
    everything = comparison.by(*axes)
    rows = everything.head(limit or len(everything))
    left = [Column(name, _once(rows, axes[: k + 1]), number=False) for k, name in enumerate(axes)]
    left += [Column(name, rows[name].map(str).tolist(), name == "worlds") for name in ("contender", "worlds")]
    notes = [f"number of worlds: {legend(comparison)}"]
    if comparison.against is not None:
        reference = comparison.contenders[comparison.against]
        notes.append(
            f"ratio: its value divided by that of {reference}, median over worlds, and the worst "
            "(for shares: difference in percentage points)"
        )
    more = f"{len(rows):,} of {counted(len(everything), 'row')}; show all: {again} --limit 0"
    parts = [_columns(comparison, k, rows) for k in range(len(comparison.measures))]
    out = terminal.console()
    terminal.show(Table(left, parts, title, notes=lambda _: notes, more=more * (len(rows) < len(everything))), out)
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
