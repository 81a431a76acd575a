"""Whether each setting's errors agree with exact theory; and `sc.explain`."""

from pathlib import Path
from typing import NamedTuple, overload

import numpy as np
import xarray as xr

from swarmcensus.analysis.explaining import one_setting
from swarmcensus.analysis.explaining.exact_errors import Floats, exact_errors
from swarmcensus.analysis.explaining.expectations import MIXED, SWARM, Origin, expect
from swarmcensus.analysis.explaining.one_setting import (
    NONE,
    Explanation,
    Interval,
    efficiency_of,
    errors_of,
    mean_of,
    terms_of,
)
from swarmcensus.results import done, loaded, origins_of, robots_in
from swarmcensus.support.bootstrap import centres
from swarmcensus.support.errors import InputError
from swarmcensus.support.intervals import estimate

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
    limit: str  # the largest part of the error, one of `Explanation.terms`; empty if theory has none
    verdict: str  # "agrees", "differs" or "unknown"
    why: str  # why the verdict is unknown


class Agreement(NamedTuple):
    """All settings compared with theory, and how many of them agree."""

    settings: list[SettingAgreement]
    exact: int  # settings with a verdict
    agree: int
    by_chance: float  # how many of `exact` would differ on average if theory holds; bounds the chance that any does


@overload
def explain(results: xr.Dataset | str | Path, setting: int) -> Explanation: ...
@overload
def explain(results: xr.Dataset | str | Path, setting: None = None) -> Agreement: ...
def explain(results: xr.Dataset | str | Path, setting: int | None = None) -> Explanation | Agreement:
    """Compare a setting's measurements with theory, as an `Explanation`, or all settings in short, as an `Agreement`.

    `results` is a dataset or a results file, `setting` a value of its coordinate. Raises InputError.
    """
    data = loaded(results)
    return agreement(data) if setting is None else one_setting.explain(data, setting)


def agreement(data: xr.Dataset) -> Agreement:
    """Compare every setting that has run with theory. Raises InputError if none has."""
    ran = done(data).any(axis=1)
    if not ran.any():
        raise InputError("no trial of these settings has been run")
    rows = [
        _setting_agreement(data, number, origin)
        for number, origin in origins_of(data, data["setting"].values[ran]).items()
    ]
    decided = [row for row in rows if row.verdict != UNKNOWN]
    return Agreement(rows, len(decided), sum(row.verdict == AGREES for row in decided), len(decided) / MISSES)


def _setting_agreement(data: xr.Dataset, number: int, origin: Origin) -> SettingAgreement:
    selected, tested = data.sel(setting=[number]), origin[1]
    ran = done(selected)[0]
    squares = np.square(errors_of(selected, ran, int(robots_in(selected).values[0])))
    squared = mean_of(squares.mean(axis=1))
    lines = expect(data, number, [tested.rounds], [SWARM, MIXED], origin, GRAPHS)
    terms = terms_of(lines, squared[0])
    expected = exact_errors(*origin, data["trial"].values[ran])
    root = float(expected.squared.mean()) ** 0.5 if not expected.why else np.nan
    ratio = _ratio(squares, expected.squared) if root > 0.0 else NONE
    too_few = f"fewer than {FEWEST:,} trials" if len(squares) < FEWEST else ""
    why = expected.why or ("readings are certain: no error is expected" if root == 0.0 else too_few)
    return SettingAgreement(
        setting=number,
        what=f"{tested.brain.name}: {tested}",
        trials=len(squares),
        measured=squared[0] ** 0.5,
        expected=root,
        ratio=ratio,
        efficiency=efficiency_of(lines, squared),
        limit=max(terms, key=lambda name: terms[name]) if terms else "",
        verdict=UNKNOWN if why else AGREES if ratio[1] <= 1.0 <= ratio[2] else DIFFERS,
        why=why,
    )


def _ratio(squares: Floats, expected: Floats) -> Interval:
    """The root of the mean ratio of squared errors (trial, robot) to their expectations.

    Ratios are taken robot by robot, as robots with poor sensors would dominate a ratio of means. Robots without an
    expected error are left out.
    """
    parts = np.divide(squares, expected, where=expected > 0.0, out=np.full(squares.shape, np.nan))
    by_trial = centres(parts, "mean")
    value, low, high = estimate(by_trial[:, np.newaxis], "mean", level=1.0 - 1.0 / MISSES)
    return value**0.5, max(low, 0.0) ** 0.5, high**0.5
