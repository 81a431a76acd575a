"""How threads share one large trial: each has its blocks of robots, and they wait for each other.

All members of a team run the same loop on the same arrays, and come to the same decisions. What depends on the robots
of all goes through `most_of` or `unanimous`. A team of one never waits.
"""

from typing import Any, NamedTuple

import numpy as np

from swarmcensus.engine.calling import count_up, counted, pass_gate, place, seen_as
from swarmcensus.engine.compiling import loop
from swarmcensus.engine.constants import BLOCK

from .states import NOBODY, copy_all

BEGIN, ME, COUNT, GATE, HERE = range(5)  # of a member: its first block, its number, how many there are, see `Team`
TURN, WAITED = 2, 3
SPINS = 2000  # looks at whether all are here, before other threads may run


class Team(NamedTuple):
    """What a member knows of its team. Its `Swarm` has the runs of its own blocks alone."""

    first: Any  # robots first ... last - 1 are its own
    last: Any
    begin: Any  # its first block
    me: Any
    count: Any
    gate: Any  # the address of a function that lets other threads run
    here: Any  # the address of how often members have come to wait
    votes: Any  # (4, member): two rows of numbers that all see; which row is next; how often a member waited


@loop(inline="always")
def team_of(member, swarm, votes, robots):
    """The team of a member."""
    first = member[BEGIN] * BLOCK
    last = min(first + np.int64(swarm.of_block.size - 1) * BLOCK, robots)
    return Team(first, last, member[BEGIN], member[ME], member[COUNT], member[GATE], member[HERE], votes)


@loop(forceinline=True)
def wait(team):
    """Return once all members are here."""
    if team.count > 1:
        meet(team)


@loop()
def meet(team):
    """`wait` for several; a function of its own, so that small swarms do not get slower.

    A thread that sleeps may be woken on the core of another one, and wait for it. So it looks again and again.
    """
    team.votes[WAITED, team.me] += 1.0
    all_here = np.int64(team.votes[WAITED, team.me]) * team.count
    count_up(team.here)
    spins = 0
    while counted(team.here) < all_here:
        spins += 1
        if spins % SPINS == 0:
            pass_gate(team.gate)


@loop()
def gather(team, number):
    """Tell all members a number; returns which row of team.votes has the numbers of all.

    Two rows are enough: who writes to a row again has waited in between, for all to have read it.
    """
    turn = np.int64(team.votes[TURN, team.me])
    team.votes[TURN, team.me] = 1 - turn
    team.votes[turn, team.me] = number
    wait(team)
    return turn


@loop()
def most_of(team, number):
    """The greatest of the members' numbers."""
    turn = gather(team, number)
    for member in range(team.count):
        number = max(number, team.votes[turn, member])
    return number


@loop()
def unanimous(team, option):
    """The option of all members but those that have NOBODY; below 0 if there is none, or if they differ."""
    turn = gather(team, option)
    for member in range(team.count):
        other = team.votes[turn, member]
        if option == NOBODY:
            option = other
        elif other not in (option, NOBODY):
            return -1.0
    return option


@loop()
def share_of(team, size):
    """Which of so many things are a member's own: from the first number up to the second."""
    return size * team.me // team.count, size * (team.me + 1) // team.count


@loop()
def copy_together(team, copies, k, array, is_kept):
    """Copy an array to the k-th of its copies, if there is one, or back unless it `is_kept`; all wait for the whole."""
    if k < copies.shape[0]:
        copy, original = place(copies[k], 0), place(array, 0)
        copy, original = seen_as(copy, array.size, array.dtype), seen_as(original, array.size, array.dtype)
        first, last = share_of(team, array.size)
        there, here = (copy, original) if is_kept else (original, copy)
        copy_all(there[first:last], here[first:last])
    wait(team)
