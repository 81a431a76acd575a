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
from swarmcensus.runs import Device, Report, run, showing
from swarmcensus.studies import Study
from swarmcensus.summaries import MEASURES, cautions_of_needs, groups_in, measures, where
from swarmcensus.support.answers import Answer
from swarmcensus.support.bootstrap import centres
from swarmcensus.support.errors import InputError, StudyError
from swarmcensus.support.files import data_path, shipped_study
from swarmcensus.support.formatting import counted
from swarmcensus.support.hints import did_you_mean
from swarmcensus.support.options import wrong_option
from swarmcensus.support.printed_tables import ASKED, REST, STAYS, Column, Table

ERROR, TAIL, SIDE, SENT = "final_error", "error_90", "right_side", "messages_sent"
SHIPPED = "shipped"  # the name of the shipped brains' results
SHOWN = {ERROR: ("error", "{:.4f}"), TAIL: ("90 %", "{:.4f}"), SIDE: ("right %", "{:.1f}"), "rank": ("rank", "{:.1f}"),
         "memory_bytes": ("memory", "{:.0f}"), "message_bytes": ("message", "{:.0f}"),
         SENT: ("messages a round", "{:.3g}")}  # fmt: skip


class Leaderboard(Answer):
    """How brains rank in a group of worlds, with a row for each contender, best first.

    `place` is missing for bounds, and for brains with opinions as estimates. Errors are |x - f| after the last round,
    and `right_side` is a share of robots. Both have a column for each kind of world, such as "final_error: networks".
    """

    data: xr.Dataset  # the results of all brains
    group: str
    worlds: int
    kinds: Sequence[str]  # groups of worlds that lie within this one
    own: Collection[str]  # names of your brains
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
        """The place of each brain of your own, and where it loses most; without any, which brain is first."""
        of = f"of {sum(row['place'] is not None for row in self.rows)}"
        said = [self._said_of(row, of) for row in self.rows if row["brain"] in self.own]
        return said or [f"{next(row['brain'] for row in self.rows if row['place'])} is number 1 {of}"]

    def _said_of(self, own: Mapping[str, Any], of: str) -> str:
        """The place of a brain, and the kind of world with the greatest distance to the best other brain."""
        if not own["place"]:
            return f"{own['brain']} is not ranked by errors, as its estimate is an opinion"
        others = [row for row in self.rows if row["place"] and row is not own]
        errors = {kind: f"{ERROR}: {kind}" for kind in self.kinds}
        lost = {kind: own[name] - min(row[name] for row in others) for kind, name in errors.items()} if others else {}
        most = (
            f"; it loses most in '{max(lost, key=lost.__getitem__)}'" if max(lost.values(), default=0.0) > 0.0 else ""
        )
        return f"{own['brain']} is number {own['place']} {of}{most}"

    @property
    def fields(self) -> dict[str, Any]:  # type: ignore[override]
        """The group, its number of worlds and kinds of these."""
        return {"group": self.group, "worlds": self.worlds, "kinds": self.kinds}

    def tables(self, limit: int) -> list[Table]:
        """Ranks, which lack kinds of worlds on a narrow terminal."""
        rounds = float(where(self.data, self.group)["rounds"].values.mean())
        columns = [
            Column("", [str(row["place"] or "") for row in self.rows], False, STAYS, name="place"),
            Column("brain", [row["brain"] for row in self.rows], False, name="brain",
                   strong=[row["brain"] in self.own for row in self.rows]),
        ]  # fmt: skip
        for name in [*self.rows[0]][3:]:
            measure, _, kind = name.partition(": ")
            title, form = SHOWN[measure]
            unit = {SENT: rounds, SIDE: 0.01}.get(measure, 1.0)
            cells = ["–" if np.isnan(row[name]) else form.format(row[name] / unit) for row in self.rows]
            if kind:
                title = kind if measure == ERROR else f"{title}: {kind}"
            columns.append(Column(title, cells, rank=ASKED if name == ERROR else REST, name=name))
        others = [name for name in groups_in(self.data) if name != self.group]
        bounds = [row["brain"] for row in self.rows if row["is_bound"]]
        notes = [
            f"{self.group}: {groups_in(self.data)[self.group]}; error: |x - f| after the last round, mean over its "
            "worlds, and by kind; 90 %: nine of ten robots err no more; right: estimates on the same side of one half "
            "as f; memory, message: bytes",
            *[f"other groups, for --group: {', '.join(others)}"] * bool(others),
            *[f"not ranked, as references that no robot can run: {', '.join(bounds)}"] * bool(bounds),
        ]
        return [Table(columns, notes=lambda _: notes).first(limit)]


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
    official = Study.load(shipped_study("leaderboard.toml") if study is None else study, set)
    if not official.groups:
        raise InputError(f"study {official.name}: it needs [groups], such as all = 'robots > 0'", key="groups")
    group = next(iter(official.groups)) if group is None else group
    if group not in official.groups:
        hint = did_you_mean(group, official.groups)
        raise wrong_option("group", group, f"{hint}there are {', '.join(official.groups)}")
    before = outline([official], merged=False)
    for name, expression in official.groups.items():
        try:
            where(before, name)
        except InputError as error:
            why = str(error).rpartition(f"{expression!r}: ")[2]
            raise StudyError.within(f"study {official.name}", f"groups.{name} = {expression!r}: {why}") from None
    studies = {SHIPPED: official}
    for file in map(Path, files):
        brain = brains.load(file)
        same = studies.setdefault(file.stem, official.with_(**{"swarm.brain": brain}))
        if [one.sha256 for one in same.brains] != [brain.sha256] or str(file) in brains.shipped():
            raise InputError.of(file, f"the leaderboard has another brain {file.stem}: rename the file")
    if len({setting.brain.label for one in studies.values() for setting in one.settings()}) < 2:
        raise InputError(f"study {official.name}: it has one brain: name files of others, to rank them", key="brain")
    results, written = {}, dict[Path, str]()
    for name, one in reversed(studies.items()):  # files of your own first: their errors and failures show soon
        path = None if out is None else data_path(Path(out), name)
        restart = fresh or (name != SHIPPED and path is not None and path.exists() and _is_of_another(path, one))
        with showing(progress, f"leaderboard, {name}") as report:
            results[name] = run(one, jobs, report, out=path, fresh=restart, say=say, cautions=False, device=device)
        written |= {} if path is None else {path: ""}
    data = merge([*reversed(results.values())]) if len(results) > 1 else results[SHIPPED]
    worlds = {name: _worlds_in(name, data) for name in official.groups}
    kinds = [name for name, few in worlds.items() if few < worlds[group]]
    known = [brain for one in studies.values() for brain in one.brains]
    answer = ranking(data, group, kinds or [group], known, [one.brains[0].name for one in [*studies.values()][1:]])
    answer.files = written
    return answer


