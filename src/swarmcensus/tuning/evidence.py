"""What a search was worth: the brain with the values found against the brain as it was, where the search never was."""

from collections.abc import Callable, Collection
from dataclasses import dataclass
from typing import Any

import numpy as np
import xarray as xr

from swarmcensus.basics.formatting import counted, grouped, places, rounded
from swarmcensus.basics.seeds import seed_for
from swarmcensus.brains import Brain
from swarmcensus.comparing.cells import p_equals
from swarmcensus.comparing.comparison import Comparison, compare_dataset
from swarmcensus.comparing.verdicts import win_shares
from swarmcensus.results.summaries import is_idle
from swarmcensus.runs.collect import Progress
from swarmcensus.studies.settings import Setting
from swarmcensus.tuning.plans import Plan
from swarmcensus.tuning.training import Floats, Training

BETTER, WORSE, LEVEL, NONE = "better", "worse", "not told apart", "not compared"


@dataclass(frozen=True)
class Evidence:
    """What the comparison of two says; `comparison` is of the tuned brain with the brain as it was, and with no other.

    `everyone` is of all brains of the study beside. Both are None where the search ended at the values there were, and
    `why` says how that came.
    """

    tuned: str
    before: str
    comparison: Comparison | None
    everyone: Comparison | None
    why: str = ""

    @property
    def verdict(self) -> str:
        """Whether the tuned brain is "better" than it was, over all worlds, "worse", or "not told apart".

        It is "not compared" where the values stay as they were.
        """
        if self.comparison is None:
            return NONE
        [contest] = self.comparison.contests
        if contest.met.sum() > 1:
            told, ahead = bool(contest.duels_apart[0]), float(contest.ahead[0])
        else:
            told, ahead = bool(contest.apart[0, 0]), float(contest.tests.balance[0, 0]) * (-1 if contest.low else 1)
        first = self._first
        return LEVEL if not told or not ahead else BETTER if (ahead > 0) == first else WORSE

    @property
    def _first(self) -> bool:
        """Whether the tuned one is the first of the pair."""
        assert self.comparison is not None
        return self.comparison.contenders[0] == self.tuned

    @property
    def sentences(self) -> list[str]:
        """What is said of it: one of all worlds, one for each world, and one of the study's other brains."""
        if self.comparison is None:
            return [f"{self.why}: the values stay as they were, and there is nothing to compare: {self.before}"]
        measure = self.comparison.measures[0]
        pairs = self.comparison.pairs.to_dict("records")
        told = {LEVEL: "is not told apart from", BETTER: "is better than", WORSE: "is worse than"}[self.verdict]
        over = ""
        for row in self.comparison.duels.to_dict("records"):
            better, worse = self.comparison.contests[0].shares(0)
            said = win_shares(better, worse) if self._first else win_shares(worse, better)
            over = f" over all {counted(len(pairs), 'world')}: {said}, p {p_equals(row['p_holm'])}"
        one = "" if over else f": {self._of_world(pairs[0])}" if pairs else ""
        lines = [f"{measure.full_label}: {self.tuned} {told} {self.before}{over}{one}"]
        if over:
            lines += [f"world {row['world']}{_where(self.comparison, row)}: {self._of_world(row)}" for row in pairs]
        if self.everyone is not None:
            lines += [f"beside the study's others: {line}" for line in self.everyone.verdict[:2] if "cost" not in line]
        return lines

    def _of_world(self, row: dict[str, Any]) -> str:
        """Such as "median of differences -0.0021 [-0.0030, -0.0011], better in 83% of 30 trials, p < 0.001".

        Differences of shares are in percentage points, as tables have shares in percent.
        """
        assert self.comparison is not None
        measure = self.comparison.measures[0]
        times = (1.0 if self._first else -1.0) * (100.0 if measure.share else 1.0)
        ends = sorted((times * row["difference_low"], times * row["difference_high"]))
        difference = times * row["difference"] + 0.0
        unit = " percentage points" if measure.share else f" {measure.unit}" if measure.unit != "1" else ""
        if np.isfinite([difference, *ends]).all():
            text = " ".join(rounded(difference, ends[0], ends[1], places(ends[1] - ends[0])))
        else:
            text = f"{difference:.3g}"
        superiority = row["superiority"] if self._first else 1 - row["superiority"]
        apart = "" if row["told_apart"] else ", not told apart"
        return (
            f"{measure.statistic} of differences {text}{unit}, better in {superiority:.0%} of {row['trials']:,} "
            f"trials, p {p_equals(row['p_holm'])}{apart}"
        )


