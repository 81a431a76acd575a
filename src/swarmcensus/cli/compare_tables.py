"""The tables of `compare`: of worlds, of pairs or of groups of worlds, with a legend and the verdict."""

from collections.abc import Sequence
from typing import Any

import numpy as np
from rich.table import Table

from swarmcensus.basics.formatting import counted, grouped
from swarmcensus.basics.terminal import UNFOLDED, console, table
from swarmcensus.comparing.cells import (
    COSTS,
    MARKS,
    PAIR_HEADS,
    Cell,
    column_head,
    columns,
    legend,
    pair_rows,
    rows_of,
)
from swarmcensus.comparing.comparison import Comparison
from swarmcensus.comparing.groups import gap_name
from swarmcensus.comparing.pair_tests import test_count
from swarmcensus.comparing.standings import AGAINST, RANKED
from swarmcensus.results.summaries import is_idle
from swarmcensus.statistics.intervals import FEWEST


def show(comparison: Comparison, title: str, again: str, limit: int, with_pairs: bool) -> None:
    """Print the worlds of a comparison: as many as fit into `limit` rows, at least one (0: all), then the verdict.

    `again` is the shell line of the command. On a narrow terminal each measure has its own table.
    """
    out = console()
    worlds = _fitting(comparison, limit)
    world, contender = rows_of(comparison, worlds)
    first = np.append(True, world[1:] != world[:-1])
    names = list(comparison.grid.worlds[0])
    left = {"world": [str(w) if new else "" for w, new in zip(world, first, strict=True)]}
    for name in names:
        values = [comparison.grid.worlds[w][name] for w in world]
        texts = ["-" if is_idle(value) else grouped(value) for value in values]
        left[name] = [text if new else "" for text, new in zip(texts, first, strict=True)]
    left["contender"] = [comparison.contenders[c] for c in contender]
    if not names:
        del left["world"]
    cells = columns(comparison, worlds)
    pages = [_rows(left, cells)]
    if pages[0].__rich_measure__(out, out.options.update(max_width=UNFOLDED)).maximum > out.width:
        pages = [_rows(left, {name: column}) for name, column in cells.items()]
    out.print(title)
    for page in pages:
        out.print(page)
    for line in _legend(comparison, cells):
        out.print(line, style="dim")
    if worlds < len(comparison.grid.worlds):
        out.print(
            f"{worlds:,} of {counted(len(comparison.grid.worlds), 'world')}; show all: {again} --limit 0",
            soft_wrap=True,
        )
    if with_pairs:
        out.print()
        out.print(_pairs(comparison, worlds))
        for line in PAIRS:
            out.print(line, style="dim")
    _print_verdict(comparison)
    if not with_pairs:
        count = sum(int((~np.isnan(contest.corrected)).sum()) for contest in comparison.contests)
        out.print(
            f"to show all {count:,} differences with effects and p-values: {again} --pairs, or --csv FILE"
            if count > 1
            else f"to show the difference with its effect and p-value: {again} --pairs, or --csv FILE",
            soft_wrap=True,
        )


def _print_verdict(comparison: Comparison) -> None:
    """Print the verdict and its cautions."""
    out = console()
    out.print()
    for sentence in comparison.verdict:
        out.print(sentence)
    for caution in comparison.cautions:
        out.print(f"caution: {caution}", style="yellow")


PAIRS = (
    "one - other: median over trials of the difference (mean for shares and for messages and bytes); [95 %]: bootstrap "
    "over trials, for each pair separately",
    "effect: matched rank-biserial correlation, from -1 to 1, above 0 if the first is better",
    "p: paired signed-rank test, exact up to 64 trials; corrected: by Holm's method over all tests of this comparison",
)


def _fitting(comparison: Comparison, limit: int) -> int:
    """How many worlds fit into `limit` rows (0: all); at least one."""
    rows = np.cumsum((comparison.settings >= 0).sum(axis=1))
    return len(rows) if not limit else max(1, int(np.searchsorted(rows, limit, side="right")))


def _rows(left: dict[str, list[str]], cells: dict[str, list[Cell]]) -> Table:
    heads, texts = [(name, name == "world") for name in left], []
    for name, column in cells.items():
        wide, wider = (max(map(len, part), default=0) for part in list(zip(*column, strict=True))[:2])
        marked = any(cell.standing for cell in column)
        wide = max(wide, len(name) if wider else 0)
        heads.append((name + (f" {'[95 %]':>{wider}}" if wider else ""), True))
        texts.append(
            [
                f"{MARKS.get(cell.standing, ' ')} " * marked
                + f"{cell.value:>{wide}}" + f" {cell.interval:>{wider}}" * bool(wider)
                for cell in column
            ]
        )  # fmt: skip
    return table(heads, zip(*left.values(), *texts, strict=True))


