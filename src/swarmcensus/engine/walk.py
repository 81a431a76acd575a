"""Bodies that walk, tick by tick: proximity, random walk, avoidance, contact, ground sensor, radio. No minds.

The model is in docs/moving-robots.md. Positions are in metres, the arena's centre at 0; a heading is kept as
its cosine and sine, so that turning is a rotation by a constant angle. `body` is `Body.numbers` (bodies.py).
"""

import math

import numpy as np

from swarmcensus.engine.compiler import compiled, entry
from swarmcensus.engine.modes import MOVING
from swarmcensus.engine.random import block, counter, unit

STAND, STRAIGHT, LEFT, RIGHT = 0, 1, 2, 3
RAYS = 8
RAY_X = np.array([math.cos(k * math.pi / 4) for k in range(RAYS)])
RAY_Y = np.array([math.sin(k * math.pi / 4) for k in range(RAYS)])
ALL_PAIRS = 48  # robots up to which looking at every pair is quicker than a grid
CONTACT = 1e-6  # metres of overlap that contact leaves
TINY = 1e-12  # keeps a ray along a wall from dividing by zero
SWEEPS = 200
SLACK = 0.02  # metres that contact may push a robot further than it goes by itself
PLACINGS = 10_000  # tries to place one robot

# columns of a robot's state
X, Y, COS, SIN, SPEED, TURN, MOVE, LEFT_TICKS, AVOIDING = range(9)
STATE = 9


@compiled
def cell(x, half, size, side):
    """Which of `side` cells of a grid a coordinate lies in."""
    return min(max(int((x + half) / size), 0), side - 1)


@compiled
def sort_into_cells(state, half, size, heads, following):
    """Put the robots into square cells, as linked lists."""
    side = heads.shape[0]
    heads[:, :] = -1
    for i in range(state.shape[0] - 1, -1, -1):
        a, b = cell(state[i, X], half, size, side), cell(state[i, Y], half, size, side)
        following[i] = heads[a, b]
        heads[a, b] = i


@compiled
def square_distance(state, i, j):
    """Between the centres of two robots."""
    dx = state[j, X] - state[i, X]
    dy = state[j, Y] - state[i, Y]
    return dx * dx + dy * dy


@entry
def place(state, body, half, key, trial):
    """Put robots anywhere without touching, headings uniform; False where there is no room left."""
    radius = body[0].radius
    robots = state.shape[0]
    size = max(2.0 * radius, half / math.sqrt(robots))
    side = int(2.0 * half / size) + 1
    heads = np.full((side, side), -1, np.int64)
    following = np.full(robots, -1, np.int64)
    for i in range(robots):
        for attempt in range(PLACINGS + 1):
            if attempt == PLACINGS:
                return False
            p, q = block(key[0], key[1], counter(trial, attempt), counter(1, i))
            x = (2.0 * unit(p) - 1.0) * (half - radius)
            y = (2.0 * unit(q) - 1.0) * (half - radius)
            a, b = cell(x, half, size, side), cell(y, half, size, side)
            free = True
            for m in range(max(a - 1, 0), min(a + 2, side)):
                for n in range(max(b - 1, 0), min(b + 2, side)):
                    j = heads[m, n]
                    while j >= 0 and free:
                        dx = x - state[j, X]
                        dy = y - state[j, Y]
                        free = dx * dx + dy * dy >= 4.0 * radius * radius
                        j = following[j]
            if free:
                break
        state[i, :] = 0.0
        state[i, X] = x
        state[i, Y] = y
        following[i] = heads[a, b]
        heads[a, b] = i
        p, _ = block(key[0], key[1], counter(trial, 0), counter(2, i))
        state[i, COS] = math.cos(2.0 * math.pi * unit(p))
        state[i, SIN] = math.sin(2.0 * math.pi * unit(p))
    return True


