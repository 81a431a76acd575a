"""The leaderboard: shipped brains, and brains of your own, ranked in the groups of worlds of one fixed study.

The study is studies/leaderboard.toml, with its groups. Results are written into a folder.
"""

import json
from collections.abc import Callable, Collection, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr

from swarmcensus import brains
from swarmcensus.analysis import ContestInput, contests, grid_of
from swarmcensus.results import load, merge, outline
from swarmcensus.runs import Device, Report, placing_of_study, run, showing
from swarmcensus.studies import Study, with_values
from swarmcensus.summaries import MEASURES, cautions_of_needs, groups_in, measures, where
from swarmcensus.support.answers import Answer
from swarmcensus.support.bootstrap import centres
from swarmcensus.support.errors import InputError, StudyError
from swarmcensus.support.files import check_writable, data_path, shipped_study
from swarmcensus.support.formatting import counted
from swarmcensus.support.hints import did_you_mean
from swarmcensus.support.printed_tables import ASKED, REST, STAYS, Column, Table
from swarmcensus.support.toml_text import read_toml

ERROR, SIDE, TAIL, SENT = "final_error", "right_side", "error_90", "messages_sent"
MEASURED = (ERROR, TAIL, SIDE, SENT)
OFFICIAL = "shipped"  # the name of the shipped brains' results
LOSS = {"brain": False, "kind of world": False, "place": True, "its own": True, "best other's": True,
        "best other": False}  # fmt: skip  # heads of the table of losses, and whether they are of numbers


class Leaderboard(Answer):
    """How brains rank in a group of worlds, with a row for each contender, best first.

    `place` is missing for bounds, and for brains with opinions as estimates. Errors are |x - f| after the last round,
    and `right_side` is a share of robots. Both have a column for each kind of world, such as "final_error: networks".
    `losses` say for each brain of your own how far it is behind the best other brain in each kind, the worst first.
    """

    data: xr.Dataset  # the results of all brains
    group: str
    worlds: int
    kinds: Sequence[str]  # groups of worlds that lie within this one
    losses: Sequence[Mapping[str, Any]]
    usual_limit = 0

    @property
    def frame(self) -> Any:
        """The rows as a pandas table, with places that are whole numbers or missing."""
        return super().frame.astype({"place": "Int64"})

    @property
    def title(self) -> str:  # type: ignore[override]
        """The group of worlds."""
        about = f"{counted(self.worlds, 'world')}, {counted(self.data.sizes['trial'], 'trial')} each"
        return f"leaderboard, {self.group}: {about}"

    @property
    def sentences(self) -> list[str]:  # type: ignore[override]
        """Where each brain of your own is and where it loses most; without any, which brain is first."""
        placed = [row for row in self.rows if row["place"]]
        said = []
        for name in dict.fromkeys(loss["brain"] for loss in self.losses):
            worst = next(loss for loss in self.losses if loss["brain"] == name)
            place = next((row["place"] for row in placed if row["brain"] == name), None)
            loses = "it is first in every kind of world"
            if worst["place"] > 1:
                there = f"number {worst['place']} of {worst['of']} there"
                loses = f"it loses most in '{worst['kind']}', to {worst['best']} ({there})"
            opinion = "not ranked by errors, as its estimate is an opinion"
            ranked = f"number {place} of {len(placed)}" if place else opinion
            said.append(f"{name} is {ranked}; {loses}")
        return said or [f"{placed[0]['brain']} is number 1 of {len(placed)}"]

    @property
    def fields(self) -> dict[str, Any]:  # type: ignore[override]
        """The group, its number of worlds and kinds of these, and the losses."""
        return {"group": self.group, "worlds": self.worlds, "kinds": self.kinds, "losses": self.losses}

    def tables(self, limit: int) -> list[Table]:
        """Ranks, which lack kinds of worlds on a narrow terminal, and where brains of your own lose."""
        rounds = float(where(self.data, self.group)["rounds"].values.mean())
        columns = [self._column("error", ERROR, ASKED), self._column("90 %", TAIL), self._column("right %", SIDE)]
        columns += [self._column(kind, f"{ERROR}: {kind}") for kind in self.kinds]
        costs = {"rank": ("rank", "{:.1f}", 1.0), "memory": ("memory_bytes", "{:.0f}", 1.0),
                 "message": ("message_bytes", "{:.0f}", 1.0), "messages a round": (SENT, "{:.3g}", rounds)}  # fmt: skip
        for head, (name, form, unit) in costs.items():
            texts = ["" if np.isnan(row[name]) else form.format(row[name] / unit) for row in self.rows]
            columns.append(Column(head, texts, rank=REST, name=name))
        columns += [self._column(f"right %: {kind}", f"{SIDE}: {kind}") for kind in self.kinds]
        notes = [
            f"{self.group}: {groups_in(self.data)[self.group]}; error: |x - f| after the last round, mean over its "
            "worlds, and by kind; 90 %: nine of ten robots err no more; right: estimates on the same side of one half "
            "as f; memory, message: bytes"
        ]
        if bounds := ", ".join(row["brain"] for row in self.rows if row["is_bound"]):
            notes.append(
                f"not ranked, as references that no robot can run: {bounds}; alone is ranked, as a robot can run it"
            )
        own = {loss["brain"] for loss in self.losses}
        names = [row["brain"] for row in self.rows]
        places = [str(row["place"] or "") for row in self.rows]
        first = [
            Column("", places, number=False, rank=STAYS, name="place"),
            Column("brain", names, number=False, strong=[name in own for name in names], name="brain"),
        ]
        tables = [Table([*first, *columns], notes=lambda _: notes).first(limit)]
        return tables + [Table.of_rows(LOSS, map(_loss_cells, self.losses))] * bool(self.losses)

    def _column(self, head: str, name: str, rank: int = REST) -> Column:
        """A measure's column, where the best of those that are ranked is strong."""
        values, low = np.array([row[name] for row in self.rows]), not name.startswith(SIDE)
        best = (np.fmin if low else np.fmax).reduce(values[[not row["is_bound"] for row in self.rows]])
        return Column(head, [cell(value, low) for value in values], strong=[*(values == best)], rank=rank, name=name)


