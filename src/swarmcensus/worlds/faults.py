"""Robots that fail: from a given round or tick on, or for some time, some of them stop moving, sensing or talking."""

from typing import Annotated, Literal, Self

import numpy as np
from pydantic import BaseModel, BeforeValidator, ConfigDict, Field, model_validator

from swarmcensus.basics.forms import LISTED, ONE_OR_SEVERAL, ROBOTS
from swarmcensus.basics.times import OR_TIME, TIME
from swarmcensus.engine.addresses import address
from swarmcensus.engine.compiler import compile_world
from swarmcensus.engine.constants import MOVING, NEVER, PARTS, SENSING, TALKING

NAMES = {"moving": MOVING, "sensing": SENSING, "talking": TALKING}
HOW_MANY = "robots of a fault are a whole number, or a fraction in [0, 1]"


def _number(value: object) -> object:
    if isinstance(value, bool | str):  # pydantic would read a number from them
        raise ValueError(HOW_MANY)
    return value


class Fault(BaseModel):
    """From round (or tick) `at` on, `robots` of a swarm, a number or a fraction, stop what `stop` says.

    With `until` they do it again from that round on; with `at` 1 they come late.
    A robot that stops talking still hears; one that stops moving is still heard, seen and bumped into.
    """

    model_config = ConfigDict(extra="forbid", frozen=True, use_attribute_docstrings=True)

    at: Annotated[int, Field(strict=True, ge=1, lt=2**31), OR_TIME, TIME]
    """The first round, tick or time with the fault."""
    robots: Annotated[int | float, BeforeValidator(_number), ROBOTS]
    """How many fail: a number, or a fraction of the swarm."""
    stop: Annotated[
        tuple[Literal["moving", "sensing", "talking"], ...],
        Field(min_length=1),
        LISTED,
        ONE_OR_SEVERAL,
    ]
    """What they stop doing."""
    until: Annotated[int, Field(strict=True, ge=1, lt=2**31), OR_TIME, TIME] | None = None
    """The first round, tick or time in which they do it again."""

    @property
    def content(self) -> dict[str, object]:
        """All that it says, for addresses."""
        return self.model_dump(exclude_none=True)

    @model_validator(mode="after")
    def _right(self) -> Self:
        if not (isinstance(self.robots, int) and self.robots >= 0) and not 0.0 <= self.robots <= 1.0:
            raise ValueError(HOW_MANY)
        return self

    def count(self, robots: int) -> int:
        """How many of a swarm fail."""
        return min(robots, self.robots if isinstance(self.robots, int) else round(self.robots * robots))


def stops(faults: tuple[Fault, ...], seed: int, trial: int, robots: int) -> np.ndarray:
    """The first round or tick at which a part of a robot does not work, (part, robot); no robots where none fail.

    Where parts work again there are more rows, as in `swarmcensus.engine.failures`: by fault, when they stop and when
    they begin again. Which robots fail is drawn afresh for each trial and each fault.
    """
    if not faults:
        return np.zeros((PARTS, 0), np.int64)
    passing = any(fault.until is not None for fault in faults)
    out = np.full((PARTS + passing * 2 * PARTS * len(faults), robots), NEVER, np.int64)
    for number, fault in enumerate(faults):
        key = address(seed, "faults", number=number, robots=robots)
        lots = np.empty((1, robots))
        compile_world().spread_uniform(key, trial, 0.0, 1.0, lots)
        failing = np.argsort(lots[0], kind="stable")[: fault.count(robots)]
        for part in map(NAMES.__getitem__, fault.stop):
            out[part, failing] = np.minimum(out[part, failing], fault.at)
            if passing:
                row = PARTS + 2 * PARTS * number + part
                out[row, failing] = fault.at
                out[row + PARTS, failing] = NEVER if fault.until is None else fault.until
    return out


def outages(found: np.ndarray) -> np.ndarray:
    """Of `stops` when each fault's parts do not work, (fault, end, part, robot); no faults where none work again."""
    return found[PARTS:].reshape(-1, 2, PARTS, found.shape[1])


def as_to_an_oracle(found: np.ndarray, lies: np.ndarray) -> np.ndarray:
    """`stops` of a swarm that an oracle hears: whoever sees is heard, and who lies (robot) never sees anything."""
    if not lies.any() and not found.size:
        return found
    out = found.copy() if found.size else np.full((len(found), lies.size), NEVER, np.int64)
    out[SENSING, lies] = 0
    out[TALKING] = NEVER
    spells = outages(out)  # of the very same numbers
    spells[:, 0, SENSING, lies] = 0
    spells[:, 1, SENSING, lies] = NEVER
    spells[:, 0, TALKING] = NEVER
    return out