@compiled
def list_others(state, half, reach, first, others, mirror, heads, following):
    """List for each robot i the robots within `reach`, in order: others[first[i]: first[i + 1]].

    mirror[e] is the place of robot i on the list of others[e]. The lists must be long enough for as many as fit.
    The cost is linear in the robots.
    """
    robots = state.shape[0]
    reach2 = reach * reach
    side = heads.shape[0]
    size = 2.0 * half / side
    crowd = robots > ALL_PAIRS
    if crowd:
        sort_into_cells(state, half, size, heads, following)
    count = 0
    for i in range(robots):
        first[i] = count
        if not crowd:
            for j in range(robots):
                if j != i and square_distance(state, i, j) < reach2:
                    others[count] = j
                    count += 1
            continue
        a, b = cell(state[i, X], half, size, side), cell(state[i, Y], half, size, side)
        for m in range(max(a - 1, 0), min(a + 2, side)):
            for n in range(max(b - 1, 0), min(b + 2, side)):
                j = heads[m, n]
                while j >= 0:
                    if j != i and square_distance(state, i, j) < reach2:
                        g = count
                        while g > first[i] and others[g - 1] > j:
                            others[g] = others[g - 1]
                            g -= 1
                        others[g] = j
                        count += 1
                    j = following[j]
    first[robots] = count
    for i in range(robots):  # robot i meets the lists of lower robots in their order: its own
        following[i] = first[i]
    for i in range(robots):
        for e in range(first[i], first[i + 1]):
            mirror[e] = following[others[e]]
            following[others[e]] += 1


@compiled
def measure(state, first, others, mirror, gaps):
    """Where every listed robot is, as seen from the one whose list it is on: gaps of rows dx, dy, d^2."""
    for i in range(state.shape[0]):
        for e in range(first[i], first[i + 1]):
            if others[e] > i:
                dx = state[others[e], X] - state[i, X]
                dy = state[others[e], Y] - state[i, Y]
                m = mirror[e]
                gaps[0, e] = dx
                gaps[1, e] = dy
                gaps[2, e] = dx * dx + dy * dy
                gaps[0, m] = -dx
                gaps[1, m] = -dy
                gaps[2, m] = gaps[2, e]


@compiled
def obstacle(state, i, body, half, first, last, gaps, rays):
    """The mean of the proximity ring's readings, as a vector in the body's frame.

    `rays` is room for rows of a ray's direction and of the distance from the centre to what it hits first.
    """
    x = state[i, X]
    y = state[i, Y]
    radius = body.radius
    reach = radius + body.proximity_range
    touching = (reach + radius) * (reach + radius)
    walls = max(abs(x), abs(y)) > half - reach
    close = False
    for e in range(first, last):
        close |= gaps[2, e] < touching
    ahead = 0.0
    aside = 0.0
    if not (walls or close):
        return ahead, aside
    for k in range(RAYS):
        dx = state[i, COS] * RAY_X[k] - state[i, SIN] * RAY_Y[k]
        dy = state[i, SIN] * RAY_X[k] + state[i, COS] * RAY_Y[k]
        rays[0, k] = dx
        rays[1, k] = dy
        wall_x = (half - math.copysign(x, x * dx)) / (abs(dx) + TINY)
        wall_y = (half - math.copysign(y, y * dy)) / (abs(dy) + TINY)
        rays[2, k] = min(wall_x, wall_y)
    if close:
        for e in range(first, last):
            if gaps[2, e] < touching:
                gx = gaps[0, e]
                gy = gaps[1, e]
                miss = radius * radius - gaps[2, e]
                for k in range(RAYS):
                    along = gx * rays[0, k] + gy * rays[1, k]
                    under = along * along + miss
                    hit = along - math.sqrt(max(under, 0.0))
                    rays[2, k] = hit if (along > 0.0) & (under >= 0.0) & (hit < rays[2, k]) else rays[2, k]
    for k in range(RAYS):
        d = rays[2, k] - radius
        if d <= body.proximity_range:
            seen = 1.0
            if d >= body.proximity_near:
                seen = min(max(4.14 * math.exp(-33.0 * d) - 0.085, 0.0), 1.0)
            ahead += seen * RAY_X[k]
            aside += seen * RAY_Y[k]
    return ahead / RAYS, aside / RAYS


