"""Which brain, or level of another factor, is better in which world, by how much and at what cost: `sc.compare`."""

import functools
from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any, overload

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from swarmcensus.analysis.comparing import showing
from swarmcensus.analysis.comparing.contenders import NONE, Grid, contender_index, grid_of
from swarmcensus.analysis.comparing.interactions import Interaction, interaction_of
from swarmcensus.analysis.comparing.pair_tests import (
    ContestInput,
    contests,
    in_worlds_too_few,
    overall_too_few,
    pairs_of,
)
from swarmcensus.analysis.comparing.pairing import pairing_of
from swarmcensus.analysis.comparing.sentences import sentences
from swarmcensus.analysis.comparing.tables import Frames
from swarmcensus.analysis.comparing.verdicts import verdict
from swarmcensus.results import as_dataset
from swarmcensus.summaries import (
    AGREED_AT_START,
    COSTS,
    SETTLING_TIMES,
    SIZES,
    TAIL_QUANTITY,
    TIMES,
    Measure,
    cautions_of,
    cells,
    done_trials,
    far_off,
    has_tail,
    known_origins,
    learnt_cells,
    learnt_numbers,
    measures,
    never_learnt,
    selecting,
    shows_tail,
)
from swarmcensus.support.errors import InputError
from swarmcensus.support.hints import did_you_mean
from swarmcensus.support.options import in_shell, option, option_conflict, wrong_option
from swarmcensus.support.printed_tables import Table

LATE = 0.9  # share of the rounds from which on agreement is late


class Comparison(Frames):
    """A comparison of contenders in worlds, with `table`, `pairs`, `ranks` and `duels` as pandas tables.

    Its rows are those of worlds, with `with_pairs` those of pairs, and with `axes` those of groups of worlds.
    """

    with_pairs: bool = False
    axes: Sequence[str] = ()

    @property
    def verdict(self) -> list[str]:
        """Who is best in how many worlds, and who does not differ from the best: one sentence each."""
        return verdict(self)

    @property
    def pair_sentences(self) -> list[str]:
        """One sentence on each difference, for a paper: values, difference and probability with intervals, the test."""
        return sentences(self)

    @functools.cached_property
    def sentences(self) -> list[str]:  # type: ignore[override]
        """The verdict, until more is added."""
        return self.verdict

    @functools.cached_property
    def rows(self) -> list[dict[str, Any]]:  # type: ignore[override]
        """Those of worlds and contenders, of pairs, or of groups of worlds."""
        frame = self.by(*self.axes) if self.axes else self.pairs if self.with_pairs else self.table
        return [*frame.to_dict("records")]

    @property
    def fields(self) -> dict[str, Any]:  # type: ignore[override]
        """What JSON says too: measures, how trials are paired, and the tables that are not the rows."""
        frames = {"worlds": self.table, "pairs": self.pairs, "ranks": self.ranks, "duels": self.duels}
        frames |= {"profiles": profiles} if len(profiles := self.profiles) else {}
        if not self.axes:
            del frames["pairs" if self.with_pairs else "worlds"]
        plain = {name: frame.to_dict("records") for name, frame in frames.items()}
        return {"measures": self.measures, "pairing": self.pairing, **plain}

    def tables(self, limit: int) -> list[Table]:
        """What is shown to people: pairs if they are asked for, and worlds or groups of them."""
        if self.axes:
            return [showing.groups_table(self, self.axes).first(limit)]
        worlds = showing.worlds_table(self, limit)
        return [showing.pairs_table(self).first(limit), worlds] if self.with_pairs else [worlds]


