"""A comparison in sentences: who is best in how many worlds, and who does not differ from the best."""

from collections.abc import Sequence

import numpy as np

from swarmcensus.analysis.comparing.cells import margin_text, p_equals
from swarmcensus.analysis.comparing.pair_tests import ALPHA, Contest, pairs_of
from swarmcensus.analysis.comparing.standings import Standings
from swarmcensus.support.formatting import counted
from swarmcensus.support.significance import groups

MOST_NAMED = 6  # contenders in one sentence
WORDS = {"level": "level at the top"}  # of standings; others are their own
LEVEL = "not told apart"


def verdict(standings: Standings) -> list[str]:
    """For each measure one sentence about single worlds, and one about all of them."""
    sentences = []
    for measure, contest in zip(standings.measures, standings.contests, strict=True):
        sentences.append(f"{measure.label}: {_by_world(standings, contest)}")
        if margin := standings.margins.get(measure.name):
            sentences.append(f"{measure.label}: {_in_practice(standings, contest, margin_text(margin, measure))}")
        if contest.met.sum() > 1 and not np.isnan(contest.duels_corrected).all():
            over_all = _overall if standings.against is None else _against_overall
            sentences.append(f"{measure.label}, over all worlds together: {over_all(standings, contest)}")
    return sentences


def _some(parts: Sequence[str], noun: str = "") -> str:
    more = len(parts) - MOST_NAMED
    return "; ".join(parts[:MOST_NAMED]) + f"; and {more} more{noun}" * (more > 0)


def _by_world(standings: Standings, contest: Contest) -> str:
    """Such as "of 6 worlds, a is best in 3, level at the top in 2; b is behind in 5"."""
    standing, alone = standings.standing(contest), standings.against is None
    worlds = int((standing != "").any(axis=1).sum())
    if not worlds:
        return "no two contenders have numbers of it in the same world"
    if alone and not (standing == "behind").any():
        return "no contender is told apart from the first" + " in any world" * (worlds > 1)
    counts = {way: (standing == way).sum(axis=0) for way in standings.ways}
    words = WORDS if alone else {"level": LEVEL}
    parts = []
    for k in np.lexsort((contest.average_ranks, *(-count for count in reversed(counts.values())))).tolist():
        there = {words.get(way, way): f" in {count[k]}" * (worlds > 1) for way, count in counts.items() if count[k]}
        if there:
            parts.append(f"{standings.contenders[k]} is {', '.join(map(''.join, there.items()))}")
    against = "" if standings.against is None else f"against {standings.contenders[standings.against]}: "
    return f"of {counted(worlds, 'world')}, " * (worlds > 1) + against + _some(parts)


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
    average = contest.average_ranks
    order = np.argsort(average, kind="stable").tolist()
    ranked = ", ".join(f"{standings.contenders[k]} {average[k]:.2f}" for k in order[:MOST_NAMED])
    more = ", ..." if len(order) > MOST_NAMED else ""
    level = groups(order, standings.apart_overall(contest))
    several = (" and ".join(standings.contenders[k] for k in group[:MOST_NAMED]) for group in level)
    outcome = f"{LEVEL}: {'; '.join(several)}" if level else "all are told apart"
    return f"average ranks {ranked}{more}; {outcome} (Friedman's test: p {p_equals(contest.friedman_corrected)})"


def _against_overall(standings: Standings, contest: Contest) -> str:
    parts = []
    for k in np.flatnonzero(~np.isnan(contest.duels_corrected)).tolist():
        (first, second), ahead = pairs_of(len(standings.contenders))[k], contest.ahead[k]
        contender, (better, worse) = first, contest.shares(k)
        if first == standings.against:
            contender, ahead, better, worse = second, -ahead, worse, better
        how = LEVEL if not contest.duels_apart[k] else "better" if ahead > 0 else "worse"
        p = p_equals(contest.duels_corrected[k])
        parts.append(f"{standings.contenders[contender]} is {how} ({win_shares(better, worse)}, p {p})")
    return "; ".join(parts)


def win_shares(better: float, worse: float) -> str:
    """The shares of trials in which one is better and worse; in the others both are equal."""
    return f"better in {better:.0%}, worse in {worse:.0%} of trials"
