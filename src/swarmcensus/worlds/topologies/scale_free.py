"""A scale-free tree by preferential attachment: Barabasi and Albert, m = 1 (paper, Sec. IV-B)."""

import numpy as np

from swarmcensus.engine import compile_world
from swarmcensus.worlds.chance import Chance


def links(robots: int, chance: Chance) -> tuple[np.ndarray, np.ndarray]:
    """Receivers and senders of one trial's tree, in both directions, sorted."""
    return compile_world().random_tree(chance.key, chance.trial, robots)  # type: ignore[no-any-return]
