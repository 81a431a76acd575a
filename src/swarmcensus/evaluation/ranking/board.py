"""`leaderboard`: run shipped brains and brains of your own in the same worlds, score them and write the page."""

import json
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import xarray as xr

from swarmcensus import brains
from swarmcensus.evaluation.ranking.losses import Losses, losses_of
from swarmcensus.evaluation.ranking.page import TITLE, page
from swarmcensus.evaluation.ranking.scores import DIVISIONS, Scores, scores_of
from swarmcensus.evaluation.ranking.table import as_text, flat, rows
from swarmcensus.results import cautions_of_needs, load, merge
from swarmcensus.runs import Device, Report, placing_of_study, run, showing
from swarmcensus.studies import Study, read_toml, to_toml
from swarmcensus.support.errors import InputError
from swarmcensus.support.files import atomic_write, check_own, check_writable, data_path, shipped_study
from swarmcensus.support.options import command

if TYPE_CHECKING:
    import pandas as pd

PAGE, FIGURE = "leaderboard.md", "leaderboard.png"
LEAST = 1e-3  # smaller errors have the same colour
SIZE = 7.0  # points: the numbers of the picture


@dataclass(frozen=True, repr=False)
class Board:
    """The outcome: results of all brains, scores of one board, losses of your own brains there, and the page.

    Its `repr` is the table that the terminal shows; `table` has all columns.
    """

    data: xr.Dataset
    name: str
    scores: Scores
    losses: list[Losses]
    page: Path | None  # of all boards, if it was written
    cautions: tuple[str, ...] = ()  # brains that need other worlds than these

    @property
    def table(self) -> "pd.DataFrame":
        """A pandas table with a row for each contender, best first, and columns for each kind of world.

        `place` is missing for bounds, and for brains with opinions as estimates. Errors are |x - f| after the last
        round, and `right_side` is a share of robots.
        """
        import pandas as pd

        return pd.DataFrame(map(flat, rows(self.scores))).astype({"place": "Int64"})

    def __repr__(self) -> str:
        """The table, what its columns mean, and where your own brains are."""
        return as_text(self.name, self.scores, self.losses, self.cautions)


def leaderboard(
    files: Sequence[str | Path] = (),
    out: str | Path | None = None,
    *,
    board: str = "honest",
    trials: int | None = None,
    seed: int | None = None,
    jobs: int | None = None,
    fresh: bool = False,
    progress: Report | bool = True,
    say: Callable[[str], None] = print,
    device: Device = "cpu",
) -> Board:
    """Run all shipped brains and those of `files` in the worlds of the leaderboard, and score them.

    The outcome has the scores of one `board` of `DIVISIONS`. Page, figure and results of all boards are written to the
    folder `out`; without it nothing is written. Results in `out` are kept, unless `fresh` or a brain's file has
    changed. `trials` and `seed` replace those of studies/leaderboard.toml. `progress` and `device` are as for `run`;
    `say` gets messages. Raises InputError before anything is run if a file is not a brain, or the folder cannot be
    written. Ctrl-C raises Interrupted, and the same call continues from there.
    """
    own_files = named([Path(file) for file in files])
    own_studies = {name: of_file(file) for name, file in own_files.items()}  # first: errors show soon
    studies = {OFFICIAL: official()} | own_studies
    studies = {name: study.with_(trials=trials, seed=seed) for name, study in studies.items()}
    for study in studies.values():
        placing_of_study(study, device, quiet=False)
    folder = None if out is None else Path(out)
    paths = dict.fromkeys(studies) if folder is None else {name: data_path(folder, name) for name in studies}
    if folder is not None:
        check_own(folder / PAGE, lambda text: text.startswith(TITLE), "leaderboard")
        for path in (folder / FIGURE, *paths.values()):
            check_writable(path)
    parts = {}
    for k, name in enumerate(sorted(studies, key=lambda name: name == OFFICIAL)):  # own first: failures show soon
        study, path = studies[name], paths[name]
        restart = fresh or (name != OFFICIAL and path is not None and _changed(path, study, say))
        with showing(progress, f"leaderboard, {name}") as report:
            part = f"part {k + 1} of {len(studies)}" if k + 1 < len(studies) else ""
            parts[name] = run(
                study, jobs, _as_part(report, name, part), out=path, fresh=restart, say=say, cautions=False,
                announce_from=0.0, device=device,
            )  # fmt: skip
    data = merge([parts[name] for name in studies]) if own_files else parts[OFFICIAL]
    brains = [brain for study in studies.values() for brain in study.brains]
    opinions = {brain.name for brain in brains if brain.is_opinion}
    oracles = {brain.name for brain in brains if brain.is_oracle}
    boards = {name: scores_of(data, opinions, oracles, name) for name in DIVISIONS}
    scores = {name: board_scores for name, board_scores in boards.items() if board_scores}
    if board not in scores:
        raise InputError.named("board", board, "no world of studies/leaderboard.toml is on it")
    own = [name for name in scores[board].contenders if name in map(str, own_files.values())]
    losses = {name: [losses_of(brain, name, scores[name]) for brain in own] for name in scores}
    cautions = tuple(cautions_of_needs(data))
    if folder is None:
        return Board(data, board, scores[board], losses[board], None, cautions)
    words = ["swarmcensus", "leaderboard", *map(str, own_files.values())]
    words += [word for option, value in (("--trials", trials), ("--seed", seed)) if value is not None
              for word in (option, str(value))]  # fmt: skip
    shipped = studies[OFFICIAL]
    from swarmcensus.figures import drawing  # imports matplotlib

    with drawing():
        _draw([*scores.values()], own, folder / FIGURE)
    with atomic_write(folder / PAGE) as temporary:
        text = page(
            [*scores.values()], [*losses.values()], cautions, command(*words), shipped.seed, shipped.trials, FIGURE
        )
        temporary.write_text(text, encoding="utf-8")
    return Board(data, board, scores[board], losses[board], folder / PAGE, cautions)


