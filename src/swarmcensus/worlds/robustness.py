"""How many liars a network bears: r-robustness and (r, s)-robustness, by looking at all pairs of sets of robots.

LeBlanc, Zhang, Koutsoukos, Sundaram, "Resilient asymptotic consensus in robust networks", 2013. A set of robots is a
number whose bits say who is in it, so that what holds within each set is found from sets with one robot less: 2^n n
steps instead of the 3^n pairs.
"""

from typing import Any

from swarmcensus.worlds.graphs import network, whole

MOST = 12  # robots


def r_robustness(graph: Any, robots: int | None = None, *, directed: bool = False) -> int:
    """The largest r for which a network is r-robust.

    It is where of every two disjoint sets of robots, neither empty, one holds a robot that hears r robots or more
    outside its set. No network of n robots has more than (n + 1) // 2; a robot alone counts as 1.

    `graph` is a networkx graph, anything that a study takes for a topology, or pairs of robot numbers from 0; of a
    directed pair (u, v), v hears u. `robots` is their number where the graph does not tell. Raises ValueError where
    there are more than 12 robots, the network differs from trial to trial, or it is none.
    """
    heard = _heard(graph, robots, directed)
    if len(heard) < 2:
        return 1
    everyone = (1 << len(heard)) - 1
    reach = [_counts(heard, some, 1)[1] for some in range(everyone + 1)]
    lowest = _lowest_within(reach)
    return min(max(reach[some], lowest[everyone ^ some]) for some in range(1, everyone))


def is_rs_robust(graph: Any, r: int, s: int, robots: int | None = None, *, directed: bool = False) -> bool:
    """Whether a network is (r, s)-robust; (r, 1) is r-robust.

    It is where of every two disjoint sets of robots, neither empty, all robots of the one, or all of the other, or s of
    both together or more hear r robots or more outside their own set. The other arguments are those of `r_robustness`.
    Raises ValueError, also where r is below 0 or s not from 1 to the number of robots.
    """
    r, s = whole("r", r), whole("s", s)
    heard = _heard(graph, robots, directed)
    if r < 0 or not 1 <= s <= len(heard):
        raise ValueError(f"(r, s) = ({r}, {s}): r is from 0 on, and s from 1 to the number of robots, {len(heard)}")
    everyone = (1 << len(heard)) - 1
    enough = 2 * len(heard)  # no two sets of which one has so many fall short
    reached = [_counts(heard, some, r)[0] for some in range(everyone + 1)]
    short = [count if count < some.bit_count() else enough for some, count in enumerate(reached)]
    lowest = _lowest_within(short)
    return all(short[some] + lowest[everyone ^ some] >= s for some in range(1, everyone))


def _counts(heard: list[int], some: int, r: int) -> tuple[int, int]:
    """How many of a set hear r robots or more outside it, and the most that one of them hears there."""
    outside = [(heard[robot] & ~some).bit_count() for robot in range(len(heard)) if some >> robot & 1]
    return sum(count >= r for count in outside), max(outside, default=0)


def _lowest_within(values: list[int]) -> list[int]:
    """For each set, the lowest value of any set in it that is not empty; of the empty one, what bounds no pair."""
    lowest = [max(values) + 1, *values[1:]]
    for some in range(1, len(values)):
        rest = some
        while rest:
            one = rest & -rest
            if some != one:
                lowest[some] = min(lowest[some], lowest[some ^ one])
            rest ^= one
    return lowest


def _heard(graph: Any, robots: int | None, directed: bool) -> list[int]:
    """Whom each robot hears, as bits; nobody hears oneself."""
    why = "for the sets of robots that are looked at double with each robot"
    found = network(graph, robots, directed, MOST, why)
    heard = [0] * found.robots
    for receiver, sender in zip(found.receivers.tolist(), found.senders.tolist(), strict=True):
        heard[receiver] |= 1 << sender
    return heard
