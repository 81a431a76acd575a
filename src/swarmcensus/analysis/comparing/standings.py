"""Each contender's standing in each world: best, level with the first, or behind; and which pairs differ."""

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from swarmcensus.analysis.comparing.contenders import Grid
from swarmcensus.analysis.comparing.pair_tests import Contest, ends_of_pairs, world_ranks
from swarmcensus.summaries import Measure
from swarmcensus.support.answers import Answer
from swarmcensus.support.hints import did_you_mean
from swarmcensus.support.intervals import Floats
from swarmcensus.support.options import wrong_option
from swarmcensus.support.significance import differences

RANKED = ("best", "level", "behind")
AGAINST = ("better", "level", "worse")


@dataclass(eq=False, repr=False, kw_only=True)
class Standings(Answer):
    """Contenders in worlds, by several measures, with a contest for each measure.

    `asked` are the measures that narrow tables keep, `costs` are what is not tested: means over robots and trials,
    bytes, and where medians hide them medians of the robots' tail (world, contender). `cautions` say what could not be
    compared, or limits the comparison, `pairing` says which trials are paired, and why. `margins` are the differences
    of measures, by name, that make no difference in practice.
    """

    title: str
    grid: Grid
    measures: list[Measure]
    asked: Collection[str]
    contests: list[Contest]
    costs: dict[str, Floats]
    settings: NDArray[np.int64]  # (world, contender), -1 if there is none
    rounds: Floats  # how long each ran, (world, contender)
    cautions: list[str]
    pairing: list[str]
    margins: Mapping[str, float]
    against: int | None  # the contender that all others are compared with; None compares every pair

    @property
    def contenders(self) -> list[str]:
        """The names of contenders, in the order of all arrays."""
        return self.grid.contenders

    @property
    def ways(self) -> tuple[str, str, str]:
        """What standings there are."""
        return RANKED if self.against is None else AGAINST

    def worlds_by(self, axes: Sequence[str]) -> dict[tuple[Any, ...], NDArray[np.intp]]:
        """The worlds of each combination of values, in the order of the worlds. Raises InputError."""
        for name in axes:
            if name in self.grid.factor:
                raise wrong_option("by", name, "it is the factor that is compared, so worlds do not differ in it")
            values = self.grid.coordinates.get(name)
            if values == []:
                raise wrong_option("by", name, "it differs between the contenders of a world")
            if values is None:
                names = [*dict.fromkeys(name for world in self.grid.worlds for name in world)]
                there = f"{did_you_mean(name, names)}worlds differ in {', '.join(names) or 'nothing'}"
                raise wrong_option("by", name, there)
            if len({*values}) < 2:
                raise wrong_option("by", name, f"all worlds have the same, {values[0]}")
        found: dict[tuple[Any, ...], list[int]] = {}
        for w in range(len(self.grid.worlds)):
            found.setdefault(tuple(self.grid.coordinates[name][w] for name in axes), []).append(w)
        return {key: np.array(worlds) for key, worlds in found.items()}

    def standing(self, contest: Contest) -> NDArray[np.str_]:
        """The standing of each contender in each world (world, contender), empty if it is missing, or alone there.

        Standings are `ways`; with `against` they are empty for the contender `against` itself.
        """
        apart, (first, second) = self.apart(contest), ends_of_pairs(len(self.contenders))
        if self.against is not None:
            standing = np.full(contest.values.shape, "", "<U6")
            for k in np.flatnonzero((first == self.against) | (second == self.against)):
                contender = first[k] + second[k] - self.against
                better = ((contest.tests.balance[:, k] < 0) == contest.low) == (contender == first[k])
                way = np.where(apart[:, contender, self.against], np.where(better, "better", "worse"), "level")
                standing[:, contender] = np.where(np.isnan(contest.corrected[:, k]), "", way)
            return standing
        ranked = world_ranks(contest.values, contest.low)
        there = ~np.isnan(ranked)
        there &= there.sum(axis=1, keepdims=True) > 1
        least = np.where(there, ranked, np.inf).min(axis=1, keepdims=True)
        # who is told apart from any of several first ones is behind; who is first is best if all others are behind
        leads = there & (ranked == least)
        behind = there & ~leads & ~(leads[:, np.newaxis] & ~apart).any(axis=2)
        best = leads & (behind.sum(axis=1) == there.sum(axis=1) - 1)[:, np.newaxis]
        return np.select([best, behind, there], ["best", "behind", "level"], "")

    def apart(self, contest: Contest) -> NDArray[np.bool_]:
        """Which contenders differ in each world, (world, contender, contender): values and test must agree."""
        first, second = ends_of_pairs(len(self.contenders))
        order = np.sign(differences(contest.values[:, first], contest.values[:, second]))
        out = np.zeros((*contest.values.shape, len(self.contenders)), np.bool_)
        # medians may be in another order than the ranks that the test compares: then nothing is said
        out[:, first, second] = out[:, second, first] = contest.apart & (order * np.sign(contest.tests.balance) >= 0)
        return out

    def apart_overall(self, contest: Contest) -> NDArray[np.bool_]:
        """Which contenders differ over the worlds that all have met, (contender, contender)."""
        if contest.met.sum() == 1:
            return np.asarray(self.apart(contest)[contest.met][0])
        first, second = ends_of_pairs(len(self.contenders))
        out = np.zeros((len(self.contenders), len(self.contenders)), np.bool_)
        out[first, second] = out[second, first] = contest.duels_apart
        return out
