"""A comparison as it is shown: tables of its worlds, pairs and costs, the verdict; as text, HTML and LaTeX."""

from collections.abc import Sequence
from itertools import pairwise
from pathlib import Path

import numpy as np
from rich.console import Console

from swarmcensus.analysis.comparing.cells import (  # fmt: skip
    COSTS,
    PAIR_HEADS,
    RANK_SUM,
    column_head,
    columns,
    cost_columns,
    legend,
    pair_rows,
    range_text,
    rows_of,
)
from swarmcensus.analysis.comparing.pair_tests import test_count
from swarmcensus.analysis.comparing.standings import Standings
from swarmcensus.analysis.comparing.verdicts import findings, reading, verdict
from swarmcensus.results import OURS, is_idle
from swarmcensus.studies import goes_unsaid
from swarmcensus.support import terminal
from swarmcensus.support.files import atomic_write
from swarmcensus.support.formatting import ONE_SIDED, counted, grouped
from swarmcensus.support.intervals import FEWEST
from swarmcensus.support.printed_tables import FIRST_OUT, INTERVAL, INTERVALS, Column, Table, html, latex as as_latex

MOST_ROWS = 40
PROPERTY = "the property `table` has all"
PAIRS = (
    "one - other: median over trials of the difference (mean for shares and for messages and bytes); [95 %]: over "
    "trials, for each pair separately",
    "P(one better): the probability that the first is better in a random trial; equal ones count one half",
    "effect: rank-biserial correlation, from -1 to 1, above 0 if the first is better",
    "corrected: by Holm's method over all tests in single worlds",
)


def as_text(standings: Standings, width: int = terminal.WIDTH, limit: int | None = None) -> str:
    """The table of worlds, what its marks mean, the verdict and the cautions, as the terminal has them."""

    worlds = worlds_table(standings, MOST_ROWS if limit is None else limit, PROPERTY, standings.title)

    def print_on(out: Console) -> None:
        terminal.show(worlds, out, PROPERTY)
        print_verdict(standings, out)

    return terminal.as_text(print_on, width)


def as_html(standings: Standings) -> str:
    """The same for notebooks."""
    return html(worlds_table(standings, MOST_ROWS, PROPERTY, standings.title), said(standings))


def said(standings: Standings) -> list[str]:
    """The verdict and the cautions, a sentence each."""
    return [*verdict(standings), *(f"caution: {caution}" for caution in standings.cautions)]


def worlds_table(standings: Standings, limit: int, more: str, title: str = "") -> Table:
    """As many worlds as fit into `limit` rows, at least one (0: all), with what they share and what marks mean.

    Where all measures do not fit, each has its own table. `more` says where the worlds are that are left out.
    """
    worlds, total = fitting(standings, limit), len(standings.grid.worlds)
    measured = columns(standings, worlds)
    one_sided = Table(measured).has_one_sided
    return Table(
        _left(standings, worlds), [[column] for column in measured], title, _same(standings),
        lambda left_out: _meanings(standings, INTERVALS not in left_out, one_sided),
        f"{worlds:,} of {counted(total, 'world')}; {more}" * (worlds < total),
    )  # fmt: skip


def pairs_table(standings: Standings, worlds: int) -> Table:
    """Each pair of contenders in each of the first `worlds` worlds, by each measure."""
    texts = ("measure", "one", "other", INTERVAL, "told apart")
    rows: Sequence[tuple[str, ...]] = pair_rows(standings, worlds)
    spare = {INTERVAL: FIRST_OUT} | {name: k for k, name in enumerate(("p", "effect"), start=1)}
    return Table(
        [
            Column(name, [row[k] for row in rows], name not in texts, spare.get(name, 0))
            for k, name in enumerate(PAIR_HEADS)
            if name != "world" or standings.grid.worlds[0]
        ],
        notes=lambda _: [*PAIRS, _tests(standings)],
    )


