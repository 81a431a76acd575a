"""When each tick of each robot was: by a common clock where all logs know the time, else by the robots' own ticks."""

from collections.abc import Iterable, Mapping
from typing import NamedTuple

from swarmcensus.robots.logs.folders import LoggedRobot
from swarmcensus.robots.logs.logs import Block, Gap, State, Tick
from swarmcensus.runtime.runtime import since

TOGETHER = 1.5  # periods: robots whose first ticks are as near as this began together


class _Boot(NamedTuple):
    """What a robot lived between two starts, or after ticks that it missed."""

    at: int  # its first block
    tick: int  # of that block
    zero: float  # when its tick 0 would have been, in periods
    ticks: bool  # whether it came to a tick
    starts: bool = True  # whether the robot started then; False: it went on after ticks that it missed


class Clock:
    """Times of blocks, in ticks, from the first start of any robot on."""

    def __init__(self, members: Iterable[LoggedRobot] = ()) -> None:
        """Read the starts of all robots."""
        self._robots: dict[int, _Robot] = {}
        self._first = 0  # the first time of all: logs may begin after many ticks
        self.is_common = False
        self.go_on(members)

    def go_on(self, members: Iterable[LoggedRobot]) -> bool:
        """Go on with blocks that were appended to logs; returns whether any earlier block has another time now."""
        for member in members:
            self._robots.setdefault(member.number, _Robot(member)).read()
        robots = self._robots.values()
        if not robots:
            return False
        begun = min(robot.reference.zero + robot.reference.tick for robot in robots)
        self.is_common = all(robot.knows_time for robot in robots)
        moved = [robot.place(robot.by_clock(begun) if self.is_common else robot.by_ticks()) for robot in robots]
        first, self._first = self._first, min(robot.times[0] for robot in robots)
        return any(moved) or first != self._first

    def time(self, robot: int, at: int) -> int:
        """The time of a block: 0 at the start, 1 after the first tick."""
        return self._robots[robot].times[at] - self._first

    def last(self, robot: int) -> int:
        """The time of a robot's last block."""
        return self._robots[robot].times[-1] - self._first

    @property
    def rounds(self) -> int:
        """The time of the last block of all."""
        return max(robot.latest for robot in self._robots.values()) - self._first


class _Robot:
    """One robot's lives and the times of its blocks, as far as its log was read."""

    def __init__(self, member: LoggedRobot) -> None:
        self.blocks = member.log.blocks
        self.lives: list[_Boot] = []
        self.knows_time = True
        self.times: list[int] = []
        self._read = 0
        self._clock = LogTimes()
        self._boot, self._period = -1, 1
        self._shifts: dict[int, int | None] = {}  # by the first block of a life: what is added to its ticks
        self._time = self._shift = self.latest = 0

    def read(self) -> None:
        """Note the lives of new blocks; where ticks are late, the earliest one tells when they were due.

        A tick is late by less than a period: where it is later, the robot has missed ticks, as after it was stopped.
        """
        for at in range(self._read, len(self.blocks)):
            block, now = self.blocks[at], self._clock.of(self.blocks[at])
            if now is None or isinstance(block, Gap):
                continue
            if isinstance(block, State):
                self.knows_time = self.knows_time and bool(block.now)
                if block.boot != self._boot or block.starts:
                    self._boot, self._period = block.boot, max(block.period, 1)
                    self.lives.append(_Boot(at, block.tick, now / self._period - block.tick, False))
                continue
            zero, life = now / self._period - block.tick, self.lives[-1]
            if life.ticks and zero - life.zero >= 1.0:
                self.lives.append(_Boot(at, block.tick, zero, True, False))
                continue
            self.lives[-1] = life._replace(zero=min(zero, life.zero) if life.ticks else zero, ticks=True)
        self._read = len(self.blocks)

    @property
    def reference(self) -> _Boot:
        """The first life with a tick: robots may wait for each other between their start and their first tick."""
        return next((life for life in self.lives if life.ticks), self.lives[0])

    def by_clock(self, begun: float) -> dict[int, int | None]:
        """Shifts since `begun`; a robot that began with the others and never started again has its own ticks."""
        reference = self.reference
        late = reference.zero + reference.tick - begun
        first = (0 if late < TOGETHER else int(late)) - reference.tick
        return {life.at: first + round(life.zero - reference.zero) for life in self.lives}

    def by_ticks(self) -> dict[int, int | None]:
        """Shifts where nothing is known of the time between two boots."""
        starts = (life.at for life in self.lives if life.starts)
        return {at: None if k else 0 for k, at in enumerate(starts)}

    def place(self, shifts: Mapping[int, int | None]) -> bool:
        """Find the times of new blocks, or of all if shifts are others than before; returns whether they are."""
        moved = not self._shifts.items() <= shifts.items()
        if moved:
            self.times, self._time, self._shift, self.latest = [], 0, 0, 0
        self._shifts = dict(shifts)
        for at in range(len(self.times), len(self.blocks)):
            block = self.blocks[at]
            if at in shifts and isinstance(block, State | Tick):
                given = shifts[at]
                least = self._time - block.tick + isinstance(block, Tick)
                self._shift = least if given is None else max(given, least)
            if isinstance(block, State | Tick):
                self._time = block.tick + self._shift
            self.times.append(self._time)
            self.latest = max(self.latest, self._time)
        return moved


class LogTimes:
    """The times of a log's blocks, one after the other.

    A boot that knew the time begins then. Another one begins at `origin` plus its ticks, but not before the boot before
    it has ended. From then on the robot's clock counts, which begins again at 2^30 ms. If it stands still or goes back,
    a tick counts as one period.
    """

    def __init__(self, origin: int = 0) -> None:
        """Start before the first block."""
        self._origin = origin
        self._now: int | None = None
        self._before: State | Tick | None = None
        self._boot = self._period = 0

    def of(self, block: Block) -> int | None:
        """The time of the next block, in ms; None for a gap, and before the first state."""
        if isinstance(block, Gap):
            return None
        if isinstance(block, State):
            if self._now is None or block.boot != self._boot or block.starts:
                own = block.now or self._origin + block.tick * block.period
                self._now = own if block.now and block.starts else max(own, self._now or 0)
                self._before = block
            self._boot, self._period = block.boot, block.period
        if self._now is None or self._before is None:
            return None
        passed = since(block.clock, self._before.clock)
        self._now += passed if passed > 0 else max(0, block.tick - self._before.tick) * self._period
        self._before = block
        return self._now
