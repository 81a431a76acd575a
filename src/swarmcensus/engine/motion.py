"""How robots move: proximity, random walk, avoidance, wheels, contact.

`body` is `Body.numbers` (bodies.py). A heading is kept as its cosine and sine, so that turning is a rotation.
"""

import math

import numpy as np

from swarmcensus.engine.compiling import loop
from swarmcensus.engine.constants import (
    AVOIDING,
    COS,
    COS_LATE,
    COS_THEN,
    LEFT_TICKS,
    MOVE,
    SIN,
    SIN_LATE,
    SIN_THEN,
    SPEED,
    TURN,
    X,
    Y,
)
from swarmcensus.engine.random import block, counter, unit

STAND, STRAIGHT, LEFT, RIGHT = 0, 1, 2, 3
RAYS = 8
AHEAD = tuple(np.arange(4))  # the first ray of each opposite pair; a tuple, as literals would each be compiled
DIAGONAL = math.sqrt(0.5)
RAY_X = np.array([1.0, DIAGONAL, 0.0, -DIAGONAL, -1.0, -DIAGONAL, 0.0, DIAGONAL])
RAY_Y = np.array([0.0, DIAGONAL, 1.0, DIAGONAL, 0.0, -DIAGONAL, -1.0, -DIAGONAL])
CONTACT = 1e-6  # metres of overlap that contact may leave; for small bodies,
CONTACT_OF_RADIUS = 2e-5
TINY = 1e-12  # avoids a division by zero for a ray along a wall
SWEEPS = 400
STRAIGHT_SWEEPS = 100  # then pushes are tilted by 45 degrees, so that a row jammed along a wall bends


@loop(forceinline=True)
def walls_along(k, dx, dy, x, y, half, rays):
    """Set rays k and k + 4, of direction (dx, dy) and opposite, to their lengths from (x, y) to the walls."""
    per_x, per_y = 1.0 / max(abs(dx), TINY), 1.0 / max(abs(dy), TINY)
    along_x = x if dx > 0.0 else -x
    along_y = y if dy > 0.0 else -y
    rays[k] = min((half - along_x) * per_x, (half - along_y) * per_y)
    rays[k + 4] = min((half + along_x) * per_x, (half + along_y) * per_y)


@loop(forceinline=True)
def disc_along(k, along, across, radius, rays):
    """Shorten rays k and k + 4, on one line, to a disc at the distances `along` and across that line."""
    under = radius * radius - across * across
    hit = abs(along) - math.sqrt(max(under, 0.0))
    hit = hit if under >= 0.0 else np.inf
    rays[k] = min(rays[k], hit if along > 0.0 else np.inf)
    rays[k + 4] = min(rays[k + 4], np.inf if along > 0.0 else hit)


@loop()
def obstacle(state, i, body, half, first, last, gaps, rays, which):
    """The mean of the proximity ring's readings, as a vector in the body's frame; `rays` is room for the ring."""
    ahead = aside = 0.0
    reach = body.radius + body.proximity_range
    x, y = state[X, i], state[Y, i]
    c, s = state[COS, i], state[SIN, i]
    met = max(abs(x), abs(y)) > half - reach
    if met:
        walls_along(AHEAD[0], c, s, x, y, half, rays)
        walls_along(AHEAD[1], (c - s) * DIAGONAL, (s + c) * DIAGONAL, x, y, half, rays)
        walls_along(AHEAD[2], -s, c, x, y, half, rays)
        walls_along(AHEAD[3], -(s + c) * DIAGONAL, (c - s) * DIAGONAL, x, y, half, rays)
    for e in range(first, last):
        gx, gy = gaps[0, e], gaps[1, e]
        if gx * gx + gy * gy < (reach + body.radius) * (reach + body.radius):
            if not met:
                met = True
                for k in range(RAYS):
                    rays[k] = np.inf
            forth, left = c * gx + s * gy, c * gy - s * gx
            disc_along(AHEAD[0], forth, left, body.radius, rays)
            disc_along(AHEAD[1], (forth + left) * DIAGONAL, (left - forth) * DIAGONAL, body.radius, rays)
            disc_along(AHEAD[2], left, forth, body.radius, rays)
            disc_along(AHEAD[3], (left - forth) * DIAGONAL, (forth + left) * DIAGONAL, body.radius, rays)
    if met:
        hits = 0
        for k in range(RAYS):
            which[hits] = k
            hits += rays[k] - body.radius <= body.proximity_range
        for hit in range(hits):
            k = which[hit]
            d = rays[k] - body.radius
            seen = min(max(4.14 * math.exp(-33.0 * d) - 0.085, 0.0), 1.0)
            seen = 1.0 if d < body.proximity_near else seen
            ahead += seen * RAY_X[k]
            aside += seen * RAY_Y[k]
    return ahead / RAYS, aside / RAYS


