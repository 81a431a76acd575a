"""Walks as data: who looked at which tile and who heard whom, tick by tick, in chunks that fit in memory."""

import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from swarmcensus.basics.errors import InputError
from swarmcensus.engine.compiler import compile_world
from swarmcensus.engine.constants import ALL_PAIRS, COS, PACE, SIN, STATE, X, Y
from swarmcensus.worlds.bodies import Body

CHUNK_BYTES = 4_000_000  # of a walk kept at a time
SENDERS = 2_000_000
NO_WISHES = np.zeros((0, 0))
NO_STOPS = np.zeros((3, 0), np.int64)


@dataclass(frozen=True)
class Chunk:
    """Some ticks of a walk of n robots.

    In the k-th of these ticks robot i hears senders[heard[k n + i]: heard[k n + i + 1]], in order.
    """

    tick: int  # the first one
    looked: np.ndarray  # (tick, robot), bool: whether an observation is made
    tiles: np.ndarray  # (tick, robot, 2): the tile under the ground sensor
    heard: np.ndarray  # (tick * robot + 1)
    senders: np.ndarray
    poses: np.ndarray  # (tick, robot, 3): x and y in metres, heading in radians; no rows where not asked for
    begin: np.ndarray  # (robot, 3): the same before the first of these ticks


def neighbours_at_most(robots: int, body: Body) -> int:
    """How many bodies fit around one robot within its reach: the densest packing of discs."""
    fit = math.pi / math.sqrt(12.0) * ((body.reach + body.skin + body.radius) / body.radius) ** 2
    return min(robots - 1, int(fit) + 1)


def set_out(
    robots: int, side: float, body: Body, key: np.ndarray, trial: int, paces: np.ndarray | None = None
) -> tuple[np.ndarray, np.ndarray, float, tuple[np.ndarray, ...], int]:
    """Put robots in their places: their state, the body's numbers, half the side, room to work in, and how many
    messages one tick may have at the most.

    `paces` are the metres a tick of each robot, by default the body's; none is faster than that.

    Raises InputError where the robots find no room.
    """
    module = compile_world("walk")
    numbers, half = body.numbers, side / 2.0
    state = np.zeros((STATE, robots))
    if not module.place(state, numbers, half, key, trial):
        raise InputError(f"{robots:,} robots find no room in a square of {side:.2f} m")
    if robots > ALL_PAIRS:  # neighbours in space are neighbours in memory, which large swarms need to be fast
        state[:] = state[:, np.lexsort((state[X], np.floor(state[Y] / body.reach)))]
    state[PACE] = body.speed * body.tick if paces is None else paces
    cells = max(1, int(side / max(body.reach + body.skin, half / math.sqrt(robots))))
    listed = max(1, robots * neighbours_at_most(robots, body))
    around = (
        np.full((2, robots), np.inf),
        np.zeros(robots + 1, np.uint32),
        np.zeros(listed // 2 + 1, np.uint32),
        np.zeros(robots + 1, np.uint32),
        np.zeros(robots, np.uint32),
        np.zeros(robots, np.uint32),
        np.zeros(robots, np.uint32),
        np.zeros(listed, np.uint32),
        np.zeros(listed, np.uint32),
        np.zeros((2, listed)),
        np.zeros((listed // 2 + 1, 2), np.uint32),
        np.zeros(1, np.uint64),
        np.zeros(robots),
        np.zeros((cells, cells), np.int32),
        np.zeros(robots, np.int32),
    )
    return state, numbers, half, around, listed


class Walk:
    """The walk of one trial: all that it is lies in arrays, which are those of the tick before the next."""

    def __init__(
        self,
        robots: int,
        side: float,
        body: Body,
        key: np.ndarray,
        trial: int,
        stop: np.ndarray,
        poses: bool = False,
        stops: np.ndarray = NO_STOPS,
        wishes: np.ndarray = NO_WISHES,
        paces: np.ndarray | None = None,
    ) -> None:
        """Put robots in their places; the rest is as `walk` takes it. Raises InputError where they find no room."""
        self.module = compile_world("walk")
        self.state, self.numbers, self.half, self.around, listed = set_out(robots, side, body, key, trial, paces)
        self.senders = np.zeros(listed + SENDERS, np.uint32)
        self.key, self.trial, self.stop, self.stops, self.wishes = key, trial, stop, stops, wishes
        self.robots, self.poses = robots, poses

    def poses_now(self) -> np.ndarray:
        """Where robots are: x, y, heading (robot, 3)."""
        x, y, sine, cosine = (self.state[row] for row in (X, Y, SIN, COS))
        return np.stack([x, y, np.arctan2(sine, cosine)], axis=1)

    def on(self, tick: int, most: int) -> Chunk | None:
        """Walk on from a tick, so many ticks at the most; None if stopped."""
        robots = self.robots
        looked = np.zeros((most, robots), np.bool_)
        tiles = np.zeros((most, robots, 2), np.int32)
        heard = np.zeros(most * robots + 1, np.int64)
        seen = np.zeros((most if self.poses else 0, robots, 3))
        begin = self.poses_now() if self.poses else seen[:0, 0]
        done = self.module.walk(
            self.state, self.numbers, self.half, self.key, self.trial, tick, looked, tiles, heard, self.senders, seen,
            *self.around, self.wishes, self.stops, self.stop,
        )  # fmt: skip
        if self.stop[0] != 0:
            return None
        said = self.senders[: heard[done * robots]].copy()
        return Chunk(tick, looked[:done], tiles[:done], heard[: done * robots + 1], said, seen[:done], begin)


def walk(
    robots: int,
    side: float,
    body: Body,
    key: np.ndarray,
    trial: int,
    ticks: int,
    stop: np.ndarray,
    poses: bool = False,
    stops: np.ndarray = NO_STOPS,
    wishes: np.ndarray = NO_WISHES,
    paces: np.ndarray | None = None,
) -> Iterator[Chunk]:
    """The walk of one trial, in chunks, from tick 1 on; `stops` as in `Setting.stops`.

    `wishes` (3, robot) of brains that steer are read anew for each tick: chunks are of one tick then.
    Raises InputError where the robots find no room.
    """
    made = Walk(robots, side, body, key, trial, stop, poses, stops, wishes, paces)
    tick, fit = 1, max(1, CHUNK_BYTES // (robots * (41 if poses else 17)))
    while tick <= ticks:
        chunk = made.on(tick, 1 if wishes.size else min(ticks + 1 - tick, fit))
        if chunk is None:
            return
        yield chunk
        tick += len(chunk.looked)
