"""Whether each setting's errors agree with exact theory; and `sc.explain`."""

import math
from collections import Counter
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NamedTuple, overload

import numpy as np
import xarray as xr

from swarmcensus.analysis.explaining import one_setting
from swarmcensus.analysis.explaining.exact_errors import exact_errors
from swarmcensus.analysis.explaining.expectations import MIXED, SWARM, Origin, expect
from swarmcensus.analysis.explaining.one_setting import (
    NONE,
    Explanation,
    Interval,
    efficiency_of,
    ends_text,
    errors_of,
    mean_of,
    terms_of,
)
from swarmcensus.results import as_dataset, origins_of
from swarmcensus.summaries import EMPTY_CELL, Summary, coordinate_columns, done_trials, varied_and_same
from swarmcensus.support.answers import Answer
from swarmcensus.support.bootstrap import centres
from swarmcensus.support.errors import InputError
from swarmcensus.support.formatting import counted
from swarmcensus.support.intervals import Floats, estimate
from swarmcensus.support.printed_tables import ASKED, REST, Column, Table, with_ends

MISSES = 1000  # one in this many settings differs by chance
FEWEST = 50  # trials for a verdict: with fewer, intervals of this level miss the truth too often
GRAPHS = 20  # graphs of which the mixing is computed, to find the largest part of the error
AGREES, DIFFERS, UNKNOWN = "agrees", "differs", "unknown"


class SettingAgreement(NamedTuple):
    """A setting compared with theory by its root mean squared error after the last round, over robots and trials."""

    setting: int
    what: str  # the setting in a line
    trials: int
    measured: float  # the root of the mean of (x - f)^2
    expected: float  # by theory; NaN if theory is not exact
    ratio: Interval  # of measured to expected, robot by robot, with its 99.9 % interval over trials
    efficiency: Interval  # the bound of the whole swarm divided by the mean squared error, with its 95 % interval
    calibration: float  # the error that wrong beliefs about b and w add; NaN if robots know their sensors
    limit: str  # the largest part of the error, one of `Explanation.terms`; empty if theory has none
    verdict: str  # "agrees", "differs" or "unknown"
    why: str  # why the verdict is unknown


@dataclass(repr=False)
class Agreement(Answer):
    """All settings compared with theory, and how many of them agree."""

    settings: list[SettingAgreement]
    data: xr.Dataset  # of these settings, in this order
    title: str = ""

    @property
    def exact(self) -> int:
        """How many settings have a verdict."""
        return sum(row.verdict != UNKNOWN for row in self.settings)

    @property
    def agree(self) -> int:
        """How many of these agree."""
        return sum(row.verdict == AGREES for row in self.settings)

    @property
    def by_chance(self) -> float:
        """How many of these would differ on average if theory holds; bounds the chance that any does."""
        return self.exact / MISSES

    @property
    def fields(self) -> dict[str, Any]:  # type: ignore[override]
        """How many agree, for JSON."""
        return {"exact": self.exact, "agree": self.agree, "by_chance": self.by_chance}

    @property
    def sentences(self) -> list[str]:  # type: ignore[override]
        """How many settings agree, how many have a verdict, and why the others have none."""
        chance, settings = self.by_chance, counted(len(self.settings), "setting")
        by_chance = f"{chance:.2g} would differ; the probability that any does is at most {100 * chance:.2g} %"
        verdict = f"{self.agree:,} of {counted(self.exact, 'setting')} with exact theory agree (by chance {by_chance})"
        if not (reasons := self._reasons()):
            return [verdict]
        some = f"{self.exact:,} of" if self.exact else "none of these"
        known = "of each, the table has the error and what limits it"
        return [verdict] * (self.exact > 0) + [
            f"a verdict on theory can be given for {some} {settings}; {known}",
            *(f"[{n}] no verdict for {counted(count, 'setting')}: {why}" for n, (why, count) in enumerate(reasons, 1)),
        ]

    def _reasons(self) -> list[tuple[str, int]]:
        """Why settings have no verdict, each reason with its number of settings."""
        return [*Counter(row.why for row in self.settings if row.why).items()]

    @property
    def rows(self) -> list[dict[str, Any]]:  # type: ignore[override]
        """A row for each setting, with its coordinates."""
        along = {str(k): c.values.tolist() for k, c in self.data.coords.items() if c.dims == ("setting",)}
        own = [dict(zip(along, values, strict=True)) for values in zip(*along.values(), strict=True)]
        return [known | with_ends(row._asdict()) for known, row in zip(own, self.settings, strict=True)]

    def tables(self, limit: int) -> list[Table]:
        """One table, without columns that are empty for all settings."""
        every, exact = self.settings, self.exact > 0
        varied, same = varied_and_same(self.data)
        reasons = [why for why, _ in self._reasons()]
        verdicts = [f"[{reasons.index(row.why) + 1}]" if row.why else row.verdict for row in every]
        columns = [
            *[Column("verdict", verdicts, number=False, rank=ASKED if exact else REST, name="verdict")]
            * (exact or len(reasons) > 1),
            _numbers("measured", [row.measured for row in every], ".5f", ASKED,
                     meaning="root mean squared error of x - f after the last round"),
            _numbers("theory", [row.expected for row in every], ".5f", name="expected",
                     meaning="its expected value, where that is exact"),
            _numbers("ratio", [row.ratio[0] for row in every], ".3f", ASKED if exact else REST,
                     intervals=[ends_text(row.ratio, "{:.3f}".format) for row in every], interval_head="[99.9 %]",
                     meaning="measured by theory, robot by robot: its interval over trials has 1 where they agree"),
            _numbers("efficiency", [row.efficiency[0] for row in every], ".3g",
                     meaning="bound of the whole swarm over the mean squared error (--setting shows its interval)"),
            _numbers("calibration", [row.calibration for row in every], ".5f",
                     meaning="error that wrong beliefs about b and w add to the estimate from all readings"),
            Column("limit", [row.limit or EMPTY_CELL for row in every], number=False, rank=ASKED, name="limit",
                   meaning="the largest part of the error"),
        ]  # fmt: skip
        known = [column for column in columns if {*column.cells} - {EMPTY_CELL}]
        left = [Column("setting", [str(row.setting) for row in every], name="setting")]
        return [Table([*left, *coordinate_columns(varied, len(every)), *known], above=same).first(limit)]


