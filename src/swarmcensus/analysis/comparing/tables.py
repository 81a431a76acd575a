"""A comparison as pandas tables, and as CSV."""

from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from swarmcensus.analysis.comparing.pair_tests import pairs_of, world_ranks
from swarmcensus.analysis.comparing.standings import AGAINST, RANKED, Standings
from swarmcensus.support import printable
from swarmcensus.support.files import atomic_write

if TYPE_CHECKING:
    import pandas as pd


def table(standings: Standings) -> "pd.DataFrame":
    """See `Comparison.table`."""
    import pandas as pd

    worlds, contenders = np.nonzero(standings.settings >= 0)
    columns: dict[str, Any] = {"world": worlds} | _coordinates(standings, worlds)
    columns["contender"] = np.array(standings.contenders, object)[contenders]
    columns["setting"] = standings.settings[worlds, contenders]
    at = worlds, contenders
    for measure, contest in zip(standings.measures, standings.contests, strict=True):
        columns[measure.name] = contest.values[at]
        columns[f"{measure.name}_low"], columns[f"{measure.name}_high"] = (ends[at] for ends in contest.value_ends)
        columns[f"{measure.name}_rank"] = world_ranks(contest.values, contest.low)[at]
        columns[f"{measure.name}_standing"] = standings.standing(contest)[at]
        columns.setdefault("trials", contest.trials[at])
    for name, parts in standings.tails.items():
        columns |= {f"{name}{end}": part[at] for end, part in zip(("", "_low", "_high"), parts, strict=True)}
    for name, values in (standings.costs | standings.sizes).items():
        columns.setdefault(name, values[at])
    return pd.DataFrame(columns)


def pairs(standings: Standings) -> "pd.DataFrame":
    """See `Comparison.pairs`.

    `difference` is the median of paired differences, the difference of medians of others, or that of means, in the
    measure's `unit`, with the ends of its 95 % interval. `superiority` is the probability that `one` is better in a
    random trial, where equal ones count one half, with the ends of its interval. `effect` is the rank-biserial
    correlation, above 0 if `one` is better. `p` is the p-value of the `test`, which is "signed-rank" for paired trials
    and "rank-sum" for others, `p_holm` the corrected one, `told_apart` whether the pair differs, and
    `equal_in_practice` whether the interval of the difference lies within the measure's margin.
    """
    import pandas as pd

    frames = []
    for measure, contest in zip(standings.measures, standings.contests, strict=True):
        worlds, which = np.nonzero(~np.isnan(contest.corrected))
        at, sign = (worlds, which), -1 if contest.low else 1
        ends = np.array(pairs_of(len(standings.contenders)), np.intp).reshape(-1, 2)[which]
        names = np.array(standings.contenders, object)
        columns: dict[str, Any] = {"measure": measure.name, "unit": measure.unit, "world": worlds}
        columns |= _coordinates(standings, worlds) | {"one": names[ends[:, 0]], "other": names[ends[:, 1]]}
        columns |= {"test": np.where(contest.paired[at], "signed-rank", "rank-sum")}
        columns |= {"trials": contest.pair_trials[0][at], "other_trials": contest.pair_trials[1][at]}
        columns |= {"one_value": contest.values[worlds, ends[:, 0]]}
        columns |= {"other_value": contest.values[worlds, ends[:, 1]], "difference": contest.difference[at]}
        columns |= {"difference_low": contest.difference_ends[0][at], "difference_high": contest.difference_ends[1][at]}
        columns |= {"superiority": contest.better[at]}
        columns |= {"superiority_low": contest.better_ends[0][at], "superiority_high": contest.better_ends[1][at]}
        columns |= {"effect": sign * contest.tests.balance[at] + 0.0, "p": contest.tests.p[at]}
        columns |= {"p_holm": contest.corrected[at], "told_apart": contest.apart[at]}
        columns |= {"equal_in_practice": contest.within(standings.margins.get(measure.name))[at]}
        frames.append(pd.DataFrame(columns))
    return pd.concat(frames, ignore_index=True)


def ranks(standings: Standings) -> "pd.DataFrame":
    """See `Comparison.ranks`.

    `average_rank` is the mean over the trials and worlds that all have met. `best` counts the worlds in which a
    contender is first and differs from all others, `level` the other worlds in which it is first or does not differ
    from the first, and `behind` the rest. With `against`, `better`, `level` and `worse` count worlds. `friedman` and
    `friedman_p` are the statistic and p-value of Friedman's test of the measure, and `friedman_p_corrected` is
    corrected for all measures.
    """
    import pandas as pd

    frames = []
    for measure, contest in zip(standings.measures, standings.contests, strict=True):
        standing = standings.standing(contest)
        ways = RANKED if standings.against is None else AGAINST
        counts = {name: (standing == name).sum(axis=0) for name in ways}
        columns = {"measure": measure.name, "contender": standings.contenders, "average_rank": contest.average_ranks}
        statistic, p = contest.friedman
        overall = {"friedman": statistic, "friedman_p": p, "friedman_p_corrected": contest.friedman_corrected}
        frames.append(pd.DataFrame(columns | counts | overall))
    return pd.concat(frames, ignore_index=True)


def duels(standings: Standings) -> "pd.DataFrame":
    """See `Comparison.duels`.

    `ahead` is the share of worlds in which `one` is better, minus the share in which it is worse, averaged over trials.
    The test is the signed-rank test over trials. A measure has no rows unless all contenders have met several worlds.
    """
    import pandas as pd

    frames = []
    names = np.array(standings.contenders, object)
    for measure, contest in zip(standings.measures, standings.contests, strict=True):
        rows = np.flatnonzero(~np.isnan(contest.duels_corrected))
        ends = np.array(pairs_of(len(names)), np.intp).reshape(-1, 2)[rows]
        average = contest.average_ranks
        tests = contest.duels
        columns: dict[str, Any] = {"measure": measure.name, "one": names[ends[:, 0]], "other": names[ends[:, 1]]}
        columns |= {"trials": (tests.below + tests.equal + tests.above)[rows], "ahead": contest.ahead[rows]}
        columns |= {"rank_difference": average[ends[:, 0]] - average[ends[:, 1]], "effect": tests.balance[rows]}
        columns |= {"p": tests.p[rows], "p_holm": contest.duels_corrected[rows]}
        frames.append(pd.DataFrame(columns | {"told_apart": contest.duels_apart[rows]}))
    return pd.concat(frames, ignore_index=True)


def write_csv(standings: Standings, path: str | Path) -> int:
    """Write `pairs` as CSV, whole or not at all, and return the number of rows. Raises InputError."""
    frame = pairs(standings)
    with atomic_write(path) as temporary:
        printable.write_csv(frame, temporary)
    return len(frame)


def _coordinates(standings: Standings, worlds: Any) -> dict[str, Any]:
    names = dict.fromkeys(name for world in standings.grid.worlds for name in world)
    return {name: [standings.grid.worlds[world].get(name) for world in worlds.tolist()] for name in names}
