"""The command `leaderboard`."""

from collections.abc import Sequence
from pathlib import Path
from typing import Annotated

from cyclopts import Parameter

from swarmcensus.cli.messages import reporting, say
from swarmcensus.cli.parameters import FOLDER, Device, Fresh, Jobs, Seed, Trials, path, takes
from swarmcensus.support.answers import Answer


def leaderboard(
    files: Annotated[Sequence[Path], takes(path, "FILE.py", several=True)] = (), /, *,
    out: Annotated[Path, FOLDER] = Path("leaderboard"), group: Annotated[str, Parameter(metavar="NAME")] = "honest",
    jobs: Jobs = None, device: Device = "cpu", trials: Trials = None, seed: Seed = None, fresh: Fresh = False,
) -> Answer:  # fmt: skip
    """Run all brains, and yours, in one fixed set of worlds.

    Args:
        files: brain files of your own
        out: folder for the results (default: leaderboard)
        group: worlds that rank the brains: honest (robots; default), liars, change (of the floor), or a kind of these
    """
    from swarmcensus.evaluation import leaderboard

    with reporting("leaderboard") as progress:
        return leaderboard(
            files, out, group=group, trials=trials, seed=seed, jobs=jobs, device=device, fresh=fresh,
            progress=progress, say=say,
        )  # fmt: skip
