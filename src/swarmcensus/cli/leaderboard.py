"""The command `leaderboard`: brains of one's own beside the shipped ones. Imports wait until needed."""

import argparse
from pathlib import Path
from typing import TYPE_CHECKING, Any

from swarmcensus.cli.options import add_run_options
from swarmcensus.cli.output import answer, reporting, say, wrote

if TYPE_CHECKING:
    from collections.abc import Iterator

    from swarmcensus.leaderboard.board import Board
    from swarmcensus.leaderboard.scores import Scores


def add_leaderboard_options(sub: argparse.ArgumentParser) -> None:
    """Of `leaderboard`."""
    sub.add_argument("files", type=Path, nargs="*", metavar="FILE.py", help="a brain file of your own")
    sub.add_argument("--out", type=Path, default=Path("leaderboard"), help="folder to write (default: %(default)s)")
    add_run_options(sub)


def leaderboard(options: argparse.Namespace) -> int:
    """Run the leaderboard and print its top, and where brains of one's own lose."""
    from swarmcensus.leaderboard.board import leaderboard

    board = leaderboard(
        options.files, options.out, trials=options.trials, seed=options.seed, jobs=options.jobs, fresh=options.fresh,
        reporting=reporting, say=say,
    )  # fmt: skip
    if options.json:
        answer("leaderboard", _told(board))
    else:
        _show(board)
    wrote(board.page)
    return 0


def _told(board: "Board") -> dict[str, Any]:
    """A row a brain in the order of the table, with its error and its share of right robots in every kind of world."""
    from swarmcensus.leaderboard.scores import COLUMNS

    scores = board.scores
    rows: list[dict[str, Any]] = []
    for place, k in _placed(scores):
        row: dict[str, Any] = {"place": place, "brain": scores.contenders[k], "rank": scores.error.ranks[k]}
        for score in (scores.error, scores.side):
            row[score.name] = score.by_world[:, k].mean()
            row[f"{score.name}_by_kind"] = dict(
                zip((column.name for column in COLUMNS), score.values[k].tolist(), strict=True)
            )
        rows.append(row | {name: values[k] for name, values in scores.costs.items()})
    return {"worlds": len(scores.worlds), "brains": rows, "losses": board.losses, "page": board.page}


def _placed(scores: "Scores") -> "Iterator[tuple[int | None, int]]":
    """Each contender's place and number, the best first: None for bounds, and for those without errors, at the end."""
    ranked, place = scores.error.order, 0
    for k in [*ranked, *(k for k in scores.side.order if k not in ranked)]:
        bound = scores.contenders[k] in scores.bounds
        place += not bound
        yield None if bound or k not in ranked else place, k


def _show(board: "Board") -> None:
    from swarmcensus.basics.terminal import console, table
    from swarmcensus.leaderboard.page import cell
    from swarmcensus.leaderboard.scores import COLUMNS

    scores = board.scores
    names = [column.name for column in COLUMNS]
    liars = [names.index("10 % liars"), names.index("30 % liars")]
    error, right = (score.by_world.mean(axis=0) for score in (scores.error, scores.side))
    rows = []
    for place, k in _placed(scores):
        ranked = k in scores.error.order
        rows.append([
            "" if place is None else f"{place}",
            scores.contenders[k],
            f"{scores.error.ranks[k]:.1f}" if ranked else "",
            *(cell(value, True) for value in (error[k], *scores.error.values[k, liars])),
            cell(right[k], False),
            *(f"{scores.costs[name][k]:.0f}" for name in ("memory_bytes", "message_bytes")),
        ])  # fmt: skip
    lying = (names[k].replace(" liars", "\nliars") for k in liars)  # two lines leave room for long names beside
    heads = ("", "brain", "rank", "error", *lying, "right\n%", "memory", "message")
    out = console()
    out.print(table([(head, head != "brain") for head in heads], rows))
    out.print(
        "error: |x - f| after the last round, mean over worlds, and over those with so many liars; right: on f's side "
        "of one half; memory, message: bytes"
    )
    if bounds := [name for name in scores.contenders if name in scores.bounds]:
        out.print(
            f"no rank among brains: {', '.join(bounds)}, which no robot could be; alone is ranked, as one could use it"
        )
    for one in board.losses:
        worst = one.columns[0]
        where = f"loses most where: {worst.column} (it is {worst.place} of {worst.of}, the best is {worst.best})"
        said = where if worst.place > 1 else "is first in every kind of world"
        out.print(f"{one.name} is number {one.place} of {one.of}, and {said}")
