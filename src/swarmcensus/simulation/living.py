"""A trial stepped by the engine, in stretches of rounds and in any order: viewers also look back.

A `Stepped` keeps copies of its state before some stretches, and goes on from the nearest copy. So any part of a trial
can be run again, to the same bits, and memory does not grow with the length of the trial.
"""

import functools
import mmap
from collections import OrderedDict
from typing import Any

import numpy as np

from swarmcensus.brains import slots
from swarmcensus.engine import ALONE, Inputs, Recorded, States, Swarm, Tally, compiler, interruptible, works
from swarmcensus.engine.constants import IS_DONE, LISTED, NOISE, SAID, TALKING
from swarmcensus.simulation import sampling
from swarmcensus.simulation.blame import blaming
from swarmcensus.simulation.inputs import inputs_of
from swarmcensus.simulation.rides import Walkers, commands_of, links_of, walk_of
from swarmcensus.simulation.swarming import fields_of, states_of, swarm_of, tally_of
from swarmcensus.simulation.traces import States as Fields, Stretch, Trace
from swarmcensus.simulation.trials import work_of
from swarmcensus.studies import Setting, addresses
from swarmcensus.support.documents import json_value
from swarmcensus.worlds import Ground

STRETCH_BYTES = 4_000_000  # of states
KEPT_BYTES = 32_000_000  # of stretches, and as much of copies
ASTRAY = -1  # the state is that of no stretch: the next run starts from a copy
MOST_ROUNDS = 200  # in a stretch: for small swarms, a hundredth of a second
MOST_READINGS = 4_000_000  # readings of a fixed network that are kept for viewers


class Stepped(Trace):
    """One trial of a setting, with at most `most` rounds in a stretch."""

    @interruptible
    def __init__(self, setting: Setting, seed: int, trial: int, most: int | None = None, use: str = "network") -> None:
        """Start its states; `use` is what brains are compiled for, "network" for all networks.

        Raises InputError if a brain does not compile, or the robots do not fit in the arena.
        """
        setting = addresses.in_trial(setting, seed, trial)
        self.setting, self.seed, self.trial, self.rounds = setting, seed, trial, setting.rounds
        self.labels = range(setting.robots)
        self.given = inputs_of(setting, seed, trial)
        self._world = _Network(setting, self.given, use) if setting.body is None else _Moving(setting, seed, self.given)
        self.swarm, self.start = self._world.swarm, self._world.start
        self.adds = bool(self.swarm.additive)
        fit = STRETCH_BYTES // self.start.history.nbytes
        self.length = int(np.clip(fit, 1, min(most or MOST_ROUNDS, setting.rounds)))
        self._next, self._every = 0, 1  # the next stretch to run; how many stretches lie between copies
        self._kept: OrderedDict[int, Stretch] = OrderedDict()
        self._copies = {0: [array.copy() for array in self._world.arrays]}

    def at(self, k: int) -> Stretch:
        """The k-th stretch, from 0 on, or the start. Raises InputError if a brain fails."""
        if k < 0:
            return self.start
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

    def truths(self, rounds: np.ndarray, on_floor: bool = False) -> np.ndarray:
        """The fill ratio as the setting has it in these rounds; of robots that move, or that of their floor."""
        return np.asarray(self._world.ground.truth(rounds)) if on_floor else super().truths(rounds)

    def floor(self) -> tuple[np.ndarray, np.ndarray]:
        """The tiles of the floor at tick 1, 1 for black, and the ticks at which they turn; see `Ground`."""
        return self._world.ground.all_tiles(), self._world.ground.turns()

    def blacks(self) -> np.ndarray:
        """Number of black readings by round on a fixed network (round, robot), of robots that are not done."""
        out = np.zeros((self.rounds + 1, self.setting.robots))
        compiler.compile_world().round_readings(self.given.sensors.of_trial(0), self.given.first, out[1:])
        return out

    @functools.cached_property
    def _blacks(self) -> np.ndarray:
        """The same for viewers; empty for a large swarm."""
        return np.zeros((0, 0)) if self.rounds * self.setting.robots > MOST_READINGS else self.blacks()

    def read(self, tick: int, robot: int) -> tuple[float, int] | None:
        """How many black readings a robot of a fixed network made in a round, and how many in all; None if unknown."""
        if tick <= 0 or not self._blacks.size:
            return None
        return float(self._blacks[tick, robot]), self.setting.observations_per_round

    def heard(self, tick: int, robot: int) -> list[dict[str, Any]]:
        """The messages that a robot heard in a round: the sender, and the contents or what they add to the sums."""
        (senders, carried), (stretch, row) = self.hears(tick, robot), self.find(tick)
        brain = self.setting.brain
        said = stretch.said[row].view(compiler.array_layout(brain).number)
        names = slots({name: brain.lengths[name] for name in brain.sums} if self.adds else brain.message)
        return [
            {"from": int(sender), "said": dict(zip(names, map(json_value, said[sender].tolist()), strict=False))}
            for sender in senders[carried > 0]
        ]

    def hears(self, tick: int, robot: int) -> tuple[np.ndarray, np.ndarray]:
        """The robots that a robot can hear in a round, and whether each link carried a message, 0 or 1."""
        senders = self._neighbours(tick, robot)
        return senders, self.carried(tick, np.full(senders.size, robot), senders)

    def carried(self, tick: int, receivers: np.ndarray, senders: np.ndarray) -> np.ndarray:
        """Whether each link carried a message in a round (link), 0 or 1; all links of each receiver are needed."""
        given, setting, (stretch, row) = self.given, self.setting, self.find(tick)
        out = np.zeros(receivers.size, np.uint8)
        delay = setting.message_delay
        if tick - delay < (1 if setting.body is None else 0):
            return out
        ends = receivers.astype(np.int64), senders.astype(np.int64)
        compiler.compile_world("living").carried(given.radio, given.first, tick, *ends, out)
        works_now = np.ones(setting.robots, np.bool_)
        if given.stops[0].shape[1]:
            works_now &= [works(given.stops[0], TALKING, i, tick - delay) for i in range(setting.robots)]
        signals = stretch.signals[row]
        talks = works_now & (signals == SAID) if signals.size else works_now
        out *= talks[senders]
        if self.swarm.jams:
            noisy = (signals == NOISE) & works_now
            out[np.isin(receivers, receivers[noisy[senders]])] = 0
        return out

    def _neighbours(self, tick: int, robot: int) -> np.ndarray:
        """The robots that a robot can hear in a round, in order."""
        everyone = np.delete(np.arange(self.setting.robots), robot)
        network = self.given.links
        if self.setting.body is None:
            return np.sort(network.senders[network.receivers == robot]) if network.mode == LISTED else everyone
        if self.setting.brain.is_oracle:
            return everyone
        links = self.find(tick)[0].links
        pairs = links[links[:, 0] == tick, 1:]
        return np.sort(np.concatenate([pairs[pairs[:, 0] == robot, 1], pairs[pairs[:, 1] == robot, 0]]))


