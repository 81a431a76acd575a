"""Which brain, or level of another factor, is better in which world, by how much and at what cost: `sc.compare`."""

from collections.abc import Collection, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from swarmcensus.analysis.comparing import groups, showing, tables
from swarmcensus.analysis.comparing.contenders import NONE, Grid, grid_of
from swarmcensus.analysis.comparing.pair_tests import (
    Contest,
    ContestInput,
    contests,
    in_worlds_too_few,
    overall_too_few,
    pairs_of,
)
from swarmcensus.analysis.comparing.pairing import pairing_of
from swarmcensus.analysis.comparing.profiles import profiles
from swarmcensus.analysis.comparing.sentences import sentences
from swarmcensus.analysis.comparing.standings import Standings
from swarmcensus.analysis.comparing.verdicts import verdict
from swarmcensus.results import (
    COSTS,
    OURS,
    SETTLING,
    SIZES,
    TAIL,
    TIMES,
    TOGETHER,
    Measure,
    Origins,
    asked_anew,
    cautions_of_edges,
    cautions_of_needs,
    cautions_of_settling,
    cells,
    done,
    failed_trials,
    far_off,
    has_tail,
    known_origins,
    labels_in,
    learnt_cells,
    learnt_numbers,
    loaded,
    measures,
    never_learnt,
    renamed,
    selecting,
    shows_tail,
)
from swarmcensus.support.errors import InputError
from swarmcensus.support.formatting import counted
from swarmcensus.support.hints import did_you_mean
from swarmcensus.support.options import in_shell, option, wrong_option

if TYPE_CHECKING:
    import pandas as pd

Floats = NDArray[np.float64]

LATE = 0.9  # share of the rounds from which on agreement is late


class Comparison(Standings):
    """A comparison of contenders in worlds, with `table`, `pairs`, `ranks` and `duels` as pandas tables.

    `verdict` states the results in sentences. Printing a comparison shows these sentences and the cautions; its `repr`,
    and a notebook, show the table of its worlds above them.
    """

    @property
    def verdict(self) -> list[str]:
        """Who is best in how many worlds, who does not differ from the best, and the costs: one sentence each."""
        return verdict(self)

    @property
    def sentences(self) -> list[str]:
        """One sentence on each difference, for a paper: values, difference and probability with intervals, the test."""
        return sentences(self)

    @property
    def table(self) -> "pd.DataFrame":
        """A pandas table with a row for each world and contender.

        Each measure has its value, the ends of its 95 % interval (`_low`, `_high`), its `_rank` in the world and its
        `_standing`. "best" differs from all others, "level" is first or does not differ from the first, "behind"
        differs from the first. With `against`, standings are "better", "level" or "worse". Costs and sizes
        follow.
        """
        return tables.table(self)

    @property
    def pairs(self) -> "pd.DataFrame":
        """A pandas table with a row for each measure, world and pair of contenders: the difference `one` - `other`."""
        return tables.pairs(self)

    @property
    def ranks(self) -> "pd.DataFrame":
        """A pandas table with a row for each measure and contender: its average rank, and where it is first."""
        return tables.ranks(self)

    @property
    def duels(self) -> "pd.DataFrame":
        """A pandas table with a row for each measure and pair: the share of common worlds in which one is ahead."""
        return tables.duels(self)

    @property
    def profiles(self) -> "pd.DataFrame":
        """A pandas table of times that may never come: the `share` of trials in which each has come by a round.

        It has a row for each measure, world, contender and round in which the share changes, and the ends of the 95 %
        interval.
        """
        return profiles(self)

    def by(self, *axes: str | Sequence[str]) -> "pd.DataFrame":
        """A pandas table: for each combination of these axes' values and contender, the number of each standing.

        With `against`, each measure also has the contender's value divided by the reference's (`_ratio`), or for shares
        their difference (`_difference`): the median over these worlds, and the worst. Raises InputError if worlds do
        not differ in such an axis.
        """
        return groups.groups(self, [name for axis in axes for name in ([axis] if isinstance(axis, str) else axis)])

    def __str__(self) -> str:
        """The verdict and the cautions, one sentence a line."""
        return "\n".join(showing.said(self))

    def __repr__(self) -> str:
        """The table of its worlds with marks and intervals, the verdict and the cautions."""
        return showing.as_text(self)

    def _repr_html_(self) -> str:
        """The same, as a notebook shows it."""
        return showing.as_html(self)


