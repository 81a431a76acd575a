"""The tables of a comparison for people: of its worlds, pairs, and groups of worlds."""

from collections.abc import Collection, Sequence
from itertools import pairwise

import numpy as np

from swarmcensus.analysis.comparing.cells import (
    TESTS,
    amount,
    column_head,
    numbers,
    p_value,
    probability,
)
from swarmcensus.analysis.comparing.pair_tests import number_of_tests
from swarmcensus.analysis.comparing.standings import Standings
from swarmcensus.analysis.comparing.tables import Frames
from swarmcensus.summaries import TAIL_QUANTITY, value_text, world_text
from swarmcensus.support.formatting import ONE_SIDED, counted, grouped
from swarmcensus.support.intervals import FEWEST
from swarmcensus.support.printed_tables import ASKED, INTERVALS, REST, STAYS, Column, Table
from swarmcensus.support.quantities import QUANTITIES

MARKS = {"best": "*", "better": "+", "worse": "-", "level": "="}
COSTS = {name: QUANTITIES[name].title for name in (TAIL_QUANTITY, "messages_sent", "bytes_sent", "memory_bytes")}
DIFFERENCE = (
    "median of the differences of trials' medians; if not paired, difference of the medians of trials' medians (means "
    "for shares and for messages and bytes); [95 %]: over trials, for each pair separately"
)
BETTER = "the probability that the first is better in a random trial; equal ones count one half"
EFFECT = "rank-biserial correlation, from -1 to 1, above 0 if the first is better"


def worlds_table(standings: Standings, limit: int) -> Table:
    """A row for each world and contender: as many worlds as fit into `limit` rows, at least one (0: all).

    The best, or better, values are strong. Of equal worlds only the first row is named.
    """
    worlds, (every, _) = standings.grid.worlds, np.nonzero(standings.settings >= 0)
    kept = max(int(every[limit]), 1) if 0 < limit < len(every) else len(worlds)
    world, contender = at = np.nonzero(standings.settings[:kept] >= 0)
    first = [True, *(one != other for one, other in pairwise(world.tolist()))]

    def once(texts: Sequence[str]) -> list[str]:
        return [texts[w] * new for w, new in zip(world.tolist(), first, strict=True)]

    columns = [Column("world", once([str(w) for w in range(kept)]), name="world")] * bool(worlds[0])
    for name in worlds[0]:
        texts = [value_text(name, each[name]) for each in worlds[:kept]]
        columns.append(Column(name, once(texts), number=False, name=name))
    names = [standings.contenders[c] for c in contender.tolist()]
    columns.append(Column(standings.grid.head, names, number=False, rank=STAYS, name="contender"))
    for measure, contest in zip(standings.measures, standings.contests, strict=True):
        with_ends = (part[at] for part in (contest.values, *contest.value_ends))
        shown = numbers(with_ends, contest.trials[at], measure)
        ways = standings.standing(contest)[at].tolist()
        unit = f" ({measure.unit})" * (measure.unit not in ("1", "rounds", "observations"))
        columns.append(Column(
            column_head(measure), [text for text, _ in shown], intervals=[ends for _, ends in shown],
            rank=ASKED if measure.name in standings.asked else REST, marks=[MARKS.get(way, "") for way in ways],
            strong=[way in ("best", "better") for way in ways], name=measure.name, unit=measure.unit,
            meaning=measure.meaning + unit,
        ))  # fmt: skip
    measured = [measure.name for measure in standings.measures]
    for name in COSTS:
        if name in standings.costs and name not in measured:
            texts = [amount(value) for value in standings.costs[name][at].tolist()]
            meaning = QUANTITIES[name].compared or QUANTITIES[name].meaning
            columns.append(Column(COSTS[name], texts, rank=REST, name=name, meaning=meaning))
    same = world_text(standings.grid.common)
    one_sided = {column.head for column in columns if Table([column]).has_one_sided}
    return Table(
        columns, above=[f"all with {same}"] * bool(same), notes=lambda left_out: _notes(standings, left_out, one_sided),
        more=f"{kept:,} of {counted(len(worlds), 'world')}" * (kept < len(worlds)),
    )  # fmt: skip


