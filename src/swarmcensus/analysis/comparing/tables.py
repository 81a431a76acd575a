"""A comparison as pandas tables."""

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from swarmcensus.analysis.comparing.pair_tests import ALPHA, ends_of_pairs, world_ranks
from swarmcensus.analysis.comparing.standings import Standings
from swarmcensus.support.intervals import FEWEST, share_interval
from swarmcensus.support.quantities import QUANTITIES

if TYPE_CHECKING:
    import pandas as pd

PROFILES = ("measure", "world", "contender", "trials", "round", "share", "share_low", "share_high")


def is_time(name: str) -> bool:
    """Whether a measure is a time that may never come."""
    return name in QUANTITIES and QUANTITIES[name].never


class Frames(Standings):
    """Standings as pandas tables."""

    @property
    def table(self) -> "pd.DataFrame":
        """A pandas table with a row for each world and contender.

        Each measure has its value, the ends of its 95 % interval (`_low`, `_high`), its `_rank` in the world and its
        `_standing`. "best" differs from all others, "level" is first or does not differ from the first, "behind"
        differs from the first. With `against`, standings are "better", "level" or "worse". Costs follow.
        """
        import pandas as pd

        worlds, contenders = at = np.nonzero(self.settings >= 0)
        columns: dict[str, Any] = {"world": worlds} | self._coordinates(worlds)
        columns |= {"contender": np.array(self.contenders, object)[contenders], "setting": self.settings[at]}
        for measure, contest in zip(self.measures, self.contests, strict=True):
            columns |= _with_ends(measure.name, contest.values, contest.value_ends, at)
            columns[f"{measure.name}_rank"] = world_ranks(contest.values, contest.low)[at]
            columns[f"{measure.name}_standing"] = self.standing(contest)[at]
            columns.setdefault("trials", contest.trials[at])
        return pd.DataFrame(columns | {name: each[at] for name, each in self.costs.items() if name not in columns})

    @property
    def pairs(self) -> "pd.DataFrame":
        """A pandas table with a row for each measure, world and pair of contenders: the difference `one` - `other`.

        `one_value` and `other_value` are medians over all robots of all trials, or means. `difference` is of trials'
        medians: the median of paired differences, the difference of medians of others, or that of means, in the
        measure's `unit`, with the ends of its 95 % interval. `superiority` is the probability that `one` is better in a
        random trial, where equal ones count one half, with the ends of its interval. `effect` is the rank-biserial
        correlation, above 0 if `one` is better. `p` is the p-value of the `test`, which is "signed-rank" for paired
        trials and "rank-sum" for others, `p_holm` the corrected one, and `told_apart` whether the pair differs. The
        first test uses the trials that both have, the second all `trials` of `one` and all `other_trials` of the other.
        `p_equal` is the corrected p-value of a difference of the measure's margin or more, and `equal_in_practice`
        whether it is at most 0.05.
        """
        import pandas as pd

        frames, names = [], np.array(self.contenders, object)
        for measure, contest in zip(self.measures, self.contests, strict=True):
            worlds, which = at = np.nonzero(~np.isnan(contest.corrected))
            ones, others = ends_of_pairs(len(names))[:, which]
            frames.append(pd.DataFrame(
                {"measure": measure.name, "unit": measure.unit, "world": worlds} | self._coordinates(worlds) | {
                    "one": names[ones], "other": names[others],
                    "test": np.where(contest.paired[at], "signed-rank", "rank-sum"),
                    "trials": contest.pair_trials[0][at], "other_trials": contest.pair_trials[1][at],
                    "one_value": contest.values[worlds, ones], "other_value": contest.values[worlds, others],
                    **_with_ends("difference", contest.difference, contest.difference_ends, at),
                    **_with_ends("superiority", contest.better, contest.better_ends, at),
                    "effect": (-1 if contest.low else 1) * contest.tests.balance[at] + 0.0, "p": contest.tests.p[at],
                    "p_holm": contest.corrected[at], "told_apart": contest.apart[at],
                    "p_equal": contest.equality[at], "equal_in_practice": contest.equality[at] <= ALPHA,
                }
            ))  # fmt: skip
        return pd.concat(frames, ignore_index=True)

    @property
    def ranks(self) -> "pd.DataFrame":
        """A pandas table with a row for each measure and contender: its average rank, and where it is first.

        `average_rank` is the mean over the trials and worlds that all have met. `best` counts the worlds in which a
        contender is first and differs from all others, `level` the other worlds in which it is first or does not differ
        from the first, and `behind` the rest. With `against`, `better`, `level` and `worse` count worlds. `friedman`
        and `friedman_p` are the statistic and p-value of Friedman's test of the measure, and `friedman_p_corrected` is
        corrected for all measures.
        """
        import pandas as pd

        frames = []
        for measure, contest in zip(self.measures, self.contests, strict=True):
            standing, (statistic, p) = self.standing(contest), contest.friedman
            counts = {way: (standing == way).sum(axis=0) for way in self.ways}
            columns = {"measure": measure.name, "contender": self.contenders, "average_rank": contest.average_ranks}
            overall = {"friedman": statistic, "friedman_p": p, "friedman_p_corrected": contest.friedman_corrected}
            frames.append(pd.DataFrame(columns | counts | overall))
        return pd.concat(frames, ignore_index=True)

    @property
    def duels(self) -> "pd.DataFrame":
        """A pandas table with a row for each measure and pair: the share of common worlds in which one is ahead.

        `ahead` is the share of worlds in which `one` is better, minus the share in which it is worse, averaged over
        trials. The test is the signed-rank test over trials, or that of the mean by empirical likelihood if its p is
        larger. A measure has no rows unless all contenders have met
        several worlds.
        """
        import pandas as pd

        frames, names = [], np.array(self.contenders, object)
        for measure, contest in zip(self.measures, self.contests, strict=True):
            rows, average = np.flatnonzero(~np.isnan(contest.duels_corrected)), contest.average_ranks
            ones, others = ends_of_pairs(len(names))[:, rows]
            frames.append(pd.DataFrame({
                "measure": measure.name, "one": names[ones], "other": names[others],
                "trials": (contest.duels.below + contest.duels.equal + contest.duels.above)[rows],
                "ahead": contest.ahead[rows], "rank_difference": average[ones] - average[others],
                "effect": contest.duels.balance[rows], "p": contest.duels.p[rows],
                "p_holm": contest.duels_corrected[rows], "told_apart": contest.duels_apart[rows],
            }))  # fmt: skip
        return pd.concat(frames, ignore_index=True)

    @property
    def profiles(self) -> "pd.DataFrame":
        """A pandas table of times that may never come: the `share` of trials in which each has come by a round.

        It has a row for each measure, world, contender and round in which the share changes, and the ends of the 95 %
        interval. A run ends for all trials of a contender at once, so the estimate of Kaplan and Meier (1958) is this
        share. A trial in which nothing happened stays in it: the profile ends below 1.
        """
        import pandas as pd

        rows: list[tuple[Any, ...]] = []
        for measure, contest in zip(self.measures, self.contests, strict=True):
            for world, contender in np.argwhere(self.settings >= 0).tolist() if is_time(measure.name) else ():
                times = contest.numbers[world, contender]
                times = times[~np.isnan(times)]
                # from the start to the end of the run, also where nothing happens
                ends = [0.0, *times[np.isfinite(times)], self.rounds[world, contender]]
                for at in np.unique(ends).tolist() if times.size else ():
                    share, low, high = share_interval(int((times <= at).sum()), times.size)
                    if times.size < FEWEST:
                        low = high = np.nan
                    rows.append((measure.name, world, self.contenders[contender], times.size, at, share, low, high))
        return pd.DataFrame(rows, columns=list(PROFILES))

    def by(self, *axes: str | Sequence[str]) -> "pd.DataFrame":
        """A pandas table: for each combination of these axes' values and contender, the number of each standing.

        Raises InputError if worlds do not differ in such an axis.
        """
        import pandas as pd

        names = [name for axis in axes for name in ([axis] if isinstance(axis, str) else axis)]
        standings = [self.standing(contest) for contest in self.contests]
        rows = []
        for values, worlds in self.worlds_by(names).items():
            for k, name in enumerate(self.contenders):
                met = worlds[self.settings[worlds, k] >= 0]
                if not met.size or k == self.against:
                    continue
                row: dict[str, Any] = dict(zip(names, values, strict=True)) | {"contender": name, "worlds": met.size}
                for measure, standing in zip(self.measures, standings, strict=True):
                    row |= {f"{measure.name}_{way}": int((standing[met, k] == way).sum()) for way in self.ways}
                rows.append(row)
        return pd.DataFrame(rows)

    def _coordinates(self, worlds: NDArray[np.intp]) -> dict[str, list[Any]]:
        names = dict.fromkeys(name for world in self.grid.worlds for name in world)
        return {name: [self.grid.worlds[world].get(name) for world in worlds.tolist()] for name in names}


def _with_ends(name: str, value: Any, ends: Sequence[Any], at: Any) -> dict[str, Any]:
    return {f"{name}{end}": part[at] for end, part in zip(("", "_low", "_high"), (value, *ends), strict=True)}
