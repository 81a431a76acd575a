"""Scores of brains in one group of worlds: by errors, and by right decisions on black or white; and where one loses."""

from collections.abc import Collection, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from swarmcensus.analysis import ALPHA, NONE, ContestInput, contests, grid_of
from swarmcensus.results import groups_in, measures, where
from swarmcensus.studies import NUMERIC
from swarmcensus.support.bootstrap import Statistic, centres

Floats = NDArray[np.float64]
ERROR, SIDE, TAIL, SENT = "final_error", "right_side", "error_90", "messages_sent"
FEW = 5  # worlds and rivals in the lists


@dataclass(frozen=True)
class Score:
    """One measure of all contenders; `low` says that low numbers are good.

    `by_world` (world, contender) has medians over trials, or means of shares, `parts` (part, contender) their means
    over the worlds of a part, `ranks` (contender,) averages over all worlds and trials, 1 is best; `numbers` is (world,
    contender, trial).
    """

    low: bool
    numbers: Floats
    by_world: Floats
    parts: Floats
    ranks: Floats

    @property
    def order(self) -> list[int]:
        """Contenders, the best first; those without a rank are left out."""
        known = np.flatnonzero(~np.isnan(self.ranks))
        return [int(k) for k in known[np.argsort(self.ranks[known], kind="stable")]]


@dataclass(frozen=True)
class Ranking:
    """All contenders in one group of worlds, of which others are `parts`."""

    group: str
    is_part: bool  # of another one
    parts: list[str]
    contenders: list[str]
    worlds: list[str]  # in a few words
    rounds: float
    error: Score
    right: Score
    tail: Floats  # (contender,): the error that 90 % of a trial's robots do not exceed, the mean over worlds of medians
    costs: dict[str, Floats]  # (contender,), means over the worlds of all groups
    bounds: Collection[str]  # contenders that no robot can run

    @property
    def placed(self) -> dict[int, int | None]:
        """Contenders, the best first, with their places: None for bounds, and without an error, which come last."""
        order = self.error.order
        ranked = [k for k in order if self.contenders[k] not in self.bounds]
        places = {k: place for place, k in enumerate(ranked, 1)}
        return {k: places.get(k) for k in dict.fromkeys([*order, *self.right.order])}

    @property
    def rows(self) -> list[dict[str, Any]]:
        """A row for each contender, best first, with its values in all these worlds and in each part of them."""
        found = []
        for k, place in self.placed.items():
            row = {"place": place, "brain": self.contenders[k], "rank": self.error.ranks[k], TAIL: self.tail[k]}
            scores = {ERROR: self.error, SIDE: self.right}
            row |= {name: score.by_world[:, k].mean() for name, score in scores.items()}
            row |= {name: values[k] for name, values in self.costs.items()}
            parts = {f"{name}: {part}": score.parts[j, k] for name, score in scores.items()
                     for j, part in enumerate(self.parts)}  # fmt: skip
            found.append(row | parts)
        return found

    def losses(self, name: str) -> dict[str, Any]:
        """Where a contender loses, by errors, or by right decisions if its estimate is an opinion.

        `groups` are all parts, and `worlds` some worlds, the worst first: its value and place, and name and value of
        the best other. `rivals` are significantly better over all worlds, the clearest first.
        """
        own, names = self.contenders.index(name), self.contenders
        score = self.right if np.isnan(self.error.ranks[own]) else self.error
        others = [k for k in range(len(names)) if k != own and names[k] not in self.bounds]
        order = [k for k in score.order if k == own or k in others]

        def sorted_losses(key: str, labels: list[str], values: Floats) -> list[dict[str, Any]]:
            found = [{key: label, **_behind(one, own, others, names, score.low)}
                     for label, one in zip(labels, values, strict=True) if not np.isnan(one[own])]  # fmt: skip
            return sorted(found, key=lambda b: (b["best_value"] - b["value"]) * (1 if score.low else -1))

        return {
            "name": name, "board": self.group, "low": score.low, "place": order.index(own) + 1, "of": len(order),
            "groups": sorted_losses("group", self.parts, score.parts),
            "worlds": sorted_losses("world", self.worlds, score.by_world)[:FEW],
            "rivals": _rivals([own, *(k for k in others if k in order)], score, names),
        }  # fmt: skip


