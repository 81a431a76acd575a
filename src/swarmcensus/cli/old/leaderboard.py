"""The command `leaderboard`. Imports wait until the command needs them."""

import argparse
import time
from pathlib import Path
from typing import TYPE_CHECKING, Any

from swarmcensus.cli.options import OF_RUNS, Command, Group, add_shared

from swarmcensus.cli.output import present, reporting, say, wrote
from swarmcensus.support.formatting import elapsed

if TYPE_CHECKING:
    from swarmcensus.evaluation import Board


def add_leaderboard_options(sub: argparse.ArgumentParser) -> None:
    """Add the options of `leaderboard`."""
    sub.add_argument("files", type=Path, nargs="*", metavar="FILE.py", help="brain files of your own")
    sub.add_argument(
        "--out", type=Path, default=Path("leaderboard"), help="folder for the results (default: %(default)s)"
    )
    sub.add_argument(
        "--board", choices=("honest", "liars", "change"), default="honest", metavar="WHICH",
        help="worlds that rank the brains: honest (robots; default), liars, or change (of the floor)",
    )  # fmt: skip
    add_shared(sub, *OF_RUNS)


def leaderboard(options: argparse.Namespace) -> int:
    """Run the leaderboard and print the ranking, and where your own brains lose most."""
    from swarmcensus.evaluation import flat, leaderboard, print_board, sentences
    from swarmcensus.support.terminal import console

    begun = time.monotonic()
    with reporting("leaderboard") as progress:
        board = leaderboard(
            options.files, options.out, board=options.board, trials=options.trials, seed=options.seed,
            jobs=options.jobs, device=options.device, fresh=options.fresh, progress=progress, say=say,
        )  # fmt: skip
    present(
        options,
        "leaderboard",
        lambda: _as_dict(board),
        lambda: map(flat, _as_dict(board)["brains"]),
        lambda: print_board(board.name, board.scores, board.losses, board.cautions, console()),
        lambda: sentences(board.losses, board.cautions),
    )
    wrote(board.page)
    say(elapsed(time.monotonic() - begun))
    return 0


def _as_dict(board: "Board") -> dict[str, Any]:
    """The board for JSON: brains in the order of the table."""
    from swarmcensus.evaluation import rows

    return {
        "board": board.name,
        "worlds": len(board.scores.worlds),
        "brains": rows(board.scores),
        "losses": board.losses,
        "cautions": board.cautions,
        "page": board.page,
    }


COMMANDS = (
    Command(
        "leaderboard", "Run all brains, and yours, in one fixed set of worlds.",
        Group.BRAINS, 3, leaderboard, add_leaderboard_options, table=True,
    ),
)  # fmt: skip
