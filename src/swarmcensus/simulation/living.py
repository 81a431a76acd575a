"""One trial in stretches of rounds, in any order: for viewers, who also look back.

A `LiveTrial` keeps copies of its state before some stretches, and goes on from the nearest copy. So any part of a trial
can be run again, to the same bits, and memory does not grow with the length of the trial.
"""

import mmap
from collections import OrderedDict
from dataclasses import dataclass, field
from functools import partial

import numpy as np

from swarmcensus.engine import ALONE, Chunk, Inputs, Recorded, States, Tally, compiler, interruptible, works
from swarmcensus.engine.constants import HEARD, IS_DONE, SENT, TALKING
from swarmcensus.simulation import sampling
from swarmcensus.simulation.blame import blaming
from swarmcensus.simulation.inputs import inputs_of
from swarmcensus.simulation.rerunning import watched
from swarmcensus.simulation.rides import Walkers, commands_of, links_of, walk_of
from swarmcensus.simulation.swarming import states_of, swarm_of, tally_of
from swarmcensus.simulation.trials import work_of
from swarmcensus.studies import Setting, addresses

STRETCH_BYTES = 4_000_000  # of states
KEPT_BYTES = 32_000_000  # of stretches, and as much of copies
ASTRAY = -1  # the state is that of no stretch: the next run starts from a copy
MOST_ROUNDS = 200  # in a stretch: for small swarms, a hundredth of a second


@dataclass(frozen=True)
class Stretch:
    """Some rounds, or ticks, of a trial: arrays (round, robot), whose first row is that of round `first`."""

    first: int
    history: np.ndarray  # (round, robot, byte): states after the round
    said: np.ndarray  # (round, robot, byte): the message of each that was heard in the round, as in an outbox
    signals: np.ndarray  # (round, robot): whether each was said, see `States`; no robots if all are said
    estimates: np.ndarray
    messages: np.ndarray  # (round, what): how many all robots have sent and heard so far
    done: np.ndarray  # (robot): which robots were done before the first of these rounds
    poses: np.ndarray = field(default_factory=partial(np.zeros, 0))  # x, y, heading; from here on only if robots move
    colours: np.ndarray = field(default_factory=partial(np.zeros, 0))  # the true tile under the sensor, 1 black
    readings: np.ndarray = field(default_factory=partial(np.zeros, 0))  # NaN where none was made
    links: np.ndarray = field(default_factory=partial(np.zeros, (0, 3), np.int64))  # (link, 3): tick, robot, robot
    known: np.ndarray | None = None  # (round, robot): whose states are known; None: all, as in every simulation

    @property
    def bytes(self) -> int:
        """How much memory it takes."""
        return sum(value.nbytes for value in vars(self).values() if isinstance(value, np.ndarray))


