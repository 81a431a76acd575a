"""A comparison in sentences: who is best in how many worlds, and who does not differ from the best."""

from collections.abc import Sequence

import numpy as np

from swarmcensus.analysis.comparing.cells import margin_text, p_equals
from swarmcensus.analysis.comparing.pair_tests import ALPHA, Contest, number_of_tests, pairs_of
from swarmcensus.analysis.comparing.standings import Standings
from swarmcensus.support.formatting import counted
from swarmcensus.support.significance import groups

MOST_NAMED = 6  # contenders in one sentence
TOGETHER = (
    "over all worlds: the trials of all worlds are tested together, by which of the contenders is ahead in each, so "
    "that a difference shows that is too small for the trials of a single world"
)
HOW = {"better": ("better", "all"), "worse": ("worse", "all"), "level": ("not told apart", "any of")}


def verdict(standings: Standings) -> list[str]:
    """For each measure one sentence about single worlds and one about all of them; then why these may differ."""
    sentences, differ = [], False
    for measure, contest in zip(standings.measures, standings.contests, strict=True):
        tested = ~np.isnan(contest.corrected)
        in_worlds = _by_world if standings.against is None else _against
        sentences.append(f"{measure.label}: {in_worlds(standings, contest)}")
        if margin := standings.margins.get(measure.name):
            sentences.append(f"{measure.label}: {_in_practice(standings, contest, margin_text(margin, measure))}")
        if contest.met.sum() > 1 and not np.isnan(contest.duels_corrected).all():
            over_all = _overall if standings.against is None else _against_overall
            sentences.append(f"{measure.label}, over all worlds: {over_all(standings, contest)}")
        differ |= bool((contest.duels_apart & (2 * contest.apart.sum(axis=0) < tested.sum(axis=0))).any())
    return sentences + [TOGETHER] * differ


def _some(parts: Sequence[str], noun: str = "") -> str:
    more = len(parts) - MOST_NAMED
    return "; ".join(parts[:MOST_NAMED]) + f"; and {more} more{noun}" * (more > 0)


def _by_world(standings: Standings, contest: Contest) -> str:
    """Such as "of 6 worlds, a is best in 3 and level at the top in 2; b is behind in all"."""
    standing = standings.standing(contest)
    worlds = int((standing != "").any(axis=1).sum())
    if not worlds:
        return "no two contenders have numbers of it in the same world"
    if not (standing == "behind").any():
        return "no contender is told apart from the first" + " in any world" * (worlds > 1)
    best, level = ((standing == way).sum(axis=0) for way in ("best", "level"))
    parts = []
    for k in np.lexsort((contest.average_ranks, -level, -best)).tolist():  # the last first
        ways = [f"{how} in {count[k]}" for how, count in (("best", best), ("level at the top", level)) if count[k]]
        how = " and ".join(ways) or "behind in all"
        if (standing[:, k] != "").any():
            parts.append(f"{standings.contenders[k]} is {how if worlds > 1 else how.rpartition(' in ')[0]}")
    return f"of {counted(worlds, 'world')}, " * (worlds > 1) + _some(parts)


def _in_practice(standings: Standings, contest: Contest, text: str) -> str:
    """Such as "equal for practical purposes, within 0.01: a and b in 2 of 3 worlds"."""
    tested, equal = (~np.isnan(contest.corrected)).sum(axis=0), (contest.equality <= ALPHA).sum(axis=0)
    parts = []
    for (first, second), worlds, count in zip(pairs_of(len(standings.contenders)), tested, equal, strict=True):
        where = f" in {count} of {counted(int(worlds), 'world')}" * (len(contest.values) > 1)
        parts += [f"{standings.contenders[first]} and {standings.contenders[second]}{where}"] * bool(count)
    if not parts:
        return f"no two are shown to be equal for practical purposes, within {text}"
    return f"equal for practical purposes, within {text}: {_some(parts, ' pairs')}"


def _overall(standings: Standings, contest: Contest) -> str:
    """Average ranks, best first, and the groups of contenders that do not differ."""
    average, apart = contest.average_ranks, standings.apart_overall(contest)
    order = np.argsort(average, kind="stable").tolist()
    ranked = ", ".join(f"{standings.contenders[k]} {average[k]:.2f}" for k in order[:MOST_NAMED])
    more = ", ..." if len(order) > MOST_NAMED else ""
    level = groups(order, apart)
    test = f"(Friedman's test: p {p_equals(contest.friedman_corrected)})"
    if not level:
        outcome = f"{'all' if len(order) > 2 else 'both'} are told apart {test}"
    elif len(level[0]) == len(order) and contest.differ:
        trials, tests = len(contest.ranks), number_of_tests(standings.contests, over_all=True)
        outcome = f"they differ {test}, but with {counted(trials, 'trial')} no two can be told apart, "
        outcome += f"corrected for {counted(tests, 'test')}"
    elif len(level[0]) == len(order):
        outcome = f"none is told apart from another {test}"
    else:
        several = (" and ".join(standings.contenders[k] for k in group[:MOST_NAMED]) for group in level)
        outcome = f"not told apart: {'; '.join(several)} {test}"
    if not np.isnan(contest.friedman_corrected) and not contest.differ and apart.any():
        outcome += ", though by this test they need not differ"
    return f"average ranks {ranked}{more}; {outcome}"


def _against(standings: Standings, contest: Contest) -> str:
    """Such as "of 5 worlds, against a: b is better in 3 and not told apart in 2; c is worse in all 5"."""
    standing, parts, alone = standings.standing(contest), [], []
    for k, name in enumerate(standings.contenders):
        met, phrases = int((standing[:, k] != "").sum()), []
        for way, (how, whole) in HOW.items():
            count = int((standing[:, k] == way).sum())
            where = f" in {whole} {met:,}" if count == met > 1 else f" in {count:,}" * (len(standing) > 1)
            phrases += [how + where] * bool(count)
        *most, last = phrases or [""]
        parts += [f"{name} is {' and '.join([', '.join(most), last] if most else [last])}"] * bool(last)
        alone += [name] * (not last and k != standings.against)
    reference = standings.contenders[standings.against or 0]
    if not parts:
        return f"no other contender has numbers of it in the worlds of {reference}"
    parts += [f"{', '.join(alone)} {'is' if len(alone) == 1 else 'are'} in no world with it"] * bool(alone)
    return f"of {counted(len(standing), 'world')}, " * (len(standing) > 1) + f"against {reference}: {'; '.join(parts)}"


def _against_overall(standings: Standings, contest: Contest) -> str:
    parts = []
    for k in np.flatnonzero(~np.isnan(contest.duels_corrected)).tolist():
        (first, second), ahead = pairs_of(len(standings.contenders))[k], contest.ahead[k]
        contender, (better, worse) = first, contest.shares(k)
        if first == standings.against:
            contender, ahead, better, worse = second, -ahead, worse, better
        how = "not told apart" if not contest.duels_apart[k] else "better" if ahead > 0 else "worse"
        p = p_equals(contest.duels_corrected[k])
        parts.append(f"{standings.contenders[contender]} is {how} ({win_shares(better, worse)}, p {p})")
    return "; ".join(parts)


def win_shares(better: float, worse: float) -> str:
    """The shares of trials in which one is better and worse; in the others both are equal."""
    return f"better in {better:.0%}, worse in {worse:.0%} of trials"
