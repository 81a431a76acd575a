"""Each contender's standing in each world: best, level with the first, or behind; and which pairs differ."""

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from swarmcensus.analysis.comparing.contenders import Grid
from swarmcensus.analysis.comparing.pair_tests import Contest, pairs_of, world_ranks
from swarmcensus.results import Measure
from swarmcensus.support.significance import differences

Floats = NDArray[np.float64]
RANKED = ("best", "level", "behind")
AGAINST = ("better", "level", "worse")


@dataclass(frozen=True)
class Standings:
    """Contenders in worlds, by several measures, with a contest for each measure.

    `costs` are means over robots and trials (world, contender), `sizes` are bytes (world, contender), `cautions` say
    what could not be compared, or limits the comparison, `pairing` says which trials are paired, and why. `margins`
    are the differences of measures, by name, that make no difference in practice. `tails` are values and ends of
    intervals, each (world, contender), that are shown next to medians which hide them; they are not tested.
    """

    title: str
    grid: Grid
    measures: list[Measure]
    contests: list[Contest]
    costs: dict[str, Floats]
    sizes: dict[str, Floats]
    settings: NDArray[np.int64]  # (world, contender), -1 if there is none
    rounds: Floats  # how long each ran, (world, contender)
    cautions: list[str]
    tails: dict[str, tuple[Floats, Floats, Floats]] = field(default_factory=dict)
    pairing: list[str] = field(default_factory=list)
    margins: Mapping[str, float] = field(default_factory=dict)
    against: int | None = None  # the contender that all others are compared with; None compares every pair

    @property
    def contenders(self) -> list[str]:
        """The names of contenders, in the order of all arrays."""
        return self.grid.contenders

    @property
    def kind(self) -> str:
        """The coordinate whose values contenders are: "brain" if brains are among them."""
        return "brain" if "brain" in self.grid.factor or not self.grid.factor else self.grid.factor[0]

    def standing(self, contest: Contest) -> NDArray[np.str_]:
        """The standing of each contender in each world (world, contender), empty if it is missing, or alone there.

        Standings are `RANKED`. With `against` they are `AGAINST`, and empty for the contender `against` itself.
        """
        if self.against is not None:
            return self._standing_against(contest, self.against)
        ranked = world_ranks(contest.values, contest.low)
        there, apart = ~np.isnan(ranked), self.apart(contest)
        there &= there.sum(axis=1, keepdims=True) > 1
        least = np.where(there, ranked, np.inf).min(axis=1, keepdims=True)
        first = there & (ranked == least)
        behind = there & ~first & ~(first[:, np.newaxis] & ~apart).any(axis=2)
        best = first & (behind.sum(axis=1) == there.sum(axis=1) - 1)[:, np.newaxis]
        return np.select([best, behind, there], ["best", "behind", "level"], "")

    def _standing_against(self, contest: Contest, reference: int) -> NDArray[np.str_]:
        apart = self.apart(contest)
        out = np.full(contest.values.shape, "", "<U6")
        for k, (first, second) in enumerate(pairs_of(len(self.contenders))):
            if reference not in (first, second) or np.isnan(contest.corrected[:, k]).all():
                continue
            first_is_better = (contest.tests.balance[:, k] < 0) == contest.low
            contender, better = (second, ~first_is_better) if first == reference else (first, first_is_better)
            way = np.where(apart[:, first, second], np.where(better, "better", "worse"), "level")
            out[:, contender] = np.where(np.isnan(contest.corrected[:, k]), "", way)
        return out

    def apart(self, contest: Contest) -> NDArray[np.bool_]:
        """Which contenders differ in each world, (world, contender, contender): values and test must agree."""
        count = len(self.contenders)
        out = np.zeros((len(contest.values), count, count), np.bool_)
        for k, (first, second) in enumerate(pairs_of(count)):
            order = np.sign(differences(contest.values[:, first], contest.values[:, second]))
            agree = order * np.sign(contest.tests.balance[:, k]) >= 0
            out[:, first, second] = out[:, second, first] = contest.apart[:, k] & agree
        return out

    def apart_overall(self, contest: Contest) -> NDArray[np.bool_]:
        """Which contenders differ over the worlds that all have met, (contender, contender)."""
        if contest.met.sum() == 1:
            return np.asarray(self.apart(contest)[contest.met][0])
        count = len(self.contenders)
        out = np.zeros((count, count), np.bool_)
        for k, (first, second) in enumerate(pairs_of(count)):
            out[first, second] = out[second, first] = contest.duels_apart[k]
        return out