def _pairs(comparison: Comparison, worlds: int) -> Table:
    texts = ("measure", "one", "other", "[95 %]", "one is better in", "told apart")
    rows: Sequence[tuple[str, ...]] = pair_rows(comparison, worlds)
    kept = [k for k, name in enumerate(PAIR_HEADS) if name != "world" or comparison.grid.worlds[0]]
    heads = [(PAIR_HEADS[k], PAIR_HEADS[k] not in texts) for k in kept]
    return table(heads, ([row[k] for k in kept] for row in rows))


def _legend(comparison: Comparison, cells: dict[str, list[Cell]]) -> list[str]:
    """The meaning of columns and marks, and the coordinates that all worlds share."""
    trials = comparison.contests[0].trials[comparison.settings >= 0]
    few = "; no intervals: fewer than 6 trials" if trials.max() < FEWEST else (
        "; [95 %]: bootstrap over trials; always: in every trial"
    )  # fmt: skip
    several = bool(trials.min() < trials.max())
    many = f"{trials.min():,} to " * several + counted(int(trials.max()), "trial")
    meanings = [
        f"{column_head(measure)}: {measure.meaning}"
        + f" ({measure.unit})" * (measure.unit not in ("1", "rounds", "observations"))
        for measure in comparison.measures
    ]
    tests = test_count(comparison.contests)
    same = [
        f"{name} {grouped(value)}" for name, value in comparison.grid.common.items()
        if not (is_idle(value) or (name == "link_success" and value == 1.0))
    ]  # fmt: skip
    costs = [name for name in COSTS.values() if name in cells]
    means = "means over robots and trials" if len(costs) > ("memory" in costs) else ""
    return [
        "; ".join(meanings),
        f"values: median over {many} of the median robot (means for shares and for messages and bytes){few}",
        *([f"{', '.join(costs)}: cost of a robot{f', {means}' * bool(means)}; memory in bytes"] if costs else []),
        f"{legend(comparison)}; {counted(tests, 'test')}, corrected by Holm's method",
        *([f"all with {', '.join(same)}"] if same else []),
    ]


Column = tuple[str, bool, list[str]]  # head, whether it holds numbers, cells


def show_groups(comparison: Comparison, title: str, again: str, axes: Sequence[str], limit: int) -> None:
    """Print one row per combination of values and contender, at most `limit` (0: all), then the verdict.

    `again` is the shell line of the command. On a narrow terminal each measure has its own table.
    """
    out = console()
    everything = comparison.by(*axes)
    rows = everything.head(limit or len(everything))
    left: list[Column] = [(name, False, _once(rows, axes[: k + 1])) for k, name in enumerate(axes)]
    left += [(name, name == "worlds", rows[name].map(str).tolist()) for name in ("contender", "worlds")]
    parts = [_columns(comparison, k, rows) for k in range(len(comparison.measures))]
    pages = [[*left, *(column for part in parts for column in part)]]
    if _table(pages[0]).__rich_measure__(out, out.options.update(max_width=UNFOLDED)).maximum > out.width:
        pages = [[*left, *part] for part in parts]
    out.print(title)
    for page in pages:
        out.print(_table(page))
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
    _print_verdict(comparison)


def _once(rows: Any, axes: Sequence[str]) -> list[str]:
    """The values of the last of these axes, shown only in the first of several rows that agree in all of them."""
    keys = rows[list(axes)].map(grouped).agg(" ".join, axis=1)
    return list(rows[axes[-1]].map(grouped).where(keys != keys.shift(), ""))


def _columns(comparison: Comparison, k: int, rows: Any) -> list[Column]:
    measure = comparison.measures[k]
    ways = RANKED if comparison.against is None else AGAINST
    heads = [f"{measure.label} " * (way == ways[0]) + MARKS.get(way, way) for way in ways]
    out: list[Column] = [
        (head, True, rows[f"{measure.name}_{way}"].map(grouped).tolist()) for head, way in zip(heads, ways, strict=True)
    ]
    if comparison.against is not None:
        for name in (gap_name(measure.share), "worst"):
            out.append((name, True, [_gap(value, measure.share) for value in rows[f"{measure.name}_{name}"]]))
    return out


def _table(columns: Sequence[Column]) -> Table:
    return table([(head, number) for head, number, _ in columns], zip(*(cells for *_, cells in columns), strict=True))


def _gap(value: float, share: bool) -> str:
    return "-" if np.isnan(value) else f"{100 * value:+.1f}" if share else f"x {value:.2f}"
