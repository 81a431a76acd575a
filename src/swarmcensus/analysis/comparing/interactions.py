"""Whether the effect of one factor differs between the levels of another: differences of differences.

With two levels of each, the effect of the factor is the first level's number minus the second's. Of levels that share
random numbers, the difference of effects is that of each trial, tested by the signed-rank test. Else the effects in
trials are two independent samples, tested by the rank-sum test. As ranks may differ where means are equal, p is at
least that of the interval of the difference. Values are means over trials: of all statistics only these add up, so that
the difference is that of the effects, and lines of a figure are parallel where there is none.
"""

import functools
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from swarmcensus.analysis.comparing.cells import column_head, numbers, p_equals, p_value
from swarmcensus.analysis.comparing.contenders import (
    BRAIN,
    NONE,
    Grid,
    check_coordinates,
    contender_index,
    grid_of,
    level_names,
)
from swarmcensus.analysis.comparing.pair_tests import (
    ALPHA,
    difference_of,
    ends_of_pairs,
    exact_if_same,
    pairs_of,
    too_few,
)
from swarmcensus.analysis.comparing.pairing import pairing_of
from swarmcensus.summaries import (
    Measure,
    cautions_of,
    choose_measures,
    known_origins,
    learnt_numbers,
    selecting,
)
from swarmcensus.support.answers import Answer
from swarmcensus.support.errors import InputError
from swarmcensus.support.formatting import counted
from swarmcensus.support.intervals import LEVEL, Estimate, Floats, estimate
from swarmcensus.support.options import in_shell, wrong_option
from swarmcensus.support.printed_tables import ASKED, REST, STAYS, Column, Table
from swarmcensus.support.rank_sums import rank_sums
from swarmcensus.support.significance import RankTest, differences, holm, signed_ranks

TESTS = {"signed-rank": "paired by trial", "rank-sum": "two samples"}


@dataclass(repr=False, eq=False, kw_only=True)
class Interaction(Answer):
    """How effects differ between levels of another factor.

    Rows are differences of differences: of two levels of `factor` between two levels of `by`. `values` of a measure are
    its numbers in trials, averaged over the worlds that have all levels, (level of the factor, level of `by`, trial);
    NaN if no world has them all.
    """

    title: str
    factor: tuple[str, ...]
    by: tuple[str, ...]
    levels: list[str]
    by_levels: list[str]
    measures: list[Measure]
    values: list[Floats]
    rows: list[dict[str, Any]]
    cautions: list[str]
    pairing: list[str]

    @functools.cached_property
    def cells(self) -> list[dict[str, Any]]:
        """The mean of each measure at each two levels (`value`), and the ends of its 95 % interval (`low`, `high`)."""
        found = []
        for measure, values in zip(self.measures, self.values, strict=True):
            for a, b in np.ndindex(values.shape[:2]):
                sample = values[a, b][~np.isnan(values[a, b]), np.newaxis]
                part = estimate(sample, "mean", measure.share)._asdict() if sample.size else {}
                found.append({"measure": measure.name, "level": self.levels[a], "by": self.by_levels[b], **part})
        return found

    @property
    def fields(self) -> dict[str, Any]:  # type: ignore[override]
        """What JSON says too: measures, factors, how trials are paired, and the values at all levels."""
        return {name: getattr(self, name) for name in ("measures", "factor", "by", "pairing", "cells")}

    @property
    def sentences(self) -> list[str]:  # type: ignore[override]
        """A sentence for each difference of effects."""
        return [sentence for measure in self.measures for sentence in self._sentences(measure)]

    def _sentences(self, measure: Measure) -> Iterator[str]:
        unit = f" ({measure.unit})" * (measure.unit != "1" and not measure.share)
        tests = f" after Holm's correction for {len(self.rows):,} tests" * (len(self.rows) > 1)
        rows = [row for row in self.rows if row["measure"] == measure.name]
        for row, (text, ends) in zip(rows, self._texts(measure), strict=True):
            one, other = (f"{row[name] * 100**measure.share + 0.0:.3g}" for name in ("effect", "other_effect"))
            effect = f"the effect of {row['one']} vs. {row['other']} on {column_head(measure)}{unit}"
            effect += f" over {counted(row['worlds'], 'world')}" * (row["worlds"] > 1)
            between = f"{one} with {row['level']} and {other} with {row['other_level']}"
            how = f"told apart ({TESTS[row['test']]}, p {p_equals(row['p_holm'])}{tests})"
            yield f"{effect} is {between}; difference {text} {ends}, {'not ' * (not row['told_apart'])}{how}"

    def _texts(self, measure: Measure) -> list[tuple[str, str]]:
        """Each difference and its interval as text."""
        rows = [row for row in self.rows if row["measure"] == measure.name]
        with_ends = (np.array([row[f"difference{end}"] for row in rows]) for end in ("", "_low", "_high"))
        trials = np.array([min(row["trials"], row["other_trials"]) for row in rows])
        return numbers(with_ends, trials, measure, differences=True)

    def tables(self, limit: int) -> list[Table]:
        """A row for each difference of effects."""
        by, measures = ", ".join(self.by), {measure.name: measure for measure in self.measures}
        texts = [text for measure in self.measures for text in self._texts(measure)]
        columns = [
            Column("measure", [column_head(measures[r["measure"]]) for r in self.rows], number=False, name="measure"),
            *(Column(head, [r[name] for r in self.rows], number=False, rank=STAYS, name=name)
              for name, head in {"one": "one", "other": "other", "level": f"{by} 1", "other_level": f"{by} 2"}.items()),
            Column("difference", [t for t, _ in texts], rank=ASKED, intervals=[ends for _, ends in texts],
                   name="difference", meaning="of effects, the first minus the second; [95 %]: over trials"),
            Column("test", [TESTS[r["test"]] for r in self.rows], number=False, rank=REST, name="test"),
            Column("corrected p", [p_value(r["p_holm"]) for r in self.rows], rank=ASKED, name="p_holm"),
            Column("differs", ["yes" if r["told_apart"] else "no" for r in self.rows], number=False, name="told_apart"),
        ]  # fmt: skip
        return [Table(columns, notes=lambda _: self.pairing).first(limit)]


