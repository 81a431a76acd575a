"""`leaderboard`: run shipped brains and brains of your own in the same worlds, score them and write the page."""

import json
from collections.abc import Callable, Collection, Sequence
from dataclasses import dataclass, field, replace
from itertools import chain
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from swarmcensus import brains
from swarmcensus.analysis import ALPHA, Contest, ContestInput, contests, grid_of, p_value
from swarmcensus.results import load, merge
from swarmcensus.runs import Device, Report, placing_of_study, run, showing
from swarmcensus.studies import Study
from swarmcensus.summaries import MEASURES, Measure, cautions_of_needs, groups_in, measures, where
from swarmcensus.support.answers import Answer
from swarmcensus.support.bootstrap import centres
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

Floats = NDArray[np.float64]
ERROR, SIDE, TAIL, SENT = "final_error", "right_side", "error_90", "messages_sent"
PAGE, FIGURE, TITLE = "leaderboard.md", "leaderboard.png", "# Leaderboard"
OFFICIAL = "shipped"  # the name of the shipped brains' results
FEW = 5  # worlds in the list of losses


@dataclass(frozen=True)
class Score:
    """A measure of all contenders in a group of worlds: `numbers` are (world, contender, trial).

    `by_world` (world, contender) has medians over trials, or means of shares, and `parts` (part, contender) their means
    over the worlds of a part of the group. `ranks` (contender,) are averages over all worlds and trials: 1 is best, and
    NaN is a contender without numbers.
    """

    measure: Measure
    numbers: Floats
    by_world: Floats
    parts: Floats
    ranks: Floats

    @property
    def order(self) -> list[int]:
        """Contenders, the best first; those without a rank are left out."""
        return [k for k in np.argsort(self.ranks, kind="stable").tolist() if not np.isnan(self.ranks[k])]