@compiled
def decide(state, i, body, half, first, last, gaps, rays, key, trial, tick):
    """What robot i does in this tick, and whether it avoids an obstacle (and so makes no observation)."""
    ahead, aside = obstacle(state, i, body, half, first, last, gaps, rays)
    if ahead * ahead + aside * aside >= body.avoid_above * body.avoid_above:
        angle = math.atan2(aside, ahead)
        if abs(angle) < body.avoid_within:
            state[i, AVOIDING] = state[i, AVOIDING] % 60.0 + 1.0
            state[i, LEFT_TICKS] = 0.0
            return (RIGHT if state[i, AVOIDING] > 30.0 or angle > 0.0 else LEFT), True
    state[i, AVOIDING] = 0.0
    if state[i, LEFT_TICKS] == 0.0:
        p, q = block(key[0], key[1], counter(trial, tick), counter(0, i))
        if p >> np.uint64(63) == np.uint64(0):
            state[i, MOVE] = STRAIGHT
            ticks = math.floor(-body.straight_mean * math.log(1.0 - unit(q)))
        else:
            state[i, MOVE] = LEFT if (p >> np.uint64(62)) & np.uint64(1) == np.uint64(0) else RIGHT
            ticks = math.floor(unit(q) * (body.turn_most + 1.0))
            if ticks == 0.0:
                state[i, MOVE] = STAND
        state[i, LEFT_TICKS] = max(ticks, 1.0)
    state[i, LEFT_TICKS] -= 1.0
    return int(state[i, MOVE]), False


@compiled
def go(state, i, share, cosine, sine):
    """Robot i moves on for a share of a tick, in which a turn has this cosine and sine."""
    if state[i, TURN] != 0.0:
        sine *= state[i, TURN]
        c = state[i, COS] * cosine - state[i, SIN] * sine
        s = state[i, SIN] * cosine + state[i, COS] * sine
        stretch = 1.5 - 0.5 * (c * c + s * s)  # a step of Newton's: rounding must not grow
        state[i, COS] = c * stretch
        state[i, SIN] = s * stretch
    state[i, X] += state[i, SPEED] * share * state[i, COS]
    state[i, Y] += state[i, SPEED] * share * state[i, SIN]


@compiled
def part(state, body, half, first, others, gaps):
    """Push apart what overlaps, robots by halves and off the walls, until nothing does.

    Only pairs that were close a tick ago can touch, however they moved. A sweep's pushes may bring others
    together, which the next sweep finds.
    """
    limit = half - body.radius
    apart = 2.0 * body.radius
    close = apart + 4.0 * body.step + SLACK
    for _ in range(SWEEPS):
        worst = 0.0
        for i in range(state.shape[0]):
            state[i, X] = min(max(state[i, X], -limit), limit)
            state[i, Y] = min(max(state[i, Y], -limit), limit)
            for e in range(first[i], first[i + 1]):
                if others[e] < i and gaps[2, e] < close * close:
                    j = others[e]
                    dx = state[i, X] - state[j, X]
                    dy = state[i, Y] - state[j, Y]
                    square = dx * dx + dy * dy
                    if square < apart * apart:
                        d = math.sqrt(square)
                        worst = max(worst, apart - d)
                        push = 0.5 * (apart - d) / max(d, 1e-9)
                        state[i, X] += push * dx
                        state[i, Y] += push * dy
                        state[j, X] -= push * dx
                        state[j, Y] -= push * dy
        if worst < CONTACT:
            break
    for i in range(state.shape[0]):
        state[i, X] = min(max(state[i, X], -limit), limit)
        state[i, Y] = min(max(state[i, Y], -limit), limit)


