"""`leaderboard`: run shipped brains and brains of your own in the same worlds, score them and write the page."""

import json
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import xarray as xr

from swarmcensus import brains
from swarmcensus.analysis import p_value
from swarmcensus.evaluation.ranking.scores import ERROR, SENT, SIDE, TAIL, Floats, Ranking, Score, rankings
from swarmcensus.results import cautions_of_needs, groups_in, load, merge
from swarmcensus.runs import Device, Report, placing_of_study, run, showing
from swarmcensus.studies import Study
from swarmcensus.support.answers import Answer
from swarmcensus.support.errors import InputError
from swarmcensus.support.files import atomic_write, check_own, check_writable, data_path, shipped_study
from swarmcensus.support.formatting import counted
from swarmcensus.support.hints import did_you_mean
from swarmcensus.support.options import command
from swarmcensus.support.printed_tables import ASKED, REST, STAYS, Column, Table, markdown
from swarmcensus.support.templates import render
from swarmcensus.support.toml_text import read_toml, to_toml
from swarmcensus.support.version import __version__

if TYPE_CHECKING:
    import pandas as pd

PAGE, FIGURE, TITLE = "leaderboard.md", "leaderboard.png", "# Leaderboard"
LEAST = 1e-3  # smaller errors have the same colour
SIZE = 7.0  # points: the numbers of the picture
OFFICIAL = "shipped"  # the name of the shipped brains' results


@dataclass(repr=False)
class Board(Answer):
    """The results of all brains, and how they rank in the worlds of one group; `losses` are of your own brains there.

    A row is a contender, best first. `place` is missing for bounds, and for brains with opinions as estimates. Errors
    are |x - f| after the last round, and `right_side` is a share of robots.
    """

    data: xr.Dataset
    ranking: Ranking
    losses: list[dict[str, Any]]
    cautions: list[str]  # brains that need other worlds than these
    page: Path | None = None  # of all groups, if it was written
    usual_limit: int = 0

    @property
    def title(self) -> str:  # type: ignore[override]
        """The group of worlds."""
        about = f"{counted(len(self.ranking.worlds), 'world')}, {counted(self.data.sizes['trial'], 'trial')} each"
        return f"leaderboard, {self.ranking.group}: {about}"

    @property
    def sentences(self) -> list[str]:  # type: ignore[override]
        """Where each brain of your own is and where it loses most; without any, which brain is first."""
        found = []
        for one in self.losses:
            worst = one["groups"][0]
            loses = "it is first in every kind of world"
            if worst["place"] > 1:
                there = f"number {worst['place']} of {worst['of']} there"
                loses = f"it loses most in '{worst['group']}', to {worst['best']} ({there})"
            found.append(f"{one['name']} is number {one['place']} of {one['of']}; {loses}")
        places = {place: self.ranking.contenders[k] for k, place in self.ranking.placed.items() if place}
        return found or [f"{places[1]} is number 1 of {len(places)}"]

    @property
    def rows(self) -> list[dict[str, Any]]:  # type: ignore[override]
        """A row for each contender, with columns for each kind of world, such as "final_error: networks"."""
        return self.ranking.rows

    @property
    def frame(self) -> "pd.DataFrame":
        """The rows as a pandas table, with places that are whole numbers or missing."""
        return super().frame.astype({"place": "Int64"})

    @property
    def fields(self) -> dict[str, Any]:  # type: ignore[override]
        """The group, its number of worlds, and the losses."""
        return {"board": self.ranking.group, "worlds": len(self.ranking.worlds), "losses": self.losses}

    @property
    def files(self) -> dict[Path, str]:  # type: ignore[override]
        """The page."""
        return {self.page: ""} if self.page else {}

    def tables(self, limit: int) -> list[Table]:
        """One table; on a narrow terminal it lacks kinds of worlds."""
        one, order = self.ranking, [*self.ranking.placed]
        (place, name, rank), parts = _columns(one, one.error, order, [loss["name"] for loss in self.losses])
        error, right = (score.by_world.mean(axis=0) for score in (one.error, one.right))
        columns = [
            Column("error", [cell(error[k], True) for k in order], rank=ASKED, name=ERROR),
            Column("90 %", [cell(one.tail[k], True) for k in order], rank=REST, name=TAIL),
            Column("right %", [cell(right[k], False) for k in order], rank=REST, name=SIDE),
        ]
        sizes = [Column(name.removesuffix("_bytes"), [f"{one.costs[name][k]:.0f}" for k in order], rank=REST, name=name)
                 for name in ("memory_bytes", "message_bytes")]  # fmt: skip
        about = groups_in(self.data)[one.group]
        notes = [
            f"{one.group}: {about}; error: |x - f| after the last round, mean over its worlds, and by kind; 90 %: nine "
            "of ten robots err no more; right: estimates on the same side of one half as f; memory, message: bytes"
        ]
        if bounds := ", ".join(name for name in one.contenders if name in one.bounds):
            notes.append(
                f"not ranked, as references that no robot can run: {bounds}; alone is ranked, as a robot can run it"
            )
        return [Table([place, name, *columns, *parts, rank, *sizes], notes=lambda _: notes).first(limit)]