def _worlds_in(group: str, data: xr.Dataset) -> set[int]:
    return {*where(data, group)["setting"].values.tolist()}


def _is_of_another(path: Path, study: Study) -> bool:
    """Whether results are of another version or name of a study's brain; other differences are refused by `run`."""
    found = {name: brain["sha256"] for name, brain in json.loads(load(path).attrs["brains"]).items()}
    return found != {brain.name: brain.sha256 for brain in study.brains}


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
    names = data["brain"].values[grid.place.max(axis=0)].tolist()
    opinions, bounds = (
        np.isin(names, [brain.name for brain in known if getattr(brain, kind)]) for kind in ("is_opinion", "is_oracle")
    )
    each = {name: np.asarray(grid.spread(measures.numbers(data, name))) for name in (ERROR, TAIL, SIDE, SENT)}
    for name in (ERROR, TAIL):
        each[name][:, opinions] = np.nan
    by_world = {name: centres(each[name], MEASURES[name].statistic) for name in (ERROR, TAIL, SIDE)}
    columns = {name: values[masks[group]].mean(axis=0) for name, values in by_world.items()}
    columns |= {f"{ERROR}: {kind}": by_world[ERROR][masks[kind]].mean(axis=0) for kind in kinds}
    # ranks need numbers of all contenders in a trial: those without any would leave no trial
    has_errors = np.asarray(~np.isnan(each[ERROR]).all(axis=(0, 2)))
    errors = ContestInput(each[ERROR][masks[group]][:, has_errors], MEASURES[ERROR].statistic)
    columns["rank"] = np.full(len(names), np.nan)
    columns["rank"][has_errors] = contests([errors], with_intervals=False)[0].average_ranks
    columns |= {name: np.nanmean(grid.spread(data[name].values.astype(float)), axis=0) for name in measures.SIZES}
    columns[SENT] = np.nanmean(each[SENT], axis=(0, 2))
    columns |= {f"{SIDE}: {kind}": by_world[SIDE][masks[kind]].mean(axis=0) for kind in kinds}
    # of equal ranks the smaller error is first; those without a rank come last, by their right decisions
    order = np.lexsort((np.where(has_errors, columns[ERROR], -columns[SIDE]), columns["rank"])).tolist()
    places = {k: place for place, k in enumerate((k for k in order if has_errors[k] and not bounds[k]), start=1)}
    rows = [
        {"place": places.get(k), "brain": grid.contenders[k], "is_bound": bool(bounds[k])}
        | {name: float(values[k]) for name, values in columns.items()}
        for k in order
    ]
    return Leaderboard(data=data, group=group, worlds=int(masks[group].sum()), kinds=kinds, own=own, rows=rows,
                       cautions=cautions_of_needs(data))  # fmt: skip