@loop(forceinline=True)
def decide(state, i, body, half, first, last, gaps, rays, which, key, trial, tick):
    """The action of robot i in this tick, and whether it avoids an obstacle (and so makes no observation)."""
    ahead, aside = obstacle(state, i, body, half, first, last, gaps, rays, which)
    square = ahead * ahead + aside * aside
    if square >= body.avoid_above * body.avoid_above and ahead > body.cos_within * math.sqrt(square):
        state[AVOIDING, i] = state[AVOIDING, i] % 60.0 + 1.0
        state[LEFT_TICKS, i] = 0.0
        return (RIGHT if state[AVOIDING, i] > 30.0 or aside > 0.0 else LEFT), True
    state[AVOIDING, i] = 0.0
    if state[LEFT_TICKS, i] == 0.0:
        p, q = block(key[0], key[1], counter(trial, tick), counter(np.int64(0), i))
        if p >> np.uint64(63) == np.uint64(0):
            state[MOVE, i] = STRAIGHT
            ticks = math.floor(-body.straight_mean * math.log(1.0 - unit(q)))
        else:
            state[MOVE, i] = LEFT if (p >> np.uint64(62)) & np.uint64(1) == np.uint64(0) else RIGHT
            ticks = math.floor(unit(q) * (body.turn_most + 1.0))
            if ticks == 0.0:
                state[MOVE, i] = STAND
        state[LEFT_TICKS, i] = max(ticks, 1.0)
    state[LEFT_TICKS, i] -= 1.0
    return int(state[MOVE, i]), False


@loop(forceinline=True)
def turn_by(turn, lag, out):
    """Fill `out` with the cosine and sine of the part of a turn before new wheel speeds take hold, and after."""
    out[0], out[1] = math.cos(turn * lag), math.sin(turn * lag)
    out[2], out[3] = math.cos(turn * (1.0 - lag)), math.sin(turn * (1.0 - lag))


@loop(forceinline=True)
def set_wheels(state, i, body, turns, speed, turn):
    """Set the motion of robot i: `speed` metres and `turn` radians per tick.

    `turns` (which, 4) holds what `turn_by` says of the turn that most make, to the left and to the right: these take
    as long as all else that a wheel does.
    """
    state[SPEED, i] = speed
    if turn != state[TURN, i]:
        state[TURN, i] = turn
        which = 0 if turn == body.turn else (1 if turn == -body.turn else 2)
        if which == 2:
            turn_by(turn, body.lag, turns[2])
        state[COS_LATE, i], state[SIN_LATE, i] = turns[which, 0], turns[which, 1]
        state[COS_THEN, i], state[SIN_THEN, i] = turns[which, 2], turns[which, 3]


@loop(forceinline=True)
def go(state, i, share, cosine, sine):
    """Move robot i for a part of a tick; `c` and `s` are the cosine and sine of its turn in that part."""
    c = state[COS, i] * cosine - state[SIN, i] * sine
    s = state[SIN, i] * cosine + state[COS, i] * sine
    stretch = 1.5 - 0.5 * (c * c + s * s)  # one Newton step keeps the heading a unit vector
    state[COS, i], state[SIN, i] = c * stretch, s * stretch
    state[X, i] += state[SPEED, i] * share * state[COS, i]
    state[Y, i] += state[SPEED, i] * share * state[SIN, i]


@loop(forceinline=True)
def keep_inside(state, i, limit):
    """Push a robot's centre off the walls."""
    state[X, i] = min(max(state[X, i], -limit), limit)
    state[Y, i] = min(max(state[Y, i], -limit), limit)


@loop()
def part(state, body, limit, close, pairs, pushed, sweep):
    """Push apart what overlaps, robots by halves and off the walls, until nothing does; returns SWEEPS then.

    A sweep's pushes may bring others together, or into a wall, which the next sweep finds. Only the `pairs` of robots
    in `close` are looked at. Once a robot is `pushed` (robot) so far that it may touch another, this ends early, and
    returns the number of the next sweep.
    """
    apart = 2.0 * body.radius
    most = body.step + 0.1 * body.radius  # slightly less than `Body.touched` allows
    bearable = min(CONTACT, CONTACT_OF_RADIUS * body.radius)
    pushed[:] = 0.0
    while sweep < SWEEPS:
        sweep += 1
        worst = furthest = 0.0
        for e in range(pairs):
            i, j = close[e, 0], close[e, 1]
            dx, dy = state[X, j] - state[X, i], state[Y, j] - state[Y, i]
            square = dx * dx + dy * dy
            if square < apart * apart:
                d = math.sqrt(square)
                worst = max(worst, apart - d)
                if d < 1e-9 * apart:  # at one place, such as a corner: each pair is pushed in its own direction
                    dx, dy, d = math.cos(float(i)), math.sin(float(i)), 1.0
                    push = 0.5 * apart
                else:
                    push = 0.5 * (apart - d) / d
                    if sweep > STRAIGHT_SWEEPS:
                        dx, dy = dx - dy, dy + dx
                state[X, i] -= push * dx
                state[Y, i] -= push * dy
                state[X, j] += push * dx
                state[Y, j] += push * dy
                keep_inside(state, i, limit)
                keep_inside(state, j, limit)
                pushed[i] += push * d
                pushed[j] += push * d
                furthest = max(furthest, pushed[i], pushed[j])
        if worst < bearable:
            return SWEEPS
        if furthest > most:
            return sweep
    return SWEEPS
