"""Who stands where in a comparison: first, level with the first, or behind, in each world and over all of them."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from swarmcensus.comparing.contenders import Field
from swarmcensus.comparing.pair_tests import Contest, pairs_of, world_ranks
from swarmcensus.results.measures import Measure

Floats = NDArray[np.float64]
RANKED = ("best", "level", "behind")
AGAINST = ("better", "level", "worse")


@dataclass(frozen=True)
class Standings:
    """Contenders in worlds, by several measures, of each of which there is a contest.

    `costs` are means over robots and trials (world, contender), `sizes` bytes (world, contender); `cautions` say what
    could not be compared, or should be known before believing it.
    """

    title: str
    field: Field
    measures: list[Measure]
    contests: list[Contest]
    costs: dict[str, Floats]
    sizes: dict[str, Floats]
    settings: NDArray[np.int64]  # (world, contender), -1 where there is none
    cautions: list[str]
    against: int | None = None  # the contender that the others are held against; None: each against each

    @property
    def contenders(self) -> list[str]:
        """The names of contenders, in the order of every array of them."""
        return self.field.contenders

    def standing(self, contest: Contest) -> NDArray[np.str_]:
        """The standing of each contender in each world (world, contender), empty where it is lacking, or alone.

        These are `RANKED`; of contenders held against one of them `AGAINST`, and that one has none.
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

    def _standing_against(self, contest: Contest, mark: int) -> NDArray[np.str_]:
        out = np.full(contest.values.shape, "", "<U6")
        for k, (one, other) in enumerate(pairs_of(len(self.contenders))):
            if mark not in (one, other) or np.isnan(contest.corrected[:, k]).all():
                continue
            first_is_better = (contest.tests.balance[:, k] < 0) == contest.low
            who, better = (other, ~first_is_better) if one == mark else (one, first_is_better)
            way = np.where(contest.apart[:, k], np.where(better, "better", "worse"), "level")
            out[:, who] = np.where(np.isnan(contest.corrected[:, k]), "", way)
        return out

    def apart(self, contest: Contest) -> NDArray[np.bool_]:
        """Who is told apart from whom in which world, (world, contender, contender)."""
        count = len(self.contenders)
        found = np.zeros((len(contest.values), count, count), np.bool_)
        for k, (one, other) in enumerate(pairs_of(count)):
            found[:, one, other] = found[:, other, one] = contest.apart[:, k]
        return found

    def apart_overall(self, contest: Contest) -> NDArray[np.bool_]:
        """Who is told apart from whom over all worlds that all have met, (contender, contender)."""
        if contest.met.sum() == 1:
            return np.asarray(self.apart(contest)[contest.met][0])
        count = len(self.contenders)
        found = np.zeros((count, count), np.bool_)
        for k, (one, other) in enumerate(pairs_of(count)):
            found[one, other] = found[other, one] = contest.duels_apart[k]
        return found
