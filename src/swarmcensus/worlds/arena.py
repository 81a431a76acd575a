"""The square that robots move in, and how many of them it holds.

Swarm density is D = N pi r^2 / L^2, with r the radio range and L the side (paper, Sec. IV-C).
"""

import math

from swarmcensus.worlds.bodies import Body

COVERED = 0.45  # of the floor by bodies: beyond it, robots placed at random soon find no room


def side(robots: int, density: float, body: Body) -> float:
    """The inner side of the arena in metres."""
    return math.sqrt(robots * math.pi * body.radio_range**2 / density)


def density(robots: int, side: float, body: Body) -> float:
    """The swarm density of an arena of this inner side in metres."""
    return robots * math.pi * body.radio_range**2 / side**2


def smallest_side(robots: int, body: Body) -> float:
    """The inner side of the smallest arena that still holds its robots with room to move."""
    return max(math.sqrt(robots * math.pi * body.radius**2 / COVERED), 4.0 * body.radius)


def largest_density(robots: int, body: Body) -> float:
    """The largest density at which the arena still holds its robots with room to move."""
    return density(robots, smallest_side(robots, body), body)
