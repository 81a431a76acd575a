"""A board as rows and as text: its brains, best first, and where brains of your own are."""

from collections.abc import Iterator, Sequence
from typing import Any

from rich.console import Console

from swarmcensus.evaluation.ranking.losses import Losses
from swarmcensus.evaluation.ranking.page import TAIL, cell
from swarmcensus.evaluation.ranking.scores import Scores
from swarmcensus.support import terminal
from swarmcensus.support.formatting import counted
from swarmcensus.support.printed_tables import NUMBER, Column, Table

LONGEST = 28  # letters of a contender's name in the table


def rows(scores: Scores) -> list[dict[str, Any]]:
    """A row for each contender in the order of the table, with error and share of right robots by kind of world."""
    found: list[dict[str, Any]] = []
    for place, k in _placed(scores):
        row: dict[str, Any] = {"place": place, "brain": scores.contenders[k], "rank": scores.error.ranks[k]}
        row["error_90"] = scores.tail[k]
        for score in (scores.error, scores.side):
            row[score.name] = score.by_world[:, k].mean()
            row[f"{score.name}_by_kind"] = dict(
                zip((column.name for column in scores.division.columns), score.values[k].tolist(), strict=True)
            )
        found.append(row | {name: values[k] for name, values in scores.costs.items()})
    return found


def flat(row: dict[str, Any]) -> dict[str, Any]:
    """A contender's row with a column for each kind of world, such as "final_error: networks"."""
    found = {name: value for name, value in row.items() if not isinstance(value, dict)}
    for name in (name for name in row if name not in found):
        found |= {f"{name.removesuffix('_by_kind')}: {kind}": value for kind, value in row[name].items()}
    return found


def as_text(name: str, scores: Scores, losses: Sequence[Losses], cautions: Sequence[str]) -> str:
    """The board as text of 120 columns."""
    return terminal.as_text(
        lambda out: print_board(name, scores, losses, cautions, out, "the property `table` has all")
    )


def print_board(
    name: str,
    scores: Scores,
    losses: Sequence[Losses],
    cautions: Sequence[str],
    out: Console,
    all_columns: str = "--json has all",
) -> None:
    """Print the board, what its columns mean, cautions, and where your own brains are.

    `all_columns` says where columns are that do not fit into a narrow console.
    """
    names = [column.name for column in scores.division.columns]
    shown = [names.index(name) for name in scores.division.shown]
    error, right = (score.by_world.mean(axis=0) for score in (scores.error, scores.side))
    placed = list(_placed(scores))
    order = [k for _, k in placed]
    kinds = [(names[c].replace(" liars", "\nliars"), scores.error.values[:, c]) for c in shown]  # to fit next to names
    columns = [
        Column("", ["" if place is None else f"{place}" for place, _ in placed]),
        Column("brain", shortened([scores.contenders[k] for k in order]), number=False),
        Column("rank", [f"{scores.error.ranks[k]:.1f}" * (k in scores.error.order) for k in order], spare=NUMBER),
        *(
            Column(head, [cell(values[k], True) for k in order])
            for head, values in [("error", error), (TAIL, scores.tail), *kinds]
        ),
        Column("right\n%", [cell(right[k], False) for k in order]),
        *(
            Column(head, [f"{scores.costs[f'{head}_bytes'][k]:.0f}" for k in order], spare=NUMBER + soon)
            for head, soon in (("memory", 1), ("message", 2))
        ),
    ]
    parts = f", and by kind: {' and '.join(scores.division.shown)}" if shown else ""
    notes = [
        f"board {name}: {scores.division.meaning}; error: |x - f| after the last round, mean over its "
        f"{counted(len(scores.worlds), 'world')}{parts}; "
        f"{TAIL}: nine of ten robots err no more; "
        "right: estimates on the same side of one half as f; memory, message: bytes"
    ]
    if bounds := [name for name in scores.contenders if name in scores.bounds]:
        notes.append(
            f"not ranked, as references that no robot can run: {', '.join(bounds)}; "
            "alone is ranked, as a robot can run it"
        )
    terminal.show(Table(columns, notes=lambda _: notes), out, all_columns)
    for sentence in sentences(losses, cautions):
        out.print(sentence)


def shortened(names: Sequence[str]) -> list[str]:
    """Names that leave room for numbers: long ones without their middle, if they still differ."""
    short = [name if len(name) <= LONGEST else f"{name[: LONGEST // 2]}…{name[1 - LONGEST // 2 :]}" for name in names]
    return short if len(set(short)) == len(names) else list(names)


def sentences(losses: Sequence[Losses], cautions: Sequence[str]) -> Iterator[str]:
    """Who is out of their range, and where each brain of your own is and where it loses most."""
    yield from (f"caution: {caution}" for caution in cautions)
    for one in losses:
        worst = one.columns[0]
        text = f"it loses most in '{worst.column}', to {worst.best} (number {worst.place} of {worst.of} there)"
        text = text if worst.place > 1 else "it is first in every kind of world"
        yield f"{one.name} is number {one.place} of {one.of}; {text}"


def _placed(scores: Scores) -> Iterator[tuple[int | None, int]]:
    """Place and number of each contender, the best first. The place is None for bounds, and for those without errors,
    which come last."""
    ranked, place = scores.error.order, 0
    for k in [*ranked, *(k for k in scores.side.order if k not in ranked)]:
        bound = scores.contenders[k] in scores.bounds
        place += not bound
        yield None if bound or k not in ranked else place, k
