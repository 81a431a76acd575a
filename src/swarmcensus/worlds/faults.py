"""Faults: from a given round or tick on, or for some time, some robots stop moving, sensing or talking."""

from typing import Annotated, Literal

import numpy as np
from pydantic import Field

from swarmcensus.engine import address, compile_world
from swarmcensus.engine.constants import MOVING, NEVER, PARTS, SENSING, TALKING
from swarmcensus.support.times import MOST, OR_TIME
from swarmcensus.support.toml_types import LISTED, ONE_OR_SEVERAL, Robots, TomlTable

NAMES = {"moving": MOVING, "sensing": SENSING, "talking": TALKING}


class Fault(TomlTable):
    """Some robots stop moving, sensing or talking at round (or tick) `at`, and begin again at `until`, if given.

    A robot that stops talking still hears. One that stops moving is still heard, seen and bumped into.
    """

    at: Annotated[int, Field(strict=True, ge=1, le=MOST), OR_TIME]
    """The first round, tick or time with the fault."""
    robots: Robots
    """How many fail: a number, or a fraction of the swarm."""
    stop: Annotated[
        tuple[Literal["moving", "sensing", "talking"], ...],
        Field(min_length=1),
        LISTED,
        ONE_OR_SEVERAL,
    ]
    """What they stop doing."""
    until: Annotated[int, Field(strict=True, ge=1, le=MOST), OR_TIME] | None = None
    """The first round, tick or time in which they do it again."""

    @property
    def content(self) -> dict[str, object]:
        """All its values, for addresses."""
        return self.model_dump(exclude_none=True)

    def count(self, robots: int) -> int:
        """How many of a swarm fail."""
        return min(robots, self.robots if isinstance(self.robots, int) else round(self.robots * robots))


def stops(faults: tuple[Fault, ...], seed: int, trial: int, robots: int) -> np.ndarray:
    """The first round or tick at which each part of a robot does not work, (part, robot); (part, 0) without faults.

    If any fault has an end, more rows follow, as in `swarmcensus.engine.failures`: for each fault, when the parts stop
    and when they work again. Which robots fail is drawn for each trial and each fault.
    """
    if not faults:
        return np.zeros((PARTS, 0), np.int64)
    some_end = any(fault.until is not None for fault in faults)
    out = np.full((PARTS + some_end * 2 * PARTS * len(faults), robots), NEVER, np.int64)
    for number, fault in enumerate(faults):
        key = address(seed, "faults", number=number, robots=robots)
        lots = np.empty((1, robots))
        compile_world().draw_uniform(key, trial, 0.0, 1.0, lots)
        failing = np.argsort(lots[0], kind="stable")[: fault.count(robots)]
        for part in map(NAMES.__getitem__, fault.stop):
            out[part, failing] = np.minimum(out[part, failing], fault.at)
            if some_end:
                row = PARTS + 2 * PARTS * number + part
                out[row, failing] = fault.at
                out[row + PARTS, failing] = NEVER if fault.until is None else fault.until
    return out


def outages(times: np.ndarray) -> np.ndarray:
    """The rows of `stops` on faults with an end, (fault, 0 stop or 1 end, part, robot); none if no fault has one."""
    return times[PARTS:].reshape(-1, 2, PARTS, times.shape[1])


def for_an_oracle(times: np.ndarray, lies: np.ndarray) -> np.ndarray:
    """`stops` as an oracle needs it: every robot that senses is heard, and robots that lie (robot) never sense."""
    if not lies.any() and not times.size:
        return times
    out = times.copy() if times.size else np.full((len(times), lies.size), NEVER, np.int64)
    out[SENSING, lies] = 0
    out[TALKING] = NEVER
    spells = outages(out)  # a view of `out`
    spells[:, 0, SENSING, lies] = 0
    spells[:, 1, SENSING, lies] = NEVER
    spells[:, 0, TALKING] = NEVER
    return out