def pairs_table(frames: Frames) -> Table:
    """A row for each pair of contenders in each world, by each measure."""
    rows, heads, differences = frames.pairs, list[str](), list[tuple[str, str]]()
    for measure in frames.measures:
        part = rows[rows["measure"] == measure.name]
        heads += [column_head(measure)] * len(part)
        ends = (part[f"difference{end}"].to_numpy() for end in ("", "_low", "_high"))
        trials = part[["trials", "other_trials"]].min(axis=1).to_numpy()
        differences += numbers(ends, trials, measure, differences=True)
    chances = [*map(probability, rows["superiority"], rows["superiority_low"], rows["superiority_high"])]
    apart = [("yes" if one else "no") + ", equal in practice" * equal
             for one, equal in zip(rows["told_apart"], rows["equal_in_practice"], strict=True)]  # fmt: skip

    tests = [text for name, text in TESTS.items() if name in {*rows["test"]}]
    tested = ", ".join(tests) + " of others" * (len(tests) > 1)
    corrected = f"{tested}, corrected by Holm's method over all tests in single worlds"
    columns = [
        Column("measure", heads, number=False, name="measure"),
        *([Column("world", [*map(str, rows["world"])], name="world")] if frames.grid.worlds[0] else []),
        *(Column(name, [*rows[name]], number=False, rank=STAYS, name=name) for name in ("one", "other")),
        Column("one - other", [t for t, _ in differences], rank=ASKED, intervals=[ends for _, ends in differences],
               name="difference", meaning=DIFFERENCE),
        Column("P(one better)", [t for t, _ in chances], rank=REST, intervals=[ends for _, ends in chances],
               name="superiority", meaning=BETTER),
        Column("effect", [f"{effect:.2f}" for effect in rows["effect"]], rank=REST, name="effect", meaning=EFFECT),
        Column("p", [*map(p_value, rows["p"])], rank=REST, name="p", meaning="before correction"),
        Column("corrected p", [*map(p_value, rows["p_holm"])], rank=ASKED, name="p_holm", meaning=corrected),
        Column("told apart", apart, number=False, name="told_apart"),
    ]  # fmt: skip
    return Table(columns)


def groups_table(frames: Frames, axes: Sequence[str]) -> Table:
    """A row for each combination of values and contender: the numbers of standings."""
    rows = frames.by(*axes)
    columns, new = [], np.zeros(len(rows), np.bool_)
    for name in axes:  # values are shown only in the first of several rows that agree in all axes so far
        values = rows[name].map(lambda value, name=name: value_text(name, value))
        new |= (values != values.shift()).to_numpy()
        columns.append(Column(name, [*values.where(new, "")], number=False, name=name))
    columns.append(Column("contender", [*rows["contender"]], number=False, rank=STAYS, name="contender"))
    columns.append(Column("worlds", [*map(grouped, rows["worlds"])], name="worlds"))
    for measure in frames.measures:
        rank = ASKED if measure.name in frames.asked else REST
        for way in frames.ways:
            name = f"{measure.name}_{way}"
            texts = [*map(grouped, rows[name])]
            columns.append(Column(f"{measure.label} {MARKS.get(way, way)}", texts, rank=rank, name=name))
    return Table(columns, notes=lambda _: [f"number of worlds: {_legend(frames)}"])


def _legend(standings: Standings) -> str:
    """The meaning of the marks."""
    if standings.against is None:
        return "* best in its world, told apart from all others; = first, or not told apart from the first"
    return f"+ better, - worse than {standings.contenders[standings.against]}, and told apart from it; = not told apart"


def _notes(standings: Standings, left_out: Collection[str], one_sided: set[str]) -> list[str]:
    """What values, intervals and marks mean; `one_sided` are the columns with intervals of one end."""
    intervals, trials = INTERVALS not in left_out, standings.contests[0].trials[standings.settings >= 0]
    over = "[95 %]: over trials" * intervals if trials.max() >= FEWEST else f"no intervals: fewer than {FEWEST} trials"
    many = f"{trials.min():,} to " * bool(trials.min() < trials.max()) + counted(int(trials.max()), "trial")
    return [
        f"values: median over all robots of {many}, or over trials where each has one value (means for shares and for "
        f"messages and bytes){f'; {over}' * bool(over)}",
        *([f"[>= x]: {ONE_SIDED}"] if intervals and one_sided - {*left_out} else []),
        f"{_legend(standings)}; {counted(number_of_tests(standings.contests), 'test')}, corrected by Holm's method",
        *standings.pairing,
    ]