@overload
def compare(
    results: xr.Dataset | str | Path, metric: str | Sequence[str] = (), where: str | None = None,
    against: str | None = None, factor: str | Sequence[str] = (), margin: float | Mapping[str, float] | None = None,
) -> Comparison: ...  # fmt: skip
@overload
def compare(
    results: xr.Dataset | str | Path, metric: str | Sequence[str] = (), where: str | None = None,
    against: str | None = None, factor: str | Sequence[str] = (), margin: float | Mapping[str, float] | None = None, *,
    interaction: str | Sequence[str],
) -> Interaction: ...  # fmt: skip
def compare(
    results: xr.Dataset | str | Path, metric: str | Sequence[str] = (), where: str | None = None,
    against: str | None = None, factor: str | Sequence[str] = (), margin: float | Mapping[str, float] | None = None, *,
    interaction: str | Sequence[str] = (),
) -> Comparison | Interaction:  # fmt: skip
    """Compare brains, or the levels of any other factor, within each world (docs/comparing.md).

    `metric` names the measures that are compared and corrected for, such as "correct" or ["final_error",
    "my_metric:low"]. By default they are the final error, the convergence, the right decisions, consensus if brains
    decide, and metrics from files. `where` selects settings, as in `swarmcensus show`. With `against`, the name of a
    contender, or of a brain with one contender only, all others are compared with it alone, which takes fewer tests.
    `factor` names one or several coordinates of settings, such as "topology": their levels are compared where all else
    is equal. Trials are paired where they share random numbers. `margin` is a difference that makes no difference in
    practice, in the measure's unit, or several by the names of measures; pairs that differ by less are called equal for
    practical purposes, corrected for their number. With `interaction`, the names of other coordinates, the answer is
    whether the effect of the factor differs between their levels. Raises InputError, for example if there is nothing to
    compare.
    """
    if interaction:
        if margin is not None:
            raise option_conflict("margin", margin, "does not go with an interaction")
        several = ([one] if isinstance(one, str) else one for one in (factor, interaction))
        return interaction_of(as_dataset(results), metric, where, against, *several)
    return compare_dataset(as_dataset(results), metric, where, against, {}, factor, margin)


def compare_dataset(
    whole: xr.Dataset, metric: str | Sequence[str], where: str | None, against: str | None,
    shown: Mapping[str, Collection[str]], factor: str | Sequence[str] = (),
    margin: float | Mapping[str, float] | None = None,
) -> Comparison:  # fmt: skip
    """Compare as `compare` does; `shown` names, by brain, parameters that appear in contenders' names in any case."""
    data = selecting.where(whole, where)
    selecting.require(data, "convergence_round", "rounds", dimensions=("setting", "trial"))
    grid, cautions = grid_of(data, whole, shown, [factor] if isinstance(factor, str) else factor)
    reference = None if against is None else contender_index(against, grid.contenders, whole)
    measured, notes_on_measures = measures.choose_measures(data, metric)
    if "delta" in data.attrs:
        delta = f"delta = {data.attrs['delta']:g}"
        measured = [replace(measure, meaning=measure.meaning.replace("delta", delta)) for measure in measured]
    margins = _margins(margin, measured, data)
    numbers = [grid.spread(learnt_numbers(data, measure.name)) for measure in measured]
    if all(np.isnan(each).all() for each in numbers):
        labels = ", ".join(measure.label for measure in measured)
        lacking = f"has numbers of {labels}" if done_trials(data).any() else "has been run"
        raise InputError(f"there is nothing to compare: no trial of these settings {lacking}")
    given = zip(numbers, measured, strict=True)
    inputs = [ContestInput(n, one.statistic, one.low, one.share, margins.get(one.name)) for n, one in given]
    origins = known_origins(data)
    paired, pairing = pairing_of(data, grid, origins)
    tested = []
    for contest, measure in zip(contests(inputs, against=reference, paired=paired), measured, strict=True):
        # Shown are medians over all robots of all trials; tests pair trials, by the median robot of each.
        value, low, high = map(grid.spread, learnt_cells(data, measure.name))
        tested.append(replace(contest, values=value, value_ends=(low, high)))
    sent = [name for name in COSTS if not measures.missing_inputs(data, name)]
    costs = {name: grid.spread(cells(data, name, intervals=False).value) for name in sent}
    costs |= {name: grid.spread(data[name].values.astype(np.float64)) for name in SIZES if name in data}
    names = [measure.name for measure in measured]
    if "final_error" in names and TAIL_QUANTITY not in names and shows_tail(data):
        costs[TAIL_QUANTITY] = grid.spread(cells(data, TAIL_QUANTITY, intervals=False).value)
        share = grid.spread(np.where(has_tail(data), far_off(data), np.nan))
        most = np.nanmax(share, axis=0, initial=0.0).tolist()
        named = [f"{name} (up to {each:.0%})" for name, each in zip(grid.contenders, most, strict=True) if each]
        far = f"robots that err more than {TIMES:g} times as much as the median robot, in {_worlds(~np.isnan(share))}"
        cautions += [f"{far}: {', '.join(named)}"] * bool(named)
    answer = Comparison(
        title=str(data.attrs.get("title", "")), grid=grid, measures=measured, contests=tested, costs=costs,
        asked=names if metric else ["final_error"],
        settings=np.where(grid.place == NONE, NONE, data["setting"].values[grid.place]),
        rounds=grid.spread(data["rounds"].values), cautions=[*cautions, *notes_on_measures],
        pairing=pairing, margins=margins, against=reference,
    )  # fmt: skip
    answer.cautions += [*_cautions(data, answer), *cautions_of(data, names, origins)]
    return answer


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
    margin = {measures.name_of(data, name, names): value for name, value in margin.items()}
    for name, value in margin.items():
        if name not in names:
            there = f"{did_you_mean(name, names)}it is not compared: the measures are {', '.join(names)}"
            raise wrong_option("margin", name, there)
        if not (isinstance(value, int | float) and 0.0 < value < np.inf):
            raise wrong_option("margin", value, "should be a number above 0")
        if value >= 1.0 and measured[names.index(name)].share:
            raise wrong_option("margin", value, f"{name} is a share: 5 % is 0.05")
    return {name: float(value) for name, value in margin.items()}


