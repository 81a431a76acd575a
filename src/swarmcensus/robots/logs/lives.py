"""A robot's life, lived again from its log by the brain that it ran: whether every bit is that of the robot."""

import contextlib
import struct
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, Literal, NamedTuple

from swarmcensus.brains import returning
from swarmcensus.robots.logs.folders import LoggedRobot, Recording
from swarmcensus.robots.logs.logs import Gap, RobotLog, State, Tick
from swarmcensus.robots.logs.replicas import Replica, Unfit, replica_of
from swarmcensus.support.fork import in_background
from swarmcensus.support.formatting import counted

ANOTHER = "the robot ran another brain: the hash of its file"
WHOLE = ANOTHER, " is another brain than the robot's: "  # in reasons that hold for a whole log
LARGE = 20_000  # blocks of all logs, from which on a second process is worth its start


class Start(NamedTuple):
    """How a robot came to its memory when it started."""

    at: int  # the block of its state
    boot: int
    tick: int
    kind: Literal["blank", "resumed", "unknown"]
    source: int = -1  # the block after which the memory was saved; -1 where none is known
    source_boot: int = -1


class Break(NamedTuple):
    """A tick that was not lived again to the bit, and in which part."""

    boot: int
    tick: int
    reason: str


class Lost(NamedTuple):
    """A part of a life that the log does not hold."""

    boot: int
    after: int  # the last tick before it
    before: int | None  # the first one after it; None: the log ends
    reason: str


class Lived(NamedTuple):
    """What a robot believed and remembered after a block of its log, and what it said and heard in it."""

    estimate: float
    memory: list[float] | None  # as `Replica.remembered`; None if it is not known, or not kept
    said: bytes | None = None
    heard: Sequence[tuple[int, bytes]] = ()  # senders and messages


@dataclass
class RobotReplay:
    """What came of living a log again."""

    number: int
    ticks: int = 0  # whole ones in the log
    relived: int = 0  # of these, to the bit
    unknown: int = 0  # of these, from a memory that is not known
    starts: list[Start] = field(default_factory=list)
    breaks: list[Break] = field(default_factory=list)
    lost: list[Lost] = field(default_factory=list)
    lived: dict[int, Lived] = field(default_factory=dict)  # by the blocks of ticks and starts

    @property
    def to_the_bit(self) -> bool:
        """Whether all that can be lived again was, to the bit."""
        return not self.breaks

    def differs(self, boot: int, tick: int, reason: str) -> None:
        """Note that a tick was not lived again; a reason for the whole log is given once, not at each state."""
        before = {one.reason for one in self.breaks if any(words in reason for words in WHOLE)}
        if reason not in before:
            self.breaks.append(Break(boot, tick, reason))


def relive(member: LoggedRobot, keep: bool = False, about: Mapping[str, Any] = {}) -> RobotReplay:
    """Live a robot's life again, from each state after a gap or a difference.

    `keep` keeps its memory of each tick; `about` is the content of swarm.json.
    """
    with returning([member.brain]):
        life = Reliving(member, keep).go_on()
    life.starts = starts_of(member)
    life.lost = [*_lost(member.log), *_lost_end(member.log, about)]
    return life


class Reliving:
    """A life on its way through its log, which may still grow."""

    def __init__(self, member: LoggedRobot, keep: bool = False) -> None:
        """Start before the first block."""
        self.member, self.keep = member, keep
        self.life = RobotReplay(member.number)
        self._at = 0  # the next block
        self._replica: Replica | None = None
        self._state: State  # that the replica started from
        self._boot = 0

    def go_on(self) -> RobotReplay:
        """Live the blocks that were not lived yet."""
        blocks = self.member.log.blocks
        while self._at < len(blocks):
            block = blocks[self._at]
            if isinstance(block, Gap):
                self._replica = None
            elif isinstance(block, State):
                self._become(block)
            else:
                self._live(block)
            self._at += 1
        return self.life

    def _become(self, state: State) -> None:
        """Check a state against a saved state, or take over a state after a start, a gap or a difference."""
        self._boot = state.boot
        replica = self._replica
        if replica is not None and not state.starts and replica.ticks == state.tick:  # else ticks are missing
            if replica.checksum == state.checksum:
                return
            self.life.differs(self._boot, state.tick, "its saved memory is not what its ticks lead to")
        self._state, self._replica = state, None
        try:
            self._replica = replica = replica_of(self.member.brain, state)
            if state.starts:
                self.life.lived[self._at] = Lived(replica.estimate, self._memory(replica))
        except Unfit as why:
            another = f"{self.member.brain.path} is another brain than the robot's: {why}"
            self.life.differs(self._boot, state.tick, _other_hash(self.member, state) or another)

    def _memory(self, replica: Replica) -> list[float] | None:
        return replica.remembered() if self.keep else None

    def _live(self, tick: Tick) -> None:
        """Live a tick, if the state before it is known."""
        replica, life = self._replica, self.life
        life.ticks += 1
        logged = life.lived[self._at] = Lived(tick.estimate, None, tick.said, [(h.sender, h.code) for h in tick.heard])
        if replica is None or replica.ticks + 1 != tick.tick:
            life.unknown += 1
            self._replica = None
            return
        if is_relived(replica, tick):
            life.relived += 1
            life.lived[self._at] = logged._replace(memory=self._memory(replica))
            return
        life.differs(self._boot, tick.tick, _other_hash(self.member, self._state) or _difference(tick, replica))
        self._replica = None


