"""Robots that move by brute force, beside reference.py: places, walks, rays, contact and radio, and whole lives."""

import math
from collections.abc import Callable
from dataclasses import dataclass
from itertools import combinations

import numpy as np

from swarmcensus.simulation import sampling
from swarmcensus.studies import addresses
from swarmcensus.studies.settings import Setting
from swarmcensus.worlds.bodies import Body
from tests.reference.rounds import (
    Failures,
    States,
    accuracy_in,
    fill_ratio_in,
    key_of,
    robots_word,
    threefry,
    tile_unit,
    unit,
    works,
)

STAND, STRAIGHT, LEFT, RIGHT = range(4)
SLANT = math.sqrt(0.5)
RAYS = [complex(x, y) for x, y in ((1, 0), (SLANT, SLANT), (0, 1), (-SLANT, SLANT))]  # what is dead ahead is on no side
RAYS += [-ray for ray in RAYS]


@dataclass
class Robot:
    """A body's state: place and heading as complex numbers; metres and radians a tick of its wheels."""

    place: complex
    heading: complex
    speed: float = 0.0
    turn: float = 0.0
    move: int = STAND
    left: int = 0
    avoiding: int = 0


def placed(n: int, side: float, body: Body, key: np.ndarray, trial: int) -> list[Robot]:
    """Robots that touch nobody and no wall, each drawn again until that is so."""
    out: list[Robot] = []
    room = side / 2 - body.radius
    for i in range(n):
        for attempt in range(10_000):
            p, q = threefry(key_of(key), (trial, attempt), (1, i))
            place = complex((2 * unit(p) - 1) * room, (2 * unit(q) - 1) * room)
            if all(abs(place - other.place) >= 2 * body.radius for other in out):
                break
        angle = 2 * math.pi * unit(threefry(key_of(key), (trial, 0), (2, i))[0])
        out.append(Robot(place, complex(math.cos(angle), math.sin(angle))))
    return out


def ray_length(start: complex, along: complex, others: list[complex], half: float, radius: float) -> float:
    """How far it is along a ray to a wall or a disc."""
    lengths = [math.inf]
    for a, v in ((start.real, along.real), (start.imag, along.imag)):
        if abs(v) > 1e-12:
            lengths.append((math.copysign(half, v) - a) / v)
    for other in others:
        gap = (other - start) * along.conjugate()  # the ray is the real axis now
        if gap.real > 0 and abs(gap.imag) <= radius:
            lengths.append(gap.real - math.sqrt(radius**2 - gap.imag**2))
    return min(lengths)


def proximity(i: int, swarm: list[Robot], half: float, body: Body) -> complex:
    """The mean over eight rays of reading times direction, ahead the real axis."""
    total = 0j
    for towards in RAYS:
        me = swarm[i]
        others = [other.place for other in swarm if other is not me]
        d = ray_length(me.place, me.heading * towards, others, half, body.radius) - body.radius
        reading = 0.0
        if d <= body.proximity_range:
            reading = 1.0 if d < body.proximity_near else min(max(4.14 * math.exp(-33 * d) - 0.085, 0.0), 1.0)
        total += reading * towards
    return total / 8


def decision(i: int, me: Robot, v: complex, body: Body, key: np.ndarray, trial: int, tick: int) -> tuple[int, bool]:
    """What a robot does in this tick, and whether it avoids."""
    angle = abs(math.degrees(math.atan2(v.imag, v.real)))
    if abs(v) >= body.avoid_above and angle < body.avoid_within:
        me.avoiding = me.avoiding % 60 + 1
        me.left = 0
        return (RIGHT if v.imag > 0 or me.avoiding > 30 else LEFT), True
    me.avoiding = 0
    if me.left == 0:
        p, q = threefry(key_of(key), (trial, tick), (0, i))
        if unit(p) < 0.5:
            me.move, ticks = STRAIGHT, math.floor(-body.straight_mean * math.log(1 - unit(q)))
        else:
            me.move, ticks = (LEFT if unit(p) < 0.75 else RIGHT), math.floor(unit(q) * (body.turn_most + 1))
            me.move = STAND if ticks == 0 else me.move
        me.left = max(ticks, 1)
    me.left -= 1
    return me.move, False


def clamp(place: complex, limit: float) -> complex:
    """Back inside the walls."""
    return complex(min(max(place.real, -limit), limit), min(max(place.imag, -limit), limit))


def push_apart(swarm: list[Robot], limit: float, radius: float) -> int:
    """Overlapping pairs part by halves, in turn, until less than a micrometre is left, or less of small bodies.

    Returns how often each pair was looked at. From the 101st time on they part aslant, which bends jammed rows.
    """
    for sweep in range(1, 401):
        worst = 0.0
        for i, j in combinations(range(len(swarm)), 2):
            one, other = swarm[i], swarm[j]
            gap = other.place - one.place
            overlap = 2 * radius - abs(gap)
            if overlap > 0:
                worst = max(worst, overlap)
                push = gap / abs(gap) * overlap / 2 * (1 + 1j if sweep > 100 else 1) if gap else 0j
                if abs(gap) < 2e-9 * radius:  # in one place: anywhere
                    push = radius * complex(math.cos(i), math.sin(i))
                one.place, other.place = clamp(one.place - push, limit), clamp(other.place + push, limit)
        if worst < min(1e-6, 2e-5 * radius):
            break
    return sweep