def leaderboard(
    files: Sequence[str | Path] = (), out: str | Path | None = None, *, study: str | Path | None = None,
    set: Mapping[str, Any] = {}, group: str | None = None, jobs: int | None = None, fresh: bool = False,
    progress: Report | bool = True, say: Callable[[str], None] = print, device: Device = "cpu",
) -> Leaderboard:  # fmt: skip
    """Run all shipped brains and those of `files` in the worlds of the leaderboard, and rank them.

    Another `study` with groups has other brains and worlds, and `set` are values in place of those of its keys, such as
    {"trials": 2}. The outcome has the ranking in the worlds of one `group`, by default the first. Results of all groups
    are written to the folder `out`; without it nothing is written. Results in `out` are kept, unless `fresh` or a
    brain's file has changed. `progress` and `device` are as for `run`; `say` gets messages. Raises
    InputError before anything is run if a file is not a brain, or the folder cannot be written. Ctrl-C raises
    Interrupted, and the same call continues from there.
    """
    own_files = files_by_name([Path(file) for file in files])
    # files of your own first: their errors and failures show soon
    studies = {name: study_of(study, set, file) for name, file in own_files.items()}
    studies[OFFICIAL] = study_of(study, set)
    groups = studies[OFFICIAL].groups
    if not groups:
        raise InputError(f"study {studies[OFFICIAL].name}: it needs [groups], such as all = 'robots > 0'", key="groups")
    group = next(iter(groups)) if group is None else group
    if group not in groups:
        raise InputError.named("group", group, f"{did_you_mean(group, groups)}there are {', '.join(groups)}")
    _check_groups(studies[OFFICIAL])
    for one in studies.values():
        placing_of_study(one, device, quiet=False)
    folder = None if out is None else Path(out)
    paths = {name: None if folder is None else data_path(folder, name) for name in studies}
    written = [path for path in paths.values() if path is not None]
    for path in written:
        check_writable(path)
    results = {}
    for name, one in studies.items():
        restart = fresh or (name != OFFICIAL and _changed(paths[name], one, say))
        with showing(progress, f"leaderboard, {name}") as report:
            results[name] = run(
                one, jobs, report, out=paths[name], fresh=restart, say=say, cautions=False, device=device
            )
    data = merge([results[OFFICIAL], *(results[name] for name in own_files)]) if own_files else results[OFFICIAL]
    known, own = [brain for one in studies.values() for brain in one.brains], {*map(str, own_files.values())}
    worlds = {name: _worlds_in(name, data) for name in groups_in(data)}
    kinds = [name for name, few in worlds.items() if few < worlds[group]]
    answer = ranking(data, group, kinds or [group], known, own)
    answer.files = dict.fromkeys(written, "")
    return answer


def _check_groups(study: Study) -> None:
    """Raise StudyError for a group that selects no setting, before anything runs."""
    before = outline([study], merged=False)
    for name, expression in study.groups.items():
        try:
            where(before, name)
        except InputError as error:
            why = str(error).rpartition(f"{expression!r}: ")[2]
            raise StudyError.within(f"study {study.name}", f"groups.{name} = {expression!r}: {why}") from None


def _worlds_in(group: str, data: xr.Dataset) -> set[int]:
    return {*where(data, group)["setting"].values.tolist()}