def evidence_of(
    data: xr.Dataset, settings: list[Setting], tuned: Brain, before: Brain, metric: str, searched: Collection[str]
) -> Evidence:
    """Compare two brains in the results of an evaluation, whose settings these are, and then all of them.

    Both are called by all parameters that were searched, those too whose value stayed as it was.
    """
    shown = {before.name: searched}
    mine = [k for k, one in enumerate(settings) if one.brain in (tuned, before)]
    found = compare_dataset(data.isel(setting=mine), metric, None, None, shown)
    names = _names(data, settings, mine, found, (tuned, before))
    everyone = compare_dataset(data, metric, None, None, shown) if len(mine) < len(settings) else None
    return Evidence(*names, found, everyone)


def _names(
    data: xr.Dataset, settings: list[Setting], mine: list[int], found: Comparison, two: tuple[Brain, Brain]
) -> tuple[str, str]:
    """What the comparison calls each of the two: the contender whose setting is of that brain."""
    numbers = data["setting"].values[mine].tolist()
    brain_of = {number: settings[k].brain for number, k in zip(numbers, mine, strict=True)}
    called: dict[Brain, str] = {}
    for world in found.settings.tolist():
        called |= {brain_of[number]: name for number, name in zip(world, found.contenders, strict=True) if number >= 0}
    return called[two[0]], called[two[1]]


def _where(found: Comparison, row: dict[str, Any]) -> str:
    """A world's coordinates that differ among worlds, in brackets."""
    world = found.field.worlds[row["world"]]
    told = ", ".join(f"{name} {grouped(value)}" for name, value in world.items() if not is_idle(value))
    return f" ({told})" if told else ""


Values = tuple[float, ...]


def without_idle(
    plan: Plan, values: Values, training: Training, show: Callable[[Progress], None]
) -> tuple[Values, list[str]]:
    """The values found, but those that change no number of any trial as they were before, and which these are.

    Each is tried by itself, then all of them together; where one can stand for another, they are put back one by one,
    as long as that changes nothing.
    """
    changed = [k for k, (value, was) in enumerate(zip(values, plan.start, strict=True)) if value != was]
    if not changed or len(values) == 1:  # where a search finds anything, its only parameter matters
        return values, []

    def as_before(*places: int) -> Values:
        return tuple(plan.start[k] if k in places else value for k, value in enumerate(values))

    def same(places: list[int]) -> bool:
        [other] = _tried(plan, [as_before(*places)], training, show)
        return np.array_equal(found, other, equal_nan=True)

    found, *others = _tried(plan, [values, *map(as_before, changed)], training, show)
    idle = [k for k, other in zip(changed, others, strict=True) if np.array_equal(found, other, equal_nan=True)]
    if len(idle) > 1 and not same(idle):
        alone, idle = idle, []
        for k in alone:
            if same([*idle, k]):
                idle.append(k)
    return as_before(*idle), [plan.ranges[k].place for k in idle]


def _tried(plan: Plan, candidates: list[Values], training: Training, show: Callable[[Progress], None]) -> list[Floats]:
    """The numbers of candidates on the same training trials, (measure, world, trial) each."""
    kept: dict[int, Floats] = {}
    brains = [plan.brain_of(values) for values in candidates]
    training.run(brains, seed_for(plan.study.seed, "influence"), kept.__setitem__, show)
    return [kept[place] for place in range(len(candidates))]
