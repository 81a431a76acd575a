"""The statistics of a comparison: a test of every two contenders in every world, corrected for their number.

Contenders are paired, trial by trial, where their trials share random numbers; others are independent samples.
"""

import functools
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from itertools import combinations
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from swarmcensus.support.bootstrap import Statistic, centres, intervals
from swarmcensus.support.formatting import counted
from swarmcensus.support.intervals import FEWEST, LEVEL, Estimate, Floats, estimate, student, student_p
from swarmcensus.support.rank_sums import ends_of_probability, rank_sums, shift
from swarmcensus.support.significance import (
    RankTest,
    differences,
    fewest_trials,
    friedman,
    holm,
    mean_tests,
    midranks,
    paired_tests,
    tails,
)

ALPHA = 1 - LEVEL
TINY = 1e-99  # half an interval of width 0
BLOCK = 2**22  # numbers that are compared at once, to bound memory


class ContestInput(NamedTuple):
    """A measure's numbers (world, contender, trial), and the statistic over trials by which they are compared.

    NaN is a missing trial; infinity is a trial in which the measured event never happened. `low` tells that low numbers
    are better, `share` that they are between 0 and 1. `margin` is a difference that makes no difference in practice.
    """

    numbers: Floats
    statistic: Statistic
    low: bool = True
    share: bool = False
    margin: float | None = None


@dataclass(frozen=True)
class Contest:
    """One measure's values (world, contender) and tests (world, pair); NaN where there is none.

    A pair's `difference` is its first contender minus its second. Where it is `paired`, tests count trials, else pairs
    of a trial of the first and a trial of the second. `better_ends` are the ends of the interval of `better`. `ranks`
    (trial, contender) are centred, and summed over the worlds that all contenders have met. `duels` (pair,) are tests
    over all these worlds: their number for a trial is the share of worlds in which the first contender is ahead, minus
    the share in which it is behind.
    `corrected` are p-values after Holm's correction for all tests in single worlds, of all measures of a comparison,
    and `duels_corrected` for all tests over all worlds; `friedman_corrected` is the p-value of Friedman's test,
    corrected for the measures alone. `equality` are the p-values of `p_of_margin`, corrected for all of these; NaN
    without a margin.
    """

    low: bool  # whether low values are better
    numbers: Floats  # of each trial, (world, contender, trial)
    values: Floats
    value_ends: tuple[Floats, Floats]
    trials: NDArray[np.int64]
    difference: Floats
    difference_ends: tuple[Floats, Floats]
    tests: RankTest
    paired: NDArray[np.bool_]
    pair_trials: NDArray[np.int64]  # of the first and of the second, (2, world, pair); of paired ones those of both
    better_ends: tuple[Floats, Floats]
    met: NDArray[np.bool_]  # which worlds all contenders have met, (world,)
    ranks: Floats
    ahead: Floats  # the mean over trials of the numbers of `duels`, (pair,)
    duels: RankTest
    friedman: tuple[float, float]  # Q and p
    corrected: Floats
    duels_corrected: Floats
    equality: Floats
    friedman_corrected: float = np.nan

    @property
    def differ(self) -> bool:
        """Whether Friedman's test finds that any contenders differ over all worlds."""
        return self.friedman_corrected <= ALPHA

    @property
    def better(self) -> Floats:
        """The probability that the first is better than the second in a random trial; equal ones count one half."""
        ahead, equal = self.tests.below if self.low else self.tests.above, self.tests.equal
        with np.errstate(invalid="ignore"):
            return np.asarray((ahead + equal / 2) / (self.tests.below + equal + self.tests.above))

    def p_of_margin(self, margin: float, statistic: Statistic) -> Floats:
        """The p-values of tested pairs that differ by the margin or more, before correction, (world, pair).

        They are at most 5 % where the interval of the difference lies within the margin: two one-sided tests by
        Student's t (Schuirmann, 1987). Far ends of medians' intervals are less well known, so that p is at least that
        of a sign test of paired differences beyond the margin, and that of n trials at least 1 / 2^n. It is 1 for
        infinite numbers: a time that never comes is equal to no other.
        """
        p = np.where(np.isnan(self.corrected), np.nan, 1.0)
        for world, pair in np.argwhere(p == 1.0).tolist():
            at, trials = (world, pair), int(self.pair_trials[:, world, pair].min())
            both = self.numbers[world, ends_of_pairs(self.numbers.shape[1])[:, pair]]
            low, high = (float(end[at]) for end in self.difference_ends)
            found = exact_if_same(float(self.difference[at]), low, high, trials)
            left = margin + found.value * np.array([1.0, -1.0]), np.abs(np.array(found[1:]) - found.value)
            if np.isfinite(found).all() and left[0].min() > 0.0 and not np.isinf(both).any():
                reach = float((left[0] / np.maximum(left[1], TINY)).min())
                off = differences(*both) * (self.paired[at] and statistic == "median")
                beyond = np.array([max((off >= margin).sum(), (off <= -margin).sum())])
                signs = float(tails(np.ones((1, trials), np.int64), beyond)[0])
                p[at] = max(signs, student_p((reach * student(trials, LEVEL)) ** 2, trials - 1))
        return p

    @property
    def apart(self) -> NDArray[np.bool_]:
        """Which pairs differ in which worlds, (world, pair): difference and test must have the same sign."""
        return np.asarray((self.corrected <= ALPHA) & (np.sign(self.difference) * np.sign(self.tests.balance) >= 0))

    @property
    def level(self) -> NDArray[np.bool_]:
        """Which pairs have the same number in every trial of every world that both have met, (pair,)."""
        differ = (self.tests.below + self.tests.above).sum(axis=0)
        return np.asarray((differ == 0) & (self.tests.equal.sum(axis=0) > 0))

    @property
    def average_ranks(self) -> Floats:
        """The mean rank of each contender, 1 the best, over the trials and worlds that all have met; NaN without."""
        if not len(self.ranks):
            return np.full(self.values.shape[1], np.nan)
        return np.asarray(self.ranks.mean(axis=0) / self.met.sum() + (self.values.shape[1] + 1) / 2)

    @property
    def duels_apart(self) -> NDArray[np.bool_]:
        """Which pairs differ over all worlds, (pair,): `ahead` and the test must have the same sign."""
        return np.asarray((self.duels_corrected <= ALPHA) & (np.sign(self.ahead) * np.sign(self.duels.balance) >= 0))

    def shares(self, pair: int) -> tuple[float, float]:
        """The shares of trials in which the first of a pair is better, and worse, in the worlds that all have met."""
        tests = self.tests
        below, equal, above = (int(part[self.met, pair].sum()) for part in (tests.below, tests.equal, tests.above))
        better, worse = (below, above) if self.low else (above, below)
        return better / (below + equal + above), worse / (below + equal + above)