def leaderboard(
    files: Sequence[str | Path] = (), out: str | Path | None = None, *, board: str = "honest",
    trials: int | None = None, seed: int | None = None, jobs: int | None = None, fresh: bool = False,
    progress: Report | bool = True, say: Callable[[str], None] = print, device: Device = "cpu",
) -> Board:  # fmt: skip
    """Run all shipped brains and those of `files` in the worlds of the leaderboard, and score them.

    The outcome has the ranking in the worlds of one group, `board`. Page, figure and results of all groups are written
    to the folder `out`; without it nothing is written. Results in `out` are kept, unless `fresh` or a brain's file has
    changed. `trials` and `seed` replace those of studies/leaderboard.toml. `progress` and `device` are as for `run`;
    `say` gets messages. Raises InputError before anything is run if a file is not a brain, or the folder cannot be
    written. Ctrl-C raises Interrupted, and the same call continues from there.
    """
    own_files = named([Path(file) for file in files])
    studies = {name: of_file(file) for name, file in own_files.items()}  # first: errors and failures show soon
    studies = {
        name: study.with_(trials=trials, seed=seed) for name, study in (studies | {OFFICIAL: official()}).items()
    }
    if board not in (groups := studies[OFFICIAL].groups):
        raise InputError.named("board", board, f"{did_you_mean(board, groups)}there are {', '.join(groups)}")
    for study in studies.values():
        placing_of_study(study, device, quiet=False)
    folder = None if out is None else Path(out)
    paths = {name: None if folder is None else data_path(folder, name) for name in studies}
    if folder is not None:
        check_own(folder / PAGE, lambda text: text.startswith(TITLE), "leaderboard")
        for path in (folder / FIGURE, *paths.values()):
            check_writable(path)  # type: ignore[arg-type]
    parts = {}
    for k, (name, study) in enumerate(studies.items(), 1):
        restart = fresh or (name != OFFICIAL and _changed(paths[name], study, say))
        with showing(progress, f"leaderboard, {name}") as report:
            part = f"part {k} of {len(studies)}" * (k < len(studies))
            parts[name] = run(
                study, jobs, _as_part(report, name, part), out=paths[name], fresh=restart, say=say, cautions=False,
                announce_from=0.0, device=device,
            )  # fmt: skip
    data = merge([parts[OFFICIAL], *(parts[name] for name in own_files)]) if own_files else parts[OFFICIAL]
    known = [brain for study in studies.values() for brain in study.brains]
    opinions, oracles = {one.name for one in known if one.is_opinion}, {one.name for one in known if one.is_oracle}
    found = rankings(data, opinions, oracles, board)
    own = [name for name in found[board].contenders if name in map(str, own_files.values())]
    losses = {name: [one.losses(brain) for brain in own] for name, one in found.items()}
    answer = Board(data, found[board], losses[board], cautions_of_needs(data))
    whole = [one for one in found.values() if not one.is_part]
    if folder is not None:
        words = [word for option, value in (("--trials", trials), ("--seed", seed)) if value is not None
                 for word in (option, str(value))]  # fmt: skip
        from swarmcensus.figures import drawing  # imports matplotlib

        with drawing():
            _draw(whole, own, folder / FIGURE)
        with atomic_write(folder / PAGE) as temporary:
            how = command("swarmcensus", "leaderboard", *map(str, own_files.values()), *words)
            text = page(whole, [losses[one.group] for one in whole], answer.cautions, how, studies[OFFICIAL])
            temporary.write_text(text, encoding="utf-8")
        answer.page = folder / PAGE
    return answer


