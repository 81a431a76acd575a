"""Walks in chunks that fit in memory: who looks at which tile and who hears whom, tick by tick."""

import math
from collections.abc import Iterator

import numpy as np

from swarmcensus.engine import Bodies, Chunk, Neighbours, compile_world
from swarmcensus.engine.constants import ALL_PAIRS, COS, PACE, SIN, STATE, X, Y
from swarmcensus.support.errors import InputError
from swarmcensus.worlds import Body

CHUNK_BYTES = 4_000_000  # of a chunk
SENDERS = 2_000_000  # of a chunk
NO_COMMANDS = np.zeros((0, 0))
NO_STOPS = np.zeros((3, 0), np.int64)


def neighbours_at_most(robots: int, body: Body) -> int:
    """How many robots fit within reach of one: the densest packing of discs."""
    fit = math.pi / math.sqrt(12.0) * ((body.reach + body.skin + body.radius) / body.radius) ** 2
    return min(robots - 1, int(fit) + 1)


class Walk:
    """The walk of one trial, as it is before the next tick."""

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
        commands: np.ndarray = NO_COMMANDS,
        speeds: np.ndarray | None = None,
    ) -> None:
        """Place the robots at random, with or without record of their `poses`, and make room for lists of neighbours.

        `stops` of each part are those of `Inputs`; `commands` (3, robot) are of brains that steer. `speeds` (robot) are
        metres a tick, by default the body's; none is faster than that. A tick has at most as many messages as the lists
        have room for. Raises InputError if the robots do not fit in the arena.
        """
        self.module = compile_world("walk")
        state = np.zeros((STATE, robots))
        self.bodies = Bodies(state, body.numbers, side / 2.0, key, commands)
        size = max(2.0 * body.radius, side / 2.0 / math.sqrt(robots))
        heads = np.full((int(side / size) + 1,) * 2, -1)
        if not self.module.place(self.bodies, trial, size, heads, np.full(robots, -1)):
            raise InputError(f"{robots:,} robots find no room in a square of {side:.2f} m", key="robots", value=robots)
        if robots > ALL_PAIRS:  # neighbours in space are neighbours in memory, which large swarms need to be fast
            state[:] = state[:, np.lexsort((state[X], np.floor(state[Y] / body.reach)))]
        state[PACE] = body.speed * body.tick if speeds is None else speeds
        cells = max(1, int(side / max(body.reach + body.skin, side / 2.0 / math.sqrt(robots))))
        listed = max(1, robots * neighbours_at_most(robots, body))
        self.neighbours = Neighbours(
            anchors=np.full((2, robots), np.inf),
            first=np.zeros(robots + 1, np.uint32),
            others=np.zeros(listed // 2 + 1, np.uint32),
            room=np.zeros(robots + 1, np.uint32),
            around=np.zeros(robots, np.uint32),
            lower=np.zeros(robots, np.uint32),
            hears=np.zeros(robots, np.uint32),
            near=np.zeros(listed, np.uint32),
            ears=np.zeros(listed, np.uint32),
            gaps=np.zeros((2, listed)),
            close=np.zeros((listed // 2 + 1, 2), np.uint32),
            pairs=np.zeros(1, np.uint64),
            pushed=np.zeros(robots),
            heads=np.zeros((cells, cells), np.int32),
            following=np.zeros(robots, np.int32),
        )
        self.senders = np.zeros(listed + SENDERS, np.uint32)
        self.trial, self.stop, self.stops, self.poses = trial, stop, stops, poses

    def poses_now(self) -> np.ndarray:
        """The robots' x, y and heading now (robot, 3)."""
        x, y, sine, cosine = (self.bodies.state[row] for row in (X, Y, SIN, COS))
        return np.stack([x, y, np.arctan2(sine, cosine)], axis=1)

    def room_for(self, tick: int, most: int) -> Chunk:
        """Room for so many ticks, from `tick` on."""
        robots = self.bodies.state.shape[1]
        looked, tiles = np.zeros((most, robots), np.bool_), np.zeros((most, robots, 2), np.int32)
        heard, poses = np.zeros(most * robots + 1, np.int64), np.zeros((most if self.poses else 0, robots, 3))
        begin = self.poses_now() if self.poses else np.zeros((0, 3))
        return Chunk(tick, looked, tiles, heard, self.senders, poses, begin)

    def on(self, tick: int, most: int) -> Chunk | None:
        """Walk at most so many ticks, from `tick` on; None if stopped."""
        chunk, robots = self.room_for(tick, most), self.bodies.state.shape[1]
        done = self.module.walk(self.bodies, self.neighbours, self.stops, self.trial, chunk, self.stop)
        if self.stop[0] != 0:
            return None
        heard, seen = chunk.heard[: done * robots + 1], (chunk.looked[:done], chunk.tiles[:done])
        return Chunk(tick, *seen, heard, self.senders[: heard[-1]].copy(), chunk.poses[:done], chunk.begin)

    def chunks(self, ticks: int) -> Iterator[Chunk]:
        """So many ticks from the first one on, in chunks that fit in memory; fewer if stopped.

        Chunks of brains that steer have one tick, because commands change from tick to tick.
        """
        fit = max(1, CHUNK_BYTES // (self.bodies.state.shape[1] * (41 if self.poses else 17)))
        tick = 1
        while tick <= ticks:
            chunk = self.on(tick, 1 if self.bodies.commands.size else min(ticks + 1 - tick, fit))
            if chunk is None:
                return
            yield chunk
            tick += len(chunk.looked)
