"""One trial a stretch at a time, forward or anywhere: for those who watch it, and look back.

A `Life` keeps copies of all that it is before some stretches, and goes on from the nearest. So any part of a trial is
there again, to the same bits, and what is kept does not grow with the trial.
"""

import mmap
from collections import OrderedDict
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from swarmcensus.engine import compiler
from swarmcensus.engine.constants import HEARD, IS_DONE, SENT, TALKING
from swarmcensus.engine.failures import works
from swarmcensus.engine.swarms import Swarm
from swarmcensus.simulation.inputs import Inputs, inputs_of
from swarmcensus.simulation.rides import Rider, links_of, wishes_of
from swarmcensus.simulation.swarming import outbox_of, swarm_of, verdicts_of
from swarmcensus.simulation.trials import blaming
from swarmcensus.simulation.walking import Chunk, Walk
from swarmcensus.studies.settings import Setting

STRETCH_BYTES = 4_000_000  # of minds
KEPT_BYTES = 32_000_000  # of stretches, and as much of copies to go on from
ASTRAY = -1  # what comes next is not known: one begins with a copy
MOST_ROUNDS = 200  # in a stretch: where little is to be done, a hundredth of a second


@dataclass(frozen=True)
class Stretch:
    """Some rounds, or ticks, of a trial: arrays (round, robot), whose first row is that of round `first`."""

    first: int
    history: np.ndarray  # (round, robot, number): minds after the round
    said: np.ndarray  # (round, robot, number): what was heard of each, as in an outbox
    estimates: np.ndarray
    messages: np.ndarray  # (round, what): how many all robots have sent and heard so far
    poses: np.ndarray  # x, y, heading after the tick; no rows of this and of what follows where robots do not move
    colours: np.ndarray  # the true tile under the sensor, 1 black
    readings: np.ndarray  # NaN where none was made
    links: np.ndarray  # (link, 3): tick, robot, robot
    done: np.ndarray  # (robot): who was done before the first of these rounds; nobody where no brain ever is

    @property
    def bytes(self) -> int:
        """What it takes."""
        return sum(value.nbytes for value in vars(self).values() if isinstance(value, np.ndarray))


class World(Protocol):
    """What goes on: all that it is lies in `arrays`."""

    swarm: Swarm
    start: Stretch  # of round 0, before any observation
    arrays: list[np.ndarray]

    def on(self, first: int, rounds: int) -> Stretch:
        """Live on for so many rounds, of which `first` is the next."""


