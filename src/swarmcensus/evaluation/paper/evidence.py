"""How claims are judged: statistics of settings, bootstrapped over trials, and the rule of verdicts."""

import contextlib
import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from swarmcensus.results import places_with, robots_in
from swarmcensus.support import intervals
from swarmcensus.support.formatting import counted
from swarmcensus.support.intervals import Floats

YES, NO, OPEN = "yes", "no", "undecided"  # of one setting
HOLDS, FAILS, UNDECIDED, UNMEASURED = "holds", "does not hold", "not decided", "not measured"
Range = tuple[float, float]
BELOW_ZERO, BELOW_ONE, ABOVE_ONE = (-math.inf, 0.0), (-math.inf, 1.0), (1.0, math.inf)


class Missing(LookupError):
    """The datasets lack settings or trials that a claim needs."""


@dataclass(frozen=True)
class Detail:
    """A claim in one setting: the measured value, its 95 % interval (None: exact) and the verdict."""

    setting: str
    value: float
    interval: Range | None
    verdict: str


@dataclass(frozen=True)
class Claim:
    """A sentence of the paper and how it is checked. `sentence` is quoted word for word, with formulas as plain text.

    `right` is the range in which the statistic confirms the sentence, and `threshold` says so in words. `measure`
    yields one detail per setting and raises Missing if data are missing. `studies` are the studies that it needs.
    """

    id: str
    title: str
    sentence: str
    section: str
    statistic: str
    threshold: str
    right: Range
    measure: Callable[["Evidence", Range], Iterable[Detail]]
    studies: tuple[str, ...] = ()
    note: Callable[["Evidence"], str] = lambda _: ""  # a further remark on the data
    explanation: Callable[["Evidence", Sequence[Detail]], str] = lambda *_: ""  # why the claim fails


@dataclass(frozen=True)
class Outcome:
    """A claim as measured: its verdict, the details, and the worst of them, which supports it least."""

    claim: Claim
    verdict: str
    details: Sequence[Detail] = ()
    note: str = ""
    worst: Detail | None = field(default=None)
    explanation: str = ""

    @property
    def holds(self) -> bool | None:
        """True, False, or None where it was not decided or not measured."""
        return {HOLDS: True, FAILS: False}.get(self.verdict)

    def count(self, verdict: str) -> int:
        """How many settings say YES, NO or OPEN."""
        return sum(d.verdict == verdict for d in self.details)


