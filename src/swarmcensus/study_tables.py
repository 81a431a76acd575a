"""The tables and keys of a study file, and what is said where one is wrong."""

import difflib
import itertools
import re
from collections.abc import Mapping
from pathlib import Path
from typing import Annotated, Any, Literal, Self, get_args

import numpy as np
from pydantic import (
    AfterValidator,
    BaseModel,
    BeforeValidator,
    ConfigDict,
    Discriminator,
    Field,
    Tag,
    ValidationError,
    ValidationInfo,
    model_validator,
)

from swarmcensus import arena, brains
from swarmcensus.bodies import Body, Positive
from swarmcensus.faults import Fault
from swarmcensus.networks import MOVING, Topology, parse_topology
from swarmcensus.patterns import Floor, parse_floor
from swarmcensus.precision import Until
from swarmcensus.sensors import Accuracy, Misjudgement, parse_accuracy, parse_assumed
from swarmcensus.toml_text import to_toml_value

MOST_TILES = 2**30  # from wall to wall: a tile is named by two 32-bit numbers
LARGEST = 2**31 - 1  # trials, robots and rounds are 32-bit numbers in an address


def _listed(value: object) -> object:
    if isinstance(value, np.ndarray | np.generic):
        value = value.tolist()
    if isinstance(value, list | tuple):
        return [v.item() if isinstance(v, np.generic) else v for v in value]
    return value if isinstance(value, list | tuple) else [value]


def _context(info: ValidationInfo, key: str, default: Any) -> Any:
    return (info.context or {}).get(key, default)


def _topology(value: object, info: ValidationInfo) -> Topology:
    return parse_topology(value, _context(info, "base", Path()), _context(info, "edges", {}))


def _floor(value: object, info: ValidationInfo) -> Floor:
    return parse_floor(value, _context(info, "base", Path()), _context(info, "images", {}))


def _brain(value: object, info: ValidationInfo) -> brains.Brain:
    if isinstance(value, brains.Brain):
        return value
    if not isinstance(value, str | Path):
        raise ValueError("a brain is a shipped brain's name or the path of a brain file")
    known = _context(info, "brains", {})
    if str(value) in known:
        return known[str(value)]  # type: ignore[no-any-return]
    return brains.load(value, _context(info, "base", None))


def _plain_text(value: str) -> str:
    if not value.isprintable():
        raise ValueError("a name is printed and drawn: it has no control characters")
    return value


def _plain_number(value: object) -> object:
    if isinstance(value, bool):
        raise ValueError("a number is wanted, not a truth value")
    return value


Whole = Annotated[int, Field(strict=True, ge=1, le=LARGEST)]
Number = Annotated[float, BeforeValidator(_plain_number)]
Share = Annotated[Number, Field(ge=0.0, le=1.0)]
BrainField = Annotated[brains.Brain, BeforeValidator(_brain)]
TopologyField = Annotated[Topology, BeforeValidator(_topology)]
FloorField = Annotated[Floor, BeforeValidator(_floor)]
AccuracyField = Annotated[Accuracy, BeforeValidator(parse_accuracy)]
AssumedField = Annotated[Accuracy | Misjudgement, BeforeValidator(parse_assumed)]


NUMBER, RULE = "(number)", "(rule)"  # how pydantic tells the two forms of `trials` apart
Trials = Annotated[
    Annotated[Whole, Tag(NUMBER)] | Annotated[Until, Tag(RULE)],
    Discriminator(lambda value: RULE if isinstance(value, Mapping | Until) else NUMBER),
]


def _grid(item: Any) -> Any:
    return Annotated[list[item], BeforeValidator(_listed), Field(min_length=1)]


class _Table(BaseModel):
    model_config = ConfigDict(extra="forbid", arbitrary_types_allowed=True, frozen=True)


class Swarm(_Table):
    """The robots: their brains, how many, how good their sensors are, and what they think of them."""

    brain: _grid(BrainField) = Field(default=["minimalistic"], validate_default=True)  # type: ignore[valid-type]
    robots: _grid(Whole)  # type: ignore[valid-type]
    accuracy: _grid(AccuracyField)  # type: ignore[valid-type]
    assumed_accuracy: _grid(AssumedField) | None = None  # type: ignore[valid-type]


class World(_Table):
    """What the robots live in: who hears whom, how much is black, how often a message gets through.

    `density`, `floor` and `body` are those of robots that move (topology "moving").
    """

    topology: _grid(TopologyField)  # type: ignore[valid-type]
    fill_ratio: _grid(Share)  # type: ignore[valid-type]
    link_success: _grid(Share) = [1.0]  # type: ignore[valid-type]
    density: _grid(Positive) | None = None  # type: ignore[valid-type]
    floor: _grid(FloorField) | None = None  # type: ignore[valid-type]
    body: Body = Body()


class Schedule(_Table):
    """How long: communication rounds (C), and observations in each (R); ticks of robots that move."""

    rounds: _grid(Whole) = [1000]  # type: ignore[valid-type]
    observations_per_round: _grid(Whole) = [10]  # type: ignore[valid-type]
    ticks: _grid(Whole) = [10_000]  # type: ignore[valid-type]


class Measure(_Table):
    """What is kept: convergence within delta, decisions among bins at checkpoints; local estimates, all estimates."""

    delta: Annotated[Number, Field(gt=0.0, allow_inf_nan=False)] = 0.01
    bins: Annotated[int, Field(strict=True, ge=1, le=10_000)] = 10
    checkpoints: _grid(Whole) | None = None  # type: ignore[valid-type]
    local: Annotated[bool, Field(strict=True)] = False
    estimates: Annotated[bool, Field(strict=True)] = False
    truth: Literal["nominal", "floor"] = "nominal"