def _other_hash(member: LoggedRobot, state: State) -> str | None:
    """A sentence if the robot's brain has another hash than the file that it was lived again with."""
    if state.brain == bytes(8) or member.brain.sha256.startswith(state.brain.hex()):
        return None
    return f"{ANOTHER} begins with {state.brain.hex()}, and that of {member.brain.path} with {member.brain.sha256[:16]}"


def _difference(tick: Tick, replica: Replica) -> str:
    """How a replica, after this tick, differs from the log."""
    if replica.said != tick.said:
        logged, again = ("nothing" if said is None else said.hex() for said in (tick.said, replica.said))
        return f"its message differs: {logged} in the log, {again} computed again"
    if replica.estimate != tick.estimate:
        return f"its estimate differs: {tick.estimate:.17g} in the log, {replica.estimate:.17g} computed again"
    return "its memory differs, or the random numbers that it drew"


def relive_all(recording: Recording, keep: bool = False) -> list[RobotReplay]:
    """Live all lives of a recording again, half of them in another process where that is possible."""
    half = len(recording.members) // 2
    if sum(len(member.log.blocks) for member in recording.members) < LARGE:
        half = len(recording.members)
    rest = in_background(lambda: [relive(member, keep, recording.about) for member in recording.members[half:]])
    return [relive(member, keep, recording.about) for member in recording.members[:half]] + rest()


def is_relived(replica: Replica, tick: Tick) -> bool:
    """Live one tick; returns whether what was said, the estimate and the memory are those of the log."""
    replica.lots, replica.lacked = list(tick.draws), 0
    if replica.first_half(tick) != tick.said:
        return False
    for heard in tick.heard:
        replica.hear(heard.code)
    replica.think()
    if replica.checksum != tick.checksum or replica.lots or replica.lacked:
        return False
    return struct.pack("<d", replica.estimate) == struct.pack("<d", tick.estimate)


def starts_of(member: LoggedRobot) -> list[Start]:
    """How each start of a log came to its memory: blank, or saved after an earlier tick of the same robot."""
    known: dict[tuple[int, int], tuple[int, int]] = {}  # tick and checksum: block and boot
    starts, boot = [], 0
    for at, block in enumerate(member.log.blocks):
        if isinstance(block, Tick):
            known[block.tick, block.checksum] = at, boot
        elif isinstance(block, State):
            boot, saved = block.boot, (block.tick, block.checksum)
            if not block.starts:
                known.setdefault(saved, (at, boot))
            elif _is_blank(member, block):
                starts.append(Start(at, boot, block.tick, "blank"))
            elif saved in known:
                starts.append(Start(at, boot, block.tick, "resumed", *known[saved]))
            else:
                starts.append(Start(at, boot, block.tick, "unknown"))
    return starts


def _is_blank(member: LoggedRobot, state: State) -> bool:
    if state.tick or any(state.owed):
        return False
    try:
        replica = replica_of(member.brain, state)
    except Unfit:
        return False
    replica._give(replica.brain.MEMORY)
    return replica.checksum == state.checksum


def _lost(log: RobotLog) -> Iterator[Lost]:
    """What a log lacks: what was cut or damaged, and ticks that were never written."""
    boot, last, gap = 0, 0, None
    for block in log.blocks:
        if isinstance(block, Gap):
            gap = block
            continue
        tick = block.tick - isinstance(block, Tick)  # the last one that should be known by now
        starts = isinstance(block, State) and block.starts
        if starts or tick < last or (isinstance(block, State) and block.boot != boot):
            if gap:
                yield Lost(boot, last, None, _damage(gap))
            boot = block.boot if isinstance(block, State) else boot
            if not starts and tick:
                yield Lost(boot, 0, tick + 1, "its start is damaged")
            last, gap = block.tick, None
            continue
        if tick != last or gap:
            yield Lost(boot, last, tick + 1, _damage(gap) if gap else "they were not written, as by a full log")
        last, gap = block.tick, None
    if gap:
        yield Lost(boot, last, None, _damage(gap))


def _lost_end(log: RobotLog, about: Mapping[str, Any]) -> Iterator[Lost]:
    """What a log lacks that was cut between two blocks: no tick of it has the last estimate in swarm.json."""
    last: Any = log.blocks[-1]
    with contextlib.suppress(LookupError, TypeError):  # of a swarm.json that others wrote
        final, robot = about["result"]["estimates"][log.number], about["robots"][log.number]
        has_ticked = not isinstance(last, Gap) and not getattr(last, "starts", False)
        if has_ticked and robot["runs_on"] == "cpython" and final not in (None, *(one.estimate for one in log.ticks)):
            yield Lost(log.states[-1].boot, last.tick, None, f"the log ends before the last estimate, {final}")


def _damage(gap: Gap) -> str:
    what = "the file was cut" if gap.is_last and gap.length < 4096 else "the file is damaged"
    return f"{what}: {counted(gap.length, 'byte')} from byte {gap.at} on"
