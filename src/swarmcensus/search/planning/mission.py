"""Missions: the area, what is known of robots and floor, what is wanted, and what is free."""

import functools
import math
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Annotated, Any, Literal, Self

from pydantic import Field, ValidationError, WrapValidator, model_validator

from swarmcensus.brains import Adversary, Brain, Format, Precision, adversary, load
from swarmcensus.search.planning.areas import check_areas
from swarmcensus.search.planning.goals import Goal, check_consistency, check_liars
from swarmcensus.studies import (
    KEYS,
    LARGEST,
    Accuracies,
    MaybeBrains,
    MaybeBrainsOrAdversaries,
    MaybeFloors,
    MaybePositives,
    Name,
    Topologies,
    Whole,
    as_declared,
    schema_of,
)
from swarmcensus.support.errors import StudyError
from swarmcensus.support.texts import read_text
from swarmcensus.support.toml_text import plain, read_toml
from swarmcensus.support.toml_types import Form, Number, Schema, Share, TomlTable, says, table_error, usual
from swarmcensus.worlds import Accuracy, Body, Positive, arena

FEWEST_TRIALS = 40  # of a first look: fewer are too imprecise to help
MOST_BINS = 10_000
COMPARED = ("commons", "minimalistic")  # brains, if the mission names none
AMONG_LIARS = ("steadfast", "minimalistic")  # the same if robots lie: one shouting liar controls commons
LIE = "shouter"  # what liars do, if the mission does not say


def _range(value: object, ends: Callable[[Any], tuple[Any, Any]]) -> tuple[Any, Any]:
    """A range from a list of two numbers, or from one number, which is both ends."""
    if isinstance(value, list | tuple):
        if len(value) != 2:
            raise ValueError("should be a number, or a range of two, the lower one first")
        return ends(tuple(value))
    try:
        return ends((value, value))
    except ValidationError as error:  # it lists each mistake twice, once for each end
        raise ValueError(error.errors()[0]["msg"]) from None


def _one_or_two(inner: Callable[[], Schema]) -> Schema:
    two = inner()
    return {"anyOf": [two["prefixItems"][0], two]}


RANGE, ONE_OR_TWO = WrapValidator(_range), Form(_one_or_two)
Wholes = Annotated[tuple[Whole, Whole], RANGE, ONE_OR_TWO]
Times = Annotated[tuple[Positive, Positive], RANGE, ONE_OR_TWO]
Shares = Annotated[tuple[Share, Share], RANGE, ONE_OR_TWO]
Right = Annotated[
    Literal["majority"] | Annotated[int, Field(strict=True, ge=2, le=MOST_BINS)],
    says(f'should be "majority", or a number of bins from 2 to {MOST_BINS:,}', "majority"),
]
SomeButNotAll = Annotated[Number, Field(ge=0.0, lt=1.0)]


class Area(TomlTable):
    """The square in which robots move: its side in metres or its area in square metres, and the kind of floor."""

    side: Positive | None = None
    """The side of the square in metres."""
    area: Positive | None = None
    """Or its area in square metres."""
    floor: MaybeFloors = usual(None)
    """The kind of floor: "tiles", {clusters = 0.2}, "half", an image."""


class Known(TomlTable):
    """What is known: sensors, the range of fill ratios, the share of messages received, the shares that fail or lie.

    Plans are for the worst of several accuracies, or lies.
    """

    accuracy: Accuracies
    """The sensor accuracy: 0.8, "U(0.525, 0.975)" or {black = 0.9, white = 0.6}; or a list, whose worst is used."""
    fill_ratio: Shares = (0.0, 1.0)
    """The possible fill ratios, a number or a range, whose worst is used."""
    link_success: Share = as_declared("link_success")
    precision: Precision = as_declared("precision")
    message: Format = as_declared("message")
    failing: SomeButNotAll = 0.0
    """The share of robots that may fail before the mission begins."""
    lying: SomeButNotAll = 0.0
    """The share of robots that may lie."""
    lie: MaybeBrainsOrAdversaries = usual(None)
    """What liars do: an adversary, or a list, whose worst is used."""


class Wanted(TomlTable):
    """What robots should know: f within a half-width, or the right bin; and what share of robots."""

    half_width: Annotated[Number, Field(gt=0.0, lt=0.5)] | None = None
    """The largest allowed distance of an estimate from the truth."""
    right: Right | None = None
    """Or "majority", or the number of bins of which an estimate should be in the right one."""
    margin: Annotated[Number, Field(ge=0.0, lt=0.5)] = 0.0
    """The least distance of f from the edges between bins."""
    confidence: Annotated[Number, Field(ge=0.5, le=0.999)] = 0.95
    """The share of robots, over all trials, that should be right."""
    truth: Literal["floor", "nominal"] | None = None
    """The truth: the floor's own share of black, or the f by which the floor was drawn."""


class Free(TomlTable):
    """What is to be found or is given (robots, minutes), and what is compared (brains, networks, densities)."""

    robots: Wholes | None = None
    """The number of robots, or a range."""
    minutes: Times | None = None
    """The number of minutes, or a range."""
    brain: MaybeBrains = usual(None)
    """The brains to compare: names of shipped brains, or paths of brain files."""
    topology: Topologies = Field(default=["moving"], validate_default=True)
    """Robots that move, or fixed networks; several are compared."""
    density: MaybePositives = usual(None)
    """The swarm density D = N π r² / L², which replaces the area; several are compared."""
    observations_per_round: Whole | None = None
    """Readings per round, on fixed networks."""
    round_seconds: Positive | None = None
    """The seconds of a round, on fixed networks."""


