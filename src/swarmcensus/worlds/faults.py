"""Faults: from a given round or tick on, or for some time, some robots stop moving, sensing or talking.

Robots that are processes may also be killed, restarted, stopped, or cut off from the others.
"""

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Annotated, Any, Literal, Self, TypeAlias

import numpy as np
from pydantic import AfterValidator, Field, model_validator

from swarmcensus.engine import address, compile_world
from swarmcensus.engine.constants import MOVING, NEVER, PARTS, SENSING, TALKING
from swarmcensus.support.times import MOST, OR_TIME
from swarmcensus.support.toml_types import LISTED, OrElse, Robots, TomlTable, ValueTable, usual

NAMES = {"moving": MOVING, "sensing": SENSING, "talking": TALKING}
Number = Annotated[int, Field(strict=True, ge=0)]  # of a robot


def _distinct(robots: tuple[int, ...]) -> tuple[int, ...]:
    if len({*robots}) < len(robots):
        raise ValueError("should name each robot once")
    return tuple(sorted(robots))


class Named(ValueTable):
    """Robots by their numbers, from 0, in place of a number of robots that are drawn."""

    named: Annotated[tuple[Number, ...], Field(min_length=1), AfterValidator(_distinct)]


Part = Literal["moving", "sensing", "talking"]
if TYPE_CHECKING:
    from swarmcensus.support.toml_types import Checked, Int, Real

    Moment: TypeAlias = Checked[Int | str, int]
    MaybeMoment: TypeAlias = Checked[Int | str | None, int | None]
    Failing: TypeAlias = Checked[Real | Mapping[str, Any], int | float | Named]
    Parts: TypeAlias = Checked[Part | Sequence[Part], tuple[Part, ...]]
else:
    Moment = Annotated[int, Field(strict=True, ge=1, le=MOST), OR_TIME]
    MaybeMoment = Moment | None
    Failing = Annotated[Robots, OrElse(Named, Mapping, Named)]
    Parts = Annotated[tuple[Part, ...], Field(min_length=1), LISTED]


class Fault(TomlTable):
    """Robots that fail.

    They stop moving, sensing or talking at round (or tick) `at`, and begin again at `until`, if given.
    A robot that stops talking still hears. One that stops moving is still heard, seen and bumped into.
    """

    at: Moment
    """The first round, tick or time with the fault."""
    robots: Failing
    """How many fail, drawn for each trial: a number, or a fraction of the swarm; or which, as {named = [3, 5]}."""
    stop: Parts = usual(())
    """What they stop doing."""
    do: Literal["kill", "restart", "stop", "cut"] | None = None
    """What happens to processes: they are killed, restarted, stopped, or cut off from the others."""
    blank: Annotated[bool, Field(strict=True)] = False
    """Whether a robot that is started again has lost its memory."""
    until: MaybeMoment = usual(None)
    """The first round, tick or time without the fault."""

    @model_validator(mode="after")
    def _check(self) -> Self:
        if bool(self.stop) == bool(self.do):
            raise ValueError("should have either stop, or, for processes, do")
        if self.do == "restart" and self.until is not None:
            raise ValueError('until does not go with do = "restart", which starts robots at once: do = "kill"')
        if self.blank and not (self.do == "restart" or (self.do == "kill" and self.until)):
            raise ValueError('blank goes with do = "restart", or with do = "kill" and until')
        return self

    @property
    def content(self) -> dict[str, Any]:
        """All values that are not usual, for addresses."""
        usual = {name: field.default for name, field in Fault.model_fields.items()}
        return {name: value for name, value in self if value != usual[name]}

    def count(self, robots: int) -> int:
        """How many of a swarm fail."""
        if isinstance(self.robots, Named):
            return len(self.robots.named)
        return min(robots, self.robots if isinstance(self.robots, int) else round(self.robots * robots))

    def failing(self, number: int, seed: int, trial: int, robots: int) -> np.ndarray:
        """The robots of a trial to which this fault, one of several by its number, happens."""
        if isinstance(self.robots, Named):
            return np.array(self.robots.named)
        lots = np.empty((1, robots))
        compile_world().draw_uniform(address(seed, "faults", number=number, robots=robots), trial, 0.0, 1.0, lots)
        return np.argsort(lots[0], kind="stable")[: self.count(robots)]


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
        failing = fault.failing(number, seed, trial, robots)
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
