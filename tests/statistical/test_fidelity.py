"""The walk against a physics simulation of 25 Khepera IV robots: D = 1, straight motion at 0.10 m/s.

The measured values stand in docs/moving-robots.md. Tolerance: 5 %, 15 % for counts of rare things, 0.01 for a
correlation near zero. With 20 trials the means' own standard errors are a third of that or less.
"""

import numpy as np
import pytest

from swarmcensus.engine.addresses import address
from swarmcensus.simulation.walking import Walk
from swarmcensus.worlds import arena
from swarmcensus.worlds.bodies import Body

TRIALS, ROBOTS, TICKS = 20, 25, 10_000
MEASURED = {
    "displacement per tick, cm": (0.712, 0.05), "mean squared displacement, 10 ticks": (0.0063, 0.05),
    "mean squared displacement, 100 ticks": (0.284, 0.05), "mean squared displacement, 1000 ticks": (3.02, 0.05),
    "heading autocorrelation, 1 tick": (0.990, 0.05), "heading autocorrelation, 10 ticks": (0.647, 0.05),
    "heading autocorrelation, 30 ticks": (0.295, 0.05),
    "ticks avoiding": (0.028, 0.15), "length of a bout": (2.65, 0.05), "bouts per robot and 1000 ticks": (10.6, 0.15),
    "neighbours": (0.869, 0.05), "P(0 neighbours)": (0.405, 0.05), "P(1 neighbour)": (0.380, 0.05),
    "P(2 neighbours)": (0.164, 0.05), "P(3 neighbours)": (0.043, 0.15),
    "episode without neighbours": (115, 0.05), "episode with neighbours": (168, 0.05),
    "distinct tiles per observation": (0.868, 0.05), "same tile twice running": (0.039, 0.05),
    "colour autocorrelation, lag 1": (0.039, 0.05), "colour autocorrelation, lag 2": (0.008, 0.15),
}  # fmt: skip


def bouts(flags):
    return int(flags[0].sum() + (flags[1:] & ~flags[:-1]).sum())


def same(tiles, looked, lag):
    """The share of observations that meet the tile of `lag` observations ago: the colours' autocorrelation."""
    hits = total = 0
    for robot in range(tiles.shape[1]):
        seen = tiles[looked[:, robot], robot]
        hits += (seen[lag:] == seen[:-lag]).all(axis=1).sum()
        total += len(seen) - lag
    return hits / total


def distinct(tiles, looked):
    places = tiles @ [1 << 20, 1]  # a number for each tile: sorted sooner than pairs
    return np.mean([len(np.unique(places[looked[:, r], r])) / looked[:, r].sum() for r in range(tiles.shape[1])])


def measure(trial):
    body = Body(speed=0.10, message_delay=2)
    side = arena.side(ROBOTS, 1.0, body)
    stop = np.zeros(1, np.uint8)
    chunks = list(Walk(ROBOTS, side, body, address(1, "walk"), trial, stop, poses=True).chunks(TICKS))
    poses, looked, tiles = (np.concatenate([getattr(c, n) for c in chunks]) for n in ("poses", "looked", "tiles"))
    neighbours = np.zeros((TICKS, ROBOTS), int)
    for chunk in chunks:
        neighbours[chunk.tick - 1 :][: len(chunk.looked)] = np.diff(chunk.heard).reshape(-1, ROBOTS)
    xy, heading, alone = poses[..., :2], poses[..., 2], neighbours == 0

    def squared(lag):
        return np.sum((xy[lag:] - xy[:-lag]) ** 2, axis=2).mean()

    def turned(lag):
        return np.cos(heading[lag:] - heading[:-lag]).mean()

    return [
        100 * np.hypot(*(xy[1:] - xy[:-1]).transpose(2, 0, 1)).mean(),
        squared(10), squared(100), squared(1000),
        turned(1), turned(10), turned(30),
        1 - looked.mean(), (~looked).sum() / bouts(~looked), 1000 * bouts(~looked) / looked.size,
        neighbours.mean(), *((neighbours == k).mean() for k in range(4)),
        alone.sum() / bouts(alone), (~alone).sum() / bouts(~alone),
        distinct(tiles, looked), same(tiles, looked, 1), same(tiles, looked, 1), same(tiles, looked, 2),
    ]  # fmt: skip


@pytest.fixture(scope="module")
def found():
    return dict(zip(MEASURED, np.transpose([measure(trial) for trial in range(TRIALS)]), strict=True))


@pytest.mark.parametrize("name", MEASURED)
def test_the_walk_is_that_of_the_physics_simulation(name, found):
    measured, tolerance = MEASURED[name]
    assert found[name].mean() == pytest.approx(measured, rel=tolerance)