class _World:
    """A trial's states: `on` runs some rounds from the next one, `first`, and `arrays` are its whole state."""

    setting: Setting
    given: Inputs
    swarm: Swarm
    ground: Ground
    states: States
    tally: Tally

    def stretch(self, first: int, history: np.ndarray, estimates: np.ndarray, *more: np.ndarray) -> Stretch:
        """These rounds as a stretch; robots are asked for decisions and intervals in each of them, if anybody is."""

        def decode(rows: slice) -> Fields:
            again = first > 0  # fields_of takes the first row for the start, before any decision
            parts = (np.concatenate([part[rows][:again], part[rows]]) for part in (history, estimates))
            with blaming(self.setting, self.given.first):
                fields = fields_of(self.setting.brains, self.swarm, *parts)
            return {name: values[again:] for name, values in fields.items()}

        return Stretch(first, estimates, decode, more[0], more[1], history, *more[2:])

    def done(self) -> np.ndarray:
        """Which robots are done by now."""
        verdicts = self.tally.verdicts
        return verdicts[:, IS_DONE] == 1.0 if verdicts.size else np.zeros(self.setting.robots, np.bool_)

    def room(self, rounds: int) -> tuple[np.ndarray, ...]:
        """Room for what is recorded of some rounds: states, messages, whether each was said, and their numbers."""
        robots, size = self.states.memory.shape
        return (
            np.empty((rounds, robots, size), np.uint8),
            np.empty((rounds, robots, self.states.outbox.shape[1]), np.uint8),
            np.empty((rounds, robots if self.states.signals.size else 0), np.uint8),
            np.zeros((rounds, 2), np.int64),
        )

    def begin(self, estimates: np.ndarray, *more: np.ndarray) -> Stretch:
        """The stretch of round 0."""
        memory, outbox, signals, _ = self.states
        said = outbox[np.newaxis, :0], signals[np.newaxis, :0]
        none = np.zeros(self.setting.robots, np.bool_)
        return self.stretch(0, memory[np.newaxis].copy(), estimates, np.zeros((1, 2)), none, *said, *more)