@compiled
def in_sight(e, first, last, gaps, radius):
    """Whether no other robot's disc lies across the line to the one at place e of a list first ... last - 1."""
    dx = gaps[0, e]
    dy = gaps[1, e]
    square = gaps[2, e]
    wide = radius * radius * square
    blocked = False
    for g in range(first, last):  # the one at place e itself is exactly `square` along, and so is not between
        along = gaps[0, g] * dx + gaps[1, g] * dy
        across = gaps[0, g] * dy - gaps[1, g] * dx
        blocked |= (along > 0.0) & (along < square) & (across * across < wide)
    return not blocked


@compiled
def has_strayed(state, anchors, skin):
    """Whether any robot has gone half the skin since the lists were made; `anchors` (robot, 2) is where it was."""
    for i in range(state.shape[0]):
        dx = state[i, X] - anchors[i, 0]
        dy = state[i, Y] - anchors[i, 1]
        if 4.0 * (dx * dx + dy * dy) > skin * skin:
            return True
    return False


@entry
def walk(
    state, bodies, half, key, trial, tick, looked, tiles, heard, senders, poses,
    anchors, first, others, mirror, gaps, sees, heads, following, stops, stop,
):  # fmt: skip
    """Walk from `tick` on, a tick for each row of `looked`; returns the ticks done, fewer where `senders` is full.

    Fills, for each tick: looked (robot): whether an observation is made; tiles (robot, 2): the tile under the
    ground sensor; heard: in the k-th of these ticks robot i hears senders[heard[k n + i]: heard[k n + i + 1]], in
    order; poses (robot, 3) of x, y and heading where it has rows. The lists of others are kept from call to call:
    they reach a skin further than robots do, and are made again once a robot has gone half of that.
    """
    body = bodies[0]
    robots = state.shape[0]
    radio2 = body.radio_range * body.radio_range
    blind = body.line_of_sight == 0.0  # to what stands between two robots
    rays = np.empty((3, RAYS))
    used = 0
    heard[0] = 0
    for k in range(looked.shape[0]):
        if stop[0] != 0 or used + others.size > senders.size:
            return k
        if tick + k == 1 or has_strayed(state, anchors, body.skin):
            list_others(state, half, body.reach + body.skin, first, others, mirror, heads, following)
            for i in range(robots):
                anchors[i, 0] = state[i, X]
                anchors[i, 1] = state[i, Y]
            measure(state, first, others, mirror, gaps)
        for i in range(robots):
            move, avoiding = STAND, False
            if stops.shape[1] == 0 or tick + k < stops[MOVING, i]:
                move, avoiding = decide(state, i, body, half, first[i], first[i + 1], gaps, rays, key, trial, tick + k)
            looked[k, i] = not avoiding
            # the wheels answer late: at first the last tick's motion goes on
            go(state, i, body.lag, body.cos_late, body.sin_late)
            state[i, SPEED] = body.step if move == STRAIGHT else 0.0
            state[i, TURN] = 1.0 if move == LEFT else (-1.0 if move == RIGHT else 0.0)
            go(state, i, 1.0 - body.lag, body.cos_then, body.sin_then)
        part(state, body, half, first, others, gaps)
        measure(state, first, others, mirror, gaps)
        for i in range(robots):
            for e in range(first[i], first[i + 1]):
                if others[e] > i:
                    near = gaps[2, e] < radio2
                    sees[e] = near and (blind or in_sight(e, first[i], first[i + 1], gaps, body.radius))
                    sees[mirror[e]] = sees[e]
        for i in range(robots):
            x = state[i, X] + body.sensor_x * state[i, COS] - body.sensor_y * state[i, SIN]
            y = state[i, Y] + body.sensor_x * state[i, SIN] + body.sensor_y * state[i, COS]
            tiles[k, i, 0] = math.floor(x / body.tile)
            tiles[k, i, 1] = math.floor(y / body.tile)
            for e in range(first[i], first[i + 1]):
                senders[used] = others[e]
                used += sees[e]
            heard[k * robots + i + 1] = used
            if poses.shape[0] > 0:
                poses[k, i, 0] = state[i, X]
                poses[k, i, 1] = state[i, Y]
                poses[k, i, 2] = math.atan2(state[i, SIN], state[i, COS])
    return looked.shape[0]
