"""The leaderboard from one call: shipped brains and one's own run in the same worlds, scored, written down."""

import contextlib
import json
import shlex
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

import xarray as xr

from swarmcensus import brains
from swarmcensus.basics.errors import InputError
from swarmcensus.basics.files import check_own, check_writable, data_path, shipped_study, whole
from swarmcensus.leaderboard.losses import Losses, losses_of
from swarmcensus.leaderboard.page import TITLE, page
from swarmcensus.leaderboard.scores import COLUMNS, Scores, scores_of
from swarmcensus.results.merging import merge
from swarmcensus.results.store import load
from swarmcensus.runs.collect import Reporting
from swarmcensus.runs.running import run
from swarmcensus.studies.study import Study
from swarmcensus.studies.toml_text import read_toml, to_toml

PAGE, FIGURE = "leaderboard.md", "leaderboard.png"


@dataclass(frozen=True)
class Board:
    """What came of it: the results of all, the scores, where each of one's own brains loses, and the page."""

    data: xr.Dataset
    scores: Scores
    losses: list[Losses]
    page: Path


def leaderboard(
    files: Sequence[str | Path] = (),
    out: str | Path = "leaderboard",
    *,
    trials: int | None = None,
    seed: int | None = None,
    jobs: int | None = None,
    fresh: bool = False,
    reporting: Reporting | None = None,
    say: Callable[[str], None] = lambda _: None,
) -> Board:
    """Run the leaderboard's worlds with all shipped brains and those of `files`, and write page, figure and results.

    What `out` holds already is not run again, unless `fresh` or a brain's file has changed; `trials` and `seed` replace
    those of studies/leaderboard.toml. `reporting(label)` is a context that gives the callback for `run`'s progress;
    `say` gets a line on what is found. Raises InputError before anything is run where a file is no brain, or the folder
    cannot be written. Ctrl-C raises Interrupted, and the same call goes on from there.
    """
    out, own = Path(out), named([Path(file) for file in files])
    entered = {name: of_file(file) for name, file in own.items()}  # before the shipped brains, which take a second
    studies = {OFFICIAL: official()} | entered
    studies = {name: study.with_(trials=trials, seed=seed) for name, study in studies.items()}
    check_own(out / PAGE, lambda text: text.startswith(TITLE), "leaderboard")
    check_writable(out / FIGURE)
    for name in studies:
        check_writable(data_path(out, name))
    parts = {}
    for name in sorted(studies, key=lambda name: name == OFFICIAL):  # what is wrong with one's own shows soon
        study, path = studies[name], data_path(out, name)
        anew = fresh or (name != OFFICIAL and _changed(path, study, say))
        with reporting(f"leaderboard, {name}") if reporting else contextlib.nullcontext() as progress:
            parts[name] = run(study, jobs, progress, out=path, fresh=anew, say=say)
    data = merge([parts[name] for name in studies]) if own else parts[OFFICIAL]
    brains = [brain for study in studies.values() for brain in study.brains]
    opinions, oracles = {one.name for one in brains if one.is_opinion}, {one.name for one in brains if one.is_oracle}
    scores = scores_of(data, opinions, oracles)
    mine = [name for name in scores.contenders if any(str(file) == name for file in own.values())]
    losses = [losses_of(name, scores) for name in mine]
    words = ["swarmcensus", "leaderboard", *map(str, own.values())]
    words += [word for option, value in (("--trials", trials), ("--seed", seed)) if value is not None
              for word in (option, str(value))]  # fmt: skip
    one = studies[OFFICIAL]
    _draw(scores, mine, out / FIGURE)
    with whole(out / PAGE) as beside:
        beside.write_text(page(scores, losses, shlex.join(words), one.seed, one.trials, FIGURE), encoding="utf-8")
    return Board(data, scores, losses, out / PAGE)


def _changed(path: Path, study: Study, say: Callable[[str], None]) -> bool:
    """Whether results are of another brain, edition or name than their study: they are of no use any more.

    What else may differ, as the seed, is for `run` to refuse.
    """
    if not path.exists():
        return False
    old = {name: one["sha256"] for name, one in json.loads(load(path).attrs["brains"]).items()}
    new = {brain.name: brain.sha256 for brain in study.brains}
    if old == new:
        return False
    before, now = (", ".join(sorted(one.keys() - other.keys())) for one, other in ((old, new), (new, old)))
    if not before:
        what = f"another edition of {', '.join(sorted(new))}"
    elif {*old.values()} == {*new.values()}:
        what = f"{before}, the same brain as {now} by another name"
    else:
        what = f"{before}, another brain than {now}"
    say(f"{path}: these results are of {what}, and are run again")
    return True


def _draw(scores: Scores, mine: list[str], path: Path) -> None:
    from swarmcensus.figures.board_cells import draw_board  # matplotlib: half a second
    from swarmcensus.figures.files import save

    order = scores.error.order
    names = [scores.contenders[k] for k in order]
    save(draw_board(names, [column.name for column in COLUMNS], scores.error.values[order], mine), path)


OFFICIAL = "shipped"  # what the shipped brains' results are called


def official() -> Study:
    """The study of all shipped brains. Raises InputError where it is missing."""
    return Study.load(shipped_study("leaderboard.toml"))


def of_file(file: Path) -> Study:
    """The same worlds for one brain file, by its path from here. Raises InputError, naming it and what is wrong."""
    path = shipped_study("leaderboard.toml")
    tables = read_toml(path.read_text(encoding="utf-8"), str(path))
    tables["swarm"]["brain"] = str(file)
    return Study.parse(to_toml(tables), where=f"leaderboard of {file}", context={"base": Path()})


def named(files: list[Path]) -> dict[str, Path]:
    """What each file's results are called. A file that is named twice is taken once.

    Raises InputError where two would be called the same, or one as ours.
    """
    names: dict[str, Path] = {}
    for file in files:
        if str(file) in brains.shipped():
            raise InputError(f"{file}: a shipped brain, which is on the board anyway: name a file of your own")
        if file.stem == OFFICIAL:
            raise InputError(f"{file}: results of this name are those of the shipped brains: call the file otherwise")
        if names.setdefault(file.stem, file).resolve() != file.resolve():
            raise InputError(f"{names[file.stem]} and {file}: both would be called {file.stem}: rename one of them")
    return names