def rankings(
    data: xr.Dataset, opinions: Collection[str], oracles: Collection[str] = (), asked: str = ""
) -> dict[str, Ranking]:
    """The ranking of each group of worlds of a study that lies within no other one, and of the group `asked`.

    The estimates of brains in `opinions` have no error; those in `oracles` are bounds.
    """
    grid, _ = grid_of(data, data)
    firsts = [next(place for place in row if place != NONE) for row in grid.place]
    columns = {str(name): one.values[firsts].tolist() for name, one in data.coords.items()
               if one.dims == ("setting",) and name not in NUMERIC}  # fmt: skip
    labels = [world_label(dict(zip(columns, world, strict=True))) for world in zip(*columns.values(), strict=True)]
    masks = {name: np.isin(columns["setting"], where(data, name)["setting"].values) for name in groups_in(data)}
    brains = [str(data["brain"].values[column[column != NONE][0]]) for column in grid.place.T]
    numbers = {name: np.asarray(grid.spread(measures.numbers(data, name))) for name in (ERROR, SIDE, TAIL, SENT)}
    numbers[ERROR][:, [brain in opinions for brain in brains]] = np.nan
    numbers[TAIL][:, [brain in opinions for brain in brains]] = np.nan
    costs = {SENT: np.nanmean(numbers[SENT], axis=(0, 2))}
    costs |= {name: np.nanmean(grid.spread(data[name].values.astype(float)), axis=0) for name in measures.SIZES}
    bounds = {name for name, brain in zip(grid.contenders, brains, strict=True) if brain in oracles}
    found = {}
    for group, own in masks.items():
        is_part = any(own.sum() < mask.sum() and not (own & ~mask).any() for mask in masks.values())
        if is_part and group != asked:
            continue
        parts = {name: mask[own] for name, mask in masks.items() if mask.sum() < own.sum() and not (mask & ~own).any()}
        parts = parts or {group: own[own]}
        error, right = (_score(numbers[name][own], [*parts.values()], name == ERROR) for name in (ERROR, SIDE))
        found[group] = Ranking(
            group, is_part, [*parts], grid.contenders, [label for label, here in zip(labels, own, strict=True) if here],
            float(np.mean(data["rounds"].values[firsts][own])), error, right,
            centres(numbers[TAIL][own], "median").mean(axis=0), costs, bounds,
        )  # fmt: skip
    return found


def _score(numbers: Floats, parts: list[NDArray[np.bool_]], low: bool) -> Score:
    known: NDArray[np.bool_] = np.asarray(~np.isnan(numbers).all(axis=(0, 2)))
    statistic: Statistic = "median" if low else "mean"
    by_world = centres(numbers, statistic)
    (contest,) = contests([ContestInput(numbers[:, known], statistic, low, not low)], with_intervals=False)
    ranks = np.full(len(known), np.nan)
    ranks[known] = contest.average_ranks
    return Score(low, numbers, by_world, np.stack([by_world[part].mean(axis=0) for part in parts]), ranks)


def _behind(values: Floats, own: int, others: list[int], names: list[str], low: bool) -> dict[str, Any]:
    """A contender's value and place among those with a value, and name and value of the best other one."""
    keys = values if low else -values
    known = [k for k in others if not np.isnan(keys[k])]
    best = min(known, key=lambda k: float(keys[k]))
    place = 1 + sum(bool(keys[k] < keys[own]) for k in known)
    return {"value": float(values[own]), "place": place, "of": len(known) + 1,
            "best": names[best], "best_value": float(values[best])}  # fmt: skip


def _rivals(known: list[int], score: Score, names: list[str]) -> list[dict[str, Any]]:
    """Contenders that are ahead of the first of `known` over all worlds, trial by trial.

    They have the shares of trials in which they are better and worse, and p-values corrected by Holm's method.
    """
    contest_input = ContestInput(score.numbers[:, known], "median" if score.low else "mean", score.low, not score.low)
    (contest,) = contests([contest_input], with_intervals=False, against=0)
    rivals = [
        {"name": names[known[k + 1]], "better": worse, "worse": better, "p": float(contest.duels_corrected[k])}
        for k in range(len(known) - 1)  # the first pairs are those of this contender
        if contest.ahead[k] < 0 and contest.duels_corrected[k] <= ALPHA
        for better, worse in [contest.shares(k)]
    ]
    return sorted(rivals, key=lambda rival: rival["worse"] - rival["better"])


def world_label(world: Mapping[str, Any]) -> str:
    """A world in a few words."""
    liars, late, lost = world.get("liars", 0), world.get("message_delay", 0), 1 - float(world["link_success"])
    words = [
        str(world["topology"]), f"accuracy {world['accuracy']}",
        f"f = {world.get('fill_ratio_change') or world['fill_ratio']}",
        f"floor {world['floor']}" * (world["floor"] not in ("", "tiles")), f"{lost:.0%} of messages lost" * (lost > 0),
        f"messages {late:.0f} round{'s' * (late > 1)} late" * (late > 0), f"{liars:.0f} liars" * (liars > 0),
    ]  # fmt: skip
    return ", ".join(filter(None, words))
