"""How claims are judged: statistics of settings, bootstrapped over trials, margins, and the rule of verdicts."""

import itertools
import math
import re
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from swarmcensus.results import robots_in
from swarmcensus.summaries import places_with
from swarmcensus.support import intervals
from swarmcensus.support.formatting import counted
from swarmcensus.support.intervals import Floats

MARGIN = 0.05  # of every ordering: what differs by less, as a ratio or a share, speaks neither for it nor against it
MUCH = 1.25  # a ratio of "much" more; what lies between it and its inverse is alike
NO_DIFFERENCE = {"less": 1.0, "more": 1.0, "lower": 0.0, "higher": 0.0}  # of ratios and of differences
LATE = 0.9  # of a run: a swarm that settles only then may not have settled at all
YES, NO, NEITHER = "yes", "no", "neither"  # what one setting says
HOLDS, PARTLY, FAILS = "holds", "holds in part", "does not hold"
UNDECIDED, UNMEASURED = "not decided", "not measured"
VERDICTS = (FAILS, PARTLY, UNDECIDED, UNMEASURED, HOLDS)
INFINITE = math.inf
Range = tuple[float, float]
Where = Mapping[str, Any]


class Missing(LookupError):
    """The datasets lack settings or trials that a claim needs."""


class Needed(NamedTuple):
    """The numbers that speak for a claim (`right`), those outside of which speak against it, and both as text.

    The ranges differ for orderings, by the margin on both sides of no difference.
    """

    words: str
    right: Range
    tolerated: Range

    @classmethod
    def of(cls, threshold: str, right: Sequence[float] = ()) -> "Needed":
        """The ranges of an ordering, of "below 0.05" and the like, or of other words with the range `right`."""
        if threshold in NO_DIFFERENCE:
            below, above = NO_DIFFERENCE[threshold] - MARGIN, NO_DIFFERENCE[threshold] + MARGIN
            if threshold in ("less", "lower"):
                return cls(f"below {below:g}, not above {above:g}", (-INFINITE, below), (-INFINITE, above))
            return cls(f"above {above:g}, not below {below:g}", (above, INFINITE), (below, INFINITE))
        least, most = f"{1 / MUCH:g}", f"{MUCH:g}"
        plain = {"much less": f"below {least}", "much more": f"above {most}", "alike": f"within {least} to {most}"}
        words = plain.get(threshold, threshold)
        if found := re.fullmatch(r"within (\S+) to (\S+)", words):
            right = float(found[1]), float(found[2])
        elif found := re.match(r"(below|above) (-?\d\S*)", words):
            end = float(found[2])
            right = (-INFINITE, end) if found[1] == "below" else (end, INFINITE)
        low, high = right
        return cls(words, (low, high), (low, high))


@dataclass(frozen=True)
class Detail:
    """A claim in one setting: the measured value, its 95 % interval (None: exact) and what it says.

    `made_of` has the numbers behind the value as text.
    """

    setting: str
    value: float
    interval: Range | None
    verdict: str
    made_of: str = ""

    @property
    def ends(self) -> Range:
        """The ends of its interval; the value, if it is exact."""
        return self.interval or (self.value, self.value)


class Finding(NamedTuple):
    """A statistic in one setting: of the sample, then of each resample; only the first if it is exact.

    None stands for two swarms of which neither has settled.
    """

    setting: str
    statistic: Floats | None
    made_of: str = ""


@dataclass(frozen=True)
class Claim:
    """A published sentence and how it is checked. A quoted `sentence` is whole, with formulas as plain text.

    Each of `measures` yields what it finds in each setting and raises Missing if data are missing; `studies` are those
    that they need. The `explanation` is printed unless the claim holds.
    """

    id: str
    title: str
    sentence: str
    section: str
    statistic: str
    needed: Needed
    measures: tuple[Callable[["Evidence"], Iterable[Finding | Detail]], ...]
    studies: tuple[str, ...] = ()
    explanation: str = ""


@dataclass(frozen=True)
class Outcome:
    """A claim as measured: its verdict, the details, settings left out, and the worst, which supports it least."""

    claim: Claim
    verdict: str
    details: Sequence[Detail] = ()
    left_out: Sequence[str] = ()
    worst: Detail | None = None

    @property
    def note(self) -> str:
        """Which settings are left out, and why."""
        if not self.left_out:
            return ""
        total = counted(len(self.details) + len(self.left_out), "setting")
        return (
            f"Left out, as neither of the two settles before the last tenth of the run: {len(self.left_out)} of "
            f"{total} ({'; '.join(self.left_out)})."
        )

    @property
    def explanation(self) -> str:
        """What is to be said of a claim that does not hold, or only in part."""
        return self.claim.explanation if self.verdict in (FAILS, PARTLY) else ""

    def count(self, verdict: str) -> int:
        """How many settings say YES, NO or NEITHER."""
        return sum(d.verdict == verdict for d in self.details)