def _numbers(head: str, values: list[float], form: str, rank: int = REST, name: str = "", **more: Any) -> Column:
    cells = [format(value, form) if math.isfinite(value) else EMPTY_CELL for value in values]
    return Column(head, cells, rank=rank, name=name or head, **more)


@overload
def explain(results: xr.Dataset | str | Path, setting: int) -> Explanation: ...
@overload
def explain(results: xr.Dataset | str | Path, setting: None = None) -> Agreement: ...
def explain(results: xr.Dataset | str | Path, setting: int | None = None) -> Explanation | Agreement:
    """Compare a setting's measurements with theory, as an `Explanation`, or all settings in short, as an `Agreement`.

    `results` is a dataset or a results file, `setting` a value of its coordinate. Raises InputError.
    """
    data = as_dataset(results)
    return agreement(data) if setting is None else one_setting.explain(data, setting)


def agreement(data: xr.Dataset) -> Agreement:
    """Compare every setting that has run with theory. Raises InputError if none has."""
    ran = done_trials(data).any(axis=1)
    if not ran.any():
        raise InputError("no trial of these settings has been run")
    origins = origins_of(data, data["setting"].values[ran])
    shown = data.sel(setting=[*origins])
    rows = [_setting_agreement(data, number, origin) for number, origin in origins.items()]
    return Agreement(rows, shown, Summary(data, shown).title)


def _setting_agreement(data: xr.Dataset, number: int, origin: Origin) -> SettingAgreement:
    selected, tested = data.sel(setting=[number]), origin[1]
    squares = np.square(errors_of(selected))
    squared = mean_of(squares.mean(axis=1))
    lines = expect(data, number, [tested.rounds], [SWARM, MIXED], origin, GRAPHS)
    terms = terms_of(lines, squared[0])
    expected = exact_errors(*origin, data["trial"].values[done_trials(selected)[0]])
    root = float(expected.squared.mean()) ** 0.5 if not expected.why else np.nan
    ratio = _ratio(squares, expected.squared) if root > 0.0 else NONE
    too_few = f"fewer than {FEWEST:,} trials" if len(squares) < FEWEST else ""
    why = expected.why or ("readings are certain: no error is expected" if root == 0.0 else too_few)
    return SettingAgreement(
        number, f"{tested.brain.name}: {tested}", len(squares), squared[0] ** 0.5, root, ratio,
        efficiency_of(lines, squared), lines.beliefs, max(terms, key=lambda name: terms[name]) if terms else "",
        UNKNOWN if why else AGREES if ratio[1] <= 1.0 <= ratio[2] else DIFFERS, why,
    )  # fmt: skip


def _ratio(squares: Floats, expected: Floats) -> Interval:
    """The root of the mean ratio of squared errors (trial, robot) to their expectations.

    Ratios are taken robot by robot, as robots with poor sensors would dominate a ratio of means. Robots without an
    expected error are left out.
    """
    parts = np.divide(squares, expected, where=expected > 0.0, out=np.full(squares.shape, np.nan))
    # robots of a trial hear one another, so the interval is over trials
    by_trial = centres(parts, "mean")
    value, low, high = estimate(by_trial[:, np.newaxis], "mean", level=1.0 - 1.0 / MISSES)
    return value**0.5, max(low, 0.0) ** 0.5, high**0.5