@dataclass(repr=False)
class Board(Answer):
    """The results of all brains, and how they rank in the worlds of one group; `losses` are of your own brains there.

    A row is a contender, best first. `place` is missing for bounds, and for brains with opinions as estimates. Errors
    are |x - f| after the last round, and `right_side` is a share of robots.
    """

    data: xr.Dataset
    group: str
    is_part: bool  # of another group
    parts: list[str]  # groups of these worlds that lie within this one
    contenders: list[str]
    worlds: list[str]  # in a few words
    error: Score
    right: Score
    tail: Floats  # (contender,): the error that 90 % of a trial's robots do not exceed, the mean over worlds of medians
    costs: dict[str, Floats]  # (contender,), means over the worlds of all groups
    bounds: Collection[str]  # contenders that no robot can run
    losses: list[dict[str, Any]] = field(default_factory=list)
    cautions: list[str] = field(default_factory=list)  # brains that need other worlds than these
    page: Path | None = None  # of all groups, if it was written
    usual_limit: int = 0

    @property
    def title(self) -> str:  # type: ignore[override]
        """The group of worlds."""
        about = f"{counted(len(self.worlds), 'world')}, {counted(self.data.sizes['trial'], 'trial')} each"
        return f"leaderboard, {self.group}: {about}"

    @property
    def sentences(self) -> list[str]:  # type: ignore[override]
        """Where each brain of your own is and where it loses most; without any, which brain is first."""
        sentences = []
        for loss in self.losses:
            worst = loss["groups"][0]
            loses = "it is first in every kind of world"
            if worst["place"] > 1:
                there = f"number {worst['place']} of {worst['of']} there"
                loses = f"it loses most in '{worst['group']}', to {worst['best']} ({there})"
            sentences.append(f"{loss['name']} is number {loss['place']} of {loss['of']}; {loses}")
        places = self.places(self.error)
        return sentences or [f"{self.contenders[next(iter(places))]} is number 1 of {len(places)}"]

    @property
    def rows(self) -> list[dict[str, Any]]:  # type: ignore[override]
        """A row for each contender, with columns for each kind of world, such as "final_error: networks"."""
        places, scores = self.places(self.error), (self.error, self.right)
        return [
            {"place": places.get(k), "brain": self.contenders[k], "rank": self.error.ranks[k], TAIL: self.tail[k]}
            | {score.measure.name: score.by_world[:, k].mean() for score in scores}
            | {name: values[k] for name, values in self.costs.items()}
            | {f"{score.measure.name}: {part}": values[k]
               for score in scores for part, values in zip(self.parts, score.parts, strict=True)}
            for k in self.order
        ]  # fmt: skip

    @property
    def frame(self) -> "pd.DataFrame":
        """The rows as a pandas table, with places that are whole numbers or missing."""
        return super().frame.astype({"place": "Int64"})

    @property
    def fields(self) -> dict[str, Any]:  # type: ignore[override]
        """The group, its number of worlds, and the losses."""
        return {"board": self.group, "worlds": len(self.worlds), "losses": self.losses}

    @property
    def files(self) -> dict[Path, str]:  # type: ignore[override]
        """The page."""
        return {self.page: ""} if self.page else {}

    @property
    def order(self) -> list[int]:
        """Contenders, the best first; those without an error come last."""
        return [*dict.fromkeys([*self.error.order, *self.right.order])]

    def places(self, score: Score) -> dict[int, int]:
        """The place of each contender by a score, the best first; bounds and those without a rank have none."""
        ranked = [k for k in score.order if self.contenders[k] not in self.bounds]
        return {k: place for place, k in enumerate(ranked, 1)}

    def losses_of(self, name: str) -> dict[str, Any]:
        """Where a contender loses, by errors, or by right decisions if its estimate is an opinion.

        `groups` are all parts, and `worlds` some worlds, the worst first: its value and place, and name and value of
        the best other. `rivals` are significantly better over all worlds, the clearest first.
        """
        own, names = self.contenders.index(name), self.contenders
        score = self.right if np.isnan(self.error.ranks[own]) else self.error
        order = [k for k in score.order if k == own or names[k] not in self.bounds]
        others, low = sorted({*order} - {own}), score.measure.low

        def sorted_losses(key: str, labels: list[str], values: Floats) -> list[dict[str, Any]]:
            losses = [{key: label, **_behind(row, own, others, names, low)}
                      for label, row in zip(labels, values, strict=True) if not np.isnan(row[own])]  # fmt: skip
            return sorted(losses, key=lambda loss: (loss["best_value"] - loss["value"]) * (1 if low else -1))

        contest = _contest(score.measure, score.numbers[:, [own, *others]], against=0)
        # the first pairs are those of this contender, so `shares` has those in which it is better, and worse
        rivals = [
            {"name": names[other], "better": worse, "worse": better, "p": float(contest.duels_corrected[pair])}
            for pair, other in enumerate(others)
            for better, worse in [contest.shares(pair)]
            if contest.ahead[pair] < 0 and contest.duels_corrected[pair] <= ALPHA
        ]
        return {
            "name": name, "board": self.group, "low": low, "place": order.index(own) + 1, "of": len(order),
            "groups": sorted_losses("group", self.parts, score.parts),
            "worlds": sorted_losses("world", self.worlds, score.by_world)[:FEW],
            "rivals": sorted(rivals, key=lambda rival: rival["worse"] - rival["better"]),
        }  # fmt: skip

    def tables(self, limit: int) -> list[Table]:
        """One table; on a narrow terminal it lacks kinds of worlds."""
        order = self.order
        (place, name, rank), parts = self.columns_of(self.error, order)
        error, right = (score.by_world.mean(axis=0) for score in (self.error, self.right))
        columns = [
            Column("error", [cell(error[k], True) for k in order], rank=ASKED, name=ERROR),
            Column("90 %", [cell(self.tail[k], True) for k in order], rank=REST, name=TAIL),
            Column("right %", [cell(right[k], False) for k in order], rank=REST, name=SIDE),
        ]
        costs = [(name, self.costs[name]) for name in measures.SIZES]
        sizes = [Column(name.removesuffix("_bytes"), [f"{values[k]:.0f}" for k in order], rank=REST, name=name)
                 for name, values in costs]  # fmt: skip
        notes = [
            f"{self.group}: {groups_in(self.data)[self.group]}; error: |x - f| after the last round, mean over its "
            "worlds, and by kind; 90 %: nine of ten robots err no more; right: estimates on the same side of one half "
            "as f; memory, message: bytes"
        ]
        if bounds := ", ".join(name for name in self.contenders if name in self.bounds):
            notes.append(
                f"not ranked, as references that no robot can run: {bounds}; alone is ranked, as a robot can run it"
            )
        return [Table([place, name, *columns, *parts, rank, *sizes], notes=lambda _: notes).first(limit)]

    def columns_of(self, score: Score, order: Sequence[int]) -> tuple[list[Column], list[Column]]:
        """Place, name and rank of contenders, and their score in each part of the worlds, where the best is strong."""
        places, (name, low) = self.places(score), (score.measure.name, score.measure.low)
        names, own = [self.contenders[k] for k in order], [loss["name"] for loss in self.losses]
        first = [
            Column("", [str(places.get(k, "")) for k in order], number=False, rank=STAYS, name="place"),
            Column("brain", names, number=False, strong=[name in own for name in names], name="brain"),
            Column("rank", [f"{score.ranks[k]:.1f}" * (k in score.order) for k in order], rank=REST, name="rank"),
        ]
        parts = []
        for part, values in zip(self.parts, score.parts, strict=True):
            best = (np.fmin if low else np.fmax).reduce(values[[*places]])
            cells, strong = [cell(values[k], low) for k in order], [bool(values[k] == best) for k in order]
            parts.append(Column(part, cells, strong=strong, rank=REST, name=f"{name}: {part}"))
        return first, parts


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
    own_files = files_by_name([Path(file) for file in files])
    # files of your own first: their errors and failures show soon
    studies = {name: study_of(file) for name, file in own_files.items()} | {OFFICIAL: study_of()}
    studies = {name: study.with_(trials=trials, seed=seed) for name, study in studies.items()}
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
    results = {}
    for k, (name, study) in enumerate(studies.items(), 1):
        restart = fresh or (name != OFFICIAL and _changed(paths[name], study, say))
        part = f"part {k} of {len(studies)}" * (k < len(studies))
        with showing(progress, f"leaderboard, {name}") as report:
            results[name] = run(
                study, jobs, _as_part(report, name, part), out=paths[name], fresh=restart, say=say, cautions=False,
                announce_from=0.0, device=device,
            )  # fmt: skip
    data = merge([results[OFFICIAL], *(results[name] for name in own_files)]) if own_files else results[OFFICIAL]
    known = [brain for study in studies.values() for brain in study.brains]
    opinions, oracles = {one.name for one in known if one.is_opinion}, {one.name for one in known if one.is_oracle}
    boards, cautions = rankings(data, opinions, oracles, board), cautions_of_needs(data)
    for one in boards.values():
        one.cautions = cautions
        one.losses = [one.losses_of(name) for name in one.contenders if name in map(str, own_files.values())]
    if folder is not None:
        words = [word for option, value in (("--trials", trials), ("--seed", seed)) if value is not None
                 for word in (option, str(value))]  # fmt: skip
        from swarmcensus.figures import drawing  # imports matplotlib

        whole = [one for one in boards.values() if not one.is_part]
        with drawing():
            _draw(whole, folder / FIGURE)
        how = command("swarmcensus", "leaderboard", *map(str, own_files.values()), *words)
        with atomic_write(folder / PAGE) as temporary:
            temporary.write_text(page(whole, how, studies[OFFICIAL]), encoding="utf-8")
        boards[board].page = folder / PAGE
    return boards[board]


