"""Bodies that walk, tick by tick: where they start, how they move, which tile they are on, whom they hear. No states.

The model is in docs/moving-robots.md. Positions are in metres, the arena's centre at 0. `body` is `Body.numbers`
(bodies.py).
"""

import math

import numpy as np

from swarmcensus.engine.calling import blank_state
from swarmcensus.engine.compiling import counting_nothing
from swarmcensus.engine.constants import (
    COS,
    COS_LATE,
    COS_THEN,
    LEFT_TICKS,
    MOVING,
    PACE,
    SIN,
    SIN_LATE,
    SIN_THEN,
    X,
    Y,
)
from swarmcensus.engine.random import block, counter, unit
from swarmcensus.engine.records import record_type

from .failures import works
from .motion import LEFT, RAYS, RIGHT, STAND, STRAIGHT, SWEEPS, decide, go, keep_inside, part, set_wheels, turn_by
from .neighbours import cell, listen, look_around

PLACINGS = 10_000  # tries to place one robot
ROOM = record_type([("rays", "f8", (RAYS,)), ("which", "u1", (RAYS,)), ("turns", "f8", (3, 4))])  # on the stack


@counting_nothing
def place(bodies, trial, size, heads, following):
    """Put robots anywhere without touching, headings uniform; False where there is no room left.

    `bodies` have states of zeros. `heads` and `following` are as in `Neighbours`, of cells of this size without robots.
    """
    state, half, key, radius = bodies.state, bodies.half, bodies.key, bodies.body[0].radius
    robots, side = state.shape[1], heads.shape[0]
    for i in range(robots):
        for attempt in range(PLACINGS + 1):
            if attempt == PLACINGS:
                return False
            p, q = block(key[0], key[1], counter(trial, attempt), counter(np.int64(1), i))
            x = (2.0 * unit(p) - 1.0) * (half - radius)
            y = (2.0 * unit(q) - 1.0) * (half - radius)
            a, b = cell(x, half, size, side), cell(y, half, size, side)
            free = True
            for m in range(max(a - 1, 0), min(a + 2, side)):
                for n in range(max(b - 1, 0), min(b + 2, side)):
                    j = heads[m, n]
                    while j >= 0 and free:
                        dx, dy = x - state[X, j], y - state[Y, j]
                        free = dx * dx + dy * dy >= 4.0 * radius * radius
                        j = following[j]
            if free:
                break
        state[X, i], state[Y, i] = x, y
        following[i] = heads[a, b]
        heads[a, b] = i
        p, _ = block(key[0], key[1], counter(trial, np.int64(0)), counter(np.int64(2), i))
        state[COS, i] = math.cos(2.0 * math.pi * unit(p))
        state[SIN, i] = math.sin(2.0 * math.pi * unit(p))
        state[COS_LATE, i] = state[COS_THEN, i] = 1.0
    return True


@counting_nothing
def walk(bodies, neighbours, stops, trial, chunk, stop):
    """Walk through the ticks of a chunk and fill it; returns the ticks done, fewer where `senders` is full."""
    state, half, key, commands, body = bodies.state, bodies.half, bodies.key, bodies.commands, bodies.body[0]
    tick, looked, tiles = chunk.tick, chunk.looked, chunk.tiles
    heard, senders, poses = chunk.heard, chunk.senders, chunk.poses
    room, around, hears, ears = neighbours.room, neighbours.around, neighbours.hears, neighbours.ears
    gaps, close, pairs, pushed = neighbours.gaps, neighbours.close, neighbours.pairs, neighbours.pushed
    robots = np.uint64(state.shape[1])
    radio2 = body.radio_range * body.radio_range
    blind = body.line_of_sight == 0.0  # radio passes through robots
    room_to_work = blank_state(ROOM)
    rays, which, turns = room_to_work.rays, room_to_work.which, room_to_work.turns
    turn_by(body.turn, body.lag, turns[0])
    turn_by(-body.turn, body.lag, turns[1])
    used = np.uint64(0)
    heard[0] = 0
    for k in range(looked.shape[0]):
        if stop[0] != 0 or used + np.uint64(ears.size) > np.uint64(senders.size):
            return k
        if tick + k == 1:
            look_around(bodies, neighbours)
        for i in range(robots):
            move, avoiding = STAND, False
            able = works(stops, MOVING, np.int64(i), tick + k)
            if able:
                move, avoiding = decide(
                    state, i, body, half, room[i], room[i] + around[i], gaps, rays, which, key, trial, tick + k
                )
            looked[k, i] = not avoiding
            # wheels answer late: the motion of the last tick goes on at first
            go(state, i, body.lag, state[COS_LATE, i], state[SIN_LATE, i])
            speed = state[PACE, i] if move == STRAIGHT else 0.0
            turn = body.turn if move == LEFT else (-body.turn if move == RIGHT else 0.0)
            if commands.shape[1] > 0 and able and not avoiding and commands[0, i] > 0.0:
                speed, turn = commands[1, i], commands[2, i]
                state[LEFT_TICKS, i] = 0.0
            set_wheels(state, i, body, turns, speed, turn)
            go(state, i, 1.0 - body.lag, state[COS_THEN, i], state[SIN_THEN, i])
            keep_inside(state, i, half - body.radius)
        sweep = np.int64(0)  # `part` would be compiled for a literal, too
        while sweep < SWEEPS:
            sweep = part(state, body, half - body.radius, close, pairs[0], pushed, sweep)
            look_around(bodies, neighbours)
        hears[:] = 0
        for i in range(robots):
            listen(i, radio2, blind, body.radius, neighbours)
            for e in range(room[i], room[i] + hears[i]):
                senders[used] = ears[e]
                used += np.uint64(1)
            heard[np.uint64(k) * robots + i + np.uint64(1)] = used
            x = state[X, i] + body.sensor_x * state[COS, i] - body.sensor_y * state[SIN, i]
            y = state[Y, i] + body.sensor_x * state[SIN, i] + body.sensor_y * state[COS, i]
            tiles[k, i, 0], tiles[k, i, 1] = math.floor(x / body.tile), math.floor(y / body.tile)
            if poses.shape[0] > 0:
                poses[k, i, 0], poses[k, i, 1] = state[X, i], state[Y, i]
                poses[k, i, 2] = math.atan2(state[SIN, i], state[COS, i])
    return looked.shape[0]
