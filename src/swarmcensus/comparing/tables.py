"""A comparison as pandas tables: what `Comparison` gives, and what becomes CSV."""

from pathlib import Path
from typing import Any

import numpy as np

from swarmcensus.basics.files import whole
from swarmcensus.comparing.pair_tests import pairs_of, world_ranks
from swarmcensus.comparing.standings import AGAINST, RANKED, Standings


def table(found: Standings) -> Any:
    """See `Comparison.table`."""
    import pandas as pd

    worlds, contenders = np.nonzero(found.settings >= 0)
    columns: dict[str, Any] = {"world": worlds} | _coordinates(found, worlds)
    columns["contender"] = np.array(found.contenders, object)[contenders]
    columns["setting"] = found.settings[worlds, contenders]
    at = worlds, contenders
    for one, contest in zip(found.measures, found.contests, strict=True):
        columns[one.name] = contest.values[at]
        columns[f"{one.name}_low"], columns[f"{one.name}_high"] = (ends[at] for ends in contest.value_ends)
        columns[f"{one.name}_rank"] = world_ranks(contest.values, contest.low)[at]
        columns[f"{one.name}_standing"] = found.standing(contest)[at]
        columns.setdefault("trials", contest.trials[at])
    for name, values in (found.costs | found.sizes).items():
        columns.setdefault(name, values[at])
    return pd.DataFrame(columns)


def pairs(found: Standings) -> Any:
    """See `Comparison.pairs`.

    `difference` is the median of the trials' differences, or their mean, in the measure's `unit`, with the ends of its
    95 % interval; `superiority` is the share of trials in which `one` is better, equal ones counted half; `effect` the
    matched rank-biserial correlation, above 0 where `one` is better; `p` is that of the signed-rank test, `p_holm` the
    same corrected, and `told_apart` what comes of it.
    """
    import pandas as pd

    some = []
    for one, contest in zip(found.measures, found.contests, strict=True):
        trials = contest.tests.below + contest.tests.equal + contest.tests.above
        worlds, which = np.nonzero(~np.isnan(contest.corrected))
        at, sign = (worlds, which), -1 if contest.low else 1
        better = contest.tests.below if contest.low else contest.tests.above
        ends = np.array(pairs_of(len(found.contenders)), np.intp).reshape(-1, 2)[which]
        names = np.array(found.contenders, object)
        columns: dict[str, Any] = {"measure": one.name, "unit": one.unit, "world": worlds}
        columns |= _coordinates(found, worlds) | {"one": names[ends[:, 0]], "other": names[ends[:, 1]]}
        columns |= {"trials": trials[at], "one_value": contest.values[worlds, ends[:, 0]]}
        columns |= {"other_value": contest.values[worlds, ends[:, 1]], "difference": contest.difference[at]}
        columns |= {"difference_low": contest.difference_ends[0][at], "difference_high": contest.difference_ends[1][at]}
        columns |= {"superiority": (better[at] + contest.tests.equal[at] / 2) / trials[at]}
        columns |= {"effect": sign * contest.tests.balance[at] + 0.0, "p": contest.tests.p[at]}
        columns |= {"p_holm": contest.corrected[at], "told_apart": contest.apart[at]}
        some.append(pd.DataFrame(columns))
    return pd.concat(some, ignore_index=True)


def ranks(found: Standings) -> Any:
    """See `Comparison.ranks`.

    `average_rank` is over the trials and worlds that all have met. `best` counts the worlds in which a contender is
    first and told apart from all others, `level` those in which it is first or not told apart from the first otherwise,
    and `behind` the rest; of contenders held against one of them `better`, `level` and `worse` count worlds.
    `friedman` and `friedman_p` are of the measure, and `friedman_p_corrected` is corrected for all measures.
    """
    import pandas as pd

    some = []
    for one, contest in zip(found.measures, found.contests, strict=True):
        standing = found.standing(contest)
        ways = RANKED if found.against is None else AGAINST
        counts = {name: (standing == name).sum(axis=0) for name in ways}
        columns = {"measure": one.name, "contender": found.contenders, "average_rank": contest.average_ranks}
        statistic, p = contest.friedman
        overall = {"friedman": statistic, "friedman_p": p, "friedman_p_corrected": contest.friedman_corrected}
        some.append(pd.DataFrame(columns | counts | overall))
    return pd.concat(some, ignore_index=True)


def duels(found: Standings) -> Any:
    """See `Comparison.duels`.

    `ahead` is the share of worlds in which `one` is better, less that in which it is worse, on average over trials; the
    test is the signed-rank test over trials. Without numbers in several worlds that all have met there is no row.
    """
    import pandas as pd

    some = []
    names = np.array(found.contenders, object)
    for one, contest in zip(found.measures, found.contests, strict=True):
        rows = np.flatnonzero(~np.isnan(contest.duels_corrected))
        ends = np.array(pairs_of(len(names)), np.intp).reshape(-1, 2)[rows]
        average = contest.average_ranks
        tests = contest.duels
        columns: dict[str, Any] = {"measure": one.name, "one": names[ends[:, 0]], "other": names[ends[:, 1]]}
        columns |= {"trials": (tests.below + tests.equal + tests.above)[rows], "ahead": contest.ahead[rows]}
        columns |= {"rank_difference": average[ends[:, 0]] - average[ends[:, 1]], "effect": tests.balance[rows]}
        columns |= {"p": tests.p[rows], "p_holm": contest.duels_corrected[rows]}
        some.append(pd.DataFrame(columns | {"told_apart": contest.duels_apart[rows]}))
    return pd.concat(some, ignore_index=True)


def write_csv(found: Standings, path: str | Path) -> int:
    """Write `pairs` as CSV, whole or not at all, and return how many rows it has. Raises InputError."""
    frame = pairs(found)
    with whole(path) as beside:
        frame.to_csv(beside, index=False, lineterminator="\n")
    return len(frame)


def _coordinates(found: Standings, worlds: Any) -> dict[str, Any]:
    names = dict.fromkeys(name for world in found.field.worlds for name in world)
    return {name: [found.field.worlds[world].get(name) for world in worlds.tolist()] for name in names}