def interaction_of(
    whole: xr.Dataset, metric: str | Sequence[str], where: str | None, against: str | None, factor: Sequence[str],
    by: Sequence[str],
) -> Interaction:  # fmt: skip
    """Compare the effects of a factor between the levels of `by`; other options are those of `compare`.

    Numbers of a trial are averaged over the worlds that have the four combinations of two levels and two others; what
    was not run in all of them is left out. Raises InputError.
    """
    data = selecting.where(whole, where)
    selecting.require(data, "convergence_round", "rounds", dimensions=("setting", "trial"))
    factor, by = tuple(dict.fromkeys(factor or (BRAIN,))), tuple(dict.fromkeys(by))
    option = "by" if in_shell() else "interaction"
    check_coordinates(data, by, option)
    if twice := {*factor} & {*by}:
        raise wrong_option(option, min(twice), "it is the factor: its effect is compared between levels of another one")
    grid, notes = grid_of(data, whole, factor=(*factor, *by))
    named = [level_names(data, whole, part, other) for part, other in ((factor, by), (by, factor))]
    (levels, by_levels) = ([*dict.fromkeys(names)] for names in named)
    place, contender = _four_ways(grid, named, levels, by_levels)
    pairs = pairs_of(len(levels))
    if against is not None:
        reference = contender_index(against, levels, whole)
        pairs = [pair for pair in pairs if reference in pair]
    origins = known_origins(data)
    paired, pairing = pairing_of(data, grid, origins)
    first, second = ends_of_pairs(len(grid.contenders))
    shared = np.zeros((len(grid.contenders),) * 2, np.bool_)
    shared[first, second] = shared[second, first] = paired.any(axis=0)
    measured, cautions = choose_measures(data, metric)
    kept, numbers_of, tests = list[Measure](), list[Floats](), list[RankTest]()
    rows = list[dict[str, Any]]()
    for measure in measured:
        every = replace(grid, place=place).spread(learnt_numbers(data, measure.name))
        why = "no trial has numbers of it" * bool(np.isnan(every).all())
        if never := int(np.isinf(every).sum()):
            how = f"never comes in {counted(never, 'trial')}, and a difference from never has no size"
            why = f"{how}: name a share, such as consensus_right"
        if why:
            if metric:
                raise wrong_option("metric", measure.name, why)
            cautions.append(f"{measure.label}: {why}")
            continue
        kept.append(measure)
        numbers_of.append(every)
        for (a, c), (b, d) in ((pair, other) for pair in pairs for other in pairs_of(len(by_levels))):
            who = np.ix_([a, c], [b, d])
            worlds = (place[:, who[0], who[1]] != NONE).all(axis=(1, 2))
            if not worlds.any():
                continue
            four, at = every[worlds][:, who[0], who[1]].mean(axis=0), contender[who]
            across = by == (BRAIN,) or bool(shared[np.ix_(at[:, 0], at[:, 1])].any())
            known = ~np.isnan(four)
            if not (known.all(axis=(0, 1)).any() if across else known.all(axis=0).any(axis=1).all()):
                continue
            row, test = _difference(four, across, factor == (BRAIN,) or bool(shared[np.ix_(at[0], at[1])].any()))
            about = {"measure": measure.name, "unit": measure.unit, "one": levels[a], "other": levels[c]}
            rows.append(about | {"level": by_levels[b], "other_level": by_levels[d], "worlds": int(worlds.sum())} | row)
            tests.append(test)
    if not kept:
        raise InputError(f"there is no difference of effects: {cautions[-1]}")
    if not rows:
        names = f"{', '.join(factor)} at each of two levels of {', '.join(by)}"
        raise InputError(f"no trial has two levels of {names}", key="by")
    for row, test, corrected in zip(rows, tests, holm(np.array([float(t.p) for t in tests])).tolist(), strict=True):
        agree = np.sign(row["difference"]) * np.sign(test.balance) >= 0
        row |= {"p": float(test.p), "p_holm": corrected, "told_apart": bool(agree and corrected <= ALPHA)}
    # levels that have met no others are not drawn
    used = [[k for k, level in enumerate(all_levels) if any(level in (row[one], row[other]) for row in rows)]
            for all_levels, one, other in ((levels, "one", "other"), (by_levels, "level", "other_level"))]  # fmt: skip
    among: Any = (slice(None), *np.ix_(*used))
    met, blank = (place[among] != NONE).all(axis=(1, 2)), np.full((*map(len, used), data.sizes["trial"]), np.nan)
    values = [every[among][met].mean(axis=0) if met.any() else blank for every in numbers_of]
    levels, by_levels = ([names[k] for k in some] for names, some in zip((levels, by_levels), used, strict=True))
    most = max(row["trials"] for row in rows)
    few = too_few(most, len(rows), "compare fewer measures or levels", paired=rows[0]["test"] == "signed-rank")
    cautions += [note for note in notes if note.startswith("where")]  # others are of what is in no pair
    cautions += [*cautions_of(data, [m.name for m in kept], origins), *[few] * bool(few)]
    return Interaction(
        title=str(data.attrs.get("title", "")), factor=factor, by=by, levels=levels,
        by_levels=by_levels, measures=kept, values=values, rows=rows, cautions=cautions, pairing=pairing,
    )  # fmt: skip