class _Network(_World):
    """States on a network."""

    def __init__(self, setting: Setting, given: Inputs, use: str) -> None:
        self.setting, self.given = setting, given
        self.kernel = compiler.compile_world("living")
        estimates = np.empty((1, setting.robots))
        with blaming(setting, given.first):
            self.swarm = swarm_of(setting, given, use)
            self.states = states_of(setting, self.swarm, given.radio.delay + 2, estimates)
            self.tally = tally_of(setting, 1).of_trial(0)
            self.kernel.start_states(self.swarm, given, self.states, self.tally)
        self.arrays = [*self.states[:3], *self.tally]
        self.start = self.begin(estimates)

    def on(self, first: int, rounds: int) -> Stretch:
        done, estimates = self.done(), np.empty((rounds, self.setting.robots))
        history, said, signals, messages = self.room(rounds)
        with blaming(self.setting, self.given.first):
            kept, alone = (history, said, signals, messages), (np.zeros(1, np.uint8), ALONE, np.zeros((4, 1)))
            states, work = self.states._replace(rows=estimates), work_of(self.swarm, self.given, self.states)
            self.kernel.live(self.swarm, self.given, states, self.tally, first, *kept, *alone, work)
        return self.stretch(first, history, estimates, messages, done, said, signals)


class _Moving(_World):
    """States of robots that move."""

    def __init__(self, setting: Setting, seed: int, given: Inputs) -> None:
        self.setting, self.given = setting, given
        self.stop = np.zeros(1, np.uint8)
        self.walkers, self.ground = Walkers(setting, given), sampling.ground(setting, seed, given.first)
        # the engine writes estimates at their tick: pages of earlier stretches are given back after use
        rows = self.walkers.states.rows
        self.pages = mmap.mmap(-1, rows.nbytes)
        self.walkers.states = self.walkers.states._replace(rows=np.frombuffer(self.pages).reshape(rows.shape))
        self.walkers.tally.counts[...] = 0  # messages that are known beforehand are counted tick by tick here
        self.swarm, self.states, self.tally = self.walkers.swarm, self.walkers.states, self.walkers.tally
        self.commands = commands_of(setting)
        self.walk = walk_of(setting, given, self.stop, self.commands, poses=True)
        self.arrays = [self.walk.bodies.state, *self.walk.neighbours, self.commands, *self.states[:3], *self.tally]
        unknown = np.full((1, setting.robots), np.nan)
        poses = self.walk.poses_now()[np.newaxis]
        self.start = self.begin(self.walkers.start, poses, unknown, np.zeros(unknown.shape, np.bool_), unknown)

    def on(self, first: int, rounds: int) -> Stretch:
        shape, rows = (rounds, self.setting.robots), self.states.rows
        history, said, signals, messages = self.room(rounds)
        poses, colours, readings = np.empty((*shape, 3)), np.empty(shape), np.full(shape, np.nan)
        looked, links, ended, done = np.empty(shape, np.bool_), [], self.done(), 0
        while done < rounds:
            chunk = self.walk.on(first + done, 1 if self.commands.size else rounds - done)
            assert chunk is not None
            part = slice(done, done + len(chunk.looked))
            colours[part] = self.ground.colours(chunk.tiles, chunk.tick)
            poses[part], looked[part] = chunk.poses, chunk.looked
            links.append(links_of(chunk))
            recorded = Recorded(history[part], readings[part], said[part], signals[part], messages[part])
            with blaming(self.setting, self.given.first):
                self.walkers.ride(chunk, colours[part] == 1.0, self.stop, recorded)
                self.walkers.steer(self.commands, chunk.tick)
            done = part.stop
        estimates = rows[first - 1 : first - 1 + rounds].copy()
        if hasattr(self.pages, "madvise"):
            self.pages.madvise(mmap.MADV_DONTNEED)
        lived, walked = (history, estimates, messages, ended, said, signals), (poses, colours, looked, readings)
        return self.stretch(first, *lived, *walked, np.concatenate(links))