def rankings(
    data: xr.Dataset, opinions: Collection[str], oracles: Collection[str] = (), asked: str = ""
) -> dict[str, Board]:
    """The board of each group of worlds of a study that lies within no other one, and of the group `asked`.

    The estimates of brains in `opinions` have no error; those in `oracles` are bounds.
    """
    grid, _ = grid_of(data, data)
    settings = grid.place.max(axis=1)  # any setting of a world tells its coordinates; a missing one is NONE, the least
    masks = {name: np.isin(data["setting"].values[settings], where(data, name)["setting"].values)
             for name in groups_in(data)}  # fmt: skip
    within = {name: [other for other, mask in masks.items() if mask.sum() < own.sum() and not (mask & ~own).any()]
              for name, own in masks.items()}  # fmt: skip
    brain_of = data["brain"].values[grid.place.max(axis=0)].tolist()
    numbers = {name: np.asarray(grid.spread(measures.numbers(data, name))) for name in (ERROR, SIDE, TAIL, SENT)}
    for name in (ERROR, TAIL):
        numbers[name][:, [brain in opinions for brain in brain_of]] = np.nan
    costs = {SENT: np.nanmean(numbers[SENT], axis=(0, 2))}
    costs |= {name: np.nanmean(grid.spread(data[name].values.astype(float)), axis=0) for name in measures.SIZES}
    bounds = {name for name, brain in zip(grid.contenders, brain_of, strict=True) if brain in oracles}
    boards = {}
    for group, own in masks.items():
        is_part, parts = group in chain(*within.values()), within[group] or [group]
        if is_part and group != asked:
            continue
        error, right = (_score(MEASURES[name], numbers[name][own], [masks[part][own] for part in parts])
                        for name in (ERROR, SIDE))  # fmt: skip
        boards[group] = Board(
            data, group, is_part, parts, grid.contenders,
            [world_label(data.isel(setting=place)) for place in settings[own]], error, right,
            centres(numbers[TAIL][own], "median").mean(axis=0), costs, bounds,
        )  # fmt: skip
    return boards


def _score(measure: Measure, numbers: Floats, parts: Collection[NDArray[np.bool_]]) -> Score:
    known = np.asarray(~np.isnan(numbers).all(axis=(0, 2)))
    by_world, ranks = centres(numbers, measure.statistic), np.full(len(known), np.nan)
    # ranks need numbers of all contenders in a trial: those without any would leave no trial
    ranks[known] = _contest(measure, numbers[:, known]).average_ranks
    return Score(measure, numbers, by_world, np.stack([by_world[part].mean(axis=0) for part in parts]), ranks)


