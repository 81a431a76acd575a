"""The evidence for a search's result: a comparison with the original on trials that the search never saw."""

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import xarray as xr

from swarmcensus.analysis import Comparison, compare_dataset, p_equals, range_text, win_shares
from swarmcensus.brains import PLAIN, Adversary, Brain
from swarmcensus.search.tuning.plans import TuningPlan
from swarmcensus.studies import Member, Setting
from swarmcensus.summaries import world_text
from swarmcensus.support.formatting import counted, decimals_for, rounded
from swarmcensus.support.printed_tables import NEVER

BETTER, WORSE, LEVEL, NONE = "better", "worse", "not told apart", "not compared"


@dataclass(frozen=True)
class Evidence:
    """The comparison of what was found, the first of the pair, with the original, and that of all brains of the study.

    If an adversary was searched, both are of adversaries, and say how the brain that hears them fares; "worse" is then
    what was searched. `all_brains` is None if the study has no others. Both are None if the search ended at the
    original values, and `why` gives the reason.
    """

    tuned: str
    before: str
    comparison: Comparison | None
    all_brains: Comparison | None
    why: str = ""
    harms: bool = False  # whether an adversary was searched

    @property
    def is_found(self) -> bool:
        """Whether the search has found a better brain, or a worse adversary."""
        return self.verdict == (WORSE if self.harms else BETTER)

    @property
    def verdict(self) -> str:
        """Whether the tuned brain is "better" than the original over all worlds, "worse", or "not told apart".

        Of an adversary it is how the swarm fares with it. It is "not compared" if the values stay as they were.
        """
        if self.comparison is None:
            return NONE
        [contest] = self.comparison.contests
        if contest.met.sum() > 1:
            apart, ahead = bool(contest.duels_apart[0]), float(contest.ahead[0])
        else:
            apart, ahead = bool(contest.apart[0, 0]), float(contest.tests.balance[0, 0]) * (-1 if contest.low else 1)
        if not apart or not ahead:
            return LEVEL
        return BETTER if ahead > 0 else WORSE

    @property
    def sentences(self) -> list[str]:
        """One sentence on all worlds, one on each world, and one on the study's other brains."""
        if self.comparison is None:
            return [f"{self.why}: the values stay as they were, and there is nothing to compare: {self.before}"]
        measure = self.comparison.measures[0]
        pairs = self.comparison.pairs.to_dict("records")
        whom = " for the swarm" * self.harms
        phrase = {LEVEL: "is not told apart from", BETTER: f"is better{whom} than", WORSE: f"is worse{whom} than"}
        over = ""
        for row in self.comparison.duels.to_dict("records"):
            shares_text = win_shares(*self.comparison.contests[0].shares(0))
            over = f" over all {counted(len(pairs), 'world')}: {shares_text}, p {p_equals(row['p_holm'])}"
        only_world = "" if over else f": {self._of_world(pairs[0])}" if pairs else ""
        lines = [f"{measure.full_label}: {self.tuned} {phrase[self.verdict]} {self.before}{over}{only_world}"]
        if over:
            for row in pairs:
                varied = world_text(self.comparison.grid.worlds[row["world"]])
                lines.append(f"world {row['world']}{f' ({varied})' * bool(varied)}: {self._of_world(row)}")
        if self.all_brains is not None and self.harms:
            lines.append(f"with the study's other liars: {_harm_of_each(self.all_brains)}")
        elif self.all_brains is not None:
            lines += [f"with the study's others: {line}" for line in self.all_brains.verdict[:2]]
        return lines

    def _of_world(self, row: dict[str, Any]) -> str:
        """A phrase such as "median of differences -0.0021 [-0.0030, -0.0011], better in 83% of 30 trials, p < 0.001".

        Differences of shares are in percentage points, because tables show shares in percent.
        """
        assert self.comparison is not None
        measure = self.comparison.measures[0]
        times = 100.0 if measure.share else 1.0
        difference, low, high = (times * row[f"difference{end}"] + 0.0 for end in ("", "_low", "_high"))
        unit = " percentage points" if measure.share else f" {measure.unit}" if measure.unit != "1" else ""
        text = f"{difference:.3g}"
        if np.isfinite([difference, low, high]).all():
            text = " ".join(rounded(difference, low, high, decimals_for(high - low)))
        apart, superiority = "" if row["told_apart"] else ", not told apart", row["superiority"]
        how = f"worse in {1 - superiority:.0%}" if self.harms else f"better in {superiority:.0%}"
        trials = f"{row['trials']:,} trials, p {p_equals(row['p_holm'])}{apart}"
        return f"{measure.statistic} of differences {text}{unit}, {how} of {trials}"


