"""A day of robots as a life that is watched: what their logs have of each tick, in place of a simulation."""

from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np

from swarmcensus.basics.documents import json_value
from swarmcensus.brains.fields import slots
from swarmcensus.deployment.messages import messages_of
from swarmcensus.engine import compiler
from swarmcensus.reliving.clocks import Clock
from swarmcensus.reliving.folders import Day
from swarmcensus.reliving.logs import Tick
from swarmcensus.reliving.others import OtherDay
from swarmcensus.simulation.inputs import Inputs
from swarmcensus.simulation.living import MOST_ROUNDS, STRETCH_BYTES, Stretch
from swarmcensus.simulation.swarming import minds_of, swarm_of, tally_of
from swarmcensus.simulation.trials import blaming
from swarmcensus.studies.settings import Setting

MOST_MADE = 4  # stretches that are kept
UNKNOWN = -1  # in place of a block: a robot was away, or its log lacks the tick


class Logged:
    """A day, as it was or under another brain, with the attributes of a simulated life."""

    adds = False  # messages are shown as they were sent

    def __init__(self, setting: Setting, given: Inputs, day: Day, lived: OtherDay, clock: Clock) -> None:
        """Order what is known of a day by rounds. Raises InputError if the brain does not compile."""
        self.setting, self.seed, self.trial, self.given = setting, day.seed, day.trial, given
        self.day, self.lived = day, lived
        self.rounds = setting.rounds
        with blaming(setting, given.first):
            self.swarm = swarm_of(setting, given, "network")
            minds = minds_of(setting, self.swarm, 1, np.empty((1, setting.robots)))
            tally = tally_of(setting, 1).of_trial(0)
            compiler.compile_world("living").start_minds(self.swarm, minds, given.first_beliefs, tally)
        self.blank = minds.memory
        shape = (self.rounds + 1, setting.robots)
        self.estimates, self.blocks = np.full(shape, np.nan), np.full(shape, UNKNOWN, np.int32)
        self.messages = np.zeros((self.rounds + 1, 2), np.int64)
        self.logs = {member.number: member.log.blocks for member in day.members}
        self._order(clock)
        reader = messages_of(setting.brain)
        self._contents, self._names = reader.read, slots(setting.brain.message)
        self.length = int(np.clip(STRETCH_BYTES // self.blank.nbytes, 1, min(MOST_ROUNDS, self.rounds)))
        self._made: dict[int, Stretch] = {}
        self.start = self._stretch(0, 1)

    def _order(self, clock: Clock) -> None:
        """Fill in which block of its log each robot had in each round, and count messages."""
        for number, estimates in self.lived.estimates.items():
            for at, estimate in estimates.items():
                time = clock.time(number, at)
                # a start counts only where no tick is: it comes after the tick
                if isinstance(self.logs[number][at], Tick) or self.blocks[time, number] == UNKNOWN:
                    self.blocks[time, number], self.estimates[time, number] = at, estimate
        for number, at in self.lived.said:
            self.messages[clock.time(number, at), 0] += 1
        for (number, at), received in self.lived.received.items():
            self.messages[clock.time(number, at), 1] += len(received)
        self.messages = self.messages.cumsum(axis=0)

    def at(self, k: int) -> Stretch:
        """The k-th stretch, from 0 on."""
        if k not in self._made:
            first = k * self.length + 1
            self._made[k] = self._stretch(first, min(self.length, self.rounds + 1 - first))
            while len(self._made) > MOST_MADE:
                del self._made[next(iter(self._made))]
        return self._made[k]

    def approach(self, k: int) -> bool:
        """Whether the k-th stretch is there: all are."""
        return True

    def kept(self, k: int) -> Stretch | None:
        """The k-th stretch; None for what was before the first round."""
        return self.at(k) if k >= 0 else None

    def read(self, tick: int, robot: int) -> tuple[float, int] | None:
        """How many black readings a robot made in a round, and how many in all; None if its log does not say."""
        block = self._block(tick, robot)
        return (float(block.blacks), block.looks) if block is not None else None

    def heard(self, stretch: Stretch, row: int, robot: int) -> list[dict[str, Any]]:
        """The messages that a robot heard in a round: the sender, and the contents."""
        return [
            {"from": sender, "said": dict(zip(self._names, self._numbers(code), strict=False))}
            for sender, code in self._received(stretch.first + row, robot)
        ]

    def carried(self, stretch: Stretch, row: int, receivers: np.ndarray, senders: np.ndarray) -> np.ndarray:
        """Whether a message was heard over each link in a round (link), 0 or 1."""
        robots = self.setting.robots
        pairs = [
            robot * robots + sender
            for robot in range(robots)
            for sender, _ in self._received(stretch.first + row, robot)
            if sender < robots
        ]
        return np.isin(receivers * robots + senders, np.array(pairs, np.int64)).astype(np.uint8)

    def _block(self, tick: int, robot: int) -> Tick | None:
        at = self.blocks[tick, robot]
        block = self.logs[robot][at] if at != UNKNOWN else None
        return block if isinstance(block, Tick) else None

    def _received(self, tick: int, robot: int) -> list[tuple[int, bytes]]:
        return self.lived.received.get((robot, int(self.blocks[tick, robot])), [])

    def _numbers(self, code: bytes) -> Iterator[Any]:
        for value in self._contents(code) or ():  # type: ignore[no-untyped-call]
            yield from map(json_value, value if isinstance(value, tuple) else (value,))

    def _stretch(self, first: int, rounds: int) -> Stretch:
        rows, robots = slice(first, first + rounds), self.setting.robots
        history, known = self._minds(rows)
        nothing = np.zeros((0, robots))
        return Stretch(
            first, history, np.zeros((rounds, robots, 0)), self.estimates[rows], self.messages[rows],
            np.zeros((0, robots, 3)), nothing, nothing, np.zeros((0, 3), np.int64), np.zeros(robots, np.bool_), known,
        )  # fmt: skip

    def _minds(self, rows: slice) -> tuple[np.ndarray, np.ndarray]:
        """Minds as the engine has them (round, robot, number), and whose are known; others are as at the start."""
        blocks, brains = self.blocks[rows], self.setting.brains
        history = np.repeat(self.blank[np.newaxis], len(blocks), axis=0)
        known = np.zeros(blocks.shape, np.bool_)
        flat, group = history.reshape(len(blocks), -1), self.given.group
        for k, brain in enumerate(brains):
            base, size = self.swarm.bases[k], self.swarm.fields[k]
            robots = np.flatnonzero(group[0] == k) if group.size else np.arange(self.setting.robots)
            records = compiler.array_layout(brain).records(
                flat[:, base : base + size * self.setting.robots].reshape(len(blocks), -1, size)
            )
            for robot in robots.tolist():
                memory = self.lived.memory.get(robot, {})
                for row, at in enumerate(blocks[:, robot].tolist()):
                    if (numbers := memory.get(at)) is not None:
                        known[row, robot] = put(records[row, robot], brain.lengths, numbers)
        return history, known


def put(record: Any, lengths: Mapping[str, int], numbers: list[float]) -> bool:
    """Put the numbers of a memory, in the order of their fields' names, into a record; returns whether they fit."""
    if sum(length or 1 for length in lengths.values()) != len(numbers):
        return False
    at = 0
    for name in sorted(lengths):
        record[name] = numbers[at : at + lengths[name]] if lengths[name] else numbers[at]
        at += lengths[name] or 1
    return True
