"""A comparison as text: a table with a row for each world and contender, the verdict, and what each contender costs."""

import io
from itertools import pairwise

from rich.console import Console
from rich.table import Table

from swarmcensus.basics.formatting import ONE_SIDED, counted, grouped
from swarmcensus.basics.terminal import FIRST_OUT, INTERVAL, INTERVALS, Column, console, fits, fitted, left_out
from swarmcensus.basics.terminal import table as table_of
from swarmcensus.comparing.cells import COSTS, MARKS, Cell, column_head, columns, legend, one_sided, range_text, rows_of
from swarmcensus.comparing.pair_tests import test_count
from swarmcensus.comparing.standings import Standings
from swarmcensus.comparing.verdicts import findings
from swarmcensus.results.summaries import is_idle
from swarmcensus.statistics.intervals import FEWEST

WIDTH = 120
PROPERTY = "the property `table` has all"


def as_text(standings: Standings, width: int = WIDTH, limit: int = 0) -> str:
    """The worlds of a comparison and its verdict as text of `width` columns; `limit` as in `print_worlds`."""
    text = io.StringIO()
    out = console(file=text, width=width, force_jupyter=False, force_terminal=False)  # a kernel claims to be both
    print_worlds(standings, out, limit, PROPERTY, PROPERTY)
    print_verdict(standings, out)
    return "\n".join(line.rstrip() for line in text.getvalue().splitlines())


def print_worlds(standings: Standings, out: Console, limit: int, all_columns: str, all_worlds: str) -> None:
    """Print as many worlds as fit into `limit` rows, at least one (0: all), with what they share and what marks mean.

    In a narrow console each measure has its own table. `all_columns` and `all_worlds` say where what is left out is.
    """
    worlds = fitting(standings, limit)
    tables, lacking = world_tables(standings, worlds, out)
    for line in same(standings):
        out.print(line, style="dim")
    for page in tables:
        out.print(page)
    for line in [*left_out(lacking, out, all_columns), *meanings(standings, worlds, INTERVALS not in lacking)]:
        out.print(line, style="dim")
    if worlds < len(standings.grid.worlds):
        out.print(f"{worlds:,} of {counted(len(standings.grid.worlds), 'world')}; {all_worlds}", soft_wrap=True)


def print_verdict(standings: Standings, out: Console) -> None:
    """Print the verdict, with costs as a table, and the cautions."""
    out.print()
    for sentence in findings(standings):
        out.print(sentence)
    if costs := cost_table(standings):
        out.print()
        out.print(costs)
        out.print("messages and bytes: sent in a trial, means over robots and trials; memory: bytes", style="dim")
    for caution in standings.cautions:
        out.print(f"caution: {caution}", style="yellow")


def fitting(standings: Standings, limit: int) -> int:
    """How many worlds fit into `limit` rows (0: all); at least one."""
    rows = (standings.settings >= 0).sum(axis=1).cumsum()
    return len(rows) if not limit else max(1, int(rows.searchsorted(limit, side="right")))


def same(standings: Standings) -> list[str]:
    """A line on the coordinates that all worlds share, if there are any."""
    texts = [
        f"{name} {grouped(value)}" for name, value in standings.grid.common.items()
        if not (is_idle(value) or (name == "link_success" and value == 1.0))
    ]  # fmt: skip
    return [f"all with {', '.join(texts)}"] * bool(texts)


def world_tables(standings: Standings, worlds: int, out: Console) -> tuple[list[Table], list[str]]:
    """The table of the first `worlds` worlds, or one for each measure if all together are too wide for `out`.

    The names are of what was left out so that it fits.
    """
    left, *measured = world_columns(standings, worlds)
    together, lacking = fitted([*left, *(column for columns in measured for column in columns)], out)
    if fits(together, out) and {*lacking} <= {INTERVALS}:
        return [together], lacking
    pages = [fitted([*left, *columns], out) for columns in measured]
    return [page for page, _ in pages], list(dict.fromkeys(name for _, names in pages for name in names))


def world_columns(standings: Standings, worlds: int) -> list[list[Column]]:
    """The columns that say which world and contender a row is of, and then those of each measure."""
    cells = columns(standings, worlds)
    return [
        _left(standings, worlds),
        *(_values(name, cells[name]) for name in map(column_head, standings.measures)),
    ]


def meanings(standings: Standings, worlds: int, intervals: bool = True) -> list[str]:
    """What the columns and marks of the first `worlds` worlds mean; `intervals` says whether they are shown."""
    trials = standings.contests[0].trials[standings.settings >= 0]
    few = "; no intervals: fewer than 6 trials" if trials.max() < FEWEST else (
        "; [95 %]: over trials" * intervals
    )  # fmt: skip
    several = bool(trials.min() < trials.max())
    many = f"{trials.min():,} to " * several + counted(int(trials.max()), "trial")
    heads = [
        f"{column_head(measure)}: {measure.meaning}"
        + f" ({measure.unit})" * (measure.unit not in ("1", "rounds", "observations"))
        for measure in standings.measures
    ]
    tests = test_count(standings.contests)
    return [
        "; ".join(heads),
        f"values: median over all robots of {many} (means for shares and for messages and bytes){few}",
        *([f"[>= x]: {ONE_SIDED}"] if intervals and one_sided(standings, worlds) else []),
        f"{legend(standings)}; {counted(tests, 'test')}, corrected by Holm's method",
    ]


def _left(standings: Standings, worlds: int) -> list[Column]:
    """The columns that say which world and contender a row is of; of equal worlds only the first row is named."""
    world, contender = (part.tolist() for part in rows_of(standings, worlds))
    new = [True, *(one != other for one, other in pairwise(world))]
    names = list(standings.grid.worlds[0])
    columns = [Column("world", [str(w) * first for w, first in zip(world, new, strict=True)])] * bool(names)
    for k, name in enumerate(names, start=1):
        values = [standings.grid.worlds[w][name] for w in world]
        texts = ["-" if is_idle(value) else grouped(value) for value in values]
        shown = [text * first for text, first in zip(texts, new, strict=True)]
        columns.append(Column(name, shown, number=False, spare=k))
    return [*columns, Column("contender", [standings.contenders[c] for c in contender], number=False)]


def _values(name: str, cells: list[Cell]) -> list[Column]:
    """The column of a measure with its marks, and that of its intervals if it has any."""
    marked = any(cell.standing for cell in cells)
    wide = max(len(cell.value) for cell in cells)
    values = [f"{MARKS.get(cell.standing, ' ')} " * marked + f"{cell.value:>{wide}}" for cell in cells]
    intervals = Column(INTERVAL, [cell.interval for cell in cells], spare=FIRST_OUT)
    return [Column(name, values), *[intervals] * any(cell.interval for cell in cells)]


def cost_table(standings: Standings) -> Table | None:
    """What a robot of each contender costs, as a range if worlds differ; None if the results do not say."""
    costs = {COSTS[name]: values for name, values in (standings.costs | standings.sizes).items() if name in COSTS}
    if not costs:
        return None
    rows = (
        [name, *(range_text(values[:, k]) or "-" for values in costs.values())]
        for k, name in enumerate(standings.contenders)
    )
    return table_of([("cost of a robot", False), *((name, True) for name in costs)], rows)
