"""Clusters: a smooth Gaussian field with one correlation length; its lowest values are black."""

import math
from typing import Annotated

import numpy as np
from numpy.typing import NDArray
from pydantic import Field

from swarmcensus.engine import compile_world, not_compiled
from swarmcensus.worlds.arena import MOST_COUNTED, Arena, Length, Score, Scores, Tiles
from swarmcensus.worlds.chance import Chance

Correlation = Annotated[Length, Field(examples=[0.2])]
FEW_COUNTED = 1_000_000  # tiles, if the lattice is too large to be kept: each tile then takes long
MOST_NODES = 1 << 24  # of a lattice that is kept in memory: 128 MB
KERNEL = 3.5  # standard deviations, where the smoothing kernel is cut off


def check(arena: Arena, *, length: Correlation) -> None:
    """Refuse lengths that are too short for the tiles."""
    if length < 2.0 * arena.tile:
        least = 2.0 * arena.tile
        raise ValueError(f'should be at least two tiles, {least:g} m; without clusters the floor is "tiles"')


def score(arena: Arena, chance: Chance, *, length: Correlation) -> Score:
    """Independent N(0, 1) numbers on a lattice, smoothed."""
    module, weights = compile_world("scores"), kernel(length, arena.tile)
    first, size = lattice(length, arena)
    nodes = np.empty((size, size))
    module.fill_nodes(chance.key, chance.trial, first, nodes)

    def field(tiles: Tiles) -> Scores:
        if not_compiled() and size:
            return smoothed(tiles, first, nodes, weights)
        out = np.empty(tiles.shape[:2])
        module.field(tiles, chance.key, chance.trial, first, nodes, weights, out)
        return out

    return field


def smoothed(tiles: Tiles, first: int, nodes: Scores, weights: Scores) -> Scores:
    """The engine's `field` by arrays, in the same order of sums: a loop over tiles takes CPython a minute."""
    apart, taps = weights.shape
    place, offset = np.divmod(tiles, apart)
    column, row = np.moveaxis(place + (1 - taps // 2 - first), -1, 0)
    across, down = np.moveaxis(weights[offset], -2, 0)
    total = np.zeros(tiles.shape[:2])
    for j in range(taps):
        line = np.zeros(tiles.shape[:2])
        for i in range(taps):
            line += across[..., i] * nodes[row + j, column + i]
        total += down[..., j] * line
    return total


def most_counted(arena: Arena, *, length: Correlation) -> int:
    """Fewer if each tile takes long."""
    return MOST_COUNTED if lattice(length, arena)[1] else FEW_COUNTED


def kernel(length: float, tile: float) -> NDArray[np.float64]:
    """Return the weights (offset, tap) along one axis that smooth a lattice to a field of this correlation length.

    Independent N(0, 1) numbers that a Gaussian of standard deviation s smooths have the correlation
    exp(-d^2 / (4 s^2)) at a distance d. It is 1/e at the correlation length, so s is half of that. Nodes are a whole
    number of tiles and at most s apart, which gives this correlation to within 0.001 from every tile. A tile lies
    `offset` tiles after the middle tap's node.
    """
    sd = length / 2.0 / tile
    apart = max(1, math.floor(sd + 1e-9))
    reach = math.ceil(KERNEL * sd / apart)
    distance = np.arange(1 - reach, reach + 1) * apart - np.arange(apart)[:, np.newaxis]
    weights = np.exp(-0.5 * (distance / sd) ** 2)
    normal: NDArray[np.float64] = weights / np.sqrt((weights**2).sum(axis=1, keepdims=True))
    return normal


def lattice(length: float, arena: Arena) -> tuple[int, int]:
    """Return the first node, in both directions, that the arena's tiles need, and the nodes in a row; 0: too many."""
    apart, taps = kernel(length, arena.tile).shape
    first = -arena.across // 2 // apart - taps
    return first, -2 * first if 4 * first**2 <= MOST_NODES else 0