def pairs_of(contenders: int) -> list[tuple[int, int]]:
    """The pairs of `contenders` contenders, in the order of every array of pairs."""
    return list(combinations(range(contenders), 2))


def number_of_tests(all_contests: Iterable[Contest], over_all: bool = False) -> int:
    """The number of pair tests of all measures, for which each is corrected: in single worlds, or over all worlds."""
    tested = (contest.duels_corrected if over_all else contest.corrected for contest in all_contests)
    return sum(int((~np.isnan(p)).sum()) for p in tested)


def ends_of_pairs(contenders: int) -> NDArray[np.intp]:
    """The first contender of each pair, and the second, (2, pair)."""
    return np.array(pairs_of(contenders), np.intp).reshape(-1, 2).T


def in_worlds_too_few(all_contests: Sequence[Contest]) -> str:
    """What the trials are too few for in single worlds, as a sentence; empty if they are enough for some."""
    trials = max(int(contest.trials.max()) for contest in all_contests)
    paired = any((contest.paired & ~np.isnan(contest.corrected)).any() for contest in all_contests)
    return too_few(trials, number_of_tests(all_contests), "compare fewer measures or worlds", paired=paired)


def overall_too_few(all_contests: Sequence[Contest]) -> str:
    """What the trials are too few for over all worlds, as a sentence; empty if they are enough for some."""
    trials = max(len(contest.ranks) for contest in all_contests)
    return too_few(trials, number_of_tests(all_contests, over_all=True), "compare fewer measures", " over all worlds")


def too_few(trials: int, tests: int, advice: str, where: str = "", paired: bool = True) -> str:
    """That no test can reach the level after correction for `tests` tests, as a sentence; empty if one can."""
    least = fewest_trials(tests, ALPHA, paired)
    if not tests or trials >= least:
        return ""
    among = f"cannot tell anything apart{where} among {counted(tests, 'test')}"
    return f"{counted(trials, 'trial')} {among}: run {least} or more, or {advice}"


