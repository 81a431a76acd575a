"""A comparison in sentences: who is best in how many worlds, who is not told apart from it, and what it costs."""

import numpy as np
from numpy.typing import NDArray

from swarmcensus.basics.formatting import counted
from swarmcensus.comparing.cells import amount, equals
from swarmcensus.comparing.pair_tests import Contest, pairs_of
from swarmcensus.comparing.standings import Standings
from swarmcensus.statistics.rankings import groups
from swarmcensus.vocabulary.quantities import QUANTITIES

MOST_NAMED = 6  # contenders in a sentence


def verdict(found: Standings) -> list[str]:
    """One sentence a measure about the worlds, one about all of them together, and one about costs."""
    sentences = []
    for one, contest in zip(found.measures, found.contests, strict=True):
        sentences.append(f"{one.label}: {_by_world(found, contest)}")
        if contest.met.sum() > 1 and not np.isnan(contest.duels_corrected).all():
            sentences.append(f"{one.label}, over all worlds: {_overall(found, contest)}")
    return sentences + costs(found)


def costs(found: Standings) -> list[str]:
    """What each contender sends and remembers, a sentence for all; nothing where results do not say it."""
    if not found.costs and "memory_bytes" not in found.sizes:
        return []
    said = []
    for k, name in enumerate(found.contenders[:MOST_NAMED]):
        sent = [f"sends {_span(v[:, k])} {QUANTITIES[n].unit}" for n, v in found.costs.items()][-1:]  # bytes, if known
        held = [f"remembers {_span(v[:, k])} bytes" for n, v in found.sizes.items() if n == "memory_bytes"]
        said.append(f"{name} {' and '.join(sent + held)}")
    more = f"; and {len(found.contenders) - MOST_NAMED} more" if len(found.contenders) > MOST_NAMED else ""
    return [f"cost of a robot in a trial: {'; '.join(said)}{more}"]


def _by_world(found: Standings, contest: Contest) -> str:
    """Such as "of 6 worlds, a is best in 3 and level at the top in 2; b is behind in all"."""
    standing = found.standing(contest)
    if found.against is not None:
        return _against(found, standing)
    worlds = int((standing != "").any(axis=1).sum())
    if not worlds:
        return "no two contenders have numbers of it in the same world"
    counts = {name: (standing == name).sum(axis=0).tolist() for name in ("best", "level")}
    if not (standing == "behind").any():
        return "nobody is told apart from whoever is first" + " in any world" * (worlds > 1)
    there = (standing != "").any(axis=0)
    order = [k for k in np.lexsort((-np.array(counts["level"]), -np.array(counts["best"]))).tolist() if there[k]]
    parts = []
    for k in order[:MOST_NAMED]:
        best, level = counts["best"][k], counts["level"][k]
        if worlds == 1:
            how = "best" if best else "level at the top" if level else "behind"
        elif best or level:
            said = [f"best in {best}"] * (best > 0) + [f"level at the top in {level}"] * (level > 0)
            how = " and ".join(said)
        else:
            how = "behind in all"
        parts.append(f"{found.contenders[k]} is {how}")
    more = f"; and {len(order) - MOST_NAMED} more" if len(order) > MOST_NAMED else ""
    return f"of {counted(worlds, 'world')}, " * (worlds > 1) + "; ".join(parts) + more


def _overall(found: Standings, contest: Contest) -> str:
    """Average ranks, best first, and who is not told apart."""
    if found.against is not None:
        return _against_overall(found, contest)
    average, apart = contest.average_ranks, found.apart_overall(contest)
    order = np.argsort(average, kind="stable").tolist()
    ranked = ", ".join(f"{found.contenders[k]} {average[k]:.2f}" for k in order[:MOST_NAMED])
    more = ", ..." if len(order) > MOST_NAMED else ""
    level = groups(order, apart)
    test = f"Friedman's test: p {equals(contest.friedman_corrected)}"
    if not level:
        told = f"all are told apart ({test})"
    elif len(level[0]) == len(order) and contest.differ:
        told = (
            f"they differ ({test}), but with {counted(len(contest.ranks), 'trial')} no two can be told apart, "
            f"corrected for {counted(tests_of(found), 'test')}"
        )
    elif len(level[0]) == len(order):
        told = f"none is told apart from another ({test})"
    else:
        several = (" and ".join(found.contenders[k] for k in one[:MOST_NAMED]) for one in level)
        told = f"not told apart: {'; '.join(several)} ({test})"
    if not np.isnan(contest.friedman_corrected) and not contest.differ and apart.any():
        told += ", though by this test they need not differ"
    return f"average ranks {ranked}{more}; {told}"


def tests_of(found: Standings) -> int:
    """How many tests of pairs there are, for all of which each is corrected."""
    return sum(int((~np.isnan(part)).sum()) for c in found.contests for part in (c.corrected, c.duels_corrected))


def _against(found: Standings, standing: NDArray[np.str_]) -> str:
    """Such as "of 5 worlds, against a: b is better in 3 and not told apart in 2; c is worse in all 5"."""
    assert found.against is not None
    mark, parts = found.contenders[found.against], []
    for k, name in enumerate(found.contenders):
        met = int((standing[:, k] != "").sum())
        said = [
            f"{how} in {f'all {met:,}' if count == met > 1 else f'{count:,}'}"
            for what, how in (("better", "better"), ("worse", "worse"), ("level", "not told apart"))
            if (count := int((standing[:, k] == what).sum()))
        ]
        if len(standing) == 1:
            said = [one.removesuffix(" in 1") for one in said]
        if said:
            parts.append(f"{name} is {' and '.join([', '.join(said[:-1]), said[-1]] if said[1:] else said)}")
    if not parts:
        return f"nobody else has numbers of it where {mark} has"
    alone = [name for k, name in enumerate(found.contenders) if name != mark and not (standing[:, k] != "").any()]
    parts += [f"{', '.join(alone)} {'is' if len(alone) == 1 else 'are'} in no world with it"] * bool(alone)
    worlds = f"of {counted(len(standing), 'world')}, " * (len(standing) > 1)
    return f"{worlds}against {mark}: {'; '.join(parts)}"


def _against_overall(found: Standings, contest: Contest) -> str:
    parts = []
    for k, (one, other) in enumerate(pairs_of(len(found.contenders))):
        if np.isnan(contest.duels_corrected[k]):
            continue
        better, worse = contest.shares(k)
        who, ahead = one, contest.ahead[k]
        if one == found.against:
            who, ahead, better, worse = other, -ahead, worse, better
        how = "not told apart" if not contest.duels_apart[k] else "better" if ahead > 0 else "worse"
        p = equals(contest.duels_corrected[k])
        parts.append(f"{found.contenders[who]} is {how} ({often(better, worse)}, p {p})")
    return "; ".join(parts)


def often(better: float, worse: float) -> str:
    """In what shares of trials one is better and worse; in the others they are equal."""
    return f"better in {better:.0%}, worse in {worse:.0%} of trials"


def _span(values: NDArray[np.float64]) -> str:
    """What a contender has in all worlds: one number, or the least and the most."""
    known = values[np.isfinite(values)]
    if not known.size:
        return "an unknown number of"
    low, high = amount(known.min()), amount(known.max())
    return low if low == high else f"{low} to {high}"