def _cautions(data: xr.Dataset, answer: Comparison) -> Iterator[str]:
    """What limits the tests of a comparison, one sentence each; what limits results is in `summaries.cautions_of`."""
    grid, compared = answer.grid, answer.contests
    counts = compared[0].trials[grid.place != NONE]
    if counts.min() < counts.max():
        said = "paired trials are those that both have; over all worlds, those that all contenders have in every world"
        yield f"contenders have {counts.min()} to {counts.max():,} trials: {said}"
    for measure, contest in zip(answer.measures, compared, strict=True):
        lacking = (contest.trials == 0) & (grid.place != NONE)
        if lacking.any():
            yield f"{measure.label}: there are no numbers of {_named(grid, lacking)} in {_worlds(lacking)}"
    names = [measure.name for measure in answer.measures]
    yield from filter(None, (in_worlds_too_few(compared), overall_too_few(compared)))
    for measure, contest in zip(answer.measures, compared, strict=True):
        for (first, second), level in zip(pairs_of(len(grid.contenders)), contest.level, strict=True):
            if level and measure.unit == "1" and not measure.share:  # counts and shares may be equal by chance
                both = f"{grid.contenders[first]} and {grid.contenders[second]}"
                yield f"{measure.label}: {both} are the same in every trial that both have"
    if "agreement_round" in names:
        values = compared[names.index("agreement_round")].values
        if (zero := np.equal(values, 0)).any():
            yield f"{_named(grid, zero)}: agreement round 0 in {_worlds(zero)}: {AGREED_AT_START}"
        ended = np.isfinite(values)
        late = (ended & (values > LATE * answer.rounds)) | ~ended.any(axis=1, keepdims=True)
        if late.any():
            yield f"agreement round: in {_worlds(late)} robots agree in the last tenth of the run, or never: run longer"
    unmoved: NDArray[np.bool_] = grid.spread(never_learnt(data).astype(np.float64)) == 1.0
    if {*SETTLING_TIMES} & {*names} and unmoved.any():
        yield (
            f"{_named(grid, unmoved)}: in {_worlds(unmoved)} at least half of the robots have K = 0: their estimates "
            "never moved by delta, so trials in which the median robot did not move count as never settled and never "
            "agreed"
        )


def _named(grid: Grid, which: NDArray[np.bool_]) -> str:
    """The contenders of which something is so in any world, from (world, contender)."""
    return ", ".join(grid.contenders[k] for k in np.flatnonzero(which.any(axis=0)))


def _worlds(which: NDArray[np.bool_]) -> str:
    """The worlds in which something is so of any contender, from (world, contender)."""
    numbers = np.flatnonzero(which.any(axis=1)).tolist()
    several = ", ".join(map(str, numbers[:8])) + (", ..." if len(numbers) > 8 else "")
    return f"world{'s' * (len(numbers) > 1)} {several}"
