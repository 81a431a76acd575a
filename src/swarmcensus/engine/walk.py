"""Bodies that walk, tick by tick: proximity, random walk, avoidance, contact, ground sensor, radio. No minds.

The model is in docs/moving-robots.md. Positions are in metres, the arena's centre at 0; a heading is kept as
its cosine and sine, so that turning is a rotation by a constant angle. `body` is `Body.numbers` (bodies.py).
"""

import math

import numpy as np

from swarmcensus.engine.compiler import compiled, entry
from swarmcensus.engine.random import block, counter, unit

STAND, STRAIGHT, LEFT, RIGHT = 0, 1, 2, 3
RAYS = 8
RAY_X = np.array([math.cos(k * math.pi / 4) for k in range(RAYS)])
RAY_Y = np.array([math.sin(k * math.pi / 4) for k in range(RAYS)])
ALL_PAIRS = 48  # robots up to which looking at every pair is quicker than a grid
CONTACT = 1e-6  # metres of overlap that contact leaves
SWEEPS = 200
PLACINGS = 10_000  # tries to place one robot

# columns of a robot's state
X, Y, COS, SIN, SPEED, TURN, MOVE, LEFT_TICKS, AVOIDING = range(9)
STATE = 9


@compiled
def cells_of(state, half, size, heads, following):
    """Sort robots into a grid of square cells as linked lists; returns the cells along a side."""
    side = heads.shape[0]
    heads[:, :] = -1
    for i in range(state.shape[0] - 1, -1, -1):
        a = min(max(int((state[i, X] + half) / size), 0), side - 1)
        b = min(max(int((state[i, Y] + half) / size), 0), side - 1)
        following[i] = heads[a, b]
        heads[a, b] = i


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
            a = min(int((x + half) / size), side - 1)
            b = min(int((y + half) / size), side - 1)
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
def meets(state, i, others, count, d2, j, reach2):
    """Robot j is put on robot i's list where it is within reach; returns the list's new length."""
    dx = state[j, X] - state[i, X]
    dy = state[j, Y] - state[i, Y]
    square = dx * dx + dy * dy
    if square < reach2:
        others[count] = j
        d2[count] = square
        return count + 1
    return count


@compiled
def neighbourhoods(state, half, reach, first, others, d2, heads, following):
    """All robots within `reach` of each robot i: others[first[i]: first[i + 1]], squared distances in `d2`.

    The lists must be long enough for as many as fit. The cost is linear in the robots.
    """
    robots = state.shape[0]
    reach2 = reach * reach
    count = 0
    if robots <= ALL_PAIRS:
        for i in range(robots):
            first[i] = count
            for j in range(i):
                count = meets(state, i, others, count, d2, j, reach2)
            for j in range(i + 1, robots):
                count = meets(state, i, others, count, d2, j, reach2)
        first[robots] = count
        return
    size = 2.0 * half / heads.shape[0]
    side = heads.shape[0]
    cells_of(state, half, size, heads, following)
    for i in range(robots):
        first[i] = count
        a = min(max(int((state[i, X] + half) / size), 0), side - 1)
        b = min(max(int((state[i, Y] + half) / size), 0), side - 1)
        for m in range(max(a - 1, 0), min(a + 2, side)):
            for n in range(max(b - 1, 0), min(b + 2, side)):
                j = heads[m, n]
                while j >= 0:
                    if j != i:
                        count = meets(state, i, others, count, d2, j, reach2)
                    j = following[j]
        # in order of robots, whatever the cells
        for e in range(first[i] + 1, count):
            j, square = others[e], d2[e]
            g = e
            while g > first[i] and others[g - 1] > j:
                others[g], d2[g] = others[g - 1], d2[g - 1]
                g -= 1
            others[g], d2[g] = j, square
    first[robots] = count


@compiled
def ray_to_wall(px, py, dx, dy, half):
    """How far from p along the unit vector d the nearest wall is."""
    far = np.inf
    if abs(dx) > 1e-12:
        far = (math.copysign(half, dx) - px) / dx
    if abs(dy) > 1e-12:
        far = min(far, (math.copysign(half, dy) - py) / dy)
    return max(far, 0.0)


@compiled
def ray_to_disc(px, py, dx, dy, qx, qy, radius):
    """How far from p along the unit vector d a disc around q is; infinite where the ray misses it."""
    ax = qx - px
    ay = qy - py
    gap = ax * ax + ay * ay - radius * radius
    if gap <= 0.0:
        return 0.0
    along = ax * dx + ay * dy
    under = along * along - gap
    if along <= 0.0 or under < 0.0:
        return np.inf
    return along - math.sqrt(under)


@compiled
def obstacle(state, i, body, half, first, others, d2):
    """The mean of the proximity ring's readings, as a vector in the body's frame."""
    x = state[i, X]
    y = state[i, Y]
    radius = body.radius
    reach = radius + body.proximity_range
    touching = (reach + radius) * (reach + radius)
    walls = max(abs(x), abs(y)) > half - reach
    close = False
    for e in range(first[i], first[i + 1]):
        close |= d2[e] < touching
    ahead = 0.0
    aside = 0.0
    if not (walls or close):
        return ahead, aside
    for k in range(RAYS):
        dx = state[i, COS] * RAY_X[k] - state[i, SIN] * RAY_Y[k]
        dy = state[i, SIN] * RAY_X[k] + state[i, COS] * RAY_Y[k]
        px = x + radius * dx
        py = y + radius * dy
        d = ray_to_wall(px, py, dx, dy, half) if walls else np.inf
        if close:
            for e in range(first[i], first[i + 1]):
                if d2[e] < touching:
                    d = min(d, ray_to_disc(px, py, dx, dy, state[others[e], X], state[others[e], Y], radius))
        if d < body.proximity_near:
            ahead += RAY_X[k]
            aside += RAY_Y[k]
        elif d <= body.proximity_range:
            seen = min(max(4.14 * math.exp(-33.0 * d) - 0.085, 0.0), 1.0)
            ahead += seen * RAY_X[k]
            aside += seen * RAY_Y[k]
    return ahead / RAYS, aside / RAYS