def _harm_of_each(comparison: Comparison) -> str:
    """The values of the measure with each adversary, such as "median 0.02 to 0.03 with creeper", the worst first."""
    measure, contest = comparison.measures[0], comparison.contests[0]
    times = 100.0 if measure.share else 1.0
    means = np.where(np.isnan(contest.values), 0.0, contest.values).mean(axis=0)
    order = np.argsort(-means if measure.low else means, kind="stable")
    unit = " %" if measure.share else "" if measure.unit == "1" else f" {measure.unit}"
    each = [f"{range_text(times * contest.values[:, k]) or NEVER}{unit} with {comparison.contenders[k]}" for k in order]
    return f"{measure.full_label}, {measure.statistic} in a world: {', '.join(each)}"


def evidence_of(data: xr.Dataset, settings: list[Setting], plan: TuningPlan, tuned: Brain | Adversary) -> Evidence:
    """Compare what was found with the original in the results of an evaluation with these settings, then with all.

    Names of both contain all searched parameters, also unchanged ones.
    """
    if plan.target.harms:
        return _evidence_of_harm(data, settings, plan, tuned)
    before = plan.target.brain
    assert isinstance(tuned, Brain)
    shown = {before.name: plan.searched}
    brains = [setting.brain.with_numbers(PLAIN) for setting in settings]
    rows = [k for one in (tuned, before) for k, brain in enumerate(brains) if brain == one]
    comparison = compare_dataset(data.isel(setting=rows), plan.metric, None, None, shown)
    all_brains = compare_dataset(data, plan.metric, None, None, shown) if len(rows) < len(settings) else None
    first, second = comparison.contenders
    return Evidence(first, second, comparison, all_brains)


def _evidence_of_harm(
    data: xr.Dataset, settings: list[Setting], plan: TuningPlan, tuned: Brain | Adversary
) -> Evidence:
    """The same of adversaries: they are the contenders, and the brain is a part of the world."""
    assert plan.target.table is not None
    table = {*plan.study.members[plan.target.table].every()}
    brain, pair = plan.target.brain.as_written, (plan.before, tuned)

    def liar_in(setting: Setting) -> Member | None:
        if setting.brain.with_numbers(PLAIN).as_written != brain:
            return None
        return next((m for m in setting.members if m in table or m.brain == tuned), None)

    liars = [(k, setting, liar) for k, setting in enumerate(settings) if (liar := liar_in(setting))]
    rows = [k for k, _, _ in liars]
    names = [plan.label(m.brain) if m.brain in pair else m.brain.label for _, _, m in liars if m.brain]
    adversaries = data.isel(setting=rows).assign_coords(brain=("setting", names))
    adversaries = adversaries.assign_attrs(parameters="{}")  # those of the brain are a part of the world
    if len(plan.study.members) > 1:
        members = [
            "; ".join(str(replace(m, brain=None) if m == liar else m) for m in s.members) for _, s, liar in liars
        ]
        adversaries = adversaries.assign_coords(members=("setting", members))
    else:  # worlds differ only in the number of liars
        adversaries = adversaries.drop_vars(["members", "adversary"])
    both = [k for one in (tuned, plan.before) for k, (_, _, liar) in enumerate(liars) if liar.brain == one]
    comparison = compare_dataset(adversaries.isel(setting=both), plan.metric, None, None, {})
    everyone = compare_dataset(adversaries, plan.metric, None, None, {}) if len(both) < len(liars) else None
    return Evidence(plan.label(tuned), plan.label(plan.before), comparison, everyone, harms=True)
