"""Who is near whom, and in sight: lists that hold for some ticks, and what is measured along them in each.

Lists reach a skin further than robots do, so that they need making again only once a robot has gone half of it. They
are looked at right before they are used, at where robots are then: nobody within reach is ever missing.
Indices are unsigned: Numba then need not ask whether one counts from the end.
"""

import numpy as np

from swarmcensus.engine.compiling import compiled, loop
from swarmcensus.engine.constants import ALL_PAIRS, X, Y

SURE = 0.99  # of the square of the skin, so that rounding loses nobody


@compiled
def cell(x, half, size, side):
    """Which of `side` cells of a grid a coordinate lies in."""
    return min(max(int((x + half) / size), 0), side - 1)


@compiled
def sort_into_cells(state, half, size, heads, following):
    """Put the robots into square cells, as linked lists."""
    side = heads.shape[0]
    heads[:, :] = -1
    for i in range(state.shape[1] - 1, -1, -1):
        a, b = cell(state[X, i], half, size, side), cell(state[Y, i], half, size, side)
        following[i] = heads[a, b]
        heads[a, b] = i


@compiled
def square_distance(state, i, j):
    """Between the centres of two robots."""
    dx = state[X, j] - state[X, i]
    dy = state[Y, j] - state[Y, i]
    return dx * dx + dy * dy


@compiled
def list_pairs(state, half, reach, first, others, room, heads, following):
    """List the pairs within `reach`, each once: of robots j > i, in order, others[first[i]: first[i + 1]].

    From room[i] to room[i + 1] there are as many places as robot i has others within reach, lower or higher.
    The cost is linear in the robots.
    """
    robots = state.shape[1]
    reach2 = reach * reach
    side = heads.shape[0]
    size = 2.0 * half / side
    crowd = robots > ALL_PAIRS
    if crowd:
        sort_into_cells(state, half, size, heads, following)
    room[:] = 0
    count = 0
    for i in range(robots):
        first[i] = count
        if crowd:
            a, b = cell(state[X, i], half, size, side), cell(state[Y, i], half, size, side)
            for m in range(max(a - 1, 0), min(a + 2, side)):
                for n in range(max(b - 1, 0), min(b + 2, side)):
                    j = heads[m, n]
                    while j >= 0:
                        if j > i and square_distance(state, i, j) < reach2:
                            g = count
                            while g > first[i] and others[g - 1] > j:
                                others[g] = others[g - 1]
                                g -= 1
                            others[g] = j
                            count += 1
                            room[j + 1] += 1
                        j = following[j]
        else:
            for j in range(i + 1, robots):
                near = square_distance(state, i, j) < reach2
                others[count] = j
                count += near
                room[j + 1] += near
        room[i + 1] += count - first[i]
    first[robots] = count
    for i in range(robots):
        room[i + 1] += room[i]


@compiled
def measure(state, reach2, close2, first, others, room, around, lower, near, gaps, close):
    """Find who is within reach of robot i: near[room[i]: room[i] + around[i]], in order, the first lower[i] below i.

    gaps[:, e] are dx and dy to the robot near[e]. Returns how many pairs are so near that they may touch by the
    end of the next tick, which are the rows of `close`.
    """
    robots = state.shape[1]
    touching = np.uint64(0)
    around[:] = 0
    for i in range(robots):
        x = state[X, i]
        y = state[Y, i]
        lower[i] = around[i]
        mine = room[i] + around[i]
        for e in range(first[i], first[i + 1]):
            j = others[e]
            dx = state[X, j] - x
            dy = state[Y, j] - y
            square = dx * dx + dy * dy
            if square < reach2:
                its = room[j] + around[j]
                near[mine] = j
                gaps[0, mine] = dx
                gaps[1, mine] = dy
                mine += np.uint64(1)
                near[its] = i
                gaps[0, its] = -dx
                gaps[1, its] = -dy
                around[j] += np.uint64(1)
                close[touching, 0] = i
                close[touching, 1] = j
                touching += np.uint64(square < close2)
        around[i] = mine - room[i]
    return touching


@compiled
def have_strayed(state, anchors, skin):
    """Whether any robot has gone nearly half the skin since the lists were made.

    `anchors` (2, robot) is where robots were then: infinitely far away where there are no lists yet.
    """
    strayed = False
    for i in range(state.shape[1]):
        dx = state[X, i] - anchors[X, i]
        dy = state[Y, i] - anchors[Y, i]
        strayed |= 4.0 * (dx * dx + dy * dy) > SURE * skin * skin
    return strayed


@loop()
def look_around(state, body, half, anchors, first, others, room, around, lower, near, gaps, close, heads, following):
    """Measure who is near whom, as `measure` does, along new lists where the old ones are too old."""
    if have_strayed(state, anchors, body.skin):
        list_pairs(state, half, body.reach + body.skin, first, others, room, heads, following)
        for i in range(state.shape[1]):
            anchors[X, i] = state[X, i]
            anchors[Y, i] = state[Y, i]
    reach2 = body.reach * body.reach
    return measure(state, reach2, body.touched * body.touched, first, others, room, around, lower, near, gaps, close)


@compiled
def in_sight(dx, dy, first, last, gaps, radius):
    """Whether no disc of those at places first ... last - 1 lies across the line to a gap of dx and dy."""
    square = dx * dx + dy * dy
    wide = radius * radius * square
    blocked = False
    for g in range(first, last):  # the one at the gap itself is exactly `square` along, and so is not between
        along = gaps[0, g] * dx + gaps[1, g] * dy
        across = gaps[0, g] * dy - gaps[1, g] * dx
        blocked |= (along > 0.0) & (along < square) & (across * across < wide)
    return not blocked


@compiled
def listen(i, radio2, blind, radius, room, around, lower, near, gaps, hears, ears):
    """Add to `ears` whom robot i and higher ones hear of each other; those of i are then complete.

    Robot i hears ears[room[i]: room[i] + hears[i]], in order if this is called for one robot after the other.
    `blind` is for radios that whoever stands between does not stop.
    """
    start = room[i]
    end = start + around[i]
    for e in range(start + lower[i], end):
        dx = gaps[0, e]
        dy = gaps[1, e]
        if dx * dx + dy * dy < radio2:
            seen = np.uint64(blind or in_sight(dx, dy, start, end, gaps, radius))
            j = near[e]
            ears[start + hears[i]] = j
            hears[i] += seen
            ears[room[j] + hears[j]] = i
            hears[j] += seen
