"""The numbers that floors are painted by: noise for each tile, and smooth Gaussian fields.

Like the kernel, this file is compiled from a copy in the cache folder (see `compiler.py`).
"""

import math

import numpy as np

from swarmcensus.engine.compiling import compiled, entry
from swarmcensus.engine.constants import TILE_ZERO
from swarmcensus.engine.random import block, counter, unit

TILES, NODES = 0, 1  # the purpose of a random number


@entry
def noise(tiles, key, trial, out):
    """Fill `out` (tick, robot) with U(0, 1) for tiles (tick, robot, 2); a tile has the same number in every tick."""
    for k in range(tiles.shape[0]):
        for i in range(tiles.shape[1]):
            place = counter(TILE_ZERO + tiles[k, i, 0], TILE_ZERO + tiles[k, i, 1])
            word, _ = block(key[0], key[1], counter(trial, TILES), place)
            out[k, i] = unit(word)


@compiled
def node(key, trial, column, row):
    """The N(0, 1) number of a lattice node (Box and Muller)."""
    a, b = block(key[0], key[1], counter(trial, NODES), counter(TILE_ZERO + column, TILE_ZERO + row))
    return math.sqrt(-2.0 * math.log(1.0 - unit(a))) * math.cos(2.0 * math.pi * unit(b))


@entry
def fill_nodes(key, trial, first, nodes):
    """Fill `nodes` (row, column) with the numbers of the lattice, from node (first, first) on."""
    for row in range(nodes.shape[0]):
        for column in range(nodes.shape[1]):
            nodes[row, column] = node(key, trial, first + column, first + row)


@compiled
def smooth_near(nodes, row, column, down, across):
    """The weighted sum of the nodes from (row, column) on."""
    total = 0.0
    for j in range(np.uint64(down.size)):
        line = 0.0
        for i in range(np.uint64(across.size)):
            line += across[i] * nodes[row + j, column + i]
        total += down[j] * line
    return total


@compiled
def smooth_far(key, trial, row, column, down, across):
    """The same sum as `smooth_near`, to the last bit, for nodes that are not stored."""
    total = 0.0
    for j in range(down.size):
        line = 0.0
        for i in range(across.size):
            line += across[i] * node(key, trial, column + i, row + j)
        total += down[j] * line
    return total


@entry
def field(tiles, key, trial, first, nodes, weights, out):
    """Fill `out` (tick, robot) with a Gaussian field at tiles (tick, robot, 2).

    Nodes are `weights.shape[0]` tiles apart, and `weights` (offset, tap) are one axis' part of the kernel for each
    place of a tile between two nodes, with squares that sum to 1: so the field is N(0, 1) everywhere. `nodes` are
    those of `fill_nodes`; beyond them a node is computed when it is met.
    """
    apart, taps = weights.shape
    for k in range(tiles.shape[0]):
        for i in range(tiles.shape[1]):
            column, row = tiles[k, i, 0] // apart, tiles[k, i, 1] // apart
            across = weights[tiles[k, i, 0] - column * apart]
            down = weights[tiles[k, i, 1] - row * apart]
            column += 1 - taps // 2
            row += 1 - taps // 2
            left, low = column - first, row - first
            if left >= 0 and low >= 0 and left + taps <= nodes.shape[1] and low + taps <= nodes.shape[0]:
                out[k, i] = smooth_near(nodes, np.uint64(low), np.uint64(left), down, across)
            else:
                out[k, i] = smooth_far(key, trial, row, column, down, across)
