"""Blobs: a smooth Gaussian field with one correlation length, black where it is lowest."""

import math
from typing import Annotated

import numpy as np
from numpy.typing import NDArray
from pydantic import Field

from swarmcensus.engine.compiler import compile_world
from swarmcensus.worlds.arena import MOST_COUNTED, Arena, Length, Score, Scores, Tiles
from swarmcensus.worlds.chance import Chance

Correlation = Annotated[Length, Field(examples=[0.2])]
SOME_COUNTED = 1_000_000  # tiles, where the lattice is too large to be kept: each tile is costly
MOST_NODES = 1 << 24  # of a lattice that are kept: 128 MB
KERNEL = 3.5  # standard deviations, where the smoothing kernel is cut off


def check(arena: Arena, *, length: Correlation) -> None:
    """Refuse lengths that tiles cannot show."""
    if length < 2.0 * arena.tile:
        least = 2.0 * arena.tile
        raise ValueError(f'should be at least two tiles, {least:g} m; without clusters the floor is "tiles"')


def score(arena: Arena, chance: Chance, *, length: Correlation) -> Score:
    """Independent N(0, 1) on a lattice, smoothed."""
    module, weights = compile_world("scores"), kernel(length, arena.tile)
    first, size = lattice(length, arena)
    nodes = np.empty((size, size))
    module.fill_nodes(chance.key, chance.trial, first, nodes)

    def field(tiles: Tiles) -> Scores:
        out = np.empty(tiles.shape[:2])
        module.field(tiles, chance.key, chance.trial, first, nodes, weights, out)
        return out

    return field


def most_counted(arena: Arena, *, length: Correlation) -> int:
    """Fewer where each tile is costly."""
    return MOST_COUNTED if lattice(length, arena)[1] else SOME_COUNTED


def kernel(length: float, tile: float) -> NDArray[np.float64]:
    """Return the weights (offset, tap) of one axis that smooth a lattice to a field of this correlation length.

    Independent N(0, 1) smoothed by a Gaussian of standard deviation s are correlated by exp(-d^2 / (4 s^2)) at a
    distance d, so s is half the correlation length, where that is 1/e. Nodes are at most s apart, a whole number of
    tiles: then the correlation is this, from every tile, to 0.001. A tile lies `offset` tiles after the node of the
    last tap but half of them.
    """
    sd = length / 2.0 / tile
    apart = max(1, math.floor(sd + 1e-9))
    reach = math.ceil(KERNEL * sd / apart)
    distance = np.arange(1 - reach, reach + 1) * apart - np.arange(apart)[:, np.newaxis]
    weights = np.exp(-0.5 * (distance / sd) ** 2)
    normal: NDArray[np.float64] = weights / np.sqrt((weights**2).sum(axis=1, keepdims=True))
    return normal


def lattice(length: float, arena: Arena) -> tuple[int, int]:
    """Return the first node, in both directions, that tiles of the arena need, and how many in a row; 0: too many."""
    apart, taps = kernel(length, arena.tile).shape
    first = -arena.across // 2 // apart - taps
    return first, -2 * first if 4 * first**2 <= MOST_NODES else 0