def _as_part(show: Report, name: str, part: str) -> Report:
    """A callback that shows the progress of one of several runs as that of a part."""
    return lambda now: show(replace(now, stage=name, part=now.part or part))


def _changed(path: Path | None, study: Study, say: Callable[[str], None]) -> bool:
    """Whether results are of another brain, version or name than the study, so that they have to be run again.

    Other differences, such as the seed, are refused by `run`.
    """
    if path is None or not path.exists():
        return False
    old = {name: brain["sha256"] for name, brain in json.loads(load(path).attrs["brains"]).items()}
    new = {brain.name: brain.sha256 for brain in study.brains}
    if old != new:
        before = ", ".join(sorted(old.keys() - new.keys())) or f"another version of {', '.join(sorted(new))}"
        say(f"{path}: these results are of {before}: running again")
    return old != new


def page(
    boards: Sequence[Ranking],
    losses: Sequence[Sequence[dict[str, Any]]],
    cautions: Sequence[str],
    how: str,
    study: Study,
) -> str:
    """The page of all groups, in Markdown, so that a repository can show it; `how` is the command that makes it."""
    own = [loss["name"] for loss in losses[0]]
    costs = boards[0].costs | {SENT: boards[0].costs[SENT] / boards[0].rounds}

    def table(one: Ranking, score: Score) -> str:
        first, parts = _columns(one, score, score.order, own)
        tail = Column(f"90 % ({one.group})", [cell(one.tail[k], True) for k in score.order])
        return markdown(Table([*first, *[tail] * score.low, *parts]))

    return render(
        Path(__file__).with_name("page.md.jinja"), title=TITLE, trials=study.trials, command=how, seed=study.seed,
        version=__version__, boards=boards, figure=FIGURE, cautions=cautions, table=table, cell=cell, counted=counted,
        own=[(name, [loss for board in losses for loss in board if loss["name"] == name]) for name in own],
        costs=[(boards[0].contenders[k], *(costs[name][k] for name in ("memory_bytes", "message_bytes", SENT)))
               for k in np.argsort(costs["memory_bytes"], kind="stable")],
        p_value=p_value,
    )  # fmt: skip


def _columns(one: Ranking, score: Score, order: Sequence[int], own: Sequence[str]) -> tuple[list[Column], list[Column]]:
    """Place, name and rank of contenders, and their score in each part of the worlds, where the best is strong."""
    ranked = [k for k in score.order if one.contenders[k] not in one.bounds]
    places = {k: str(place) for place, k in enumerate(ranked, 1)}
    names = [one.contenders[k] for k in order]
    first = [
        Column("", [places.get(k, "") for k in order], number=False, rank=STAYS, name="place"),
        Column("brain", names, number=False, strong=[name in own for name in names], name="brain"),
        Column("rank", [f"{score.ranks[k]:.1f}" * (k in score.order) for k in order], rank=REST, name="rank"),
    ]
    what, parts = ERROR if score.low else SIDE, []
    for part, values in zip(one.parts, score.parts, strict=True):
        best = np.fmin.reduce(values[ranked]) if score.low else np.fmax.reduce(values[ranked])
        cells = [cell(values[k], score.low) for k in order]
        strong = [bool(values[k] == best) for k in order]
        parts.append(Column(part, cells, strong=strong, rank=REST, name=f"{what}: {part}"))
    return first, parts


def cell(value: float, low: bool) -> str:
    """A value as text: an error in four digits, a share in percent."""
    return "–" if np.isnan(value) else f"{value:.4f}" if low else f"{100 * value:.1f}"


def _draw(boards: Sequence[Ranking], own: list[str], path: Path) -> None:
    """Write a heatmap of the errors in all groups, a row per contender: dark is worse, your own are bold.

    The best of the first group comes first.
    """
    from matplotlib.colors import LogNorm  # matplotlib takes half a second
    from matplotlib.figure import Figure
    from matplotlib.ticker import NullFormatter

    from swarmcensus.figures import save, write_numbers

    order = boards[0].error.order
    names = [boards[0].contenders[k] for k in order]
    columns = [part for one in boards for part in one.parts]
    values: Floats = np.concatenate([one.error.parts for one in boards]).T[order]
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
