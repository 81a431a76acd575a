"""A comparison as Python shows it: the table of its worlds with marks and intervals, then its verdict."""

from pathlib import Path

import numpy as np

from swarmcensus.basics.formatting import counted, grouped
from swarmcensus.basics.templates import render
from swarmcensus.comparing.cells import MARKS, columns, legend, rows_of
from swarmcensus.comparing.standings import Standings
from swarmcensus.comparing.verdicts import verdict
from swarmcensus.results.summaries import is_idle

MOST_ROWS = 60


def as_text(standings: Standings) -> str:
    """The table, what its marks mean, the verdict and the cautions."""
    worlds = _fitting(standings)
    texts = _texts(standings, worlds)
    widths = [max(map(len, (head, *column))) for head, column in texts.items()]
    rows = [list(texts), *zip(*texts.values(), strict=True)]
    shown = ("  ".join(map(str.ljust, row, widths)).rstrip() for row in rows)
    return "\n".join([standings.title, *shown, *_below(standings, worlds), "", *said(standings)])


def as_html(standings: Standings) -> str:
    """The same for notebooks."""
    worlds = _fitting(standings)
    texts = _texts(standings, worlds)
    return render(
        Path(__file__).with_name("comparison.html.jinja"), title=standings.title, heads=list(texts),
        rows=list(zip(*texts.values(), strict=True)), below=_below(standings, worlds), said=said(standings),
    )  # fmt: skip


def said(standings: Standings) -> list[str]:
    """The verdict and the cautions, a sentence each."""
    return [*verdict(standings), *(f"caution: {caution}" for caution in standings.cautions)]


def _fitting(standings: Standings) -> int:
    """How many worlds are shown."""
    rows = np.cumsum((standings.settings >= 0).sum(axis=1))
    return max(1, int(np.searchsorted(rows, MOST_ROWS, side="right")))


def _texts(standings: Standings, worlds: int) -> dict[str, list[str]]:
    """Columns with a text for each world and contender; a world's coordinates stand in its first row alone."""
    world, contender = rows_of(standings, worlds)
    first = np.append(True, world[1:] != world[:-1])
    texts: dict[str, list[str]] = {}
    for name in standings.grid.worlds[0]:
        values = [standings.grid.worlds[w][name] for w in world]
        shown = ["-" if is_idle(value) else grouped(value) for value in values]
        texts[name] = [text if new else "" for text, new in zip(shown, first, strict=True)]
    texts["contender"] = [standings.contenders[c] for c in contender]
    for head, cells in columns(standings, worlds).items():
        value, interval = (max(len(cell[part]) for cell in cells) for part in (0, 1))
        texts[head] = [
            f"{MARKS.get(cell.standing, ' ')} {cell.value:>{value}} {cell.interval:>{interval}}".rstrip()
            for cell in cells
        ]
    return texts


def _below(standings: Standings, worlds: int) -> list[str]:
    """What a reader of the table needs to know."""
    total = len(standings.grid.worlds)
    more = [f"the first {worlds:,} of {counted(total, 'world')}; its table has all"] if worlds < total else []
    meanings = "; ".join(f"{measure.label}: {measure.meaning}" for measure in standings.measures)
    return [*more, meanings, f"{legend(standings)}; [95 % interval] over trials"]
