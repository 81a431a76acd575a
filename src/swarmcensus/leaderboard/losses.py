"""Where a brain loses: in which kinds of worlds it is how far behind, and against whom."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from swarmcensus.comparing.pair_tests import ALPHA, Asked, contests
from swarmcensus.leaderboard.scores import COLUMNS, Floats, Score, Scores, World
from swarmcensus.statistics.corrections import holm

FEW = 5  # worlds and rivals that are named


@dataclass(frozen=True)
class Behind:
    """One kind of world: the brain's value, its place among how many, and the best other one's name and value."""

    column: str
    value: float
    place: int
    of: int
    best: str
    best_value: float


@dataclass(frozen=True)
class Rival:
    """One that is better over all worlds: in what shares of trials it is better, and worse; the corrected p-value."""

    name: str
    better: float
    worse: float
    p: float


@dataclass(frozen=True)
class Losses:
    """What there is to say of one brain: by kinds of worlds, the worst of them first; by single worlds; by rivals."""

    name: str
    low: bool  # whether its values are errors, not shares
    place: int
    of: int
    columns: list[Behind]
    worlds: list[tuple[str, Behind]]
    rivals: list[Rival]  # the clearest first


def losses_of(name: str, scores: Scores) -> Losses:
    """Where the contender of this name loses, by errors, or by sides where its estimate is an opinion."""
    mine, names = scores.contenders.index(name), scores.contenders
    others = [k for k in range(len(names)) if k != mine and names[k] not in scores.bounds]
    score = scores.side if np.isnan(scores.error.ranks[mine]) else scores.error
    low = score.low
    columns = [
        behind
        for k, column in enumerate(COLUMNS)
        if (behind := _behind(column.name, score.values[:, k], mine, others, names, low))
    ]
    worlds = [
        (told(world), behind)
        for k, world in enumerate(scores.worlds)
        if (behind := _behind("", score.by_world[k], mine, others, names, low))
    ]
    gap = _gap(low)
    worlds.sort(key=lambda one: -gap(one[1]))
    order = [k for k in score.order if k == mine or k in others]
    return Losses(
        name, low, order.index(mine) + 1, len(order), sorted(columns, key=lambda one: -gap(one)), worlds[:FEW],
        _rivals(mine, others, score, names),
    )  # fmt: skip


def _gap(low: bool) -> Any:
    return lambda one: (one.value - one.best_value) * (1 if low else -1)


def _behind(column: str, values: Floats, mine: int, others: list[int], names: list[str], low: bool) -> Behind | None:
    keys = values if low else -values
    known = [k for k in others if not np.isnan(keys[k])]
    if np.isnan(keys[mine]) or not known:
        return None
    best = min(known, key=lambda k: float(keys[k]))
    place = 1 + sum(bool(keys[k] < keys[mine]) for k in known)
    return Behind(column, float(values[mine]), place, len(known) + 1, names[best], float(values[best]))


def _rivals(mine: int, others: list[int], score: Score, names: list[str]) -> list[Rival]:
    """Those that are ahead of it over all worlds, trial by trial; corrected for being many by Holm's method."""
    known = [mine, *(k for k in others if not np.isnan(score.ranks[k]))]
    asked = Asked(score.numbers[:, known], "median" if score.low else "mean", score.low, not score.low)
    (contest,) = contests([asked], with_intervals=False, against=0)
    pairs = range(len(known) - 1)  # its own are the first ones
    corrected = holm(contest.duels.p[: len(known) - 1])
    rivals = [
        Rival(names[known[k + 1]], *contest.shares(k)[::-1], float(corrected[k]))
        for k in pairs
        if contest.ahead[k] < 0 and corrected[k] <= ALPHA
    ]
    return sorted(rivals, key=lambda one: one.worse - one.better)


def told(world: World) -> str:
    """A world in a few words."""
    change = world.get("fill_ratio_change", "")
    liars, late, lost = world.get("liars", 0), world.get("message_delay", 0), float(world["link_success"]) < 1.0
    words = [
        str(world["topology"]),
        f"accuracy {world['accuracy']}",
        f"f = {change or world['fill_ratio']}",
        f"floor {world['floor']}" if world["floor"] not in ("", "tiles") else "",
        f"{1 - world['link_success']:.0%} of messages lost" if lost else "",
        f"messages {late:.0f} round{'s' * (late > 1)} late" if late else "",
        f"{liars:.0f} liars" if liars else "",
    ]
    return ", ".join(filter(None, words))
