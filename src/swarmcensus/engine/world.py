"""Random numbers that a world draws once per trial: accuracies spread over a swarm, and random trees.

Like the kernel, this file is compiled from a copy in the cache folder (see `compiler.py`).
"""

import math

import numpy as np

from swarmcensus.engine.changes import renew, source_of
from swarmcensus.engine.compiling import entry
from swarmcensus.engine.constants import TILE_ZERO
from swarmcensus.engine.draws import arrange, count_blacks
from swarmcensus.engine.random import block, counter, unit, words


@entry
def draw_uniform(key, first_trial, low, high, out):
    """Fill `out` (trial, robot) with U(low, high)."""
    bits = np.empty(out.shape[1], np.uint64)
    for trial in range(out.shape[0]):
        words(key, first_trial + trial, 0, 0, 0, bits.size, bits)
        for i in range(out.shape[1]):
            out[trial, i] = low + (high - low) * unit(bits[i])


@entry
def draw_normal(key, first_trial, mean, sd, out):
    """Fill `out` (trial, robot) with N(mean, sd) truncated to [0, 1]; the mean lies in [0, 1], sd > 0.

    Rejection from a uniform on [0, 1] or, where that is narrower, nine deviations either side: what lies
    further out has a probability below 2^-53.
    """
    low, high = max(0.0, mean - 9.0 * sd), min(1.0, mean + 9.0 * sd)
    for trial in range(out.shape[0]):
        for i in range(out.shape[1]):
            attempt = 0
            while True:
                a, b = block(key[0], key[1], counter(first_trial + trial, attempt), np.uint64(i))
                x = low + (high - low) * unit(a)
                z = (x - mean) / sd
                if unit(b) < math.exp(-0.5 * z * z):
                    out[trial, i] = x
                    break
                attempt += 1


@entry
def random_tree(key, trial, edges):
    """Fill `edges` (robot - 1, 2) with a Barabasi-Albert tree (m = 1): each robot, from 1 on, and which it joins.

    It picks one in proportion to its links: a uniform end of a uniform earlier link.
    """
    robots = edges.shape[0] + 1
    bits = np.empty(robots, np.uint64)
    words(key, trial, 0, 0, 0, robots, bits)
    for i in range(1, robots):
        end = np.int64(unit(bits[i]) * (2 * (i - 1)))
        child = 1 + end // 2  # link number `child` is between that robot and its parent
        edges[i - 1, 0] = i
        edges[i - 1, 1] = 0 if i == 1 else child if end % 2 == 0 else edges[child - 1, 1]


@entry
def paint_tiles(tiles, key, trial, fill_ratio, black):
    """Fill `black` (tick, robot) for tiles (tick, robot, 2) that are black independently, with this probability."""
    k0, k1, c0 = key[0], key[1], counter(trial, 0)
    place = np.empty(tiles.shape[1], np.uint64)  # computed before the ciphers, so that these are vectorised
    for k in range(tiles.shape[0]):
        for i in range(tiles.shape[1]):
            place[i] = counter(TILE_ZERO + tiles[k, i, 0], TILE_ZERO + tiles[k, i, 1])
        for i in range(tiles.shape[1]):
            word, _ = block(k0, k1, c0, place[i])
            black[k, i] = unit(word) < fill_ratio


@entry
def round_readings(sensors, trial, out):
    """Fill `out` (round, robot) with the number of black readings in each round, from round 1 on."""
    robots = np.uint64(out.shape[1])
    bits = np.zeros(out.shape[1], np.uint64)
    source = source_of(sensors)
    for k in range(out.shape[0]):
        renew(source, k + 1, 0, out.shape[1])
        count_blacks(out[k], bits, source.tables, sensors.looks, sensors.key, trial, k + 1, np.uint64(0), robots)


@entry
def single_readings(sensors, trial, out):
    """Fill `out` (observation, robot) with the single readings of a trial, 1 for black."""
    robots, looks = out.shape[1], sensors.looks
    bits, blacks, source = np.zeros(robots, np.uint64), np.zeros(robots), source_of(sensors)
    for step in range(out.shape[0]):
        left = looks - step % looks
        if left == looks:
            tick = step // looks + 1
            renew(source, tick, 0, robots)
            count_blacks(blacks, bits, source.tables, looks, sensors.key, trial, tick, np.uint64(0), np.uint64(robots))
        arrange(out[step], blacks, bits, left, sensors.order, trial, step + 1, np.uint64(0))
