"""The table of a comparison as text: a row for each world and contender, and once what each contender costs."""

import io
from itertools import pairwise

from rich.console import Console
from rich.table import Table

from swarmcensus.basics.formatting import counted, grouped
from swarmcensus.basics.terminal import FIRST_OUT, INTERVAL, INTERVALS, Column, console, fits, fitted, left_out
from swarmcensus.basics.terminal import table as table_of
from swarmcensus.comparing.cells import COSTS, MARKS, Cell, column_head, columns, range_text, rows_of
from swarmcensus.comparing.standings import Standings
from swarmcensus.results.summaries import is_idle

MOST_ROWS = 40
WIDTH = 120


def table_text(standings: Standings, width: int = WIDTH, limit: int = MOST_ROWS) -> str:
    """The table of a comparison as text, of as many worlds as fit into `limit` rows (0: all).

    Above it is what all worlds share, below it what was left out to fit into `width` columns, and the costs.
    """
    text = io.StringIO()
    out = console(file=text, width=width, force_jupyter=False, force_terminal=False)  # a kernel claims to be both
    worlds = fitting(standings, limit)
    for line in same(standings):
        out.print(line)
    tables, lacking = world_tables(standings, worlds, out)
    for page in tables:
        out.print(page)
    for line in left_out(lacking, out, "the property `table` has all"):
        out.print(line)
    if worlds < len(standings.grid.worlds):
        out.print(f"{worlds:,} of {counted(len(standings.grid.worlds), 'world')}")
    if costs := cost_table(standings):
        out.print()
        out.print(costs)
    return "\n".join(line.rstrip() for line in text.getvalue().splitlines())


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
    left, cells = _left(standings, worlds), columns(standings, worlds)
    measured = [_values(name, cells[name]) for name in map(column_head, standings.measures)]
    together, lacking = fitted([*left, *(column for columns in measured for column in columns)], out)
    if fits(together, out) and {*lacking} <= {INTERVALS}:
        return [together], lacking
    pages = [fitted([*left, *columns], out) for columns in measured]
    return [page for page, _ in pages], list(dict.fromkeys(name for _, names in pages for name in names))


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
