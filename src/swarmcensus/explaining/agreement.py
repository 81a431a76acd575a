"""All settings beside exact theory, how far off estimates are and should be; and the door: `sc.explain`."""

from pathlib import Path
from typing import NamedTuple, overload

import numpy as np
import xarray as xr

from swarmcensus.basics.errors import InputError
from swarmcensus.explaining import one_setting
from swarmcensus.explaining.exact_errors import Floats, exact
from swarmcensus.explaining.expectations import MIXED, SWARM, Origin, expect
from swarmcensus.explaining.one_setting import (
    NONE,
    Explanation,
    Interval,
    efficiency_of,
    errors_of,
    mean_of,
    terms_of,
)
from swarmcensus.results.source_study import origins_of
from swarmcensus.results.store import load
from swarmcensus.results.summaries import done
from swarmcensus.results.values import robots_in
from swarmcensus.statistics.bootstrap import centres
from swarmcensus.statistics.intervals import estimate

MISSES = 1000  # one of so many settings differs by chance
FEWEST = 50  # trials of a verdict: of fewer, intervals at this level miss more often than they say
GRAPHS = 20  # of whose mixing the largest part of the error is told
AGREES, DIFFERS, UNKNOWN = "agrees", "differs", "unknown"


class Held(NamedTuple):
    """A setting held against theory: root mean squared errors after the last round, over robots and trials."""

    setting: int
    what: str  # the setting in a line
    trials: int
    measured: float  # the root of the mean of (x - f)^2
    expected: float  # what theory says it is; NaN where theory is not exact
    ratio: Interval  # of both, robot by robot, and the ends of its 99.9 % interval over trials
    efficiency: Interval  # the bound of the whole swarm over the mean squared error, at 95 %
    limit: str  # the largest part of the error: "sensors", "floor", "time" or "mixing"; empty where theory has none
    verdict: str  # "agrees", "differs" or "unknown"
    why: str  # it is unknown


class Agreement(NamedTuple):
    """All settings held against theory, and how many of them agree."""

    settings: list[Held]
    exact: int  # settings with a verdict
    agree: int
    by_chance: float  # how many of `exact` would differ if theory holds in all; that any does is at most as likely


@overload
def explain(results: xr.Dataset | str | Path, setting: int) -> Explanation: ...
@overload
def explain(results: xr.Dataset | str | Path, setting: None = None) -> Agreement: ...
def explain(results: xr.Dataset | str | Path, setting: int | None = None) -> Explanation | Agreement:
    """A setting's measured figures beside theory's, as an `Explanation`, or all settings' in short, as an `Agreement`.

    `results` is a dataset or a results file, `setting` a number of its coordinate. Raises InputError.
    """
    data = load(results) if isinstance(results, str | Path) else results
    return agreement(data) if setting is None else one_setting.explain(data, setting)


def agreement(data: xr.Dataset) -> Agreement:
    """Every setting that has run, held against theory. Raises InputError."""
    ran = done(data).any(axis=1)
    if not ran.any():
        raise InputError("none of these settings' trials has been run")
    rows = [_held(data, number, origin) for number, origin in origins_of(data, data["setting"].values[ran]).items()]
    told = [row for row in rows if row.verdict != UNKNOWN]
    return Agreement(rows, len(told), sum(row.verdict == AGREES for row in told), len(told) / MISSES)


def _held(data: xr.Dataset, number: int, origin: Origin) -> Held:
    one, found = data.sel(setting=[number]), origin[1]
    ran = done(one)[0]
    squares = np.square(errors_of(one, ran, int(robots_in(one).values[0])))
    squared = mean_of(squares.mean(axis=1))
    lines = expect(data, number, [found.rounds], [SWARM, MIXED], origin, GRAPHS)
    terms = terms_of(lines, squared[0])
    expected = exact(*origin, data["trial"].values[ran])
    root = float(expected.squared.mean()) ** 0.5 if not expected.why else np.nan
    ratio = _ratio(squares, expected.squared) if root > 0.0 else NONE
    few = f"fewer than {FEWEST:,} trials" if len(squares) < FEWEST else ""
    why = expected.why or ("readings are certain: no error is expected" if root == 0.0 else few)
    return Held(
        setting=number,
        what=f"{found.brain.name}: {found}",
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
    """The root of the mean of squared errors (trial, robot), each over its own expectation, for poor sensors would
    drown all others else; robots of which no error is expected are left out."""
    parts = np.divide(squares, expected, where=expected > 0.0, out=np.full(squares.shape, np.nan))
    by_trial = centres(parts, "mean")
    value, low, high = estimate(by_trial[:, np.newaxis], "mean", level=1.0 - 1.0 / MISSES)
    return value**0.5, max(low, 0.0) ** 0.5, high**0.5
