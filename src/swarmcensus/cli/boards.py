"""The command `leaderboard`: brains of one's own beside the shipped ones. Imports wait until needed."""

import argparse
import sys
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from swarmcensus.leaderboard.board import Board


def leaderboard(options: argparse.Namespace) -> int:
    """Run the leaderboard and print its top, and where brains of one's own lose."""
    from swarmcensus.leaderboard.board import leaderboard
    from swarmcensus.runs.progress import reporting

    board = leaderboard(
        options.files, options.out, trials=options.trials, seed=options.seed, jobs=options.jobs, fresh=options.fresh,
        reporting=reporting, say=lambda line: print(line, file=sys.stderr),
    )  # fmt: skip
    _show(board)
    print(board.page)
    return 0


def _show(board: "Board") -> None:
    from swarmcensus.basics.terminal import console, table
    from swarmcensus.leaderboard.page import cell
    from swarmcensus.leaderboard.scores import COLUMNS

    scores = board.scores
    names = [column.name for column in COLUMNS]
    liars = [names.index("10 % liars"), names.index("30 % liars")]
    error, right = (score.by_world.mean(axis=0) for score in (scores.error, scores.side))
    rest = [k for k in scores.side.order if k not in scores.error.order]
    rows = []
    place = 0
    for k in [*scores.error.order, *rest]:
        ranked = k not in rest
        place += scores.contenders[k] not in scores.bounds
        rows.append([
            f"{place}" if ranked and scores.contenders[k] not in scores.bounds else "",
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