class Life:
    """One trial of a setting: its k-th stretch of `length` rounds is there by `at(k)`, in whatever order."""

    def __init__(self, setting: Setting, seed: int, trial: int) -> None:
        """Wake its minds. Raises InputError where its brain is not compiled, or robots find no room."""
        self.setting, self.seed, self.trial = setting, seed, trial
        self.given = inputs_of(setting, seed, trial)
        self._world: World = (_Network if setting.body is None else _Moving)(setting, seed, self.given)
        self.swarm, self.start = self._world.swarm, self._world.start
        self.length = int(np.clip(STRETCH_BYTES // self.start.history.nbytes, 1, min(MOST_ROUNDS, setting.rounds)))
        self._next, self._every = 0, 1  # the stretch that comes next; how many from copy to copy
        self._kept: OrderedDict[int, Stretch] = OrderedDict()
        self._copies = {0: [array.copy() for array in self._world.arrays]}

    def at(self, k: int) -> Stretch:
        """A stretch, from 0 on. Raises InputError where a brain fails."""
        while not self.approach(k):
            pass
        return self._kept[k]

    def approach(self, k: int) -> bool:
        """Go on towards a stretch, by one; whether it is there."""
        if k not in self._kept:
            near = max(one for one in self._copies if one <= k)
            if not near <= self._next <= k:
                for array, copy in zip(self._world.arrays, self._copies[near], strict=True):
                    array[...] = copy
                self._next = near
            now, self._next = self._next, ASTRAY  # until it is there: a brain may fail half-way
            first = now * self.length + 1
            self._keep(now, self._world.on(first, min(self.length, self.setting.rounds + 1 - first)))
            self._next = now + 1
            self._copy()
        if k in self._kept:
            self._kept.move_to_end(k)
        return k in self._kept

    def kept(self, k: int) -> Stretch | None:
        """A stretch, if it need not be computed."""
        return self._kept.get(k)

    def _keep(self, k: int, stretch: Stretch) -> None:
        self._kept[k] = stretch
        while len(self._kept) > 1 and sum(one.bytes for one in self._kept.values()) > KEPT_BYTES:
            self._kept.popitem(last=False)

    def _copy(self) -> None:
        """Remember all that is, now and then: twice as seldom each time that it is too much."""
        if self._next % self._every == 0 and self._next not in self._copies:
            self._copies[self._next] = [array.copy() for array in self._world.arrays]
            one = sum(array.nbytes for array in self._world.arrays)
            while len(self._copies) > 1 and len(self._copies) * one > KEPT_BYTES:
                self._every *= 2
                self._copies = {at: copy for at, copy in self._copies.items() if at % self._every == 0}


class _Network:
    def __init__(self, setting: Setting, seed: int, given: Inputs) -> None:
        assert given.links is not None
        self.setting, self.given = setting, given
        self.kernel = compiler.compile_world("living")
        robots = setting.robots
        with blaming(setting, given.first):
            self.swarm = swarm_of(setting, given, "network")
            self.memory = np.empty((robots, int(self.swarm.fields.sum())))
            self.outbox = outbox_of(self.swarm, setting, setting.message_delay + 2)
            self.counts = np.zeros((2, robots), np.int64)
            verdicts, agreed = verdicts_of(setting, 1, robots)
            self.verdicts, self.agreed = verdicts[0], agreed[0]
            start = np.empty((1, robots))
            beliefs = (belief[0] for belief in given.beliefs)
            self.kernel.wake(*self.swarm, self.memory, *beliefs, start, self.verdicts, self.agreed)
        self.arrays = [self.memory, self.outbox, self.counts, self.verdicts, self.agreed]
        minds, nobody = self.memory[np.newaxis].copy(), np.zeros(robots, np.bool_)
        self.start = _standing(0, minds, self.outbox[np.newaxis, :0], start, np.zeros((1, 2)), nobody)

    def on(self, first: int, rounds: int) -> Stretch:
        setting, given, links = self.setting, self.given, self.given.links
        assert links is not None
        history, done = np.empty((rounds, *self.memory.shape)), _done(self.verdicts, setting.robots)
        said = np.empty((rounds, setting.robots, self.outbox.shape[1]))
        estimates, messages = np.empty((rounds, setting.robots)), np.zeros((rounds, 2), np.int64)
        sensors = (a[0] for a in (*given.sensors, given.drift))
        with blaming(setting, given.first):
            self.kernel.live(
                *self.swarm, self.memory, self.outbox, estimates, first, given.first, *sensors, setting.course,
                setting.observations_per_round, given.readings, given.losses, links.mode, links.receivers,
                links.senders, given.loss_threshold, given.stops[0], setting.message_delay, self.counts, self.verdicts,
                self.agreed, history, said, messages, np.zeros(1, np.uint8),
            )  # fmt: skip
        return _standing(first, history, said, estimates, messages, done)


def _standing(
    first: int, history: np.ndarray, said: np.ndarray, estimates: np.ndarray, messages: np.ndarray, done: np.ndarray
) -> Stretch:
    nothing = np.zeros((0, estimates.shape[1]))
    poses, links = np.zeros((*nothing.shape, 3)), np.zeros((0, 3), np.int64)
    return Stretch(first, history, said, estimates, messages, poses, nothing, nothing, links, done)


def _done(verdicts: np.ndarray, robots: int) -> np.ndarray:
    """Who is done by now."""
    return verdicts[:, IS_DONE] == 1.0 if verdicts.size else np.zeros(robots, np.bool_)


class _Moving:
    def __init__(self, setting: Setting, seed: int, given: Inputs) -> None:
        assert setting.body is not None
        self.setting, self.given = setting, given
        self.stop = np.zeros(1, np.uint8)
        self.rider, self.ground = Rider(setting, given), setting.ground(seed, given.first)
        # the engine addresses estimates by their tick: of the pages, those of one stretch are enough
        self.pages = mmap.mmap(-1, self.rider.rows.nbytes)
        self.rider.rows = np.frombuffer(self.pages).reshape(self.rider.rows.shape)
        self.rider.counts[...] = 0  # what is known beforehand of the whole trial is counted by tick here
        self.swarm, self.wishes = self.rider.swarm, wishes_of(setting)
        self.walk = Walk(
            setting.robots, setting.arena_side, setting.fastest, given.walk, given.first, self.stop, True,
            given.stops[0], self.wishes, given.paces[0],
        )  # fmt: skip
        rider = self.rider
        self.arrays = [
            self.walk.state, *self.walk.around, self.wishes, rider.memory, rider.outbox, rider.counts, rider.verdicts,
            rider.agreed,
        ]  # fmt: skip
        shape = (1, setting.robots)
        self.start = Stretch(
            0, rider.memory[np.newaxis].copy(), rider.outbox[np.newaxis, :0], rider.start, np.zeros((1, 2)),
            self.walk.poses_now()[np.newaxis], np.full(shape, np.nan), np.full(shape, np.nan),
            np.zeros((0, 3), np.int64), np.zeros(setting.robots, np.bool_),
        )  # fmt: skip

    def on(self, first: int, rounds: int) -> Stretch:
        setting, rider, robots = self.setting, self.rider, self.setting.robots
        shape = (rounds, robots)
        history, said = np.empty((rounds, *rider.memory.shape)), np.empty((*shape, rider.outbox.shape[1]))
        poses, colours, readings = np.empty((*shape, 3)), np.empty(shape), np.full(shape, np.nan)
        messages, links, ended = np.zeros((rounds, 2), np.int64), [], _done(rider.verdicts, robots)
        done = 0
        while done < rounds:
            chunk = self.walk.on(first + done, 1 if self.wishes.size else rounds - done)
            assert chunk is not None
            part = slice(done, done + len(chunk.looked))
            colours[part] = self.ground.colours(chunk.tiles, chunk.tick)
            poses[part] = chunk.poses
            links.append(links_of(chunk))
            for row in range(part.start, part.stop):
                one = slice(row, row + 1)
                with blaming(setting, self.given.first):
                    rider.ride(_tick(chunk, row - done), colours[one] == 1.0, self.stop, (history[one], readings[one]))
                    rider.wish(self.wishes, first + row)
                heard = (first + row - rider.delay) % (rider.delay + 1) * robots
                said[row] = rider.outbox[heard : heard + robots]
                if self.swarm.flag < 0:
                    rider.counts[SENT] += [works(rider.stops, TALKING, i, first + row) for i in range(robots)]
                messages[row] = rider.counts[SENT].sum(), rider.counts[HEARD].sum()
            done = part.stop
        estimates = rider.rows[first - 1 : first - 1 + rounds].copy()
        if hasattr(self.pages, "madvise"):
            self.pages.madvise(mmap.MADV_DONTNEED)
        return Stretch(
            first, history, said, estimates, messages, poses, colours, readings, np.concatenate(links), ended
        )


def _tick(chunk: Chunk, k: int) -> Chunk:
    """The k-th tick of a chunk alone."""
    robots = chunk.looked.shape[1]
    return Chunk(
        chunk.tick + k, chunk.looked[k : k + 1], chunk.tiles[k : k + 1],
        chunk.heard[k * robots : (k + 1) * robots + 1], chunk.senders, chunk.poses[k : k + 1], chunk.begin,
    )  # fmt: skip