class Evidence:
    """Datasets by the name of their study, with one bootstrap of their trials for all statistics."""

    def __init__(
        self, datasets: Mapping[str, xr.Dataset], resamples: int = intervals.RESAMPLES, trials: int | None = None
    ) -> None:
        """Use the first `trials` trials, by default as many as all datasets have.

        Trials of the same number have the same readings in all settings.
        """
        self.datasets = datasets
        self.trials = common_trials(datasets, datasets) if trials is None else trials
        self.counts = intervals.resample(max(self.trials, 1), resamples)
        self._medians: dict[object, Floats] = {}

    def setting(self, study: str, **where: object) -> xr.Dataset:
        """The one setting with these coordinates, with the trials in use. Raises Missing if there is none."""
        data, place = self._find(study, where)
        return data.isel(setting=place, trial=slice(self.trials))

    def column(self, study: str, variable: str, **where: object) -> Floats:
        """A variable of one setting as it is recorded, (trial,), (trial, robot) or (trial, checkpoint)."""
        data, place = self._find(study, where)
        if variable not in data:
            raise Missing(f"{study}: {variable}")
        column = data[variable].variable.isel(setting=place, trial=slice(self.trials))
        values = np.asarray(column.transpose("trial", ...).values, float)
        return values[:, : int(robots_in(data).values[place])] if "robot" in column.dims else values

    def _find(self, study: str, where: Mapping[str, object]) -> tuple[xr.Dataset, int]:
        data = self.datasets.get(study)
        if data is None or not all(name in data for name in where):
            raise Missing(f"{study}: {where}")
        places = places_with(data, where)
        if places.size != 1:
            raise Missing(f"{study}: {places.size} settings with {where}")
        return data, int(places[0])

    def values(self, study: str, variable: str, **where: object) -> Floats:
        """`column` of a variable that is never negative. Raises Missing if it or one of its trials is missing."""
        values = self.column(study, variable, **where)
        if not (values >= 0).all():  # -1 and NaN mark trials that were not run
            raise Missing(f"{study}: trials with {where}")
        return values

    def median(self, study: str, variable: str, **where: object) -> Floats:
        """The median over robots and trials of one setting: of the sample, then of each resample. Raises Missing."""
        key = study, variable, *sorted(where.items())
        if key not in self._medians:
            self._medians[key] = intervals.medians(self.values(study, variable, **where), self.counts)
        return self._medians[key]

    def mean(self, by_trial: Floats) -> Floats:
        """The mean over trials of (trial,): of the sample, then of each resample."""
        return intervals.means(by_trial, self.counts)

    def share(self, hits: NDArray[Any], tries: NDArray[Any]) -> Floats:
        """All hits divided by all tries, both (trial,): of the sample, then of each resample; NaN without tries."""
        all_hits, all_tries = self.counts @ np.asarray(hits, float), self.counts @ np.asarray(tries, float)
        shares = np.full(all_tries.shape, np.nan)
        np.divide(all_hits, all_tries, out=shares, where=all_tries > 0)
        return shares

    def judge(self, setting: str, statistic: Floats, right: Range) -> Detail:
        """The verdict is yes if the interval lies within `right`, and no if it lies outside on one side."""
        value, low, high = intervals.interval(statistic)
        verdict = OPEN
        if self.trials >= intervals.FEWEST:
            if right[0] < low and high < right[1]:
                verdict = YES
            elif high < right[0] or low > right[1]:
                verdict = NO
        return Detail(setting, value, (low, high), verdict)


def check(datasets: Mapping[str, xr.Dataset], claims: Iterable[Claim]) -> list[Outcome]:
    """Check claims on datasets by the name of their study.

    A claim is "not measured" if settings are missing or some of their trials were not run. Of its studies, only the
    trials that all of them have count.
    """
    sizes = {claim: common_trials(datasets, claim.studies) for claim in claims}
    evidence = {trials: Evidence(datasets, trials=trials) for trials in set(sizes.values())}
    return [outcome(claim, evidence[trials]) for claim, trials in sizes.items()]


def common_trials(datasets: Mapping[str, xr.Dataset], studies: Iterable[str]) -> int:
    """The number of trials that all of these studies have, of those with a dataset."""
    return min((datasets[name].sizes["trial"] for name in studies if name in datasets), default=0)


def outcome(claim: Claim, evidence: Evidence) -> Outcome:
    """Check one claim: it holds if all settings say yes, and does not hold if at least one says no."""
    try:
        details = tuple(claim.measure(evidence, claim.right))
        note = claim.note(evidence)
    except Missing:
        return Outcome(claim, UNMEASURED)
    verdicts = {d.verdict for d in details}
    explanation = ""
    with contextlib.suppress(Missing):  # a reason may need more data than the verdict does
        explanation = claim.explanation(evidence, details) if NO in verdicts else ""
    undecided = f"{UNDECIDED} by {counted(evidence.trials, 'trial')}"
    verdict = FAILS if NO in verdicts else undecided if OPEN in verdicts else HOLDS

    def margin(detail: Detail) -> float:
        low, high = detail.interval or (detail.value, detail.value)
        least = min(low - claim.right[0], claim.right[1] - high)
        return -math.inf if math.isnan(least) else least

    order = (NO, OPEN, YES)
    worst = min(details, key=lambda d: (order.index(d.verdict), margin(d)))
    return Outcome(claim, verdict, details, note, worst, explanation)
