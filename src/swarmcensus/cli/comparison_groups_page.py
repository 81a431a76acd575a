"""What the terminal shows of a comparison of many worlds: in how many of them a contender is how, axis by axis."""

from collections.abc import Sequence
from typing import Any

import numpy as np
from rich.table import Table

from swarmcensus.basics.counting import counted, grouped
from swarmcensus.basics.terminal import UNFOLDED, console, table
from swarmcensus.cli.compare_tables import tell
from swarmcensus.comparing.cells import MARKS, marks_of
from swarmcensus.comparing.comparison import Comparison
from swarmcensus.comparing.groups import gap_of
from swarmcensus.comparing.standings import AGAINST, RANKED

Column = tuple[str, bool, list[str]]  # its head, whether it has numbers, and its cells


def show(found: Comparison, title: str, again: str, axes: Sequence[str], limit: int) -> None:
    """Print a row for each combination of values and contender, `limit` at the most (0: all), then the verdict.

    `again` is the command that shows it. In a terminal that is too narrow, each measure has a table of its own.
    """
    out = console()
    everything = found.by(*axes)
    rows = everything.head(limit or len(everything))
    left: list[Column] = [(name, False, _once(rows, axes[: k + 1])) for k, name in enumerate(axes)]
    left += [(name, name == "worlds", rows[name].map(str).tolist()) for name in ("contender", "worlds")]
    parts = [_columns(found, k, rows) for k in range(len(found.measures))]
    pages = [[*left, *(column for part in parts for column in part)]]
    if _table(pages[0]).__rich_measure__(out, out.options.update(max_width=UNFOLDED)).maximum > out.width:
        pages = [[*left, *part] for part in parts]
    out.print(title)
    for page in pages:
        out.print(_table(page))
    out.print(f"in how many worlds: {marks_of(found)}", style="dim")
    if found.against is not None:
        mark = found.contenders[found.against]
        out.print(
            f"ratio: its value by that of {mark}, the median over worlds, and the worst "
            "(of shares: difference in points)",
            style="dim",
        )
    if len(rows) < len(everything):
        out.print(f"{len(rows):,} of {counted(len(everything), 'row')}; all of them: {again} --limit 0", soft_wrap=True)
    tell(found)


def _once(rows: Any, axes: Sequence[str]) -> list[str]:
    """What is said of an axis, in the first row of all that share it, and what stands left of it."""
    keys = rows[list(axes)].map(grouped).agg(" ".join, axis=1)
    return list(rows[axes[-1]].map(grouped).where(keys != keys.shift(), ""))


def _columns(found: Comparison, k: int, rows: Any) -> list[Column]:
    one = found.measures[k]
    ways = RANKED if found.against is None else AGAINST
    heads = [f"{one.label} " * (way == ways[0]) + MARKS.get(way, way) for way in ways]
    out: list[Column] = [
        (head, True, rows[f"{one.name}_{way}"].map(grouped).tolist()) for head, way in zip(heads, ways, strict=True)
    ]
    if found.against is not None:
        for name in (gap_of(one.share), "worst"):
            out.append((name, True, [_gap(value, one.share) for value in rows[f"{one.name}_{name}"]]))
    return out


def _table(columns: Sequence[Column]) -> Table:
    return table([(head, number) for head, number, _ in columns], zip(*(cells for *_, cells in columns), strict=True))


def _gap(value: float, share: bool) -> str:
    return "-" if np.isnan(value) else f"{100 * value:+.1f}" if share else f"x {value:.2f}"
