"""A board as rows and as text: its brains, best first, and where brains of your own are."""

import io
from collections.abc import Iterator, Sequence
from typing import Any

from rich.console import Console

from swarmcensus.basics.formatting import counted
from swarmcensus.basics.terminal import NUMBER, Column, console, fitted, left_out
from swarmcensus.ranking.losses import Losses
from swarmcensus.ranking.page import cell
from swarmcensus.ranking.scores import Scores

WIDTH = 120


def rows(scores: Scores) -> list[dict[str, Any]]:
    """A row for each contender in the order of the table, with error and share of right robots by kind of world."""
    found: list[dict[str, Any]] = []
    for place, k in _placed(scores):
        row: dict[str, Any] = {"place": place, "brain": scores.contenders[k], "rank": scores.error.ranks[k]}
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


def as_text(name: str, scores: Scores, losses: Sequence[Losses]) -> str:
    """The board as text of 120 columns."""
    text = io.StringIO()
    out = console(file=text, width=WIDTH, force_jupyter=False, force_terminal=False)  # a kernel claims to be both
    print_board(name, scores, losses, out, "the property `table` has all")
    return "\n".join(line.rstrip() for line in text.getvalue().splitlines())


def print_board(
    name: str, scores: Scores, losses: Sequence[Losses], out: Console, all_columns: str = "--json has all"
) -> None:
    """Print the board, what its columns mean, and where your own brains are.

    `all_columns` says where columns are that do not fit into a narrow console.
    """
    names = [column.name for column in scores.division.columns]
    shown = [names.index(name) for name in scores.division.shown]
    error, right = (score.by_world.mean(axis=0) for score in (scores.error, scores.side))
    cells = []
    for place, k in _placed(scores):
        ranked = k in scores.error.order
        cells.append([
            "" if place is None else f"{place}",
            scores.contenders[k],
            f"{scores.error.ranks[k]:.1f}" if ranked else "",
            *(cell(value, True) for value in (error[k], *scores.error.values[k, shown])),
            cell(right[k], False),
            *(f"{scores.costs[name][k]:.0f}" for name in ("memory_bytes", "message_bytes")),
        ])  # fmt: skip
    kinds = (names[k].replace(" liars", "\nliars") for k in shown)  # in two lines, so that long names fit beside them
    heads = ("", "brain", "rank", "error", *kinds, "right\n%", "memory", "message")
    spare = {"message": NUMBER + 2, "memory": NUMBER + 1, "rank": NUMBER}
    columns = [
        Column(head, [row[k] for row in cells], head != "brain", spare.get(head, 0)) for k, head in enumerate(heads)
    ]
    page, lacking = fitted(columns, out)
    out.print(page)
    for line in left_out(lacking, out, all_columns):
        out.print(line)
    parts = f", and by kind: {' and '.join(scores.division.shown)}" if shown else ""
    out.print(
        f"board {name}: {scores.division.meaning}; error: |x - f| after the last round, mean over its "
        f"{counted(len(scores.worlds), 'world')}{parts}; "
        "right: estimates on the same side of one half as f; memory, message: bytes"
    )
    if bounds := [name for name in scores.contenders if name in scores.bounds]:
        out.print(
            f"not ranked, as bounds that no robot can reach: {', '.join(bounds)}; "
            "alone is ranked, as a robot can run it"
        )
    for sentence in sentences(losses):
        out.print(sentence)


def sentences(losses: Sequence[Losses]) -> Iterator[str]:
    """Where each brain of your own is, and where it loses most."""
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
