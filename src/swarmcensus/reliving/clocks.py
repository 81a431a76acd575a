"""When each tick of each robot was: by a common clock where all logs know the time, else by the robots' own ticks."""

from collections.abc import Mapping
from typing import NamedTuple

from swarmcensus.reliving.folders import Member
from swarmcensus.reliving.log_times import timed
from swarmcensus.reliving.logs import Gap, State, Tick

TOGETHER = 1.5  # periods: robots whose first ticks are as near as this began together


class _Life(NamedTuple):
    """What a robot lived between two starts."""

    at: int  # the block of its first state
    tick: int  # of that state
    zero: float  # when its tick 0 would have been, in periods
    ticks: bool  # whether it came to a tick


class Clock:
    """Times of blocks, in ticks, from the first start of any robot on."""

    def __init__(self, members: tuple[Member, ...]) -> None:
        """Read the starts of all robots."""
        lives = {member.number: _lives(member) for member in members}
        self.restarted = any(len(of_robot) > 1 for of_robot in lives.values())
        self.is_common = self.restarted and all(state.now for member in members for state in member.log.states)
        if self.is_common:
            references = {number: _reference(of_robot) for number, of_robot in lives.items()}
            begun = min(one.zero + one.tick for one in references.values())
            self.times = {m.number: _by_clock(m, lives[m.number], references[m.number], begun) for m in members}
        else:
            self.times = {member.number: _by_ticks(member, lives[member.number]) for member in members}
        first = min(of_robot[0] for of_robot in self.times.values())  # logs may begin after many ticks
        self.times = {number: [time - first for time in of_robot] for number, of_robot in self.times.items()}

    def time(self, robot: int, at: int) -> int:
        """The time of a block: 0 at the start, 1 after the first tick."""
        return self.times[robot][at]

    @property
    def rounds(self) -> int:
        """The time of the last block of all."""
        return max(max(times) for times in self.times.values())


def _lives(member: Member) -> list[_Life]:
    """The lives of a robot; where ticks are late, the earliest one tells when they were due."""
    lives: list[_Life] = []
    boot = -1
    places = [at for at, block in enumerate(member.log.blocks) if not isinstance(block, Gap)]
    known = list(timed(member.log.blocks))
    for at, (now, block) in zip(places[len(places) - len(known) :], known, strict=True):
        if isinstance(block, State):
            if block.boot != boot or block.starts:
                boot, period = block.boot, max(block.period, 1)
                lives.append(_Life(at, block.tick, now / period - block.tick, False))
            continue
        zero = now / period - block.tick
        life = lives[-1]
        lives[-1] = life._replace(zero=min(zero, life.zero) if life.ticks else zero, ticks=True)
    return lives


def _reference(lives: list[_Life]) -> _Life:
    """The first life with a tick: robots may wait for each other between their start and their first tick."""
    return next((life for life in lives if life.ticks), lives[0])


def _by_clock(member: Member, lives: list[_Life], reference: _Life, begun: float) -> list[int]:
    """Times of blocks since `begun`; a robot that began with the others and never started again has its own ticks."""
    late = reference.zero + reference.tick - begun
    first = (0 if late < TOGETHER else int(late)) - reference.tick
    shifts = {life.at: first + round(life.zero - reference.zero) for life in lives}
    return _times(member, shifts)


def _by_ticks(member: Member, lives: list[_Life]) -> list[int]:
    """Times of blocks where nothing is known of the time between two boots."""
    return _times(member, {life.at: None if at else 0 for at, life in enumerate(lives)})


def _times(member: Member, shifts: Mapping[int, int | None]) -> list[int]:
    """Times of blocks; `shifts` has, by the block of a start, what is added to the ticks from there on."""
    times: list[int] = []
    time = shift = 0
    for at, block in enumerate(member.log.blocks):
        if isinstance(block, State) and at in shifts:
            given = shifts[at]
            shift = time - block.tick if given is None else max(given, time - block.tick)
        if isinstance(block, State | Tick):
            time = block.tick + shift
        times.append(time)
    return times