def _as_part(show: Report, name: str, part: str) -> Report:
    """A callback that shows the progress of one of several runs as that of a part."""
    return lambda now: show(replace(now, stage=name, part=now.part or part))


def _changed(path: Path, study: Study, say: Callable[[str], None]) -> bool:
    """Whether results are of another brain, version or name than the study, so that they have to be run again.

    Other differences, such as the seed, are refused by `run`.
    """
    if not path.exists():
        return False
    old = {name: brain["sha256"] for name, brain in json.loads(load(path).attrs["brains"]).items()}
    new = {brain.name: brain.sha256 for brain in study.brains}
    if old == new:
        return False
    before, now = (", ".join(sorted(names)) for names in (old.keys() - new.keys(), new.keys() - old.keys()))
    if not before:
        what = f"another version of {', '.join(sorted(new))}"
    elif {*old.values()} == {*new.values()}:
        what = f"{before}, the same brain as {now} by another name"
    else:
        what = f"{before}, another brain than {now}"
    say(f"{path}: these results are of {what}: running again")
    return True


def _draw(boards: Sequence[Scores], own: list[str], path: Path) -> None:
    """Write the picture of the errors on all boards, a row per contender: dark is worse, your own are bold.

    The best of the first board comes first.
    """
    from matplotlib.colors import LogNorm  # matplotlib takes half a second
    from matplotlib.figure import Figure
    from matplotlib.ticker import NullFormatter

    from swarmcensus.figures import save, write_numbers

    order = boards[0].error.order
    names = [boards[0].contenders[k] for k in order]
    columns = [column.name for scores in boards for column in scores.division.columns]
    values = np.concatenate([scores.error.values for scores in boards], axis=1)[order]
    rows, count = values.shape
    figure = Figure(figsize=(2.6 + 0.72 * count, 1.5 + 0.215 * rows), layout="constrained")
    axes = figure.add_subplot()
    known = values[np.isfinite(values)]
    norm = LogNorm(max(LEAST, known.min(initial=1.0)), max(known.max(initial=LEAST), 2 * LEAST), clip=True)
    image = axes.imshow(values, cmap="cividis_r", norm=norm, aspect="auto")
    write_numbers(axes, image, values, "{:.3f}".format, SIZE)
    axes.set_xticks(range(count), columns, size=SIZE + 1, rotation=35, ha="left", rotation_mode="anchor")
    axes.set_yticks(range(rows), names, size=SIZE + 1)
    for label, name in zip(axes.get_yticklabels(), names, strict=True):
        label.set_fontweight("bold" if name in own else "normal")
    axes.tick_params(length=0, labeltop=True, labelbottom=False, top=False)
    axes.spines[:].set_visible(False)
    bar = figure.colorbar(image, ax=axes, pad=0.01, fraction=0.03)
    bar.set_label("error of the last estimate", size=SIZE + 1)
    bar.ax.tick_params(which="both", labelsize=SIZE)
    bar.ax.yaxis.set_major_formatter("{x:g}")
    bar.ax.yaxis.set_minor_formatter(NullFormatter())
    save(figure, path)


OFFICIAL = "shipped"  # the name of the shipped brains' results


def official() -> Study:
    """The study of all shipped brains. Raises InputError if it is missing."""
    return Study.load(shipped_study("leaderboard.toml"))


def of_file(file: Path) -> Study:
    """The worlds of the leaderboard for one brain file. Raises InputError, naming the file and the error."""
    path = shipped_study("leaderboard.toml")
    tables = read_toml(path.read_text(encoding="utf-8"), str(path))
    tables["swarm"]["brain"] = str(file)
    return Study.parse(to_toml(tables), where=f"leaderboard of {file}", context={"base": Path()})


def named(files: list[Path]) -> dict[str, Path]:
    """Brain files by the name of their results. A file that is given twice counts once.

    Raises InputError for a shipped brain, and if two names are equal or one is that of the shipped brains' results.
    """
    names: dict[str, Path] = {}
    for file in files:
        if str(file) in brains.shipped():
            raise InputError.of(file, "a shipped brain is on the leaderboard anyway: give a file of your own")
        if file.stem == OFFICIAL:
            raise InputError.of(file, "this name is reserved for the results of the shipped brains: rename the file")
        if names.setdefault(file.stem, file).resolve() != file.resolve():
            why = f"results of both would be named {file.stem}: rename one"
            raise InputError.of(file, why, where=f"{names[file.stem]} and {file}")
    return names
