"""The command `leaderboard`."""

from collections.abc import Sequence
from pathlib import Path
from typing import Annotated

from swarmcensus.cli.messages import reporting, say
from swarmcensus.cli.parameters import FOLDER, NAME, USUAL, Fresh, Hardware, Seed, Set, Trials, path, takes, values_of
from swarmcensus.support.answers import Answer


def leaderboard(
    files: Annotated[Sequence[Path], takes(path, "FILE.py", several=True)] = (), /, *,
    study: Annotated[Path | None, takes(path, "STUDY.toml")] = None, set: Set = (),
    out: Annotated[Path, FOLDER] = Path("leaderboard"), group: Annotated[str | None, NAME] = None,
    hardware: Hardware = USUAL, trials: Trials = None, seed: Seed = None, fresh: Fresh = False,
) -> Answer:  # fmt: skip
    """Run all brains, and yours, in one fixed set of worlds.

    Args:
        files: brain files of your own
        study: other worlds and brains than those of the leaderboard: a study with [groups]
        out: folder for the results (default: leaderboard)
        group: worlds that rank the brains: honest (robots; default), liars, change (of the floor), or a kind of these
    """
    from swarmcensus.evaluation import leaderboard

    more = {key: value for key, value in (("trials", trials), ("seed", seed)) if value is not None}
    with reporting("leaderboard") as progress:
        return leaderboard(
            files, out, study=study, set=values_of(set, **more) | more, group=group, fresh=fresh, progress=progress,
            say=say, **vars(hardware),
        )  # fmt: skip