class LiveTrial:
    """One trial of a setting: `at(k)` is its k-th stretch of `length` rounds."""

    @interruptible
    def __init__(self, setting: Setting, seed: int, trial: int) -> None:
        """Start its states. Raises InputError if a brain does not compile, or the robots do not fit in the arena."""
        setting = addresses.in_trial(setting, seed, trial)
        self.setting, self.seed, self.trial = setting, seed, trial
        self.given = inputs_of(setting, seed, trial)
        self._world = (_Network if setting.body is None else _Moving)(setting, seed, self.given)
        self.swarm, self.start = self._world.swarm, self._world.start
        self.length = int(np.clip(STRETCH_BYTES // self.start.history.nbytes, 1, min(MOST_ROUNDS, setting.rounds)))
        self._next, self._every = 0, 1  # the next stretch to run; how many stretches lie between copies
        self._kept: OrderedDict[int, Stretch] = OrderedDict()
        self._copies = {0: [array.copy() for array in self._world.arrays]}

    def at(self, k: int) -> Stretch:
        """The k-th stretch, from 0 on. Raises InputError if a brain fails."""
        while not self.approach(k):
            pass
        return self._kept[k]

    @interruptible
    def approach(self, k: int) -> bool:
        """Run one stretch on the way to the k-th; returns whether that is reached."""
        if k not in self._kept:
            near = max(one for one in self._copies if one <= k)
            if not near <= self._next <= k:
                for array, copy in zip(self._world.arrays, self._copies[near], strict=True):
                    array[...] = copy
                self._next = near
            now, self._next = self._next, ASTRAY  # a brain may fail half-way
            first = now * self.length + 1
            with watched([self.setting], self.seed, self.trial):
                self._kept[now] = self._world.on(first, min(self.length, self.setting.rounds + 1 - first))
            while len(self._kept) > 1 and sum(stretch.bytes for stretch in self._kept.values()) > KEPT_BYTES:
                self._kept.popitem(last=False)
            self._next = now + 1
            self._copy()
        if k in self._kept:
            self._kept.move_to_end(k)
        return k in self._kept

    def stretch(self, k: int) -> Stretch | None:
        """The k-th stretch if it is kept, else None."""
        return self._kept.get(k)

    def _copy(self) -> None:
        """Copy the state before some stretches: half as often each time that copies take too much memory."""
        if self._next % self._every == 0 and self._next not in self._copies:
            self._copies[self._next] = [array.copy() for array in self._world.arrays]
            one = sum(array.nbytes for array in self._world.arrays)
            while len(self._copies) > 1 and len(self._copies) * one > KEPT_BYTES:
                self._every *= 2
                self._copies = {at: copy for at, copy in self._copies.items() if at % self._every == 0}


class _Network:
    """A trial on a network: `on` runs some rounds from the next one, `first`, and `arrays` are its whole state."""

    def __init__(self, setting: Setting, seed: int, given: Inputs) -> None:
        self.setting, self.given = setting, given
        self.kernel = compiler.compile_world("living")
        robots = setting.robots
        with blaming(setting, given.first):
            self.swarm = swarm_of(setting, given, "network")
            self.states = states_of(setting, self.swarm, given.radio.delay + 2, np.empty((1, robots)))
            self.tally = tally_of(setting, 1).of_trial(0)
            self.kernel.start_states(self.swarm, given, self.states, self.tally)
        memory, outbox, signals, start = self.states
        self.arrays = [memory, outbox, signals, *self.tally]
        self.start = Stretch(
            0, memory[np.newaxis].copy(), outbox[np.newaxis, :0], signals[np.newaxis, :0], start, np.zeros((1, 2)),
            np.zeros(robots, np.bool_),
        )  # fmt: skip

    def on(self, first: int, rounds: int) -> Stretch:
        setting = self.setting
        done = _done(self.tally, setting.robots)
        history, said, signals = room_for(self.states, rounds)
        estimates, messages = np.empty((rounds, setting.robots)), np.zeros((rounds, 2), np.int64)
        with blaming(setting, self.given.first):
            self.kernel.live(
                self.swarm, self.given, self.states._replace(rows=estimates), self.tally, first, history, said, signals,
                messages, np.zeros(1, np.uint8), ALONE, np.zeros((4, 1)), work_of(self.swarm, self.given, self.states),
            )  # fmt: skip
        return Stretch(first, history, said, signals, estimates, messages, done)


def room_for(states: States, rounds: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Room for `history`, `said` and `signals` of a stretch."""
    robots, size = states.memory.shape
    return (
        np.empty((rounds, robots, size), np.uint8),
        np.empty((rounds, robots, states.outbox.shape[1]), np.uint8),
        np.empty((rounds, robots if states.signals.size else 0), np.uint8),
    )


def _done(tally: Tally, robots: int) -> np.ndarray:
    """Which robots are done by now."""
    return tally.verdicts[:, IS_DONE] == 1.0 if tally.verdicts.size else np.zeros(robots, np.bool_)


class _Moving:
    """The same of robots that move."""

    def __init__(self, setting: Setting, seed: int, given: Inputs) -> None:
        assert setting.body is not None
        self.setting, self.given = setting, given
        self.stop = np.zeros(1, np.uint8)
        self.walkers, self.ground = Walkers(setting, given), sampling.ground(setting, seed, given.first)
        # the engine writes estimates at their tick: pages of earlier stretches are given back after use
        rows = self.walkers.states.rows
        self.pages = mmap.mmap(-1, rows.nbytes)
        self.walkers.states = self.walkers.states._replace(rows=np.frombuffer(self.pages).reshape(rows.shape))
        self.walkers.tally.counts[...] = 0  # messages that are known beforehand are counted tick by tick here
        self.swarm, self.commands = self.walkers.swarm, commands_of(setting)
        self.walk = walk_of(setting, given, self.stop, self.commands, poses=True)
        memory, outbox, signals, _ = self.walkers.states
        self.arrays = [
            self.walk.bodies.state, *self.walk.neighbours, self.commands, memory, outbox, signals,
            *self.walkers.tally,
        ]  # fmt: skip
        shape = (1, setting.robots)
        self.start = Stretch(
            0, memory[np.newaxis].copy(), outbox[np.newaxis, :0], signals[np.newaxis, :0], self.walkers.start,
            np.zeros((1, 2)), np.zeros(setting.robots, np.bool_), self.walk.poses_now()[np.newaxis],
            np.full(shape, np.nan), np.full(shape, np.nan),
        )  # fmt: skip

    def on(self, first: int, rounds: int) -> Stretch:
        setting, walkers, robots = self.setting, self.walkers, self.setting.robots
        shape = (rounds, robots)
        _, outbox, signals, rows = walkers.states
        counts, delay = walkers.tally.counts, self.given.radio.delay
        history, said, does = room_for(walkers.states, rounds)
        poses, colours, readings = np.empty((*shape, 3)), np.empty(shape), np.full(shape, np.nan)
        messages, links, ended = np.zeros((rounds, 2), np.int64), [], _done(walkers.tally, robots)
        done = 0
        while done < rounds:
            chunk = self.walk.on(first + done, 1 if self.commands.size else rounds - done)
            assert chunk is not None
            part = slice(done, done + len(chunk.looked))
            colours[part] = self.ground.colours(chunk.tiles, chunk.tick)
            poses[part] = chunk.poses
            links.append(links_of(chunk))
            for row in range(part.start, part.stop):
                one = slice(row, row + 1)
                with blaming(setting, self.given.first):
                    recorded = Recorded(history[one], readings[one])
                    walkers.ride(_tick(chunk, row - done), colours[one] == 1.0, self.stop, recorded)
                    walkers.steer(self.commands, first + row)
                heard = (first + row - delay) % (delay + 1) * robots
                said[row] = outbox[heard : heard + robots]
                if signals.size:
                    does[row] = signals[heard : heard + robots]
                else:
                    counts[SENT] += [works(self.given.stops[0], TALKING, i, first + row) for i in range(robots)]
                messages[row] = counts[SENT].sum(), counts[HEARD].sum()
            done = part.stop
        estimates = rows[first - 1 : first - 1 + rounds].copy()
        if hasattr(self.pages, "madvise"):
            self.pages.madvise(mmap.MADV_DONTNEED)
        return Stretch(
            first, history, said, does, estimates, messages, ended, poses, colours, readings, np.concatenate(links)
        )


def _tick(chunk: Chunk, k: int) -> Chunk:
    """The k-th tick of a chunk alone."""
    robots, one = chunk.looked.shape[1], slice(k, k + 1)
    return chunk._replace(
        tick=chunk.tick + k, looked=chunk.looked[one], tiles=chunk.tiles[one], poses=chunk.poses[one],
        heard=chunk.heard[k * robots : (k + 1) * robots + 1],
    )  # fmt: skip