class Tables(_Table):
    """The study file as a whole."""

    name: Annotated[str, Field(min_length=1), AfterValidator(_plain_text)] = "study"
    seed: Annotated[int, Field(strict=True, ge=0, lt=2**63)] = 0
    trials: Trials
    swarm: Swarm
    world: World
    schedule: Schedule = Schedule()
    measure: Measure = Measure()
    faults: tuple[Fault, ...] = ()

    @model_validator(mode="after")
    def _fits(self) -> Self:
        for topology, robots in itertools.product(self.world.topology, self.swarm.robots):
            topology.check(robots)
        for key, values in (("swarm.brain", self.swarm.brain), ("world.topology", self.world.topology)):
            names = [v.name for v in values]
            if len(set(names)) < len(names):
                raise ValueError(f"two entries of {key} have one name: {', '.join(names)}")
        if isinstance(self.trials, Until) and self.trials.checkpoint is not None:
            known = self.measure.checkpoints
            if known is not None and self.trials.checkpoint not in known:
                raise ValueError(f"trials.until = {self.trials.until!r}: {self.trials.checkpoint} is no checkpoint")
            if self.trials.checkpoint > self.last_round:
                raise ValueError(f"trials.until = {self.trials.until!r}: that comes after the last round")
        late = [c for c in self.measure.checkpoints or () if c > self.last_round]
        if late:
            raise ValueError(f"measure.checkpoints = {late[0]} comes after the last round, {self.last_round}")
        for topology in self.world.topology:
            _plain_text(topology.name)
        steps = max(self.schedule.rounds) * max(self.schedule.observations_per_round)
        if self.measure.local and steps > LARGEST:
            raise ValueError(f"measure.local = true follows {steps} observations: {LARGEST} at the most")
        self._check_moving()
        for n, fault in enumerate(self.faults):
            most = min(self.swarm.robots)
            if isinstance(fault.robots, int) and fault.robots > most:
                raise ValueError(f"faults[{n}].robots = {fault.robots}: there are {most} robots")
            if "moving" in fault.stop and not any(t.name == MOVING for t in self.world.topology):
                raise ValueError(f'faults[{n}].stop = "moving": these robots never move: topology "moving" is not here')
        return self

    @property
    def last_round(self) -> int:
        """The last round, or tick, of the longest setting."""
        moving = [t.name == MOVING for t in self.world.topology]
        rounds = [] if all(moving) else self.schedule.rounds
        ticks = self.schedule.ticks if any(moving) else []
        return int(max([*rounds, *ticks]))

    def _check_moving(self) -> None:
        if not any(t.name == MOVING for t in self.world.topology):
            if self.world.density is not None:
                raise ValueError('world.density is of robots that move: it goes with topology = "moving"')
            if self.world.floor is not None:
                raise ValueError('world.floor is under robots that move: it goes with topology = "moving"')
            return
        if self.world.density is None:
            raise ValueError("world.density is missing: robots that move need a swarm density, such as 1")
        if self.measure.local:
            raise ValueError("measure.local = true follows robots on fixed networks, not robots that move")
        sources: dict[str, str] = {}
        for floor in self.world.floor or ():
            floor.check(self.world.body.tile)
            picture = floor.picture
            if picture and sources.setdefault(picture.name, picture.source) != picture.source:
                raise ValueError(f"two images of world.floor have one name: {picture.name}")
        for robots, density in itertools.product(self.swarm.robots, self.world.density):
            largest = arena.largest_density(robots, self.world.body)
            if density > largest:
                raise ValueError(
                    f"world.density = {density}: the arena cannot hold {robots} robots; the largest that can is "
                    f"{largest:.1f}"
                )
            across = arena.side(robots, density, self.world.body) / self.world.body.tile
            if across > MOST_TILES:
                raise ValueError(
                    f"world.density = {density}: the arena is {across:.2g} tiles wide; {MOST_TILES:,} is the most"
                )


def explain(error: ValidationError, name: str, model: type[BaseModel] = Tables) -> str:
    """The first thing that is wrong, as a sentence: file, key, value, and what would be right."""
    first = min(error.errors(), key=lambda e: e["type"] != "extra_forbidden")
    place = tuple(p for p in first["loc"] if p not in (NUMBER, RULE))
    key = "".join(f"[{p}]" if isinstance(p, int) else f".{p}" for p in place).lstrip(".")
    more = f" (and {error.error_count() - 1} more)" if error.error_count() > 1 else ""
    if first["type"] == "extra_forbidden":
        known = list(Until.model_fields) if place[0] == "trials" else _known_keys(model, place[:-1])
        close = difflib.get_close_matches(str(first["loc"][-1]), known, n=1)
        hint = f"did you mean {close[0]!r}? " if close else ""
        return f"{name}: unknown key {key}: {hint}known here: {', '.join(known)}{more}"
    if first["type"] == "missing":
        return f"{name}: {key} is missing{more}"
    message = first["msg"].removeprefix("Value error, ").replace("Input should", "should")
    message = re.sub(r".*at least 1 item.*", "should be a list of at least one", message)
    if not key:
        return f"{name}: {message}{more}"
    value = first["input"]
    shown = to_toml_value(value) if isinstance(value, str | int | float | list | dict) else repr(value)
    return f"{name}: {key} = {shown[:200]}: {message}{more}"


def _known_keys(model: type[BaseModel], path: tuple[int | str, ...]) -> list[str]:
    for part in (part for part in path if isinstance(part, str)):
        kind = model.model_fields[part].annotation
        model = next(k for k in (kind, *get_args(kind)) if isinstance(k, type) and issubclass(k, BaseModel))
    return list(model.model_fields)
