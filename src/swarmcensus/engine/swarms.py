"""A swarm as the engine's loops take it: which robots have which brain, and where their minds lie."""

from typing import Any, NamedTuple

import numpy as np

from swarmcensus.engine.constants import BLOCK


class Swarm(NamedTuple):
    """Robots in groups that are alike; minds of a group lie in rows as long as its brain asks for, a row a robot.

    In `memory` (robot, field) a group has room for all robots, from its base on, and uses the rows of its own; that is
    so little that nothing is gained by packing them. What CPython calls takes the items one by one: Numba is slow to
    tell the type of a tuple of them.
    """

    minds: Any  # (group, function): addresses of the brains' functions, see `constants.py`
    bases: np.ndarray  # (group): where its rows begin, in numbers
    fields: np.ndarray  # (group): how long a row is
    named: np.ndarray  # (group): whether a mind holds its robot's name, before its beliefs
    blanks: np.ndarray  # (group, field): a mind before its first observation
    runs: np.ndarray  # (run, 3): group, first robot, last robot + 1; none reaches over a block's end
    of_block: np.ndarray  # (block + 1): where the runs of a block of BLOCK robots begin
    additive: bool  # whether all brains only add up what they hear
    flag: int  # where in a message is whether it was SAID at all, or NOISE; -1 where all are
    jams: bool  # whether any brain may drown what others say
    luck: np.ndarray  # two keys of two words each; empty where no brain asks for luck
    honest: np.ndarray  # (robot): who counts where robots decide; empty where all do


def runs_of(group: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The `runs` and `of_block` of robots' groups (robot)."""
    robots = group.size
    cuts = np.flatnonzero(np.diff(group)) + 1
    first = np.unique(np.concatenate([np.arange(0, robots, BLOCK), cuts]))
    runs = np.stack([group[first], first, np.append(first[1:], robots)], axis=1).astype(np.uint64)
    of_block = np.searchsorted(first, np.arange(0, robots + BLOCK, BLOCK))
    return runs, of_block[: -(-robots // BLOCK) + 1].astype(np.uint64)