def _four_ways(
    grid: Grid, named: Sequence[Sequence[str]], levels: list[str], by_levels: list[str]
) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
    """The place of each setting, (world, level, other level), and the contender with these levels; -1 is none."""
    place = np.full((len(grid.worlds), len(levels), len(by_levels)), NONE, np.intp)
    contender = np.full(place.shape[1:], NONE, np.intp)
    for world, k in np.argwhere(grid.place != NONE).tolist():
        setting = grid.place[world, k]
        at = levels.index(named[0][setting]), by_levels.index(named[1][setting])
        place[world, *at], contender[at] = setting, k
    return place, contender


def _difference(four: Floats, across: bool, within: bool) -> tuple[dict[str, Any], RankTest]:
    """The difference of effects with its interval, and its test, from numbers (level of the factor, other one, trial).

    `across` says whether the levels between which effects are compared share random numbers, `within` whether those
    of the factor do.
    """
    effects = differences(four[0], four[1])  # (level, trial)
    row: dict[str, Any] = dict(zip(("effect", "other_effect"), np.nanmean(effects, axis=1).tolist(), strict=True))
    one, other = effects
    if across and not within:  # the levels of the factor are the independent ones
        one, other = differences(four[:, 0], four[:, 1])
    if across and within:
        one = differences(one, other)
        other = 0.0 * one
    one, other = one[~np.isnan(one)], other[~np.isnan(other)]

    def found(level: float = LEVEL) -> tuple[float, float, float]:
        return difference_of(one, other, _estimate(one, level), _estimate(other, level))

    test, how = (signed_ranks(one), "signed-rank") if across and within else (rank_sums(one, other), "rank-sum")
    ends = dict(zip(("difference", "difference_low", "difference_high"), found(), strict=True))
    test = test._replace(p=np.maximum(test.p, _p_of_mean(found)))
    return row | {"test": how, "trials": one.size, "other_trials": other.size} | ends, test


def _estimate(sample: Floats, level: float) -> Estimate:
    value, low, high = estimate(sample[:, np.newaxis], "mean", level=level)
    return exact_if_same(value, low if differences(sample, sample[0]).any() else np.nan, high, sample.size)


def _p_of_mean(found: Callable[[float], tuple[float, float, float]]) -> float:
    """The p-value of which the interval just holds 0; 0 if there is no interval."""
    least, most = -15.0, 0.0  # powers of ten
    for _ in range(20):
        power = (least + most) / 2
        _, low, high = found(1 - 10**power)
        least, most = (power, most) if low <= 0.0 <= high else (least, power)
    return 10**least
