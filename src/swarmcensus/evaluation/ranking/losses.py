"""Where a brain loses: how far it is behind in which kinds of worlds, and to whom."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from swarmcensus.analysis import ALPHA, ContestInput, contests
from swarmcensus.evaluation.ranking.scores import Floats, Score, Scores, World
from swarmcensus.support.significance import holm

FEW = 5  # number of worlds and rivals in the lists


@dataclass(frozen=True)
class Behind:
    """One kind of world: the brain's value, its place among `of`, and name and value of the best other brain."""

    column: str
    value: float
    place: int
    of: int
    best: str
    best_value: float


@dataclass(frozen=True)
class Rival:
    """A brain that is better over all worlds: the shares of trials in which it is better and worse, corrected p."""

    name: str
    better: float
    worse: float
    p: float


@dataclass(frozen=True)
class Losses:
    """The losses of one brain on one board: by kind of world, the worst first; by single worlds; by rivals."""

    name: str
    board: str
    low: bool  # whether its values are errors, not shares
    place: int
    of: int
    columns: list[Behind]
    worlds: list[tuple[str, Behind]]
    rivals: list[Rival]  # the clearest first


def losses_of(name: str, board: str, scores: Scores) -> Losses:
    """Where this contender loses on a board, by errors, or by right decisions if its estimate is an opinion."""
    own, names = scores.contenders.index(name), scores.contenders
    others = [k for k in range(len(names)) if k != own and names[k] not in scores.bounds]
    score = scores.side if np.isnan(scores.error.ranks[own]) else scores.error
    low = score.low
    columns = [
        behind
        for k, column in enumerate(scores.division.columns)
        if (behind := _behind(column.name, score.values[:, k], own, others, names, low))
    ]
    worlds = [
        (world_label(world), behind)
        for k, world in enumerate(scores.worlds)
        if (behind := _behind("", score.by_world[k], own, others, names, low))
    ]
    gap = _gap(low)
    worlds.sort(key=lambda pair: -gap(pair[1]))
    order = [k for k in score.order if k == own or k in others]
    return Losses(
        name, board, low, order.index(own) + 1, len(order),
        sorted(columns, key=lambda behind: -gap(behind)), worlds[:FEW],
        _rivals(own, others, score, names),
    )  # fmt: skip


def _gap(low: bool) -> Any:
    """How far a value is behind the best other one, as a function of a `Behind`."""
    return lambda behind: (behind.value - behind.best_value) * (1 if low else -1)


def _behind(column: str, values: Floats, own: int, others: list[int], names: list[str], low: bool) -> Behind | None:
    keys = values if low else -values
    known = [k for k in others if not np.isnan(keys[k])]
    if np.isnan(keys[own]) or not known:
        return None
    best = min(known, key=lambda k: float(keys[k]))
    place = 1 + sum(bool(keys[k] < keys[own]) for k in known)
    return Behind(column, float(values[own]), place, len(known) + 1, names[best], float(values[best]))


def _rivals(own: int, others: list[int], score: Score, names: list[str]) -> list[Rival]:
    """Contenders that are ahead of it over all worlds, trial by trial; p-values are corrected by Holm's method."""
    known = [own, *(k for k in others if not np.isnan(score.ranks[k]))]
    contest_input = ContestInput(score.numbers[:, known], "median" if score.low else "mean", score.low, not score.low)
    (contest,) = contests([contest_input], with_intervals=False, against=0)
    pairs = range(len(known) - 1)  # the first duels are those of this contender
    corrected = holm(contest.duels.p[: len(known) - 1])
    rivals = [
        Rival(names[known[k + 1]], *contest.shares(k)[::-1], float(corrected[k]))
        for k in pairs
        if contest.ahead[k] < 0 and corrected[k] <= ALPHA
    ]
    return sorted(rivals, key=lambda rival: rival.worse - rival.better)


def world_label(world: World) -> str:
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