class Contender(NamedTuple):
    """A study and the coordinates that select its settings; if `local`, estimates are those of robots by themselves."""

    name: str
    study: str
    where: Where
    local: bool = False

    def within(self, world: Where) -> tuple[str, Where]:
        """The study, and all coordinates of the contender's setting in a world."""
        return self.study, {**world, **self.where}


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

    def find(self, contender: Contender, world: Where) -> tuple[xr.Dataset, int]:
        """The dataset of a contender, and the place of its setting in a world. Raises Missing if there is none."""
        study, where = contender.within(world)
        data = self.datasets.get(study)
        if data is None or not all(name in data for name in where):
            raise Missing(f"{study}: {where}")
        places = places_with(data, where)
        if places.size != 1:
            raise Missing(f"{study}: {places.size} settings with {where}")
        return data, int(places[0])

    def number(self, contender: Contender, world: Where, coordinate: str) -> float:
        """A coordinate of one setting, such as its `rounds`. Raises Missing."""
        data, place = self.find(contender, world)
        return float(data[coordinate].values[place])

    def column(self, contender: Contender, world: Where, variable: str) -> Floats:
        """A variable of one setting as it is recorded, (trial,), (trial, robot) or (trial, checkpoint)."""
        data, place = self.find(contender, world)
        if variable not in data:
            raise Missing(f"{contender.study}: {variable}")
        column = data[variable].variable.isel(setting=place, trial=slice(self.trials))
        values = np.asarray(column.transpose("trial", ...).values, float)
        return values[:, : int(robots_in(data).values[place])] if "robot" in column.dims else values

    def values(self, contender: Contender, world: Where, variable: str, least: int = 0) -> Floats:
        """`column` of a variable that is never below `least`. Raises Missing if it or one of its trials is missing."""
        values = self.column(contender, world, variable)
        if not (values >= least).all():  # a lower number and NaN mark trials that were not run
            raise Missing(f"{contender.study}: trials with {contender.within(world)[1]}")
        return values

    def median(self, contender: Contender, world: Where, variable: str) -> Floats:
        """The median over robots and trials of one setting: of the sample, then of each resample. Raises Missing."""
        study, where = contender.within(world)
        # many claims ask for the same medians, and each takes a bootstrap
        key = study, variable, *sorted(where.items())
        if key not in self._medians:
            self._medians[key] = intervals.medians(self.values(contender, world, variable), self.counts)
        return self._medians[key]

    def mean(self, by_trial: Floats) -> Floats:
        """The mean over trials of (trial,): of the sample, then of each resample."""
        return intervals.means(by_trial, self.counts)

    def share(self, hits: NDArray[Any], tries: NDArray[Any]) -> Floats:
        """All hits divided by all tries, both (trial,): of the sample, then of each resample; NaN without tries."""
        return ratio(self.counts @ np.asarray(hits, float), self.counts @ np.asarray(tries, float))

    def judge(self, found: Finding, needed: Needed) -> Detail:
        """What a setting says: yes if its interval is in the right range, no if it is outside what is tolerated."""
        setting, statistic, made_of = found
        assert statistic is not None
        exact = statistic.size == 1
        value, low, high = [float(statistic[0])] * 3 if exact else intervals.interval(statistic)
        says = NEITHER
        if exact or self.trials >= intervals.FEWEST:
            if needed.right[0] <= low and high <= needed.right[1]:
                says = YES
            elif high < needed.tolerated[0] or low > needed.tolerated[1]:
                says = NO
        return Detail(setting, value, None if exact else (low, high), says, made_of)


def ratio(above: Floats, below: Floats) -> Floats:
    """The quotient; NaN where the divisor is 0, so that such a setting decides nothing."""
    quotient = np.full(above.shape, np.nan)
    np.divide(above, below, out=quotient, where=below != 0)
    return quotient


def check(datasets: Mapping[str, xr.Dataset], claims: Iterable[Claim]) -> list[Outcome]:
    """Check claims on datasets by the name of their study.

    A claim is "not measured" if settings are missing or some of their trials were not run. Of its studies, only the
    trials that all of them have count.
    """
    # one bootstrap for each number of trials, so that statistics of one claim share resamples
    sizes = {claim: common_trials(datasets, claim.studies) for claim in claims}
    evidence = {trials: Evidence(datasets, trials=trials) for trials in set(sizes.values())}
    return [outcome(claim, evidence[trials]) for claim, trials in sizes.items()]


def common_trials(datasets: Mapping[str, xr.Dataset], studies: Iterable[str]) -> int:
    """The number of trials that all of these studies have, of those with a dataset."""
    return min((datasets[name].sizes["trial"] for name in studies if name in datasets), default=0)


def outcome(claim: Claim, evidence: Evidence) -> Outcome:
    """Check one claim. Swarms of which neither has settled are left out: their K are in no order."""
    details: list[Detail] = []
    left_out = []
    try:
        for found in itertools.chain.from_iterable(measure(evidence) for measure in claim.measures):
            if isinstance(found, Detail):
                details.append(found)
            elif found.statistic is None:
                left_out.append(found.setting)
            else:
                details.append(evidence.judge(found, claim.needed))
    except Missing:
        return Outcome(claim, UNMEASURED)

    def support(detail: Detail) -> tuple[int, float]:
        least = min(detail.ends[0] - claim.needed.right[0], claim.needed.right[1] - detail.ends[1])
        return (NO, NEITHER, YES).index(detail.verdict), -math.inf if math.isnan(least) else least

    verdict, (low, high) = verdict_on(details), claim.needed.tolerated
    tolerated = all(low <= detail.ends[0] and detail.ends[1] <= high for detail in details)
    if verdict == UNDECIDED and evidence.trials >= intervals.FEWEST and tolerated:
        verdict = FAILS  # there is no order
    return Outcome(claim, verdict, details, left_out, min(details, key=support, default=None))


def verdict_on(details: Sequence[Detail]) -> str:
    """A claim holds if most settings speak for it and none against it.

    It does not hold if most speak against it, or half while none speaks for it. Nothing is decided if fewer do and none
    speaks for it. Otherwise it holds in part.
    """
    said = [detail.verdict for detail in details]
    half, against = len(said) / 2, said.count(NO)
    if YES not in said:
        return FAILS if against and against >= half else UNDECIDED
    if not against and said.count(YES) > half:
        return HOLDS
    return FAILS if against > half else PARTLY