def contests(
    measures: list[ContestInput], with_intervals: bool = True, against: int | None = None,
    paired: NDArray[np.bool_] | None = None,
) -> list[Contest]:  # fmt: skip
    """The contest of each measure. Without intervals, they and Friedman's test, which take most of the time, are NaN.

    With `against` only pairs with that contender are tested. `paired` (world, pair) says which are tested trial by
    trial, by default all; tests over all worlds always are, which is valid for independent trials too. The pair tests
    in single worlds, of all measures, are one family: the probability of any false positive is at most 5 %. The pair
    tests over all worlds are another, and so are those of equality. So are Friedman's tests, one for each measure,
    which find whether any contenders differ, but not which.
    """
    untested = [_contest(contest, with_intervals, against, paired) for contest in measures]
    for contest, (_, statistic, _, _, margin) in zip(untested, measures, strict=True):
        contest.equality[...] = contest.p_of_margin(margin, statistic) if margin else np.nan
    for name in ("corrected", "duels_corrected", "equality"):
        family = [getattr(contest, name) for contest in untested]
        corrected, at = holm(np.concatenate([part.ravel() for part in family])), 0
        for part in family:
            part[...] = corrected[at : at + part.size].reshape(part.shape)
            at += part.size
    overall = holm(np.array([contest.friedman[1] for contest in untested]))
    return [replace(contest, friedman_corrected=float(p)) for contest, p in zip(untested, overall, strict=True)]