def compare(
    results: xr.Dataset | str | Path,
    metric: str | Sequence[str] = (),
    where: str | None = None,
    against: str | None = None,
    factor: str | Sequence[str] = (),
    margin: float | Mapping[str, float] | None = None,
) -> Comparison:
    """Compare brains, or the levels of any other factor, within each world (docs/comparing.md).

    `metric` names the measures that are compared and corrected for, such as "correct" or ["final_error",
    "my_metric:low"]. By default they are the final error, the convergence, the right decisions, consensus if brains
    decide, and metrics from files. `where` selects settings, as in `swarmcensus show`. With `against`, the name of a
    contender, or of a brain with one contender only, all others are compared with it alone, which takes fewer tests.
    `factor` names one or several coordinates of settings, such as "topology": their levels are compared where all else
    is equal. Trials are paired where they share random numbers. `margin` is a difference that makes no difference in
    practice, in the measure's unit, or several by the names of measures; differences with intervals within it are
    called equal for practical purposes. Raises InputError, for example if there is nothing to compare.
    """
    return compare_dataset(loaded(results), metric, where, against, {}, factor, margin)


def compare_dataset(
    whole: xr.Dataset,
    metric: str | Sequence[str],
    where: str | None,
    against: str | None,
    shown: Mapping[str, Collection[str]],
    factor: str | Sequence[str] = (),
    margin: float | Mapping[str, float] | None = None,
) -> Comparison:
    """Compare as `compare` does; `shown` names, by brain, parameters that appear in contenders' names in any case."""
    data = selecting.where(whole, where)
    selecting.require(data, "convergence_round", "rounds", dimensions=("setting", "trial"))
    grid, cautions = grid_of(data, whole, shown, [factor] if isinstance(factor, str) else factor)
    if not isinstance(against, str | None):
        raise wrong_option("against", against, "should be the name of a contender")
    reference = None if against is None else _contender_index(against, grid.contenders, labels_in(whole))
    measured, notes_on_measures = measures.chosen(data, metric)
    if "delta" in data.attrs:
        delta = f"delta = {data.attrs['delta']:g}"
        measured = [replace(measure, meaning=measure.meaning.replace("delta", delta)) for measure in measured]
    margins = _margins(margin, measured, data)
    numbers = [grid.spread(learnt_numbers(data, measure.name)) for measure in measured]
    if all(np.isnan(each).all() for each in numbers):
        labels = ", ".join(measure.label for measure in measured)
        lacking = f"has numbers of {labels}" if done(data).any() else "has been run"
        raise InputError(f"there is nothing to compare: no trial of these settings {lacking}")
    inputs = [
        ContestInput(each, measure.statistic, measure.low, measure.share)
        for each, measure in zip(numbers, measured, strict=True)
    ]
    origins = known_origins(data)
    paired, pairing = pairing_of(data, grid, origins)
    all_contests = [
        _as_shown(contest, measure.name, data, grid)
        for contest, measure in zip(contests(inputs, against=reference, paired=paired), measured, strict=True)
    ]
    costs = {
        name: grid.spread(cells(data, name, intervals=False).value) for name in COSTS if not measures.lacks(data, name)
    }
    sizes = {name: grid.spread(data[name].values.astype(np.float64)) for name in SIZES if name in data}
    settings = np.where(grid.place == NONE, NONE, data["setting"].values[grid.place])
    names = [measure.name for measure in measured]
    tails: dict[str, tuple[Floats, Floats, Floats]] = {}
    if "final_error" in names and TAIL not in names and shows_tail(data):
        value, low, high = map(grid.spread, cells(data, TAIL))
        tails[TAIL] = value, low, high
        cautions += _of_tails(data, grid)
    cautions += [*notes_on_measures, *_cautions(data, grid, measured, numbers, all_contests, costs, origins)]
    title = str(data.attrs.get("title", ""))
    return Comparison(
        title=title,
        grid=grid,
        measures=measured,
        contests=all_contests,
        costs=costs,
        sizes=sizes,
        settings=settings,
        rounds=grid.spread(data["rounds"].values),
        cautions=cautions,
        tails=tails,
        pairing=pairing,
        margins=margins,
        against=reference,
    )


