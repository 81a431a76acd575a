"""When the ticks of a log happened: times since 1970, or since the beginning if the robot knew none."""

from collections.abc import Iterable, Iterator

from swarmcensus.reliving.logs import Gap, State, Tick
from swarmcensus.robot.runtime import since


def timed(blocks: Iterable[State | Tick | Gap], origin: int = 0) -> Iterator[tuple[int, State | Tick]]:
    """Each state and tick of a log with its time in ms.

    A boot that knew the time begins then. Another one begins at `origin` plus its ticks, but not before the boot before
    it has ended. From then on the robot's clock counts, which begins again at 2^30 ms. If it stands still or goes back,
    a tick counts as one period.
    """
    now: int | None = None
    before: State | Tick | None = None
    boot = period = 0
    for block in blocks:
        if isinstance(block, Gap):
            continue
        if isinstance(block, State):
            if now is None or block.boot != boot or block.starts:
                own = block.now or origin + block.tick * block.period
                now = own if block.now and block.starts else max(own, now or 0)
                before = block
            boot, period = block.boot, block.period
        if now is None or before is None:
            continue
        passed = since(block.clock, before.clock)
        now += passed if passed > 0 else max(0, block.tick - before.tick) * period
        before = block
        yield now, block
