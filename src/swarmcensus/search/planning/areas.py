"""How many robots an arena holds, and whether networks are connected."""

import math
from typing import Any

from swarmcensus.support.formatting import counted
from swarmcensus.worlds import Body, arena, components

CONNECTED = ("full", "ring", "line", "scale-free")  # networks of any size


class Unreachable(ValueError):
    """The goal cannot be reached, as theory or the network shows; the message says why."""


def capacity(side: float, body: Body) -> int:
    """How many robots fit into a square of this side in metres, with room to move."""
    if side < arena.smallest_side(1, body):
        return 0
    return int(arena.COVERED * side**2 / (math.pi * body.radius**2) + 1e-9)


def fewest(density: float, body: Body) -> int:
    """The fewest robots with an arena, which follows from their density, that is large enough to move in."""
    return max(1, math.ceil(density / arena.largest_density(1, body) - 1e-9))


def check_network(mission: Any, robots: int) -> None:
    """Raise Unreachable if the network of so many robots cannot be made, or is not connected."""
    topology = mission.setting.topology
    if topology.named in CONNECTED:
        return
    try:
        topology.check(robots)
        links = topology.links(robots, mission.study.seed, 0, 1, lossless=False, sums=False)
    except ValueError as error:
        raise Unreachable(
            f"world.topology: no network of {counted(robots, 'robot')} can be made, because {error}: say as "
            "swarm.robots how many robots it can have"
        ) from None
    if not links.receivers.size and topology.named:
        return  # everyone hears everyone
    if (parts := components(robots, links.receivers, links.senders)[0]) > 1:
        raise Unreachable(
            f"the goal cannot be reached, because world.topology {topology.name!r} of {robots:,} robots is not "
            f"connected: it has {parts} parts, and messages of one never reach the others"
        )