def in_sight(one: complex, other: complex, others: list[complex], radius: float) -> bool:
    """Whether no third disc lies across the segment between two centres."""
    way = other - one
    for third in others:
        along = min(max(((third - one) * way.conjugate()).real / abs(way) ** 2, 0.0), 1.0)
        if abs(one + along * way - third) < radius:
            return False
    return True


def audible(swarm: list[Robot], body: Body) -> list[list[int]]:
    """Whom each robot hears: in range, and in sight unless the radio goes through bodies."""
    out: list[list[int]] = [[] for _ in swarm]
    for i, j in combinations(range(len(swarm)), 2):
        one, other = swarm[i].place, swarm[j].place
        between = [swarm[k].place for k in range(len(swarm)) if k not in (i, j)] if body.line_of_sight else []
        if abs(other - one) < body.radio_range and in_sight(one, other, between, body.radius):
            out[i].append(j)
            out[j].append(i)
    return [sorted(heard) for heard in out]


@dataclass
class Tick:
    """What a tick of a walk comes to, by robot."""

    poses: list[tuple[float, float, float]]
    looked: list[bool]
    tiles: list[tuple[int, int]]
    heard: list[list[int]]


def step(
    swarm: list[Robot], side: float, body: Body, key: np.ndarray, trial: int, tick: int,
    stands: list[list[tuple[int, int]]], wants: list[tuple[float, float] | None],
) -> Tick:  # fmt: skip
    """All robots move on by a tick; `wants` are metres and radians a tick."""
    seen = [proximity(i, swarm, side / 2, body) for i in range(len(swarm))]
    looked = []
    limit = side / 2 - body.radius
    for i, me in enumerate(swarm):
        able = works(stands[i], tick)
        move, avoids = decision(i, me, seen[i], body, key, trial, tick) if able else (STAND, False)
        looked.append(not avoids)
        speed = body.speed * body.tick if move == STRAIGHT else 0.0
        turn = 2 * body.turn_speed / body.wheel_distance * body.tick * {LEFT: 1, RIGHT: -1}.get(move, 0)
        wanted = wants[i]
        if wanted is not None and able and not avoids:
            speed, turn = wanted
            me.left = 0
        for share, v, w in ((body.wheel_lag, me.speed, me.turn), (1 - body.wheel_lag, speed, turn)):
            me.heading *= complex(math.cos(share * w), math.sin(share * w))
            me.place += share * v * me.heading
        me.speed, me.turn = speed, turn
        me.place = clamp(me.place, limit)
    push_apart(swarm, limit, body.radius)
    sensors = [me.place + me.heading * complex(*body.sensor) for me in swarm]
    tiles = [(math.floor(s.real / body.tile), math.floor(s.imag / body.tile)) for s in sensors]
    return Tick(poses(swarm), looked, tiles, audible(swarm, body))


def poses(swarm: list[Robot]) -> list[tuple[float, float, float]]:
    """Places and headings."""
    return [(me.place.real, me.place.imag, math.atan2(me.heading.imag, me.heading.real)) for me in swarm]


def command(
    me: object, steer: Callable[[object], tuple[float, float] | None], body: Body
) -> tuple[float, float] | None:
    """What a state wants, as metres and radians a tick that its wheels can do."""
    if (wanted := steer(me)) is None:
        return None
    most = body.speed, 2 * body.turn_speed / body.wheel_distance
    load = sum(abs(x) / m if m else math.inf for x, m in zip(wanted, most, strict=True) if x)
    return tuple(x * body.tick / max(load, 1.0) for x in wanted)  # type: ignore[return-value]


@dataclass
class Life:
    """A trial of moving robots: its walk, what was read (NaN: nothing), and estimates from before the first tick."""

    begin: list[tuple[float, float, float]]
    ticks: list[Tick]
    colours: list[list[bool]]
    readings: list[list[float]]
    estimates: list[list[float]]
    states: States


def lives(setting: Setting, seed: int, trial: int, failed: Failures) -> Life:
    """One trial of robots that move, on independent tiles."""
    body, n = setting.body, setting.robots
    assert body is not None
    assert setting.density is not None
    side = math.sqrt(n * math.pi * body.radio_range**2 / setting.density)
    walk, floor = addresses.walk_key(setting, seed), addresses.floor_key(setting, seed)
    reads = addresses.readings_key(setting, seed)
    b, w = (np.broadcast_to(side_of[0], n) for side_of in sampling.accuracies(setting, seed, trial, 1)[:2])
    who = sampling.groups(setting, seed, trial, 1)[0] if setting.members else [0] * n
    swarm, states = placed(n, side, body, walk, trial), States(setting, seed, trial, failed)
    out = Life(poses(swarm), [], [], [], states.estimates, states)
    wants: list[tuple[float, float] | None] = [None] * n
    for tick in range(1, setting.rounds + 1):
        now = step(swarm, side, body, walk, trial, tick, failed.moving, wants)
        black = [tile_unit(floor, trial, 0, *tile)[0] < fill_ratio_in(setting, tick) for tile in now.tiles]
        read = []
        for i in range(n):
            best = accuracy_in(setting, who[i], b[i] if black[i] else w[i], tick)
            right = unit(robots_word(reads, trial, tick, i)) < best
            able = now.looked[i] and works(failed.sensing[i], tick)
            read.append(float(black[i] == right) if able else math.nan)
        states.live(tick, read, 1, now.heard, body.message_delay)
        if setting.brain.steers:
            for i in range(n):
                states.cast(i, tick, 2)
            wants = [command(me, setting.brain.functions.steer, body) for me in states.states]
        out.ticks.append(now)
        out.colours.append(black)
        out.readings.append(read)
    return out
