"""A comparison as Python shows it: the table of its worlds with marks and intervals, then its verdict."""

from pathlib import Path

from swarmcensus.basics.formatting import counted
from swarmcensus.basics.templates import render
from swarmcensus.comparing import table_text
from swarmcensus.comparing.standings import Standings
from swarmcensus.comparing.verdicts import verdict

MOST_ROWS = 40


def as_text(standings: Standings) -> str:
    """The table, what its marks mean, the verdict and the cautions, as the terminal has them."""
    return f"{standings.title}\n{table_text.as_text(standings, limit=MOST_ROWS)}"


def as_html(standings: Standings) -> str:
    """The same for notebooks."""
    worlds, total = table_text.fitting(standings, MOST_ROWS), len(standings.grid.worlds)
    columns = [column for part in table_text.world_columns(standings, worlds) for column in part]
    more = [f"{worlds:,} of {counted(total, 'world')}; {table_text.PROPERTY}"] if worlds < total else []
    return render(
        Path(__file__).with_name("comparison.html.jinja"), title=standings.title, columns=columns,
        rows=list(zip(*(column.cells for column in columns), strict=True)), above=table_text.same(standings),
        below=[*table_text.meanings(standings, worlds), *more], said=said(standings),
    )  # fmt: skip


def said(standings: Standings) -> list[str]:
    """The verdict and the cautions, a sentence each."""
    return [*verdict(standings), *(f"caution: {caution}" for caution in standings.cautions)]