def _contest(measure: Measure, numbers: Floats, against: int | None = None) -> Contest:
    contest_input = ContestInput(numbers, measure.statistic, measure.low, measure.share)
    return contests([contest_input], with_intervals=False, against=against)[0]


def _behind(values: Floats, own: int, others: list[int], names: list[str], low: bool) -> dict[str, Any]:
    """A contender's value and place among those with a value, and name and value of the best other one."""
    keys = values if low else -values
    known = [k for k in others if not np.isnan(keys[k])]
    best = min(known, key=lambda k: float(keys[k]))
    place = 1 + sum(bool(keys[k] < keys[own]) for k in known)
    return {"value": float(values[own]), "place": place, "of": len(known) + 1,
            "best": names[best], "best_value": float(values[best])}  # fmt: skip


def world_label(setting: xr.Dataset) -> str:
    """The world of a setting in a few words."""
    world: dict[str, Any] = {"liars": 0, "message_delay": 0, "fill_ratio_change": ""}
    world |= {str(name): coordinate.item() for name, coordinate in setting.coords.items() if not coordinate.ndim}
    liars, late, lost = world["liars"], world["message_delay"], 1 - float(world["link_success"])
    words = [
        str(world["topology"]), f"accuracy {world['accuracy']}",
        f"f = {world['fill_ratio_change'] or world['fill_ratio']}",
        f"floor {world['floor']}" * (world["floor"] not in ("", "tiles")), f"{lost:.0%} of messages lost" * (lost > 0),
        f"messages {late:.0f} round{'s' * (late > 1)} late" * (late > 0), f"{liars:.0f} liars" * (liars > 0),
    ]  # fmt: skip
    return ", ".join(filter(None, words))


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


def page(boards: Sequence[Board], how: str, study: Study) -> str:
    """The page of all groups, in Markdown, so that a repository can show it; `how` is the command that makes it."""
    first = boards[0]
    costs = first.costs | {SENT: first.costs[SENT] / where(first.data, first.group)["rounds"].values.mean()}

    def table(board: Board, score: Score) -> str:
        about, parts = board.columns_of(score, score.order)
        tail = Column(f"90 % ({board.group})", [cell(board.tail[k], True) for k in score.order])
        return markdown(Table([*about, *[tail] * score.measure.low, *parts]))

    return render(
        Path(__file__).with_name("page.md.jinja"), title=TITLE, trials=study.trials, command=how, seed=study.seed,
        version=__version__, boards=boards, figure=FIGURE, cautions=first.cautions, table=table, cell=cell,
        losses_of_brains=[*zip(*(board.losses for board in boards), strict=True)], counted=counted, p_value=p_value,
        costs=[(first.contenders[k], *(costs[name][k] for name in (*measures.SIZES, SENT)))
               for k in np.argsort(costs["memory_bytes"], kind="stable")],
    )  # fmt: skip


def cell(value: float, low: bool) -> str:
    """A value as text: an error in four digits, a share in percent."""
    return "–" if np.isnan(value) else f"{value:.4f}" if low else f"{100 * value:.1f}"


def _draw(boards: Sequence[Board], path: Path) -> None:
    """Write a heatmap of the errors in all groups, a row per contender: dark is worse, your own are bold.

    The best of the first group comes first.
    """
    from matplotlib.figure import Figure  # matplotlib takes half a second

    from swarmcensus.figures import draw_cells, save

    order, own = boards[0].error.order, [loss["name"] for loss in boards[0].losses]
    names, parts = [boards[0].contenders[k] for k in order], [part for board in boards for part in board.parts]
    values = np.concatenate([board.error.parts for board in boards]).T[order]
    figure = Figure(figsize=(2.6 + 0.72 * len(parts), 1.5 + 0.215 * len(names)), layout="constrained")
    axes = figure.add_subplot()
    draw_cells(axes, values, MEASURES[ERROR], numbered=True, misled=np.zeros(values.shape, np.bool_))
    axes.invert_yaxis()
    axes.set_xticks(range(len(parts)), parts, rotation=35, ha="right", rotation_mode="anchor")
    axes.set_yticks(range(len(names)), names)
    for label in axes.get_yticklabels():
        label.set_fontweight("bold" if label.get_text() in own else "normal")
    axes.tick_params(length=0, labelsize=8)
    axes.spines[:].set_visible(False)
    save(figure, path)


def study_of(file: Path | None = None) -> Study:
    """The study of all shipped brains, or its worlds for the brain of one file.

    Raises InputError, naming the file and the error.
    """
    path = shipped_study("leaderboard.toml")
    if file is None:
        return Study.load(path)
    tables = read_toml(path.read_text(encoding="utf-8"), str(path))
    tables["swarm"]["brain"] = str(file)
    return Study.parse(to_toml(tables), where=f"leaderboard of {file}", context={"base": Path()})


def files_by_name(files: list[Path]) -> dict[str, Path]:
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
