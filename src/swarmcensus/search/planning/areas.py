"""Checks of a mission's area, of how many robots it holds, and of whether networks are connected."""

import math
from operator import attrgetter
from typing import Any

from swarmcensus.support.errors import StudyError
from swarmcensus.support.formatting import counted
from swarmcensus.worlds import arena, components

MOST_ROBOTS = 1_000_000
YEAR = 366 * 24 * 60  # minutes
CONNECTED = ("full", "ring", "line", "scale-free")  # networks of any size
MOST_TILES = 2**30  # from wall to wall: a tile is addressed by two 32-bit numbers


class Unreachable(ValueError):
    """The goal cannot be reached, as theory or the network shows; the message says why."""


def check_areas(mission: Any) -> None:
    """Raise StudyError if the area is missing, given twice, too small or too large, or does not apply."""
    area, free = mission.area, mission.free
    if free.robots is not None and free.robots[1] > MOST_ROBOTS:
        raise StudyError.at("free.robots", free.robots[1], f"a plan has at most {MOST_ROBOTS:,} robots")
    if free.minutes is not None and free.minutes[1] > YEAR:
        raise StudyError.at("free.minutes", f"{free.minutes[1]:g}", f"a plan is for at most a year, {YEAR:,} min")
    moving, fixed = (any(topology.moves == moves for topology in free.topology) for moves in (True, False))
    sized = area.side is not None or area.area is not None
    if area.side is not None and area.area is not None:
        raise _twice("area.side", "area.area")
    if not moving:
        for key in ("area.side", "area.area", "area.floor", "free.density"):
            if attrgetter(key)(mission) is not None:
                raise StudyError(f'{key} is of robots that move: it goes with topology = "moving"', key=key)
        if mission.wanted.truth == "floor":
            where = "robots that move: on fixed networks each reading is of another tile"
            raise StudyError(f'wanted.truth = "floor" is of {where}', key="wanted.truth", value="floor")
    elif sized and free.density is not None:
        raise _twice("free.density", f"area.{'side' if area.side is not None else 'area'}")
    elif not sized and free.density is None:
        sizes = "a side in metres, or an area in square metres, or leave it to a swarm density (free.density)"
        raise StudyError(f"area: should have {sizes}", key="area")
    if area.floor is not None and len(area.floor) > 1:
        raise StudyError("area.floor: should be one kind of floor", key="area.floor")
    for key in ("observations_per_round", "round_seconds"):
        if not fixed and getattr(free, key) is not None:
            once = "robots that move observe once a tick at most"
            raise StudyError(f"free.{key} is of fixed networks: {once}", key=f"free.{key}")
    for world in mission.worlds:
        if world.moves:
            _check_area(world)
        else:
            check_networks(world)
        if free.minutes is not None and world.rounds(free.minutes[0]) < 1:
            less = f"that is less than one round of {60 * world.round_minutes:g} s"
            raise StudyError.at("free.minutes", f"{free.minutes[0]:g}", less)


def _twice(first: str, second: str) -> StudyError:
    return StudyError(f"{first} and {second} both say how large the area is: give one of them", key=second)


def _check_area(world: Any) -> None:
    density, robots = world.density, world.free.robots
    if density is None:
        most = capacity(world)
        if robots is not None and robots[1] > most:
            holds = f"a square of {world.side:g} m holds {counted(most, 'robot')} at the most"
            raise StudyError.at("free.robots", robots[1], holds)
        if most < 1:
            raise StudyError(f"a square of {world.side:g} m cannot hold a robot", key="area")
    else:
        most_dense = arena.COVERED * (world.body.radio_range / world.body.radius) ** 2
        if density > most_dense:
            raise StudyError.at("free.density", f"{density:g}", f"bodies have room to move up to {most_dense:.4g}")
        if robots is not None and robots[0] < fewest(world):
            few = f"at a density of {density:g} fewer than {fewest(world):,} robots have no room to move"
            raise StudyError.at("free.robots", robots[0], few)
    across = world.sized(robots[1] if robots else 1000).side / world.body.tile
    if across > MOST_TILES:
        raise StudyError(f"the area is {across:.2g} tiles wide: {MOST_TILES:,} is the most", key="area")


def capacity(world: Any) -> int:
    """How many robots fit into the area, with room to move."""
    if world.side < arena.smallest_side(1, world.body):
        return 0
    return int(arena.COVERED * world.side**2 / (math.pi * world.body.radius**2) + 1e-9)


def fewest(world: Any) -> int:
    """The fewest robots with an area, which follows from their density, that is large enough to move in."""
    alone = arena.largest_density(1, world.body)
    return max(1, math.ceil(float(world.density) / alone - 1e-9))


def check_networks(world: Any) -> None:
    """Raise Unreachable if a given size has no connected network, or if a list of edges comes without its size."""
    topology, sizes = world.free.topology[0], world.free.robots
    if sizes is None and topology.edges is not None:
        robots = 1 + max((max(pair) for pair in topology.edges), default=0)
        raise Unreachable(
            f"free.topology: the edges of {topology.name!r} have {counted(robots, 'robot')}: say free.robots = {robots}"
        )
    for robots in dict.fromkeys(sizes or ()):
        check_network(world, robots)


def check_network(world: Any, robots: int) -> None:
    """Raise Unreachable if the network of so many robots cannot be made, or is not connected."""
    topology = world.free.topology[0]
    if topology.named in CONNECTED:
        return
    try:
        topology.check(robots)
        links = topology.links(robots, world.seed, 0, 1, lossless=False, sums=False)
    except ValueError as error:
        raise Unreachable(
            f"free.topology: no network of {counted(robots, 'robot')} can be made, because {error}: say as "
            "free.robots how many robots it can have"
        ) from None
    if not links.receivers.size and topology.named:
        return  # everyone hears everyone
    if (parts := components(robots, links.receivers, links.senders)[0]) > 1:
        raise Unreachable(
            f"the goal cannot be reached, because free.topology {topology.name!r} of {robots:,} robots is not "
            f"connected: it has {parts} parts, and messages of one never reach the others"
        )