def _tests(standings: Standings) -> str:
    """Which tests the p-values are of."""
    paired = np.concatenate([contest.paired[~np.isnan(contest.corrected)] for contest in standings.contests])
    signed, summed = "Wilcoxon's signed-rank test of paired trials", RANK_SUM
    return f"p: {signed if paired.all() else summed if not paired.any() else f'{signed}, {summed} of others'}"


def print_verdict(standings: Standings, out: Console) -> None:
    """Print the verdict, with costs as a table, and the cautions."""
    out.print()
    for sentence in findings(standings):
        out.print(sentence)
    if note := reading(standings):
        out.print(note, style="dim")
    costs = {COSTS[name]: values for name, values in (standings.costs | standings.sizes).items() if name in COSTS}
    if costs:
        heads = {standings.grid.head if standings.grid.factor else "cost of a robot": False}
        heads |= dict.fromkeys(costs, True)
        rows = ([name, *(range_text(values[:, k]) or "-" for values in costs.values())]
                for k, name in enumerate(standings.contenders))  # fmt: skip
        meaning = "messages and bytes: sent in a trial, means over robots and trials; memory: bytes"
        out.print()
        terminal.show(Table.of_rows(heads, rows, notes=lambda _: [meaning]), out)
    for caution in standings.cautions:
        out.print(f"caution: {caution}", style="yellow")


def latex(standings: Standings, worlds: int | None = None) -> str:
    """The table of the first `worlds` worlds, by default of all: a row for each world and contender.

    Marks are those of the terminal; the best, or better, values are bold. A comment explains them, for the caption.
    """
    total = len(standings.grid.worlds)
    worlds = total if worlds is None else worlds
    world, contender = (part.tolist() for part in rows_of(standings, worlds))
    new = [True, *(one != other for one, other in pairwise(world))]
    left = [
        Column(name, [("--" if is_idle(value) else str(value)) * first for value, first in
                      zip((standings.grid.worlds[w].get(name) for w in world), new, strict=True)], number=False)
        for name in standings.grid.worlds[0]
    ]  # fmt: skip
    return as_latex(Table(
        [*left, Column(standings.grid.head, [standings.contenders[c] for c in contender], number=False)],
        [columns(standings, worlds), cost_columns(standings, worlds)],
        f"{total:,} worlds, {len(standings.contenders):,} contenders: {standings.title}",
        notes=lambda _: [legend(standings)],
        blocks=[row for row, first in enumerate(new) if first and row],
    ))  # fmt: skip


def write_latex(standings: Standings, path: str | Path) -> None:
    """Write the table of all worlds, whole or not at all. Raises InputError."""
    with atomic_write(path) as temporary:
        temporary.write_text(latex(standings), encoding="utf-8")


def fitting(standings: Standings, limit: int) -> int:
    """How many worlds fit into `limit` rows (0: all); at least one."""
    rows = (standings.settings >= 0).sum(axis=1).cumsum()
    return len(rows) if not limit else max(1, int(rows.searchsorted(limit, side="right")))


def _same(standings: Standings) -> list[str]:
    """A line on the coordinates that all worlds share, if there are any."""
    texts = [
        f"{name} {grouped(value)}" for name, value in standings.grid.common.items()
        if not (is_idle(value) or goes_unsaid(name, value))
    ]  # fmt: skip
    return [f"all with {', '.join(texts)}"] * bool(texts)


def _meanings(standings: Standings, intervals: bool, one_sided: bool) -> list[str]:
    """What columns and marks mean; `intervals` says whether they are shown, `one_sided` whether some have one end."""
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
    heads += [f"{OURS[name].label}: {OURS[name].meaning} (median over trials, not tested)" for name in standings.tails]
    tests = test_count(standings.contests)
    return [
        "; ".join(heads),
        f"values: median over all robots of {many}, or over trials where each has one value (means for shares and for "
        f"messages and bytes){few}",
        *([f"[>= x]: {ONE_SIDED}"] if intervals and one_sided else []),
        f"{legend(standings)}; {counted(tests, 'test')}, corrected by Holm's method",
        *standings.pairing,
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
    return [*columns, Column(standings.grid.head, [standings.contenders[c] for c in contender], number=False)]
