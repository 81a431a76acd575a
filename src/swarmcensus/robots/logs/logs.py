"""A robot's log, read: blocks to states and ticks, whatever was cut or damaged."""

import struct
from binascii import crc32
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple

from swarmcensus.runtime import log as written
from swarmcensus.support.errors import ResultsError

PART = 16_384  # bytes of a log that are read at a time while it grows
AROUND = 5, 2  # bytes before the body of a block and after it


class Heard(NamedTuple):
    """A message that a brain received."""

    sender: int
    boot: int  # the low byte of the sender's boot count
    tick: int  # the low two bytes of the sender's tick
    code: bytes  # the message, without header and checksum


class State(NamedTuple):
    """What a robot was, and what its state held, at a start or when it saved its memory."""

    starts: bool
    feedback: bool
    single: bool
    form: int  # of the message, in `FORMATS`; 0 if unknown
    boot: int
    mark: int  # the lower half of the datagrams'
    number: int
    code_bytes: int  # of a message, without header and checksum
    tick: int
    period: int  # ms
    clock: int  # ms; it begins again at 2^30
    brain: bytes  # the first 8 of the SHA-256 of the brain's file
    now: int  # ms since 1970 when the robot started; 0 if unknown
    b: float
    w: float
    parameters: tuple[float, ...]  # by name
    numbers: tuple[float, ...]  # of the memory
    owed: tuple[float, ...]  # what rounding took of messages

    @property
    def checksum(self) -> int:
        """The checksum of what the robot saved, as ticks have it."""
        saved = (*self.numbers, *self.owed)
        return crc32(struct.pack(f"<{len(saved)}d", *saved))


class Tick(NamedTuple):
    """What happened in one tick, in this order."""

    tick: int
    clock: int  # ms, when it began
    blacks: int
    looks: int
    said: bytes | None
    heard: tuple[Heard, ...]
    draws: tuple[float, ...]
    estimate: float
    checksum: int  # CRC-32 of the memory and of what is owed, at the end


class Gap(NamedTuple):
    """Bytes of a log that hold no whole block."""

    at: int
    length: int
    is_last: bool  # nothing follows: the log was cut


Block = State | Tick | Gap


@dataclass(frozen=True)
class RobotLog:
    """All that is whole in a log, in its order."""

    path: Path
    number: int
    blocks: Sequence[Block]  # a list that grows where a `LogReader` reads the log

    @property
    def states(self) -> list[State]:
        """The states, of which the first is of a start."""
        return [block for block in self.blocks if isinstance(block, State)]

    @property
    def ticks(self) -> list[Tick]:
        """The ticks."""
        return [block for block in self.blocks if isinstance(block, Tick)]

    @property
    def last(self) -> State | Tick:
        """The last state or tick."""
        return next(block for block in reversed(self.blocks) if not isinstance(block, Gap))


def read_log(path: str | Path) -> RobotLog:
    """Read the log of one robot. Raises InputError if the file cannot be read, or has no whole state."""
    path = Path(path)
    try:
        blocks = tuple(_blocks(path.read_bytes(), path))
    except OSError as error:
        raise ResultsError.of(path, f"{error.strerror}") from None
    number = _number_of(blocks, path)
    if number is None:
        what = "" if blocks else "the file is empty, and "
        raise ResultsError.of(path, f"{what}should be a robot's log, which begins with what the robot is")
    return RobotLog(path, number, blocks)


class LogReader:
    """Reads the log of one robot while it grows: only what was appended since it was last read."""

    def __init__(self, path: Path) -> None:
        """Read nothing yet; the file need not exist."""
        self.path = path
        self.blocks: list[Block] = []
        self.log: RobotLog | None = None  # known after the first state
        self.is_behind = False  # whether there is more than was read
        self._at = 0  # the byte that is read next
        self._state: State | None = None  # the last one

    def more(self, most: int = PART) -> bool:
        """Append new whole blocks of the next `most` bytes to `blocks`; returns whether there are any.

        A last block that is not whole is left for the next time, because it may still be being written. Raises
        InputError if the file cannot be read, or is not a log of one robot.
        """
        try:
            with self.path.open("rb") as file:
                file.seek(self._at)
                data = file.read(most)
                self.is_behind = len(data) == most and file.read(1) != b""
        except FileNotFoundError:
            return False
        except OSError as error:
            raise ResultsError.of(self.path, f"{error.strerror}") from None
        before = [self._state] if self._state else []
        new = list(_blocks(data, self.path, self._at, self._state.code_bytes if self._state else -1))
        end = self._at + len(data)
        if new and isinstance(new[-1], Gap) and new[-1].is_last:
            end = new.pop().at  # type: ignore[union-attr]
        self._at = end
        if not new and self.is_behind:  # a block, or damage, that is longer
            return self.more(16 * most)
        number = _number_of([*before, *new], self.path)
        self._state = next((block for block in reversed(new) if isinstance(block, State)), self._state)
        self.blocks += new
        if self.log is None and number is not None:
            self.log = RobotLog(self.path, number, self.blocks)
        return bool(new)


