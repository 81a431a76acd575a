"""The command `leaderboard`. Imports wait until the command needs them."""

import argparse
import time
from pathlib import Path
from typing import TYPE_CHECKING, Any

from swarmcensus.basics.formatting import elapsed
from swarmcensus.cli.options import add_run_options
from swarmcensus.cli.output import present, reporting, say, wrote

if TYPE_CHECKING:
    from collections.abc import Iterator

    from swarmcensus.ranking.board import Board
    from swarmcensus.ranking.scores import Scores


def add_leaderboard_options(sub: argparse.ArgumentParser) -> None:
    """Add the options of `leaderboard`."""
    sub.add_argument("files", type=Path, nargs="*", metavar="FILE.py", help="brain files of your own")
    sub.add_argument(
        "--out", type=Path, default=Path("leaderboard"), help="folder for the results (default: %(default)s)"
    )
    sub.add_argument(
        "--board", choices=("honest", "liars", "change"), default="honest",
        help="worlds that rank the brains: honest robots, liars, or a floor that changes (default: %(default)s)",
    )  # fmt: skip
    add_run_options(sub)


def leaderboard(options: argparse.Namespace) -> int:
    """Run the leaderboard and print the ranking, and where your own brains lose most."""
    from swarmcensus.ranking.board import leaderboard

    begun = time.monotonic()
    board = leaderboard(
        options.files, options.out, board=options.board, trials=options.trials,
        seed=options.seed, jobs=options.jobs, fresh=options.fresh,
        reporting=reporting, say=say,
    )  # fmt: skip
    present(
        options,
        "leaderboard",
        lambda: _as_dict(board),
        lambda: map(_flat, _as_dict(board)["brains"]),
        lambda: _show(board),
        lambda: _sentences(board),
    )
    wrote(board.page)
    say(elapsed(time.monotonic() - begun))
    return 0


def _as_dict(board: "Board") -> dict[str, Any]:
    """The board for JSON: brains in the order of the table, with error and share of right robots by kind of world."""
    scores = board.scores
    rows: list[dict[str, Any]] = []
    for place, k in _placed(scores):
        row: dict[str, Any] = {"place": place, "brain": scores.contenders[k], "rank": scores.error.ranks[k]}
        for score in (scores.error, scores.side):
            row[score.name] = score.by_world[:, k].mean()
            row[f"{score.name}_by_kind"] = dict(
                zip((column.name for column in scores.division.columns), score.values[k].tolist(), strict=True)
            )
        rows.append(row | {name: values[k] for name, values in scores.costs.items()})
    return {
        "board": board.name,
        "worlds": len(scores.worlds),
        "brains": rows,
        "losses": board.losses,
        "page": board.page,
    }


def _flat(row: dict[str, Any]) -> dict[str, Any]:
    """A brain's row with a column for each kind of world, such as "error: ring"."""
    flat = {name: value for name, value in row.items() if not isinstance(value, dict)}
    for name in (name for name in row if name not in flat):
        flat |= {f"{name.removesuffix('_by_kind')}: {kind}": value for kind, value in row[name].items()}
    return flat


def _placed(scores: "Scores") -> "Iterator[tuple[int | None, int]]":
    """Place and number of each contender, the best first. The place is None for bounds, and for those without errors,
    which come last."""
    ranked, place = scores.error.order, 0
    for k in [*ranked, *(k for k in scores.side.order if k not in ranked)]:
        bound = scores.contenders[k] in scores.bounds
        place += not bound
        yield None if bound or k not in ranked else place, k


def _show(board: "Board") -> None:
    from swarmcensus.basics.formatting import counted
    from swarmcensus.basics.terminal import NUMBER, Column, console, fitted, left_out
    from swarmcensus.ranking.page import cell

    scores = board.scores
    names = [column.name for column in scores.division.columns]
    shown = [names.index(name) for name in scores.division.shown]
    error, right = (score.by_world.mean(axis=0) for score in (scores.error, scores.side))
    rows = []
    for place, k in _placed(scores):
        ranked = k in scores.error.order
        rows.append([
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
        Column(head, [row[k] for row in rows], head != "brain", spare.get(head, 0)) for k, head in enumerate(heads)
    ]
    out = console()
    page, lacking = fitted(columns, out)
    out.print(page)
    for line in left_out(lacking, out):
        out.print(line)
    parts = f", and by kind: {' and '.join(scores.division.shown)}" if shown else ""
    out.print(
        f"board {board.name}: {scores.division.meaning}; error: |x - f| after the last round, mean over its "
        f"{counted(len(scores.worlds), 'world')}{parts}; "
        "right: estimates on the same side of one half as f; memory, message: bytes"
    )
    if bounds := [name for name in scores.contenders if name in scores.bounds]:
        out.print(
            f"not ranked, as bounds that no robot can reach: {', '.join(bounds)}; "
            "alone is ranked, as a robot can run it"
        )
    for sentence in _sentences(board):
        out.print(sentence)


def _sentences(board: "Board") -> "Iterator[str]":
    """Where each brain of your own is, and where it loses most."""
    for losses in board.losses:
        worst = losses.columns[0]
        text = f"its worst kind of world is '{worst.column}' (number {worst.place} of {worst.of}; best is {worst.best})"
        text = text if worst.place > 1 else "it is first in every kind of world"
        yield f"{losses.name} is number {losses.place} of {losses.of}; {text}"
