"""Who is near whom, and in sight: lists that last some ticks, and distances measured along them in each tick.

Lists reach a skin further than robots do, so they are made again only once a robot has gone half the skin. Whether they
are too old is checked right before use: nobody within reach is ever missing (Verlet lists, as in molecular dynamics).
Indices are unsigned: Numba then does not check for negative ones.
"""

import numpy as np

from swarmcensus.engine.compiling import loop
from swarmcensus.engine.constants import ALL_PAIRS, X, Y

SURE = 0.99  # share of the squared skin, so that rounding loses no neighbour


@loop(forceinline=True)
def cell(x, half, size, side):
    """The cell of a grid with `side` cells that a coordinate lies in."""
    return min(max(int((x + half) / size), 0), side - 1)


@loop(forceinline=True)
def sort_into_cells(state, half, size, heads, following):
    """Put the robots into square cells, as linked lists."""
    side = heads.shape[0]
    heads[:, :] = -1
    for i in range(state.shape[1] - 1, -1, -1):
        a, b = cell(state[X, i], half, size, side), cell(state[Y, i], half, size, side)
        following[i] = heads[a, b]
        heads[a, b] = i


@loop(forceinline=True)
def square_distance(state, i, j):
    """The squared distance between the centres of two robots."""
    dx, dy = state[X, j] - state[X, i], state[Y, j] - state[Y, i]
    return dx * dx + dy * dy


@loop()
def list_pairs(state, half, reach, neighbours):
    """List the pairs within `reach`, each once: others[first[i]: first[i + 1]] are those of i with j > i, in order.

    Robot i gets the places from room[i] to room[i + 1], one for each robot within reach. The cost is linear in the
    number of robots.
    """
    first, others, room = neighbours.first, neighbours.others, neighbours.room
    heads, following = neighbours.heads, neighbours.following
    robots, reach2, side = state.shape[1], reach * reach, heads.shape[0]
    size, crowd = 2.0 * half / side, robots > ALL_PAIRS
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


@loop()
def measure(state, reach2, close2, neighbours):
    """Find who is within reach of robot i: near[room[i]: room[i] + around[i]], in order, the first lower[i] below i.

    gaps[:, e] are dx and dy to the robot near[e]. Fills `close` with the pairs so near that they may touch by the end
    of the next tick, and returns how many they are.
    """
    first, others, room, around = neighbours.first, neighbours.others, neighbours.room, neighbours.around
    lower, near, gaps, close = neighbours.lower, neighbours.near, neighbours.gaps, neighbours.close
    robots = state.shape[1]
    touching = np.uint64(0)
    around[:] = 0
    for i in range(robots):
        x, y = state[X, i], state[Y, i]
        lower[i] = around[i]
        place = room[i] + around[i]
        for e in range(first[i], first[i + 1]):
            j = others[e]
            dx, dy = state[X, j] - x, state[Y, j] - y
            square = dx * dx + dy * dy
            if square < reach2:
                other_place = room[j] + around[j]
                near[place] = j
                gaps[0, place], gaps[1, place] = dx, dy
                place += np.uint64(1)
                near[other_place] = i
                gaps[0, other_place], gaps[1, other_place] = -dx, -dy
                around[j] += np.uint64(1)
                close[touching, 0], close[touching, 1] = i, j
                touching += np.uint64(square < close2)
        around[i] = place - room[i]
    return touching


@loop(forceinline=True)
def have_strayed(state, anchors, skin):
    """Whether any robot has moved nearly half the skin since the lists were made.

    `anchors` (2, robot) is where robots were then; infinity before the first lists.
    """
    strayed = False
    for i in range(state.shape[1]):
        dx, dy = state[X, i] - anchors[X, i], state[Y, i] - anchors[Y, i]
        strayed |= 4.0 * (dx * dx + dy * dy) > SURE * skin * skin
    return strayed


@loop()
def look_around(bodies, neighbours):
    """Measure who is near whom, along new lists if robots have moved too far since the old ones were made."""
    state, body, anchors = bodies.state, bodies.body[0], neighbours.anchors
    if have_strayed(state, anchors, body.skin):
        list_pairs(state, bodies.half, body.reach + body.skin, neighbours)
        for i in range(state.shape[1]):
            anchors[X, i], anchors[Y, i] = state[X, i], state[Y, i]
    neighbours.pairs[0] = measure(state, body.reach * body.reach, body.touched * body.touched, neighbours)


@loop(forceinline=True)
def in_sight(dx, dy, first, last, gaps, radius):
    """Whether no disc at places first ... last - 1 crosses the line to a robot at dx and dy."""
    square = dx * dx + dy * dy
    wide = radius * radius * square
    blocked = False
    for g in range(first, last):  # the robot itself is exactly `square` along, so it is not between
        along = gaps[0, g] * dx + gaps[1, g] * dy
        across = gaps[0, g] * dy - gaps[1, g] * dx
        blocked |= (along > 0.0) & (along < square) & (across * across < wide)
    return not blocked


@loop(forceinline=True)
def listen(i, radio2, blind, radius, neighbours):
    """Note in `ears` which of robot i and higher robots hear each other; then i has all that it hears.

    Robot i hears ears[room[i]: room[i] + hears[i]], in order if this is called for robots 0, 1, 2, ... With `blind`,
    radio passes through robots.
    """
    room, around, lower, near = neighbours.room, neighbours.around, neighbours.lower, neighbours.near
    gaps, hears, ears = neighbours.gaps, neighbours.hears, neighbours.ears
    start = room[i]
    end = start + around[i]
    for e in range(start + lower[i], end):
        dx, dy = gaps[0, e], gaps[1, e]
        if dx * dx + dy * dy < radio2:
            seen = np.uint64(blind or in_sight(dx, dy, start, end, gaps, radius))
            j = near[e]
            ears[start + hears[i]] = j
            hears[i] += seen
            ears[room[j] + hears[j]] = i
            hears[j] += seen
