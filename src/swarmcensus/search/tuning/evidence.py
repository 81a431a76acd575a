"""The evidence for a search's result: a comparison with the original on trials that the search never saw."""

from dataclasses import dataclass, replace

import xarray as xr

from swarmcensus.analysis import Comparison, compare_dataset, p_equals, win_shares
from swarmcensus.brains import PLAIN, Adversary, Brain
from swarmcensus.search.tuning.plans import TuningPlan
from swarmcensus.studies import Member, Setting

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
        """One sentence on all worlds, and two on the study's other brains or liars."""
        if self.comparison is None:
            return [f"{self.why}: the values stay as they were, and there is nothing to compare: {self.before}"]
        compared, [contest] = self.comparison, self.comparison.contests
        whom = " for the swarm" * self.harms
        phrase = {LEVEL: "is not told apart from", BETTER: f"is better{whom} than", WORSE: f"is worse{whom} than"}
        worlds = int(contest.met.sum())
        over, tests = (f" over all {worlds:,} worlds", compared.duels) if worlds > 1 else ("", compared.pairs)
        found = f"{win_shares(*contest.shares(0))}, p {p_equals(tests['p_holm'].iloc[0])}"
        others = self.all_brains.verdict[:2] if self.all_brains else []
        return [
            f"{compared.measures[0].full_label}: {self.tuned} {phrase[self.verdict]} {self.before}{over}: {found}",
            *(f"with the study's other {'liars' if self.harms else 'brains'}: {line}" for line in others),
        ]


def evidence_of(data: xr.Dataset, settings: list[Setting], plan: TuningPlan, tuned: Brain | Adversary) -> Evidence:
    """Compare what was found with the original in the results of an evaluation with these settings, then with all.

    Names of both contain all searched parameters, also unchanged ones.
    """
    programs: list[Brain | Adversary] = [setting.brain.with_numbers(PLAIN) for setting in settings]
    shown = {plan.before.name: plan.searched}
    if plan.target.harms:
        data, programs = _with_liars_as_contenders(data, settings, plan, tuned)
        shown = {}
    rows = [k for one in (tuned, plan.before) for k, program in enumerate(programs) if program == one]
    comparison = compare_dataset(data.isel(setting=rows), plan.metric, None, None, shown)
    comparison.with_pairs = True
    everyone = compare_dataset(data, plan.metric, None, None, shown) if len(rows) < len(programs) else None
    tuned_name, before = comparison.contenders
    return Evidence(tuned_name, before, comparison, everyone, harms=plan.target.harms)


def _with_liars_as_contenders(
    data: xr.Dataset, settings: list[Setting], plan: TuningPlan, tuned: Brain | Adversary
) -> tuple[xr.Dataset, list[Brain | Adversary]]:
    """The settings in which the brain hears a liar, named by the liar, and these; the brain is a part of the world."""
    assert plan.target.table is not None
    table = {*plan.study.members[plan.target.table].every()}
    brain, pair = plan.target.brain.as_written, (plan.before, tuned)

    def liar_in(setting: Setting) -> Member | None:
        if setting.brain.with_numbers(PLAIN).as_written != brain:
            return None
        return next((m for m in setting.members if m in table or m.brain == tuned), None)

    liars = [(k, setting, liar) for k, setting in enumerate(settings) if (liar := liar_in(setting))]
    programs = [liar.brain for _, _, liar in liars if liar.brain]
    names = [plan.label(one) if one in pair else one.label for one in programs]
    heard = data.isel(setting=[k for k, _, _ in liars]).assign_coords(brain=("setting", names))
    heard = heard.assign_attrs(parameters="{}")  # those of the brain are a part of the world
    if len(plan.study.members) > 1:
        members = [
            "; ".join(str(replace(m, brain=None) if m == liar else m) for m in s.members) for _, s, liar in liars
        ]
        return heard.assign_coords(members=("setting", members)), programs
    return heard.drop_vars(["members", "adversary"]), programs  # worlds differ only in the number of liars