def _margins(margin: float | Mapping[str, float] | None, measured: list[Measure], data: xr.Dataset) -> dict[str, float]:
    """The margin of each measure that has one. Raises InputError."""
    names = [measure.name for measure in measured]
    if margin is None:
        return {}
    if not isinstance(margin, Mapping):
        if len(names) > 1:
            example = option("margin", f"{names[0]}={margin}") if in_shell() else f"margin={{{names[0]!r}: {margin}}}"
            raise wrong_option("margin", margin, f"there are {len(names)} measures: name one, as {example}")
        margin = {names[0]: margin}
    margin = {measures.named(data, name, names): value for name, value in margin.items()}
    for name, value in margin.items():
        if name not in names:
            there = f"{did_you_mean(name, [*names, *OURS])}it is not compared: the measures are {', '.join(names)}"
            raise wrong_option("margin", name, there)
        if not (isinstance(value, int | float) and 0.0 < value < np.inf):
            raise wrong_option("margin", value, "should be a number above 0")
        if value >= 1.0 and next(measure for measure in measured if measure.name == name).share:
            raise wrong_option("margin", value, f"{name} is a share: 5 % is 0.05")
    return {name: float(value) for name, value in margin.items()}


def _as_shown(contest: Contest, name: str, data: xr.Dataset, grid: Grid) -> Contest:
    """A contest with the values and intervals that summaries and figures have.

    Their medians are over all robots of all trials; tests pair trials, by the median robot of each.
    """
    value, low, high = map(grid.spread, learnt_cells(data, name))
    return replace(contest, values=value, value_ends=(low, high))


def _contender_index(name: str, contenders: list[str], labels: Mapping[str, str]) -> int:
    """The place of the contender with this name or label, or of the only contender of the brain with it."""
    if name not in contenders:
        name = renamed(name, labels)
    if name in contenders:
        return contenders.index(name)
    levels = [contender for contender in contenders if contender.partition("=")[2] == name]
    if len(levels) == 1:
        return contenders.index(levels[0])
    matches = [contender for contender in contenders if contender.startswith(f"{name} ")]
    if len(matches) > 1:
        raise wrong_option("against", name, f"these are several, {', '.join(matches)}: name one")
    if not matches:
        hint = did_you_mean(name, contenders)
        raise wrong_option("against", name, f"{hint}there are {', '.join(contenders)}")
    return contenders.index(matches[0])


