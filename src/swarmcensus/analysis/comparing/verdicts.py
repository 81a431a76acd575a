"""A comparison in sentences: who is best in how many worlds, who does not differ from the best, and the costs."""

import numpy as np
from numpy.typing import NDArray

from swarmcensus.analysis.comparing.cells import margin_text, p_equals, range_text
from swarmcensus.analysis.comparing.pair_tests import Contest, overall_count, pairs_of
from swarmcensus.analysis.comparing.standings import Standings
from swarmcensus.support.formatting import counted
from swarmcensus.support.quantities import QUANTITIES
from swarmcensus.support.significance import groups

MOST_NAMED = 6  # contenders in one sentence
UNKNOWN = "an unknown number of"


def verdict(standings: Standings) -> list[str]:
    """For each measure one sentence about single worlds and one about all of them; then one about costs."""
    return findings(standings) + costs(standings)


def findings(standings: Standings) -> list[str]:
    """The verdict without costs."""
    sentences = []
    for measure, contest in zip(standings.measures, standings.contests, strict=True):
        sentences.append(f"{measure.label}: {_by_world(standings, contest)}")
        if margin := standings.margins.get(measure.name):
            text = margin_text(margin, measure)
            sentences.append(f"{measure.label}: {_in_practice(standings, contest, margin, text)}")
        if contest.met.sum() > 1 and not np.isnan(contest.duels_corrected).all():
            sentences.append(f"{measure.label}, over all worlds: {_overall(standings, contest)}")
    return sentences


def costs(standings: Standings) -> list[str]:
    """One sentence on what each contender sends and remembers; empty if the results do not contain it."""
    if not standings.costs and "memory_bytes" not in standings.sizes:
        return []
    phrases = []
    for k, name in enumerate(standings.contenders[:MOST_NAMED]):
        sent = [f"sends {range_text(v[:, k]) or UNKNOWN} {QUANTITIES[n].unit}" for n, v in standings.costs.items()]
        held = [
            f"remembers {range_text(v[:, k]) or UNKNOWN} bytes"
            for n, v in standings.sizes.items()
            if n == "memory_bytes"
        ]
        phrases.append(f"{name} {' and '.join(sent[-1:] + held)}")  # bytes sent if known, else messages
    more = f"; and {len(standings.contenders) - MOST_NAMED} more" if len(standings.contenders) > MOST_NAMED else ""
    return [f"cost of a robot in a trial: {'; '.join(phrases)}{more}"]


def reading(standings: Standings) -> str:
    """Why contenders may differ over all worlds and in few single ones, if some do; otherwise empty."""
    for contest in standings.contests:
        tested = (~np.isnan(contest.corrected)).sum(axis=0)
        if (contest.duels_apart & (2 * contest.apart.sum(axis=0) < tested)).any():
            return (
                "over all worlds: the trials of all worlds are tested together, by which of the contenders is ahead in "
                "each, so that a difference shows that is too small for the trials of a single world"
            )
    return ""


def _by_world(standings: Standings, contest: Contest) -> str:
    """Such as "of 6 worlds, a is best in 3 and level at the top in 2; b is behind in all"."""
    standing = standings.standing(contest)
    if standings.against is not None:
        return _against(standings, standing)
    worlds = int((standing != "").any(axis=1).sum())
    if not worlds:
        return "no two contenders have numbers of it in the same world"
    counts = {name: (standing == name).sum(axis=0).tolist() for name in ("best", "level")}
    if not (standing == "behind").any():
        return "no contender is told apart from the first" + " in any world" * (worlds > 1)
    there = (standing != "").any(axis=0)
    by = contest.average_ranks, -np.array(counts["level"]), -np.array(counts["best"])  # the last first
    order = [k for k in np.lexsort(by).tolist() if there[k]]
    parts = []
    for k in order[:MOST_NAMED]:
        best, level = counts["best"][k], counts["level"][k]
        if worlds == 1:
            how = "best" if best else "level at the top" if level else "behind"
        elif best or level:
            phrases = [f"best in {best}"] * (best > 0) + [f"level at the top in {level}"] * (level > 0)
            how = " and ".join(phrases)
        else:
            how = "behind in all"
        parts.append(f"{standings.contenders[k]} is {how}")
    more = f"; and {len(order) - MOST_NAMED} more" if len(order) > MOST_NAMED else ""
    return f"of {counted(worlds, 'world')}, " * (worlds > 1) + "; ".join(parts) + more


