"""Recordings as traces: what robots' logs have of each round, as a simulated trial has it."""

import functools
import threading
from collections.abc import Collection, Iterator, Mapping, Sequence, Set
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr

from swarmcensus.brains import Brain, slots
from swarmcensus.robots.logs.answers import gaps_in
from swarmcensus.robots.logs.clocks import Clock
from swarmcensus.robots.logs.folders import Recording, read_recording
from swarmcensus.robots.logs.lives import RobotReplay, relive_all
from swarmcensus.robots.logs.logs import Block, Tick
from swarmcensus.simulation import (
    DECIDED,
    ENDS,
    IS_DONE,
    STRETCH_BYTES,
    States,
    Stretch,
    Trace,
    free,
    in_ticks,
    inputs_of,
)
from swarmcensus.studies import Setting
from swarmcensus.support.documents import json_value
from swarmcensus.support.errors import ResultsError
from swarmcensus.translation import messages_of

MOST_VALUES = 2**26  # of a trace
MOST_LENGTH = 50  # rounds of a stretch: the last one is recomputed when logs have grown
MOST_MADE = 16  # stretches that are kept
UNKNOWN = -1  # in place of a block: a robot was away, or its log lacks the tick


def shape_of(brain: Brain, taken: Collection[str]) -> dict[str, int]:
    """The fields of what `Replica.remembered` returns, in its order, with their lengths; 0 for a number."""
    verdicts = [DECIDED] * brain.decides + [IS_DONE] * brain.ends + [*ENDS] * brain.has_interval
    memory = {name: brain.lengths[name] for name in sorted(brain.lengths)}
    return memory | {free(name, taken): 0 for name in verdicts}