def _contest(
    contest_input: ContestInput, with_intervals: bool, against: int | None, paired: NDArray[np.bool_] | None
) -> Contest:
    numbers, statistic, low, share, _ = contest_input
    worlds, contenders, trials = numbers.shape
    most = 1.0 if share else np.inf
    first, second = ends_of_pairs(contenders)
    tested = np.full(len(first), True) if against is None else (first == against) | (second == against)
    known = ~np.isnan(numbers)
    met = np.asarray(np.all(known.any(axis=2), axis=1))
    whole = np.all(known[met], axis=(0, 1)) & met.any()  # trials that all contenders have in all of these worlds
    ahead, ranks = (np.zeros((int(whole.sum()), count)) for count in (len(first), contenders))
    # block by block of worlds: the differences of all pairs in all of them may not fit into memory
    parts: list[tuple[Floats, Floats, Floats, RankTest]] = []
    step = max(1, BLOCK // max(1, len(first) * trials))
    for start in range(0, worlds, step):
        block = numbers[start : start + step]
        pair_differences = differences(block[:, first], block[:, second])
        ends = _ends(pair_differences, statistic, with_intervals, -most, most)
        parts.append((centres(pair_differences, statistic), *ends, paired_tests(pair_differences)))
        signs = np.sign(pair_differences[met[start : start + step]][..., whole]).sum(axis=0).T
        ahead -= signs if low else -signs
    # a rank is the middle one plus half the number of better contenders minus half that of worse ones
    np.subtract.at(ranks.T, first, ahead.T / 2)
    np.add.at(ranks.T, second, ahead.T / 2)
    ahead /= max(met.sum(), 1)
    difference, lowest, highest = (np.concatenate([part[k] for part in parts]) for k in range(3))
    tests = RankTest(*(np.concatenate(columns) for columns in zip(*(part[3] for part in parts), strict=True)))
    # what follows replaces the tests of pairs whose trials share nothing
    paired = np.ones((worlds, len(first)), np.bool_) if paired is None else paired
    ends = _ends(numbers, statistic, with_intervals, 0.0 if share else -np.inf, most)
    for world, pair in np.argwhere(~paired & tested).tolist():
        one, other = _samples(numbers, world, pair)
        if one.size and other.size:
            left = _alone(one, statistic, share, (world, first[pair]), ends)
            right = _alone(other, statistic, share, (world, second[pair]), ends)
            found = difference_of(one, other, left, right, with_intervals)
            difference[world, pair], lowest[world, pair], highest[world, pair] = found
            for into, number in zip(tests, rank_sums(one, other), strict=True):
                into[world, pair] = number
    counts, common = known.sum(axis=2), (known[:, first] & known[:, second]).sum(axis=2)
    sizes = np.stack([np.where(paired, common, counts[:, who]) for who in (first, second)])
    duels = mean_tests(ahead.T)
    overall = tested & (met.sum() > 1)  # in one world, its own tests are enough
    return Contest(
        low, numbers, centres(numbers, statistic), ends, np.asarray(counts), difference, (lowest, highest),
        tests, paired, sizes, _better_ends(numbers, tests, low, paired, sizes, with_intervals), met, ranks,
        ahead=centres(ahead.T, "mean"), duels=duels, equality=np.empty(difference.shape),
        friedman=friedman(ranks) if len(ranks) and contenders > 1 and with_intervals else (np.nan, np.nan),
        corrected=np.where(tested & (tests.below + tests.equal + tests.above > 0), tests.p, np.nan),
        duels_corrected=np.where(overall & (duels.below + duels.equal + duels.above > 0), duels.p, np.nan),
    )  # fmt: skip


def _samples(numbers: Floats, world: int, pair: int) -> tuple[Floats, Floats]:
    """The numbers that the two contenders of a pair have in a world."""
    one, other = numbers[world, ends_of_pairs(numbers.shape[1])[:, pair]]
    return one[~np.isnan(one)], other[~np.isnan(other)]


def difference_of(
    first: Floats, second: Floats, one: Estimate, other: Estimate, with_interval: bool = True
) -> tuple[float, float, float]:
    """The difference of two independent samples and the ends of its interval, from the estimate of `one` and `other`.

    It is that of their medians, or means, and its interval is put together from their two intervals: Zou and Donner,
    "Construction of confidence limits about effect measures", 2008. If a number is infinite, it is the median of all
    differences, see `shift`.
    """
    if not (np.isfinite(first).all() and np.isfinite(second).all()):
        return shift(first, second)
    value = one.value - other.value
    if not with_interval or (one.low == one.high == one.value and other.low == other.high == other.value):
        return value, np.nan, np.nan
    below = float(np.hypot(one.value - one.low, other.high - other.value))
    return value, value - below, value + float(np.hypot(one.high - one.value, other.value - other.low))


def _alone(
    sample: Floats, statistic: Statistic, share: bool, at: tuple[int, int], ends: tuple[Floats, Floats]
) -> Estimate:
    """The median or mean of one sample and its interval, `exact_if_same`.

    `ends` are those of medians, found for all samples at once, and `at` is the sample's place there.
    """
    if statistic == "mean":
        return estimate(sample[:, np.newaxis], "mean", share)
    return exact_if_same(float(np.median(sample)), float(ends[0][at]), float(ends[1][at]), sample.size)


def exact_if_same(value: float, low: float, high: float, trials: int) -> Estimate:
    """An estimate, of which the interval has width 0 if it is not known although trials are enough: all are equal."""
    same = np.isnan(low) and trials >= FEWEST
    return Estimate(value, value if same else low, value if same else high)


def _better_ends(
    numbers: Floats, tests: RankTest, low: bool, paired: NDArray[np.bool_], sizes: NDArray[np.int64], wanted: bool
) -> tuple[Floats, Floats]:
    """The ends of the intervals of `Contest.better`, each (world, pair)."""
    ends = np.full((2, *paired.shape), np.nan)
    ahead, behind = (tests.below, tests.above) if low else (tests.above, tests.below)
    for world, pair in np.argwhere(sizes.all(axis=0)).tolist() if wanted else ():
        counts = tuple(int(part[world, pair]) for part in (ahead, tests.equal, behind))
        if paired[world, pair]:
            ends[:, world, pair] = _ends_of_trials(*counts)
        else:
            one, other = _samples(numbers, world, pair)
            ends[:, world, pair] = ends_of_probability(other, one) if low else ends_of_probability(one, other)
    return ends[0], ends[1]


@functools.lru_cache(maxsize=4096)
def _ends_of_trials(ahead: int, equal: int, behind: int) -> tuple[float, float]:
    """The interval of the probability of being ahead, from so many trials; equal ones count one half."""
    scores = np.repeat([1.0, 0.5, 0.0], [ahead, equal, behind])
    _, least, most = estimate(scores[:, np.newaxis], "mean", share=True)
    return least, most


def _ends(values: Floats, statistic: Statistic, wanted: bool, least: float, most: float) -> tuple[Floats, Floats]:
    if not wanted:
        return np.full(values.shape[:-1], np.nan), np.full(values.shape[:-1], np.nan)
    low, high = np.clip(intervals(values.reshape(-1, values.shape[-1]), statistic), least, most)
    return low.reshape(values.shape[:-1]), high.reshape(values.shape[:-1])


def world_ranks(values: Floats, low: bool) -> Floats:
    """The rank of each contender's value in each world (world, contender); 1 is best, NaN is missing."""
    return midranks(values if low else -values)
