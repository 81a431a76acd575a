"""A scale-free tree by preferential attachment: Barabasi and Albert, m = 1 (paper, Sec. IV-B)."""

import numpy as np

from swarmcensus.engine import compile_world
from swarmcensus.worlds.chance import Chance


def edges(robots: int, chance: Chance) -> np.ndarray:
    """The tree of one trial: each robot joins one that is picked in proportion to its links."""
    pairs = np.empty((robots - 1, 2), np.int64)
    compile_world().random_tree(chance.key, chance.trial, pairs)
    return pairs