def _number_of(blocks: Sequence[Block], path: Path) -> int | None:
    """The number of the robot of a log; None without a state. Raises InputError if there are several."""
    numbers = [block.number for block in blocks if isinstance(block, State)]
    if strangers := set(numbers) - set(numbers[:1]):
        raise ResultsError.of(path, f"the log is of robot {numbers[0]} and of robot {min(strangers)}: of one is right")
    return numbers[0] if numbers else None


def _blocks(data: bytes, path: Path, origin: int = 0, size: int = -1) -> Iterator[Block]:
    """The blocks of a part of a log from byte `origin` on; `size`: bytes of a message, known after the first state."""
    at = 0
    while at < len(data):
        kind, body, after = block_at(data, at)
        if body is None or (kind == written.TICK and size < 0):
            after = _next_state(data, at)
            yield Gap(origin + at, after - at, after == len(data))
        elif kind == written.STATE:
            try:
                state = _state(body, path)
            except struct.error:
                yield Gap(origin + at, after - at, after == len(data))
            else:
                size = state.code_bytes
                yield state
        elif kind == written.TICK and (tick := _tick(body, size)):
            yield tick
        at = after


def block_at(data: bytes, at: int) -> tuple[int, bytes | None, int]:
    """The kind and the body of the block that begins here, None if it is not whole, and where the next one begins."""
    before, behind = AROUND
    if at + before + behind > len(data):
        return 0, None, at
    kind, length = struct.unpack_from("<BI", data, at)
    end = at + before + length
    if end + behind > len(data) or struct.unpack_from("<H", data, end)[0] != crc32(data[at:end]) & 0xFFFF:
        return kind, None, at
    return kind, data[at + before : end], end + behind


def _next_state(data: bytes, at: int) -> int:
    """Where the next whole state begins: ticks after damage begin from an unknown memory."""
    while (found := data.find(written.MAGIC, at + 1)) >= 0:
        begins = found - AROUND[0]
        if begins > at and data[begins] == written.STATE and block_at(data, begins)[1] is not None:
            return begins
        at = found
    return len(data)


def _state(body: bytes, path: Path) -> State:
    head = struct.calcsize(written.HEAD)
    magic, version, flags, form, *rest = struct.unpack_from(written.HEAD, body)
    if magic != written.MAGIC:
        raise struct.error("another kind of state")
    if version != written.VERSION:
        raise ResultsError.of(path, f"a log of version {version}: this swarmcensus reads version {written.VERSION}")
    *rest, parameters, numbers, owed = rest
    values = struct.unpack_from(f"<{parameters + numbers + owed}d", body, head)
    starts, feedback, single = (bool(flags & flag) for flag in (written.STARTS, written.FEEDBACK, written.SINGLE))
    own, owes = values[parameters : parameters + numbers], values[parameters + numbers :]
    return State._make([starts, feedback, single, form, *rest, values[:parameters], own, owes])


def _tick(body: bytes, size: int) -> Tick | None:
    """A tick; None if its parts do not fit, as those of another writer."""
    try:
        tick, clock, blacks, looks, flags, count = struct.unpack_from(written.OPENING, body)
        at = struct.calcsize(written.OPENING)
        said, heard, draws = None, [], ()
        if flags & written.SAID:
            said = body[at : at + size]
            at += size
        for _ in range(count):
            sender, boot, sent = struct.unpack_from(written.FROM, body, at)
            at += struct.calcsize(written.FROM) + size
            heard.append(Heard(sender, boot, sent, body[at - size : at]))
        if flags & written.DREW:
            drawn = struct.unpack_from("<H", body, at)[0]
            draws = struct.unpack_from(f"<{drawn}d", body, at + 2)
            at += 2 + 8 * drawn
        estimate, checksum = struct.unpack(written.ENDING, body[at:])
    except struct.error:
        return None
    return Tick(tick, clock, blacks, looks, said, tuple(heard), draws, estimate, checksum)