def ranking(
    data: xr.Dataset, group: str, kinds: Sequence[str], known: Collection[brains.Brain], own: Collection[str] = ()
) -> Leaderboard:
    """How contenders rank in the worlds of a group; `known` are the brains, and those in `own` are yours.

    Numbers of a world are medians over trials, or means of shares, and others their means over worlds. A `rank` is an
    average over all worlds and trials. Estimates of opinions have no error, and oracles no place.
    """
    grid, _ = grid_of(data, data)
    numbers = data["setting"].values[grid.place.max(axis=1)]  # any setting of a world tells its coordinates
    masks = {name: np.isin(numbers, [*_worlds_in(name, data)]) for name in (group, *kinds)}
    contender_brains = data["brain"].values[grid.place.max(axis=0)].tolist()
    opinions, oracles = (
        {brain.name for brain in known if getattr(brain, name)} for name in ("is_opinion", "is_oracle")
    )
    each = {name: np.asarray(grid.spread(measures.numbers(data, name))) for name in MEASURED}
    for name in (ERROR, TAIL):
        each[name][:, [brain in opinions for brain in contender_brains]] = np.nan
    by_world = {name: centres(each[name], MEASURES[name].statistic) for name in (ERROR, TAIL, SIDE)}
    # ranks need numbers of all contenders in a trial: those without any would leave no trial
    has_errors = np.asarray(~np.isnan(each[ERROR]).all(axis=(0, 2)))
    errors = ContestInput(each[ERROR][masks[group]][:, has_errors], MEASURES[ERROR].statistic)
    columns = {"rank": np.full(len(has_errors), np.nan)}
    columns["rank"][has_errors] = contests([errors], with_intervals=False)[0].average_ranks
    columns |= {name: values[masks[group]].mean(axis=0) for name, values in by_world.items()}
    columns |= {name: np.nanmean(grid.spread(data[name].values.astype(float)), axis=0) for name in measures.SIZES}
    columns[SENT] = np.nanmean(each[SENT], axis=(0, 2))
    columns |= {f"{name}: {kind}": by_world[name][masks[kind]].mean(axis=0) for name in (ERROR, SIDE) for kind in kinds}
    bounds = np.array([brain in oracles for brain in contender_brains])
    # those without a rank come last, by their right decisions
    order = np.lexsort((np.where(has_errors, 0.0, -columns[SIDE]), columns["rank"])).tolist()
    ranked = [k for k in order if has_errors[k] and not bounds[k]]
    rows = []
    for k in order:
        place = ranked.index(k) + 1 if k in ranked else None
        row = {"place": place, "brain": grid.contenders[k], "is_bound": bool(bounds[k])}
        rows.append(row | {name: float(values[k]) for name, values in columns.items()})
    losses = [loss for row in rows if row["brain"] in own for loss in _losses(row, rows, kinds)]
    return Leaderboard(data=data, group=group, worlds=int(masks[group].sum()), kinds=kinds, rows=rows, losses=losses,
                       cautions=cautions_of_needs(data))  # fmt: skip


def _losses(own: Mapping[str, Any], rows: Sequence[Mapping[str, Any]], kinds: Sequence[str]) -> list[dict[str, Any]]:
    """How far a brain is behind the best other one in each kind of worlds, by errors or by right decisions."""
    measure = ERROR if own["place"] else SIDE
    others, sign = [row for row in rows if row is not own and not row["is_bound"]], 1 if measure == ERROR else -1
    losses = []
    for kind in kinds:
        name = f"{measure}: {kind}"
        rivals = sorted((row for row in others if not np.isnan(row[name])), key=lambda row: sign * row[name])
        place = 1 + sum(sign * row[name] < sign * own[name] for row in rivals)
        losses.append({
            "brain": own["brain"], "kind": kind, "measure": measure, "place": place, "of": len(rivals) + 1,
            "value": own[name], "best_value": rivals[0][name], "best": rivals[0]["brain"],
        })  # fmt: skip
    return sorted(losses, key=lambda loss: sign * (loss["best_value"] - loss["value"]))


def _loss_cells(loss: Mapping[str, Any]) -> list[str]:
    """A row of the table of losses."""
    values = [cell(loss[name], loss["measure"] == ERROR) for name in ("value", "best_value")]
    return [loss["brain"], loss["kind"], f"{loss['place']} of {loss['of']}", *values, loss["best"]]


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


def cell(value: float, low: bool) -> str:
    """A value as text: an error in four digits, a share in percent."""
    return "–" if np.isnan(value) else f"{value:.4f}" if low else f"{100 * value:.1f}"


def study_of(study: str | Path | None = None, values: Mapping[str, Any] = {}, file: Path | None = None) -> Study:
    """The leaderboard's study, or another, with other values of some keys; with a file its worlds for this brain.

    Raises InputError, naming the file and the error.
    """
    path = shipped_study("leaderboard.toml") if study is None else Path(study)
    if file is None:
        return Study.load(path, values)
    tables, where = read_toml(path.read_text(encoding="utf-8"), str(path)), f"leaderboard of {file}"
    return Study.changed(
        with_values(tables, values), {"swarm.brain": brains.load(file)}, where=where, context={"base": path.parent}
    )


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