def _in_practice(standings: Standings, contest: Contest, margin: float, text: str) -> str:
    """Such as "equal for practical purposes, within 0.01: a and b in 2 of 3 worlds"."""
    tested, equal = ~np.isnan(contest.corrected), contest.within(margin)
    parts = []
    for k, (first, second) in enumerate(pairs_of(len(standings.contenders))):
        worlds, count = int(tested[:, k].sum()), int(equal[:, k].sum())
        if count:
            where = f" in {count} of {counted(worlds, 'world')}" if len(contest.values) > 1 else ""
            parts.append(f"{standings.contenders[first]} and {standings.contenders[second]}{where}")
    if not parts:
        return f"no two are shown to be equal for practical purposes, within {text}"
    more = f"; and {len(parts) - MOST_NAMED} more pairs" if len(parts) > MOST_NAMED else ""
    return f"equal for practical purposes, within {text}: {'; '.join(parts[:MOST_NAMED])}{more}"


def _overall(standings: Standings, contest: Contest) -> str:
    """Average ranks, best first, and the groups of contenders that do not differ."""
    if standings.against is not None:
        return _against_overall(standings, contest)
    average, apart = contest.average_ranks, standings.apart_overall(contest)
    order = np.argsort(average, kind="stable").tolist()
    ranked = ", ".join(f"{standings.contenders[k]} {average[k]:.2f}" for k in order[:MOST_NAMED])
    more = ", ..." if len(order) > MOST_NAMED else ""
    level = groups(order, apart)
    test = f"Friedman's test: p {p_equals(contest.friedman_corrected)}"
    if not level:
        outcome = f"{'all' if len(order) > 2 else 'both'} are told apart ({test})"
    elif len(level[0]) == len(order) and contest.differ:
        outcome = (
            f"they differ ({test}), but with {counted(len(contest.ranks), 'trial')} no two can be told apart, "
            f"corrected for {counted(overall_count(standings.contests), 'test')}"
        )
    elif len(level[0]) == len(order):
        outcome = f"none is told apart from another ({test})"
    else:
        several = (" and ".join(standings.contenders[k] for k in group[:MOST_NAMED]) for group in level)
        outcome = f"not told apart: {'; '.join(several)} ({test})"
    if not np.isnan(contest.friedman_corrected) and not contest.differ and apart.any():
        outcome += ", though by this test they need not differ"
    return f"average ranks {ranked}{more}; {outcome}"


def _against(standings: Standings, standing: NDArray[np.str_]) -> str:
    """Such as "of 5 worlds, against a: b is better in 3 and not told apart in 2; c is worse in all 5"."""
    assert standings.against is not None
    reference, parts = standings.contenders[standings.against], []
    for k, name in enumerate(standings.contenders):
        met = int((standing[:, k] != "").sum())
        phrases = [
            f"{how} in {f'{whole} {met:,}' if count == met > 1 else f'{count:,}'}"
            for what, how, whole in (
                ("better", "better", "all"),
                ("worse", "worse", "all"),
                ("level", "not told apart", "any of"),
            )
            if (count := int((standing[:, k] == what).sum()))
        ]
        if len(standing) == 1:
            phrases = [phrase.removesuffix(" in 1") for phrase in phrases]
        if phrases:
            parts.append(
                f"{name} is {' and '.join([', '.join(phrases[:-1]), phrases[-1]] if phrases[1:] else phrases)}"
            )
    if not parts:
        return f"no other contender has numbers of it in the worlds of {reference}"
    alone = [
        name for k, name in enumerate(standings.contenders) if name != reference and not (standing[:, k] != "").any()
    ]
    parts += [f"{', '.join(alone)} {'is' if len(alone) == 1 else 'are'} in no world with it"] * bool(alone)
    worlds = f"of {counted(len(standing), 'world')}, " * (len(standing) > 1)
    return f"{worlds}against {reference}: {'; '.join(parts)}"


def _against_overall(standings: Standings, contest: Contest) -> str:
    parts = []
    for k, (first, second) in enumerate(pairs_of(len(standings.contenders))):
        if np.isnan(contest.duels_corrected[k]):
            continue
        better, worse = contest.shares(k)
        contender, ahead = first, contest.ahead[k]
        if first == standings.against:
            contender, ahead, better, worse = second, -ahead, worse, better
        how = "not told apart" if not contest.duels_apart[k] else "better" if ahead > 0 else "worse"
        p = p_equals(contest.duels_corrected[k])
        parts.append(f"{standings.contenders[contender]} is {how} ({win_shares(better, worse)}, p {p})")
    return "; ".join(parts)


def win_shares(better: float, worse: float) -> str:
    """The shares of trials in which one is better and worse; in the others both are equal."""
    return f"better in {better:.0%}, worse in {worse:.0%} of trials"
