"""A robot's life, lived again from its log by the brain that it ran: whether every bit is that of the robot."""

import contextlib
import struct
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, NamedTuple

from swarmcensus.brains import Brain, slots
from swarmcensus.robots.logs.clocks import Clock
from swarmcensus.robots.logs.folders import LoggedRobot, Recording
from swarmcensus.robots.logs.foreign_logs import strangers_of
from swarmcensus.robots.logs.logs import Gap, RobotLog, State, Tick
from swarmcensus.robots.logs.replicas import Replica, Unfit, replica_of
from swarmcensus.support.fork import in_background
from swarmcensus.support.formatting import counted

LARGE = 20_000  # blocks of all logs, from which on a second process is worth its start
# a log lacks its end that is further before that of others than robots stop apart, or than their clocks differ
LEAST_TICKS, LEAST_MS, LEAST_SHARE = 5, 1000, 0.02


class Break(NamedTuple):
    """A tick that was not lived again to the bit, and in what."""

    boot: int
    tick: int
    field: str  # such as "message.x_hat"; one of the memory is only known where the robot saved it


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
    breaks: list[Break] = field(default_factory=list)
    lost: list[Lost] = field(default_factory=list)  # what its log alone shows; `lost_in` knows more
    lived: dict[int, Lived] = field(default_factory=dict)  # by the blocks of ticks and starts

    @property
    def to_the_bit(self) -> bool:
        """Whether all that can be lived again was, to the bit."""
        return not self.breaks


def relive(member: LoggedRobot, keep: bool = False) -> RobotReplay:
    """Live a robot's life again, from each state after a gap or a difference; `keep` keeps its memory of each tick."""
    life = Reliving(member, keep).go_on()
    life.lost = [*_lost(member.log)]
    return life


class Reliving:
    """A life on its way through its log, which may still grow."""

    def __init__(self, member: LoggedRobot, keep: bool = False) -> None:
        """Start before the first block."""
        self.member, self.keep = member, keep
        self.life = RobotReplay(member.number)
        self._at = 0  # the next block
        self._replica: Replica | None = None
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
            names = slots({name: self.member.brain.lengths[name] for name in replica.fields})
            which = _first_name(names, state.numbers, replica.numbers())
            self.life.breaks.append(Break(self._boot, state.tick, f"memory{which}"))
        self._replica = None
        try:
            self._replica = replica = replica_of(self.member.brain, state)
            if state.starts:
                self.life.lived[self._at] = Lived(replica.estimate, self._memory(replica))
        except Unfit as what:
            self.life.breaks.append(Break(self._boot, state.tick, str(what)))

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
        life.breaks.append(Break(self._boot, tick.tick, _difference(self.member.brain, tick, replica)))
        self._replica = None


def _difference(brain: Brain, tick: Tick, replica: Replica) -> str:
    """In what a replica, after this tick, differs from the log."""
    if replica.said != tick.said:
        logged, again = ((said and replica.messages.read(said)) or () for said in (tick.said, replica.said))
        return f"message{_first_name(brain.message, logged, again)}"
    if replica.checksum != tick.checksum:
        return "memory"
    return "estimate" if replica.estimate != tick.estimate else "random numbers"


def _first_name(names: Iterable[str], logged: Iterable[Any], again: Iterable[Any]) -> str:
    """The first name by which two rows differ; empty if one of them is shorter, or they are the same."""
    return next((f".{name}" for name, x, y in zip(names, logged, again, strict=False) if x != y), "")


def relive_all(recording: Recording, keep: bool = False) -> list[RobotReplay]:
    """Live all lives of a recording again, half of them in another process where that is possible."""
    half = len(recording.members) // 2
    if sum(len(member.log.blocks) for member in recording.members) < LARGE:
        half = len(recording.members)
    rest = in_background(lambda: [relive(member, keep) for member in recording.members[half:]])
    return [relive(member, keep) for member in recording.members[:half]] + rest()


def lost_in(recording: Recording) -> dict[int, list[Lost]]:
    """What each log lacks, by robot, without living it again."""
    lost = {member.number: [*_lost(member.log)] for member in recording.members}
    for log, reason in _cut_ends(recording):
        lost[log.number] = lost[log.number] or [Lost(log.states[-1].boot, log.last.tick, None, reason)]
    return lost


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


def _lost(log: RobotLog) -> Iterator[Lost]:
    """What a log lacks: what was cut or damaged, and ticks that were never written."""
    boot, last, gap = 0, 0, ""
    for block in log.blocks:
        if isinstance(block, Gap):
            gap = f"the file is cut or damaged: {counted(block.length, 'byte')} from byte {block.at} on"
            continue
        known = block.tick - isinstance(block, Tick)  # the last one that should be known by now
        state = block if isinstance(block, State) else None
        if known < last or (state and (state.starts or state.boot != boot)):
            if gap:
                yield Lost(boot, last, None, gap)
            boot = state.boot if state else boot
            if known and not (state and state.starts):
                yield Lost(boot, 0, known + 1, "its start is damaged")
        elif known != last or gap:
            yield Lost(boot, last, known + 1, gap or "they were not written, as by a full log")
        last, gap = block.tick, ""
    if gap:
        yield Lost(boot, last, None, gap)


def _cut_ends(recording: Recording) -> Iterator[tuple[RobotLog, str]]:
    """The logs that were cut between two blocks, and how that is known."""
    strangers, counts = strangers_of(recording), dict[int, int]()
    own = [member for member in recording.members if member.number not in strangers]
    with contextlib.suppress(LookupError, TypeError):  # none is known, or others wrote swarm.json
        counts = {k: x for k, x in enumerate(recording.about["result"]["ticks"]) if isinstance(x, int)}
    logs, clock = {member.number: member.log for member in own}, Clock(own)
    heard = _last_heard(logs) if logs.keys() - counts.keys() else {}
    for number, log in logs.items():
        earlier, ticks = clock.rounds - clock.last(number), [tick.tick for tick in log.ticks]
        least = max(LEAST_TICKS, LEAST_MS / max(log.states[0].period, 1), LEAST_SHARE * clock.rounds)
        if len(ticks) < counts.get(number, 0):
            yield log, f"it has {len(ticks):,} of {counts[number]:,} lived ticks"
        elif heard.get(number, 0) > max(ticks, default=0) + LEAST_TICKS:  # of all boots: some robots cannot count them
            yield log, f"another robot heard it in its tick {heard[number]:,}"
        elif number not in counts and clock.is_common and not log.states[-1].boot and earlier > least:
            yield log, f"it ends {earlier:,} ticks before the last log: it was cut, or the robot stopped"


def _last_heard(logs: Mapping[int, RobotLog]) -> dict[int, int]:
    """The last tick of each robot's last boot in which another heard it, or an earlier one; messages count to 2^16."""
    boots = {number: log.states[-1].boot & 0xFF for number, log in logs.items()}
    first = {k: min(state.tick for state in log.states if state.boot & 0xFF == boots[k]) for k, log in logs.items()}
    last = dict(first)
    for receiver, log in logs.items():
        at = dict(first)
        for one in (one for tick in log.ticks for one in tick.heard if one.sender != receiver):
            if boots.get(one.sender) == one.boot:
                at[one.sender] += (one.tick - at[one.sender] + 0x8000) % 0x10000 - 0x8000
                last[one.sender] = max(last[one.sender], at[one.sender])
    return last