class Mission(TomlTable):
    """A whole mission file. Properties that depend on the network are of its `worlds`, which have one network each."""

    name: Name = "mission"
    """The title of the plan."""
    seed: Annotated[int, Field(strict=True, ge=0, lt=2**63)] = 0
    """The seed; an equal seed gives an equal plan."""
    trials: Annotated[int, Field(strict=True, ge=FEWEST_TRIALS, le=100_000)] = 200
    """The trials of each confirming simulation."""
    area: Area = Area()
    """The square in which robots move."""
    known: Known
    """What is known."""
    wanted: Wanted
    """What robots should know."""
    free: Free
    """What is to be found, or is given."""
    body: Body = Body()
    """The body of robots that move."""

    @model_validator(mode="after")
    def _right(self) -> Self:
        for key, ends in (
            ("known.fill_ratio", self.known.fill_ratio),
            ("free.robots", self.free.robots),
            ("free.minutes", self.free.minutes),
        ):
            if ends is not None and ends[0] > ends[1]:
                raise StudyError.at(key, f"[{ends[0]:g}, {ends[1]:g}]", "the lower end of a range comes first")
        check_consistency(self)
        check_liars(self)
        check_areas(self)
        return self

    @property
    def brains(self) -> list[Brain]:
        """The brains that are compared."""
        return self.free.brain or [shipped_brain(name) for name in (AMONG_LIARS if self.known.lying else COMPARED)]

    @property
    def lies(self) -> list[Adversary]:
        """What liars may do, of which the worst is used; empty if nobody lies."""
        if not self.known.lying:
            return []
        return self.known.lie or [shipped_adversary(LIE)]

    @property
    def worlds(self) -> list[Self]:
        """The mission for each network and density that is compared."""
        worlds = []
        for topology in self.free.topology:
            densities: list[float | None] = [*(self.free.density or ())] if topology.moves else []
            for density in densities or [None]:
                world = {"topology": [topology], "density": None if density is None else [density]}
                worlds.append(self.model_copy(update={"free": self.free.model_copy(update=world)}))
        return worlds

    def sized(self, robots: int) -> Self:
        """The mission for a swarm of this size; if a density is given, with the area that follows from it."""
        if self.density is None:
            return self
        side = arena.side(robots, self.density, self.body)
        return self.model_copy(update={"area": self.area.model_copy(update={"side": side})})

    @property
    def accuracy(self) -> Accuracy:
        """The accuracy that is planned for, which is the first."""
        return self.known.accuracy[0]

    @property
    def density(self) -> float | None:
        """The swarm density of a world, if it is given instead of an area."""
        return self.free.density[0] if self.free.density and self.moves else None

    @property
    def moves(self) -> bool:
        """Whether the robots of a world move."""
        return self.free.topology[0].moves

    @property
    def side(self) -> float | None:
        """The inner side of the area in metres; None on fixed networks, and if it follows from a density."""
        return self.area.side if self.area.area is None else self.area.area**0.5

    @property
    def round_minutes(self) -> float:
        """The minutes of a round: a tick if robots move, else `round_seconds`, by default a tick for each reading."""
        if self.moves:
            return self.body.tick / 60.0
        return (self.free.round_seconds or self.readings_per_round * self.body.tick) / 60.0

    @property
    def readings_per_round(self) -> int:
        """The readings per round."""
        return 1 if self.moves else self.free.observations_per_round or KEYS["observations_per_round"].default

    @property
    def on_floor(self) -> bool:
        """Whether the truth is the floor's own share of black, which is the default if robots move."""
        return self.moves and self.wanted.truth != "nominal"

    @property
    def goal(self) -> Goal:
        """The goal, which tells which estimates are right."""
        bins = 2 if self.wanted.right == "majority" else self.wanted.right
        return Goal(self.wanted.half_width, bins, self.wanted.margin, self.wanted.confidence)

    def failing(self, robots: int) -> int:
        """How many of the robots fail; at least one robot works and is honest."""
        return min(round(self.known.failing * robots), robots - self.lying(robots) - 1)

    def lying(self, robots: int) -> int:
        """How many of the robots lie, rounded up; at least one robot is honest."""
        return min(math.ceil(self.known.lying * robots - 1e-9), robots - 1)

    def rounds(self, minutes: float) -> int:
        """How many whole rounds fit into these minutes."""
        return min(int(minutes / self.round_minutes + 1e-9), LARGEST)


TABLES: dict[str, str] = {  # the table of each key
    key: table
    for table in ("area", "known", "wanted", "free")
    for key in Mission.model_fields[table].annotation.model_fields  # type: ignore[union-attr]
}
shipped_brain, shipped_adversary = functools.cache(load), functools.cache(adversary.load)


def mission_of(tables: Mapping[str, Any], where: str = "mission", base: Path | None = None) -> Mission:
    """Check a mission's tables; brain files, edge lists and images are looked for in `base`. Raises InputError."""
    given = {"known": {}, "wanted": {}, "free": {}} | plain(dict(tables))
    try:
        return Mission.model_validate(given, context={"base": base or Path()})
    except ValidationError as error:
        raise table_error(error, where, Mission, given) from None


def load_mission(path: str | Path) -> dict[str, Any]:
    """The tables of a mission file, not yet checked. Raises InputError."""
    where = f"mission file {path}"
    return read_toml(read_text(path, where, StudyError, ending=".toml"), where)


def schema() -> Schema:
    """The JSON schema of mission files, as `swarmcensus.studies.schema` has that of study files.

    It rejects only invalid missions; `plan` also checks how keys go together.
    """
    return schema_of(Mission, "mission")
