"""A recording in place of a simulation: what robots' logs have of each tick."""

import threading
from collections.abc import Iterator, Mapping, Sequence, Set
from typing import Any

import numpy as np

from swarmcensus.brains import slots
from swarmcensus.engine import compiler
from swarmcensus.robots import Block, Clock, Recording, Relived, Tick
from swarmcensus.simulation import STRETCH_BYTES, Stretch, blaming, inputs_of, states_of, swarm_of, tally_of
from swarmcensus.studies import Setting
from swarmcensus.support.documents import json_value
from swarmcensus.translation import messages_of

MOST_LENGTH = 50  # rounds of a stretch: the last one is recomputed when logs have grown
MOST_MADE = 16  # stretches that are kept
UNKNOWN = -1  # in place of a block: a robot was away, or its log lacks the tick


class Logged:
    """A recording, as it was or with another brain, with the attributes of a simulated trial.

    Logs may grow: `grow` takes what is new. A robot at work, or at work at the end, that has no tick in the last rounds
    is shown in them as after its last tick.
    """

    adds = False  # messages are shown as they were sent
    estimates: np.ndarray  # (round, robot), with room for more rounds
    blocks: np.ndarray  # (round, robot): which block of its log a robot had
    changed: np.ndarray  # (round): the version since which a round is as it is
    messages: np.ndarray  # (round, what): how many all robots had sent and heard
    _counts: np.ndarray  # the same of one round

    def __init__(self, setting: Setting, recording: Recording, lived: Relived, clock: Clock, at_work: Set[int]) -> None:
        """Order what is known of a recording by rounds. Raises InputError if the brain does not compile."""
        self.setting, self.seed, self.trial = setting, recording.seed, recording.trial
        self.given = given = inputs_of(setting, self.seed, self.trial)
        self.lived, self.clock = lived, clock
        with blaming(setting, given.first):
            self.swarm = swarm_of(setting, given, "network")
            states = states_of(setting, self.swarm, 1, np.empty((1, setting.robots)))
            tally = tally_of(setting, 1).of_trial(0)
            compiler.compile_world("living").start_states(self.swarm, given, states, tally)
        self.blank = states.memory
        self.rounds = 0
        self.version = 0  # counts changes
        self.at_work: Set[int] = frozenset()
        self.logs: dict[int, Sequence[Block]] = {}
        self._last: dict[int, tuple[int, int]] = {}  # by robot: the last round with an estimate, and the block
        self._make_room(0)
        reader = messages_of(setting.brain)
        self._contents, self._names = reader.read, slots(setting.brain.message)
        self.length = int(np.clip(STRETCH_BYTES // self.blank.nbytes, 1, MOST_LENGTH))
        self._made: dict[int, tuple[int, Stretch]] = {}  # with the version that they show
        self._lock = threading.Lock()
        self.grow(recording, {member.number: 0 for member in recording.members}, False, at_work)

    def grow(self, recording: Recording, new: Mapping[int, int], moved: bool, at_work: Set[int]) -> None:
        """Take the blocks of some robots from the first new one on; all again if rounds of known ones have `moved`."""
        with self._lock:
            self.logs = {member.number: member.log.blocks for member in recording.members}
            if moved:
                self._last = {}
                self._make_room(0)
                new = dict.fromkeys(self.logs, 0)
            rounds = max(self.clock.rounds, 1)
            if len(self.blocks) <= rounds:
                self._make_room(2 * rounds if self.version else rounds + 1, keep=not moved)
            self.version += 1
            for number in self.at_work ^ at_work:  # they are away after their last ticks, or not
                self.changed[self._last.get(number, (-1, 0))[0] + 1 :] = self.version
            for number, first in new.items():
                self._order(number, first)
            if moved:
                self.changed[:] = self.version
            self.messages = self._counts[: rounds + 1].cumsum(axis=0)
            self.at_work, self.rounds = at_work, rounds

    def since(self, version: int) -> int:
        """The first round that has changed after a version; one after the last if none has."""
        changed = np.flatnonzero(self.changed[: self.rounds + 1] > version)
        return int(changed[0]) if changed.size else self.rounds + 1

    def _make_room(self, rounds: int, keep: bool = False) -> None:
        """Make room for this many rounds; `keep` keeps what is known."""
        old = [self.estimates, self.blocks, self._counts, self.changed] if keep else []
        robots = self.setting.robots
        self.estimates = np.full((rounds, robots), np.nan)
        self.blocks = np.full((rounds, robots), UNKNOWN, np.int32)
        self._counts = np.zeros((rounds, 2), np.int64)
        self.changed = np.zeros(rounds, np.int64)
        for values, before in zip((self.estimates, self.blocks, self._counts, self.changed), old, strict=False):
            values[: len(before)] = before

    def _order(self, number: int, first: int) -> None:
        """Fill in which block of its log a robot had in each round, from the block `first` on, and count messages."""
        lived, blocks = self.lived, self.logs[number]
        estimates = lived.estimates.get(number, {})
        begins = self._last.get(number, (-1, 0))[0] + 1
        for at in range(first, len(blocks)):
            time = self.clock.time(number, at)
            estimate = estimates.get(at)
            # a start counts only in a round without a tick, because it comes after the tick
            if estimate is not None and (isinstance(blocks[at], Tick) or self.blocks[time, number] == UNKNOWN):
                self.blocks[time, number], self.estimates[time, number] = at, estimate
                begins = min(begins, time)
                self._last[number] = max(self._last.get(number, (-1, 0)), (time, at))  # a forged tick may go back
            self._counts[time] += (number, at) in lived.said, len(lived.received.get((number, at), ()))
        self.changed[begins:] = self.version

    def at(self, k: int) -> Stretch:
        """The k-th stretch, from 0 on."""
        first = k * self.length + 1
        with self._lock:
            rounds = min(self.length, self.rounds + 1 - first)
            version, stretch = self._made.pop(k, (-1, None))
            if stretch is None or self.changed[first : first + rounds].max(initial=0) > version:
                version, stretch = self.version, self._stretch(first, rounds)
            self._made[k] = version, stretch
            while len(self._made) > MOST_MADE:
                del self._made[next(iter(self._made))]
        return stretch

    @property
    def start(self) -> Stretch:
        """Before the first tick."""
        with self._lock:
            return self._stretch(0, 1)

    def approach(self, k: int) -> bool:
        """Whether the k-th stretch is there: all are."""
        return True

    def stretch(self, k: int) -> Stretch | None:
        """The k-th stretch; None for what was before the first round."""
        return self.at(k) if k >= 0 else None

    def read(self, tick: int, robot: int) -> tuple[float, int] | None:
        """How many black readings a robot made in a round, and how many in all; None if its log does not say."""
        at = self._at(tick, robot)
        block = self.logs[robot][at] if at != UNKNOWN else None
        return (float(block.blacks), block.looks) if isinstance(block, Tick) else None

    def heard(self, stretch: Stretch, row: int, robot: int) -> list[dict[str, Any]]:
        """The messages that a robot heard in a round: the sender, and the contents."""
        return [
            {"from": sender, "said": dict(zip(self._names, self._numbers(code), strict=False))}
            for sender, code in self._received(stretch.first + row, robot)
        ]

    def hears(self, stretch: Stretch, row: int, robot: int) -> tuple[np.ndarray, np.ndarray]:
        """The robots that a robot heard in a round, and 1 for each."""
        senders = np.array([sender for sender, _ in self._received(stretch.first + row, robot)], np.int64)
        return senders, np.ones(senders.size, np.uint8)

    def carried(self, stretch: Stretch, row: int, receivers: np.ndarray, senders: np.ndarray) -> np.ndarray:
        """Whether a message was heard over each link in a round (link), 0 or 1."""
        tick, robots = stretch.first + row, self.setting.robots
        pairs = [i * robots + j for i in range(robots) for j, _ in self._received(tick, i) if j < robots]
        return np.isin(receivers * robots + senders, np.array(pairs, np.int64)).astype(np.uint8)

    def _at(self, tick: int, robot: int) -> int:
        """The block of a robot's log that shows it in a round, or UNKNOWN."""
        last, block = self._last.get(robot, (-1, UNKNOWN))
        return block if tick > last and robot in self.at_work else int(self.blocks[tick, robot])

    def _received(self, tick: int, robot: int) -> list[tuple[int, bytes]]:
        return self.lived.received.get((robot, self._at(tick, robot)), [])

    def _numbers(self, code: bytes) -> Iterator[Any]:
        for value in self._contents(code) or ():  # type: ignore[no-untyped-call]
            yield from map(json_value, value if isinstance(value, tuple) else (value,))

    def _stretch(self, first: int, rounds: int) -> Stretch:
        rows, robots = slice(first, first + rounds), self.setting.robots
        blocks, estimates = self.blocks[rows].copy(), self.estimates[rows].copy()
        for robot in self.at_work & self._last.keys():
            last, at = self._last[robot]
            later = slice(max(last + 1 - first, 0), None)
            blocks[later, robot], estimates[later, robot] = at, self.estimates[last, robot]
        history, known = self._states(blocks)
        return Stretch(
            first, history, np.zeros((rounds, robots, 0)), np.zeros((rounds, 0)), estimates, self.messages[rows],
            np.zeros(robots, np.bool_), known=known,
        )  # fmt: skip

    def _states(self, blocks: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """States as the engine has them (round, robot, byte), and which are known; others are as at the start."""
        history = np.repeat(self.blank[np.newaxis], len(blocks), axis=0)
        known = np.zeros(blocks.shape, np.bool_)
        flat, group = history.reshape(len(blocks), -1), self.given.group
        for k, brain in enumerate(self.setting.brains):
            base, size = self.swarm.bases[k], self.swarm.sizes[k]
            robots = np.flatnonzero(group[0] == k) if group.size else np.arange(self.setting.robots)
            records = compiler.array_layout(brain).records(
                flat[:, base : base + size * self.setting.robots].reshape(len(blocks), -1, size)
            )
            for robot in robots.tolist():
                memory = self.lived.memory.get(robot, {})
                known[:, robot] = put(records[:, robot], brain.lengths, [memory.get(at) for at in blocks[:, robot]])
        return history, known


def put(records: Any, lengths: Mapping[str, int], states: list[list[float] | None]) -> list[bool]:
    """Put the numbers of states, in the order of their fields' names, into records; returns which are known and fit."""
    width = sum(length or 1 for length in lengths.values())
    fit = [numbers is not None and len(numbers) == width for numbers in states]
    rows = np.flatnonzero(fit)
    values = np.array([states[row] for row in rows]).reshape(len(rows), width)
    at = 0
    for name in sorted(lengths):
        records[name][rows] = values[:, at : at + lengths[name]] if lengths[name] else values[:, at]
        at += lengths[name] or 1
    return fit