class Logged(Trace):
    """A recording: the estimates of its logs, and the memory of states that were lived again.

    Logs may grow: `grow` takes what is new. A robot at work, or at work at the end, that has no tick in the last rounds
    is shown in them as after its last tick. The `setting` of a recording is not always known.
    """

    _estimates: np.ndarray  # (round, robot), with room for more rounds
    blocks: np.ndarray  # (round, robot): which block of its log a robot had
    changed: np.ndarray  # (round): the version since which a round is as it is
    messages: np.ndarray  # (round, what): how many all robots had sent and heard
    _counts: np.ndarray  # the same of one round

    def __init__(
        self, recording: Recording, lives: Sequence[RobotReplay], clock: Clock, setting: Setting | None = None,
        at_work: Set[int] = frozenset(),
    ) -> None:  # fmt: skip
        """Order what is known of a recording by rounds. Raises InputError if its logs span too many."""
        self.seed, self.trial, self.clock = recording.seed, recording.trial, clock
        self.labels = [*range(setting.robots)] if setting else [member.number for member in recording.members]
        self._brains: dict[int | None, Brain] = {None: recording.brain}  # by robot, and others that states may have
        if setting is not None:
            self.setting = setting
            self.given = inputs_of(setting, self.seed, self.trial)
            self._brains |= {-1 - k: brain for k, brain in enumerate(setting.brains)}
        self._members = {number: column for column, number in enumerate(self.labels)}
        self._meet(recording)
        self.rounds = 0
        self.version = 0  # counts changes
        self.at_work: Set[int] = frozenset()
        self.logs: dict[int, Sequence[Block]] = {}
        self._last: dict[int, tuple[int, int]] = {}  # by robot: the last round with an estimate, and the block
        self._make_room(0)
        self.length = int(np.clip(STRETCH_BYTES // (8 * len(self.labels) * max(len(self._fields), 1)), 1, MOST_LENGTH))
        self._made: dict[int, tuple[int, Stretch]] = {}  # with the version that they show
        self._lock = threading.Lock()
        self.grow(recording, lives, {member.number: 0 for member in recording.members}, False, at_work)

    def grow(
        self, recording: Recording, lives: Sequence[RobotReplay], new: Mapping[int, int], moved: bool, at_work: Set[int]
    ) -> None:
        """Take the blocks of some robots from the first new one on; all again if rounds of known ones have `moved`."""
        with self._lock:
            self._meet(recording)
            self.logs = {member.number: member.log.blocks for member in recording.members}
            self._lived = {life.number: life.lived for life in lives}
            if moved:
                self._last = {}
                self._make_room(0)
                new = dict.fromkeys(self.logs, 0)
            rounds = max(self.clock.rounds, 1)
            if (rounds + 1) * len(self.labels) * len(slots(self._fields)) > MOST_VALUES:
                too_many = f"its logs span {rounds:,} ticks, too many to keep: is one damaged?"
                raise ResultsError.of(recording.folder, too_many)
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

    def _meet(self, recording: Recording) -> None:
        """Note the brains of robots that are new, and the fields of all."""
        for member in recording.members:
            self._brains.setdefault(member.number, member.brain)
        taken = {name for brain in self._brains.values() for name in brain.lengths}
        self._shapes = {number: shape_of(brain, taken) for number, brain in self._brains.items()}
        self._fields: dict[str, int] = {}
        for number, brain in self._brains.items():
            for name in dict.fromkeys([*brain.memory, *self._shapes[number]]):
                self._fields[name] = max(self._shapes[number][name], self._fields.get(name, 0))

    def since(self, version: int) -> int:
        """The first round that has changed after a version; one after the last if none has."""
        changed = np.flatnonzero(self.changed[: self.rounds + 1] > version)
        return int(changed[0]) if changed.size else self.rounds + 1

    def _make_room(self, rounds: int, keep: bool = False) -> None:
        """Make room for this many rounds; `keep` keeps what is known."""
        old = [self._estimates, self.blocks, self._counts, self.changed] if keep else []
        robots = len(self.labels)
        self._estimates = np.full((rounds, robots), np.nan)
        self.blocks = np.full((rounds, robots), UNKNOWN, np.int32)
        self._counts = np.zeros((rounds, 2), np.int64)
        self.changed = np.zeros(rounds, np.int64)
        for values, before in zip((self._estimates, self.blocks, self._counts, self.changed), old, strict=False):
            values[: len(before)] = before

    def _order(self, number: int, first: int) -> None:
        """Fill in which block of its log a robot had in each round, from the block `first` on, and count messages."""
        lived, blocks, column = self._lived[number], self.logs[number], self._members[number]
        begins = self._last.get(number, (-1, 0))[0] + 1
        for at in range(first, len(blocks)):
            if (one := lived.get(at)) is None:
                continue
            time = self.clock.time(number, at)
            # a start counts only in a round without a tick, because it comes after the tick
            if isinstance(blocks[at], Tick) or self.blocks[time, column] == UNKNOWN:
                self.blocks[time, column], self._estimates[time, column] = at, one.estimate
                begins = min(begins, time)
                self._last[number] = max(self._last.get(number, (-1, 0)), (time, at))  # a forged tick may go back
            self._counts[time] += one.said is not None, len(one.heard)
        self.changed[begins:] = self.version

    def at(self, k: int) -> Stretch:
        """The k-th stretch, from 0 on, or the start."""
        with self._lock:
            if k < 0:
                return self._stretch(0, 1)
            first = k * self.length + 1
            rounds = min(self.length, self.rounds + 1 - first)
            version, stretch = self._made.pop(k, (-1, None))
            if stretch is None or self.changed[first : first + rounds].max(initial=0) > version:
                version, stretch = self.version, self._stretch(first, rounds)
            self._made[k] = version, stretch
            while len(self._made) > MOST_MADE:
                del self._made[next(iter(self._made))]
        return stretch

    @property
    def start(self) -> Stretch:  # type: ignore[override]
        """Before the first tick."""
        return self.at(-1)

    def stretch(self, k: int) -> Stretch | None:
        """The k-th stretch; None for what was before the first round."""
        return self.at(k) if k >= 0 else None

    def read(self, tick: int, robot: int) -> tuple[float, int] | None:
        """How many black readings a robot made in a round, and how many in all; None if its log does not say."""
        at = self._at(tick, robot)
        block = self.logs[robot][at] if at != UNKNOWN else None
        return (float(block.blacks), block.looks) if isinstance(block, Tick) else None

    def heard(self, tick: int, robot: int) -> list[dict[str, Any]]:
        """The messages that a robot heard in a round: the sender, and the contents."""
        names = slots(self.setting.brain.message)
        return [
            {"from": sender, "said": dict(zip(names, self._numbers(code), strict=False))}
            for sender, code in self._received(tick, robot)
        ]

    def hears(self, tick: int, robot: int) -> tuple[np.ndarray, np.ndarray]:
        """The robots that a robot heard in a round, and 1 for each."""
        senders = np.array([sender for sender, _ in self._received(tick, robot)], np.int64)
        return senders, np.ones(senders.size, np.uint8)

    def carried(self, tick: int, receivers: np.ndarray, senders: np.ndarray) -> np.ndarray:
        """Whether a message was heard over each link in a round (link), 0 or 1."""
        robots = len(self.labels)
        pairs = [i * robots + j for i in range(robots) for j, _ in self._received(tick, i) if j < robots]
        return np.isin(receivers * robots + senders, np.array(pairs, np.int64)).astype(np.uint8)

    def _at(self, tick: int, robot: int) -> int:
        """The block of a robot's log that shows it in a round, or UNKNOWN."""
        last, block = self._last.get(robot, (-1, UNKNOWN))
        return block if tick > last and robot in self.at_work else int(self.blocks[tick, self._members[robot]])

    def _received(self, tick: int, robot: int) -> Sequence[tuple[int, bytes]]:
        one = self._lived.get(robot, {}).get(self._at(tick, robot))
        return one.heard if one else ()

    @functools.cached_property
    def _read_message(self) -> Any:
        return messages_of(self.setting.brain).read

    def _numbers(self, code: bytes) -> Iterator[Any]:
        for value in self._read_message(code) or ():
            yield from map(json_value, value if isinstance(value, tuple) else (value,))

    def _stretch(self, first: int, rounds: int) -> Stretch:
        rows, robots = slice(first, first + rounds), len(self.labels)
        blocks, estimates = self.blocks[rows].copy(), self._estimates[rows].copy()
        for robot in self.at_work & self._last.keys():
            last, at = self._last[robot]
            later, column = slice(max(last + 1 - first, 0), None), self._members[robot]
            blocks[later, column], estimates[later, column] = at, self._estimates[last, column]
        decode = functools.partial(self._decode, first, blocks)
        return Stretch(first, estimates, decode, self.messages[rows], np.zeros(robots, np.bool_))

    def _decode(self, first: int, blocks: np.ndarray, rows: slice) -> States:
        """The states after these blocks of the robots' logs (round, robot); NaN where they are not known."""
        blocks = blocks[rows]
        found = {
            name: np.full((*blocks.shape, size)[: 3 if size else 2], np.nan) for name, size in self._fields.items()
        }
        for number in self._members.keys() & self._shapes.keys():
            shape = self._shapes[number]
            lived, column, at = self._lived.get(number, {}), self._members[number], 0
            memories = [lived[block].memory if block in lived else None for block in blocks[:, column].tolist()]
            known = [row for row, memory in enumerate(memories) if memory is not None]
            numbers = np.array([memories[row] for row in known])
            for name, size in shape.items() if known else ():
                if size:
                    found[name][known, column, :size] = numbers[:, at : at + size]
                else:
                    found[name][known, column] = numbers[:, at]
                at += size or 1
        decided = next((name for name in self._fields if name.rstrip("_") == DECIDED), "")
        if decided and first + (rows.start or 0) == 0:
            found[decided][0][~np.isnan(found[decided][0])] = -1.0  # before any observation nobody has decided
        return found


def as_trace(recording: Recording, lives: Sequence[RobotReplay]) -> xr.Dataset:
    """The trace of a recording as a dataset, as `replay` returns it."""
    trace = in_ticks(Logged(recording, lives, Clock(recording.members)).dataset())
    if not all(member.honest for member in recording.members):
        says = {"long_name": "1 where metrics count the robot"}
        trace["honest"] = ("robot", np.array([member.honest for member in recording.members], np.int8), says)
    several = " and ".join(recording.kinds) if len(recording.kinds) > 1 else ""
    title = f"{recording.title}: {several or recording.brain.label}"
    trace.attrs |= {"brain": several or recording.brain.name, "title": title}
    trace.attrs |= {"bins": recording.bins, "delta": recording.delta}
    if recording.fill_ratio is not None:
        trace.attrs["fill_ratio"] = recording.fill_ratio
    return trace


def trace_in(folder: Path) -> xr.Dataset:
    """The trace of a folder of robots' logs; `gaps` is what they lack. Raises InputError."""
    recording = read_recording(folder)
    return as_trace(recording, relive_all(recording, keep=True)).assign_attrs(gaps=gaps_in(recording))
