"""The boards, and the scores of each contender on one of them: by errors, and by right decisions on black or white."""

from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from swarmcensus.analysis import NONE, ContestInput, Grid, contests, grid_of
from swarmcensus.results import measures
from swarmcensus.studies import NUMERIC
from swarmcensus.support.bootstrap import Statistic, centres
from swarmcensus.worlds import MOVING

Floats = NDArray[np.float64]
World = Mapping[str, Any]
ERROR, SIDE, TAIL = "final_error", "right_side", "error_90"


@dataclass(frozen=True)
class BoardColumn:
    """A kind of world: its name, its meaning, and which worlds belong to it."""

    name: str
    meaning: str
    holds: Callable[[World], bool]


def _harder(world: World) -> set[str]:
    """What makes a world harder than one of honest robots, sure messages and a fixed floor of independent tiles."""
    there = {
        "liars": world.get("liars", 0),
        "losses": float(world["link_success"]) < 1.0,
        "delays": world.get("message_delay", 0),
        "clusters": world["floor"] not in ("", "tiles"),
        "change": world.get("fill_ratio_change", ""),
    }
    return {name for name, holds in there.items() if holds}


def _moves(world: World) -> bool:
    return str(world["topology"]) == MOVING


def _lying(share: float) -> Callable[[World], bool]:
    return lambda w: _harder(w) <= {"liars"} and abs(w.get("liars", 0) / w["robots"] - share) < 0.01


@dataclass(frozen=True)
class Division:
    """Worlds that one board ranks together: its title, which worlds belong to it, and their kinds."""

    title: str
    meaning: str
    holds: Callable[[World], bool]
    columns: tuple[BoardColumn, ...]
    shown: tuple[str, ...]  # columns that the shell shows


DIVISIONS = {
    "honest": Division(
        "Honest robots",
        "all robots are honest, and the floor stays",
        lambda w: not _harder(w) & {"liars", "change"},
        (
            BoardColumn("networks", "fixed networks, nothing lost", lambda w: not _harder(w) and not _moves(w)),
            BoardColumn("moving", "robots that move, nothing lost", lambda w: not _harder(w) and _moves(w)),
            BoardColumn("poor sensors", "both, b = w = 0.55", lambda w: not _harder(w) and w["accuracy"] == "0.55"),
            BoardColumn(
                "mixed sensors",
                "both, b = w from U(0.525, 0.975)",
                lambda w: not _harder(w) and w["accuracy"][0] == "U",
            ),
            BoardColumn("f near 1/2", "both, f = 0.47", lambda w: not _harder(w) and w["fill_ratio"] == 0.47),
            BoardColumn("lost messages", "half of all messages are lost", lambda w: "losses" in _harder(w)),
            BoardColumn("clusters", "black lies in clusters", lambda w: "clusters" in _harder(w)),
        ),
        ("networks", "moving"),
    ),
    "liars": Division(
        "Liars",
        "some robots say that all is black, and the floor stays",
        lambda w: _harder(w) & {"liars", "change"} == {"liars"},
        (
            BoardColumn("10 % liars", "2 of 20 robots lie, nothing lost", _lying(0.1)),
            BoardColumn("30 % liars", "6 of 20 robots lie, nothing lost", _lying(0.3)),
        ),
        ("10 % liars", "30 % liars"),
    ),
    "change": Division(
        "A floor that changes",
        "all robots are honest, and the floor changes halfway",
        lambda w: _harder(w) & {"liars", "change"} == {"change"},
        (BoardColumn("change", "networks and moving robots", lambda w: True),),
        (),
    ),
}


@dataclass(frozen=True)
class Score:
    """One measure of all contenders; `low` says that low numbers are good.

    `values` (contender, column) are means over worlds of medians over trials, `ranks` (contender,) averages over all
    worlds and trials, 1 is best; `by_world` is (world, contender) and `numbers` (world, contender, trial).
    """

    name: str
    low: bool
    numbers: Floats
    values: Floats
    ranks: Floats
    by_world: Floats

    @property
    def order(self) -> list[int]:
        """Contenders, the best first; those without a rank are left out."""
        known = np.flatnonzero(~np.isnan(self.ranks))
        return [int(k) for k in known[np.argsort(self.ranks[known], kind="stable")]]


@dataclass(frozen=True)
class Scores:
    """One board: contenders, its worlds and scores."""

    division: Division
    grid: Grid
    worlds: Sequence[World]
    error: Score
    side: Score
    tail: Floats  # (contender,): the error that 90 % of a trial's robots do not exceed, the mean over worlds of medians
    costs: dict[str, Floats]  # (contender,), means over the worlds of all boards
    bounds: frozenset[str]  # contenders that are bounds: no robot can reach them

    @property
    def contenders(self) -> list[str]:
        """Their names."""
        return self.grid.contenders


def scores_of(
    data: xr.Dataset, opinions: Collection[str], oracles: Collection[str] = (), board: str = "honest"
) -> Scores | None:
    """Score results on one board; None if they have none of its worlds.

    The estimates of brains in `opinions` have no error; those in `oracles` are bounds.
    """
    division, (grid, _) = DIVISIONS[board], grid_of(data, data)
    columns = {
        str(name): values.values.tolist()
        for name, values in data.coords.items()
        if values.dims == ("setting",) and name not in NUMERIC
    }
    firsts = [next(place for place in row if place != NONE) for row in grid.place]
    worlds = [{name: values[k] for name, values in columns.items()} for k in firsts]
    own = np.array([division.holds(world) for world in worlds])
    if not own.any():
        return None
    worlds = [world for world, holds in zip(worlds, own, strict=True) if holds]
    brains = [str(data["brain"].values[column[column != NONE][0]]) for column in grid.place.T]

    def by_world(values: Any) -> Floats:
        return np.asarray(grid.spread(values)[own])

    without = [brain in opinions for brain in brains]
    errors, tails = (by_world(measures.numbers(data, name)) for name in (ERROR, TAIL))
    errors[:, without] = tails[:, without] = np.nan
    sides = by_world(measures.numbers(data, SIDE))
    costs = {name: np.nanmean(grid.spread(measures.numbers(data, name)), axis=(0, 2)) for name in ("messages_sent",)}
    costs |= {name: np.nanmean(grid.spread(data[name].values.astype(float)), axis=0) for name in measures.SIZES}
    bounds = frozenset(name for name, brain in zip(grid.contenders, brains, strict=True) if brain in oracles)
    error, side = (
        _score(name, numbers, worlds, division, low)
        for name, numbers, low in ((ERROR, errors, True), (SIDE, sides, False))
    )
    return Scores(division, grid, worlds, error, side, centres(tails, "median").mean(axis=0), costs, bounds)


def _score(name: str, numbers: Floats, worlds: Sequence[World], division: Division, low: bool) -> Score:
    known: NDArray[np.bool_] = np.asarray(~np.isnan(numbers).all(axis=(0, 2)))
    statistic: Statistic = "median" if low else "mean"
    by_world = centres(numbers, statistic)
    (contest,) = contests([ContestInput(numbers[:, known], statistic, low, not low)], with_intervals=False)
    ranks = np.full(len(known), np.nan)
    ranks[known] = contest.average_ranks
    masks = [np.array([column.holds(world) for world in worlds]) for column in division.columns]
    columns = [by_world[mask].mean(axis=0) if mask.any() else np.full(len(known), np.nan) for mask in masks]
    return Score(name, low, numbers, np.stack(columns, axis=1), ranks, by_world)