def _cautions(
    data: xr.Dataset,
    grid: Grid,
    measured: list[Measure],
    numbers_of: list[Floats],
    all_contests: list[Contest],
    costs: dict[str, Floats],
    origins: Origins,
) -> list[str]:
    """What limits a comparison, one sentence each."""
    cautions = []
    failed = len(failed_trials(data))
    if failed:
        cautions.append(f"{counted(failed, 'trial')} failed and cannot be compared")
    counts = all_contests[0].trials[grid.place != NONE]
    if counts.min() < counts.max():
        cautions.append(
            f"contenders have {counts.min()} to {counts.max():,} trials: a pair is compared in the trials that both "
            "have, and over all worlds in the trials that all contenders have in every world"
        )
    for measure, numbers in zip(measured, numbers_of, strict=True):
        lacking = np.isnan(numbers).all(axis=2) & (grid.place != NONE)
        if lacking.any():
            names = [name for name, absent in zip(grid.contenders, lacking.any(axis=0), strict=True) if absent]
            cautions.append(
                f"{measure.label}: there are no numbers of {', '.join(names)} in {_worlds(lacking.any(axis=1))}"
            )
    cautions += cautions_of_needs(data, [measure.name for measure in measured], origins)
    cautions += filter(None, (in_worlds_too_few(all_contests), overall_too_few(all_contests)))
    pairs = [(grid.contenders[i], grid.contenders[j]) for i, j in pairs_of(len(grid.contenders))]
    cautions += [
        f"{measure.label}: {first} and {second} are the same in every trial that both have"
        for measure, contest in zip(measured, all_contests, strict=True)
        if measure.unit == "1" and not measure.share  # counts and shares may be equal by chance
        for (first, second), level in zip(pairs, contest.level, strict=True)
        if level
    ]
    absent = dict.fromkeys(lacked for name in COSTS if name not in costs for lacked in measures.lacks(data, name))
    absent |= dict.fromkeys(name for name in SIZES if name not in data)
    if absent:
        cautions.append(f"these results do not say what brains cost: they have no {', no '.join(absent)}")
    if "anonymous" in data:
        seen = grid.spread(data["anonymous"].values.astype(np.float64))
        named = [name for k, name in enumerate(grid.contenders) if (seen[:, k] == 0).any()]
        if grid.factor and "brain" not in grid.factor:
            named = list(dict.fromkeys(data["brain"].values[data["anonymous"].values == 0].tolist()))
        if len(named) == 1:
            cautions.append(f"{named[0]} is not anonymous: it uses its robot's name")
        elif named:
            cautions.append(f"{', '.join(named)} are not anonymous: they use their robots' names")
    names = [measure.name for measure in measured]
    if "correct" in names:
        cautions += cautions_of_edges(data)
    if "agreement_round" in names:
        cautions += _of_agreement(grid, all_contests[names.index("agreement_round")], data)
    if {*SETTLING} & {*names}:
        unmoved = np.asarray(grid.spread(never_learnt(data).astype(np.float64)) == 1.0)
        named = [name for k, name in enumerate(grid.contenders) if unmoved[:, k].any()]
        if named:
            where = _worlds(np.asarray(unmoved.any(axis=1)))
            cautions.append(
                f"{', '.join(named)}: in {where} at least half of the robots have K = 0: their estimates never moved "
                "by delta, so trials in which the median robot did not move count as never settled and never agreed"
            )
    if "convergence_round" in names:
        cautions += cautions_of_settling(data)
        if "delta" in asked_anew(data):
            cautions.append("K was computed again from stored estimates, so it is always one of the checkpoints")
    if asked_anew(data):
        changed = " and ".join(f"{key} = {data.attrs[key]:g}" for key in asked_anew(data))
        cautions.append(f"computed with {changed}, which is not the study's own")
    return cautions


def _of_agreement(grid: Grid, contest: Contest, data: xr.Dataset) -> list[str]:
    """Sentences on worlds in which robots never part, and in which more rounds would tell more, if there are any."""
    zero: NDArray[np.bool_] = np.equal(contest.values, 0)
    names = ", ".join(grid.contenders[k] for k in np.flatnonzero(zero.any(axis=0)))
    together = f"{names}: agreement round 0 in {_worlds(np.asarray(zero.any(axis=1)))}: {TOGETHER}"
    rounds = grid.spread(data["rounds"].values)
    late = (contest.values > LATE * rounds) & np.isfinite(contest.values)
    never = (contest.values == np.inf) | np.isnan(contest.values)
    found = np.asarray(late.any(axis=1) | never.all(axis=1))
    later = f"agreement round: in {_worlds(found)} robots agree in the last tenth of the run, or never: run longer"
    return [together] * bool(zero.any()) + [later] * bool(found.any())


def _of_tails(data: xr.Dataset, grid: Grid) -> list[str]:
    """A sentence on the contenders with a tail that their median error hides, if there are any."""
    share = grid.spread(np.where(has_tail(data), far_off(data), np.nan))
    most = [
        (name, float(column[~np.isnan(column)].max(initial=0.0)))
        for name, column in zip(grid.contenders, share.T, strict=True)
    ]
    named = ", ".join(f"{name} (up to {most:.0%})" for name, most in most if most)
    if not named:
        return []
    where = _worlds(np.asarray(~np.isnan(share).all(axis=1)))
    return [f"robots that err more than {TIMES:g} times as much as the median robot, in {where}: {named}"]


def _worlds(which: NDArray[np.bool_]) -> str:
    numbers = np.flatnonzero(which).tolist()
    several = ", ".join(map(str, numbers[:8])) + (", ..." if len(numbers) > 8 else "")
    return f"world{'s' * (len(numbers) > 1)} {several}"
