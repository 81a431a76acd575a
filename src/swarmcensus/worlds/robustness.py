"""How many liars a network tolerates: r-robustness and (r, s)-robustness, over all pairs of sets of robots.

LeBlanc, Zhang, Koutsoukos, Sundaram, "Resilient asymptotic consensus in robust networks", 2013. A set of robots is a
number with one bit for each robot. The lowest value within each set follows from sets with one robot less, so 2^n n
steps suffice instead of 3^n pairs.
"""

from typing import Any

from swarmcensus.worlds.graphs import network, whole

MOST = 12  # robots


def r_robustness(graph: Any, robots: int | None = None, *, directed: bool = False) -> int:
    """The largest r for which a network is r-robust.

    It is r-robust if, for every two disjoint non-empty sets of robots, at least one set has a robot that hears r or
    more robots outside its set. No network of n robots has more than (n + 1) // 2; a single robot counts as 1.

    `graph` is a networkx graph, any topology of a study file, or pairs of robot numbers from 0; in a directed pair
    (u, v), v hears u. `robots` is their number, if the graph does not give it. Raises ValueError for more than 12
    robots, for a network that differs from trial to trial, and for anything else.
    """
    heard = _neighbours(graph, robots, directed)
    if len(heard) < 2:
        return 1
    everyone = (1 << len(heard)) - 1
    reach = [_counts(heard, members, 1)[1] for members in range(everyone + 1)]
    lowest = _lowest_within(reach)
    return min(max(reach[members], lowest[everyone ^ members]) for members in range(1, everyone))


def is_rs_robust(graph: Any, r: int, s: int, robots: int | None = None, *, directed: bool = False) -> bool:
    """Whether a network is (r, s)-robust; (r, 1) is r-robust.

    It is (r, s)-robust if, for every two disjoint non-empty sets of robots, all robots of one set, or s or more robots
    of both together, hear r or more robots outside their own set. The other arguments are those of `r_robustness`.
    Raises ValueError, also for r below 0 and for s not from 1 to the number of robots.
    """
    r, s = whole("r", r), whole("s", s)
    heard = _neighbours(graph, robots, directed)
    if r < 0 or not 1 <= s <= len(heard):
        raise ValueError(f"(r, s) = ({r}, {s}): r is from 0 on, and s from 1 to the number of robots, {len(heard)}")
    everyone = (1 << len(heard)) - 1
    enough = 2 * len(heard)  # so large that a pair with this value is always enough
    reached = [_counts(heard, members, r)[0] for members in range(everyone + 1)]
    short = [count if count < members.bit_count() else enough for members, count in enumerate(reached)]
    lowest = _lowest_within(short)
    return all(short[members] + lowest[everyone ^ members] >= s for members in range(1, everyone))


def _counts(heard: list[int], members: int, r: int) -> tuple[int, int]:
    """How many robots of a set hear r or more outside it, and the most that one of them hears outside."""
    outside = [(heard[robot] & ~members).bit_count() for robot in range(len(heard)) if members >> robot & 1]
    return sum(count >= r for count in outside), max(outside, default=0)


def _lowest_within(values: list[int]) -> list[int]:
    """For each set, the lowest value of its non-empty subsets; for the empty set a value above all."""
    lowest = [max(values) + 1, *values[1:]]
    for members in range(1, len(values)):
        rest = members
        while rest:
            robot = rest & -rest  # the lowest bit
            if members != robot:
                lowest[members] = min(lowest[members], lowest[members ^ robot])
            rest ^= robot
    return lowest


def _neighbours(graph: Any, robots: int | None, directed: bool) -> list[int]:
    """Whom each robot hears, as bits."""
    why = "as the number of sets doubles with each robot"
    found = network(graph, robots, directed, MOST, why)
    heard = [0] * found.robots
    for receiver, sender in zip(found.receivers.tolist(), found.senders.tolist(), strict=True):
        heard[receiver] |= 1 << sender
    return heard
