"""A robot's body: by default the Khepera IV of the paper's Sec. IV-C, every part a parameter of a study."""

import math
from typing import TYPE_CHECKING, Annotated, TypeAlias

import numpy as np
from pydantic import BeforeValidator, Field, ValidationInfo

from swarmcensus.engine import record_type
from swarmcensus.support.times import parse_time
from swarmcensus.support.toml_types import Number, TomlTable, usual

# outside these bounds, squares and quotients of lengths and times would overflow
Positive = Annotated[Number, Field(gt=0.0, ge=1e-9, le=1e9)]
Least = Annotated[Number, Field(ge=0.0, le=1e9)]
Place = Annotated[Number, Field(ge=-1e9, le=1e9)]
Ticks = Annotated[int, Field(strict=True, ge=0, le=1000)]


def _delay(value: object, info: ValidationInfo) -> object:
    if isinstance(value, str) and "tick" in info.data:  # it is missing if the tick itself is wrong
        return parse_time(value).ticks(info.data["tick"], least=0)
    return value


if TYPE_CHECKING:
    from swarmcensus.support.toml_types import Checked, Int

    Delay: TypeAlias = Checked[Int | str, int]
else:
    Delay = Annotated[Ticks, BeforeValidator(_delay)]


AS_THEY_ARE = (  # numbers of a body that the engine takes by these names
    "radius", "tick", "straight_mean", "turn_most", "proximity_range", "proximity_near", "avoid_above", "tile",
    "radio_range", "line_of_sight", "touched", "reach", "skin",
)  # fmt: skip


class Body(TomlTable):
    """The body of robots that move: a disc with two wheels, in SI units.

    Sources: the paper, Sec. IV-C; docs/moving-robots.md for what it leaves open.
    """

    speed: Least = 0.14
    """m/s, straight."""
    turn_speed: Least = 0.14
    """m/s of each wheel, against each other, when turning on the spot."""
    wheel_distance: Positive = 0.1054
    """m, between the wheels."""
    radius: Positive = 0.0704
    """m, of the body, a disc."""
    tick: Positive = 0.1
    """s, between two decisions."""
    wheel_lag: Annotated[Number, Field(ge=0.0, le=1.0)] = 0.1
    """Of a tick, until new wheel speeds take hold."""
    straight_mean: Positive = 15.0
    """Ticks of a straight run: floor of an exponential."""
    turn_most: Annotated[int, Field(strict=True, ge=0, le=10_000)] = 10
    """Ticks of a turn: uniform from 0."""
    proximity_range: Least = 0.12
    """m from the body's edge, along 8 rays."""
    proximity_near: Least = 0.04
    """m, below which a ray reads 1."""
    avoid_above: Positive = 0.01
    """Length of the mean reading from which there is an obstacle."""
    avoid_within: Annotated[Number, Field(gt=0.0, le=180.0)] = 100.0
    """Degrees from straight ahead, where an obstacle counts."""
    sensor: tuple[Place, Place] = (0.0614, 0.010)
    """m ahead and to the left of the centre: the ground sensor."""
    tile: Positive = 0.01
    """m, the side of a floor tile."""
    radio_range: Positive = 0.7
    """m between centres."""
    line_of_sight: Annotated[bool, Field(strict=True)] = True
    """Whether a body in between stops a message."""
    message_delay: Delay = usual(1)
    """Ticks, or a time: how old a message is when it is heard."""

    @property
    def numbers(self) -> np.ndarray:
        """The body in the engine's form: one record of float64."""
        values = {name: float(getattr(self, name)) for name in AS_THEY_ARE} | {
            "step": self.speed * self.tick,
            "turn": 2.0 * self.turn_speed * self.tick / self.wheel_distance,
            "lag": self.wheel_lag,
            "cos_within": math.cos(math.radians(self.avoid_within)),
            "sensor_x": self.sensor[0],
            "sensor_y": self.sensor[1],
        }
        record = np.zeros(1, record_type([(name, "f8") for name in values]))
        record[0] = tuple(values.values())
        return record

    @property
    def reach(self) -> float:
        """How far away a robot may be that is heard, seen or bumped into, or that blocks a message."""
        seen = 2.0 * self.radius + self.proximity_range
        return max(math.hypot(self.radio_range, self.radius), seen, self.touched)

    @property
    def touched(self) -> float:
        """The largest distance of two robots that may touch by the end of the next tick, with a margin for contacts."""
        return 2.0 * self.radius + 4.0 * self.speed * self.tick + 0.25 * self.radius

    @property
    def skin(self) -> float:
        """How much further than `reach` neighbour lists go, so that they stay valid for some ticks."""
        return max(8.0 * self.speed * self.tick, 0.1 * self.reach)
