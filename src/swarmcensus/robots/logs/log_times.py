"""When the ticks of a log happened: times since 1970, or since the beginning if the robot knew none."""

from swarmcensus.robots.logs.logs import Block, Gap, State, Tick
from swarmcensus.runtime.runtime import since


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