@compiled
def decide(state, i, body, half, first, others, d2, key, trial, tick):
    """What robot i does in this tick, and whether it avoids an obstacle (and so makes no observation)."""
    ahead, aside = obstacle(state, i, body, half, first, others, d2)
    angle = math.atan2(aside, ahead)
    if ahead * ahead + aside * aside >= body.avoid_above * body.avoid_above and abs(angle) < body.avoid_within:
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
def go(state, i, share, body):
    """Robot i moves on with its speed and turn for a share of a tick."""
    turn = state[i, TURN] * share
    if turn != 0.0:
        c = math.cos(turn)
        s = math.sin(turn)
        cosine = state[i, COS] * c - state[i, SIN] * s
        sine = state[i, SIN] * c + state[i, COS] * s
        stretch = 1.5 - 0.5 * (cosine * cosine + sine * sine)  # one step of Newton's: rounding must not grow
        state[i, COS] = cosine * stretch
        state[i, SIN] = sine * stretch
    way = state[i, SPEED] * share
    state[i, X] += way * state[i, COS]
    state[i, Y] += way * state[i, SIN]


@compiled
def part(state, body, half, first, others):
    """Push apart what overlaps, robots by halves and off the walls, until nothing does."""
    limit = half - body.radius
    apart = 2.0 * body.radius
    for _ in range(SWEEPS):
        worst = 0.0
        for i in range(state.shape[0]):
            state[i, X] = min(max(state[i, X], -limit), limit)
            state[i, Y] = min(max(state[i, Y], -limit), limit)
            for e in range(first[i], first[i + 1]):
                j = others[e]
                if j < i:
                    dx = state[i, X] - state[j, X]
                    dy = state[i, Y] - state[j, Y]
                    square = dx * dx + dy * dy
                    if square < apart * apart:
                        d = math.sqrt(square)
                        overlap = apart - d
                        worst = max(worst, overlap)
                        push = 0.5 * overlap / max(d, 1e-9)
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
def in_sight(state, i, e, first, last, others, d2, radius):
    """Whether no other robot's disc lies across the line from robot i to the one at place e of its list."""
    dx = state[others[e], X] - state[i, X]
    dy = state[others[e], Y] - state[i, Y]
    square = d2[e]
    for g in range(first, last):
        if g != e and d2[g] < square + radius * radius:
            ax = state[others[g], X] - state[i, X]
            ay = state[others[g], Y] - state[i, Y]
            along = ax * dx + ay * dy
            if 0.0 < along < square:
                across = ax * dy - ay * dx
                if across * across < radius * radius * square:
                    return False
    return True


@entry
def look_around(state, bodies, half, first, others, d2, heads, following):
    """The neighbourhoods of robots that have just been placed."""
    neighbourhoods(state, half, bodies[0].reach, first, others, d2, heads, following)


@entry
def walk(
    state, bodies, half, key, trial, tick, looked, tiles, heard, links_i, links_j, poses,
    first, others, d2, heads, following, stop,
):  # fmt: skip
    """Walk from `tick` on, a tick for each row of `looked`; returns the ticks done, fewer where links are full.

    Fills, for each tick: looked (robot): whether an observation is made; tiles (robot, 2): the tile under the
    ground sensor; heard[k]: where its links begin in (links_i, links_j), i < j; poses (robot, 3) of x, y and
    heading where it has rows. `first`, `others`, `d2` hold the neighbourhoods of the state and are kept so.
    """
    body = bodies[0]
    robots = state.shape[0]
    radio2 = body.radio_range * body.radio_range
    used = 0
    for k in range(looked.shape[0]):
        if stop[0] != 0 or used + others.size // 2 > links_i.size:
            return k
        for i in range(robots):
            move, avoiding = decide(state, i, body, half, first, others, d2, key, trial, tick + k)
            looked[k, i] = not avoiding
            go(state, i, body.lag, body)  # the wheels answer late: at first the last tick's motion goes on
            state[i, SPEED] = body.step if move == STRAIGHT else 0.0
            state[i, TURN] = body.turn if move == LEFT else (-body.turn if move == RIGHT else 0.0)
            go(state, i, 1.0 - body.lag, body)
        part(state, body, half, first, others)
        neighbourhoods(state, half, body.reach, first, others, d2, heads, following)
        heard[k] = used
        for i in range(robots):
            tiles[k, i, 0] = math.floor(
                (state[i, X] + body.sensor_x * state[i, COS] - body.sensor_y * state[i, SIN]) / body.tile
            )
            tiles[k, i, 1] = math.floor(
                (state[i, Y] + body.sensor_x * state[i, SIN] + body.sensor_y * state[i, COS]) / body.tile
            )
            for e in range(first[i], first[i + 1]):
                if others[e] > i and d2[e] < radio2:
                    if body.line_of_sight == 0.0 or in_sight(
                        state, i, e, first[i], first[i + 1], others, d2, body.radius
                    ):
                        links_i[used] = i
                        links_j[used] = others[e]
                        used += 1
            if poses.shape[0] > 0:
                poses[k, i, 0] = state[i, X]
                poses[k, i, 1] = state[i, Y]
                poses[k, i, 2] = math.atan2(state[i, SIN], state[i, COS])
        heard[k + 1] = used
    return looked.shape[0]
