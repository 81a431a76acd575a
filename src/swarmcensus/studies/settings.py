"""Settings, the points of a study's grid: the keys in which they differ, and the record of one value each.

A key is declared once, in its table here. `keys_of` makes `KEYS` of the declarations, and the rest follows from it: the
grid, cases, checks, coordinates, captions, addresses of random numbers, tables of pages. A key also needs a field of
`Setting` and, in **simulation**, its use.
"""

import functools
from collections.abc import Iterable
from dataclasses import dataclass
from typing import Annotated, Any

import numpy as np
from numpy.typing import ArrayLike
from pydantic import Field

from swarmcensus.brains import Brain, Value
from swarmcensus.engine import IN_SUMS, IN_SUMS_OF_ALL, ONE_BY_ONE
from swarmcensus.studies.fields import (
    Accuracies,
    BodyTable,
    Brains,
    Delays,
    FillRatios,
    Formats,
    MaybeBeliefs,
    MaybeFloors,
    MaybePositives,
    Precisions,
    Shares,
    Times,
    Topologies,
    Wholes,
)
from swarmcensus.studies.keys import Coordinate, Key, keys_of
from swarmcensus.studies.members import Member
from swarmcensus.support.formatting import counted
from swarmcensus.support.toml_types import TomlTable, usual
from swarmcensus.worlds import (
    Accuracy,
    Body,
    Change,
    Distribution,
    Fault,
    Floor,
    Misjudgement,
    Topology,
    along,
    arena,
    steady,
)

HOW_LONG = "robots that move observe once a tick at most, and schedule.ticks says how long"


class Swarm(TomlTable):
    """The robots: their number, brains and sensors."""

    brain: Annotated[Brains, Key(
        coordinate=Coordinate("text", "{}", plural="brains", always=True, of=lambda setting: setting.brain.name),
    )] = Field(default=["minimalistic"], validate_default=True)  # fmt: skip
    """A shipped brain's name or the path of a brain file; {file = "...", prior = 1} gives it parameters."""
    robots: Annotated[Wholes, Key(
        draws=("readings", "losses", "luck", "luck alone", "floor", "walk"), coordinate=Coordinate(
            "whole number", "N = {:,.0f}", "robots $N$", "numbers of robots", counts=True, always=True,
        ),
    )]  # fmt: skip
    """N, how many."""
    accuracy: Annotated[Accuracies, Key(
        draws=("readings",), coordinate=Coordinate("text", "accuracy {}", "sensor accuracy", "accuracies", always=True),
    )]  # fmt: skip
    """The true b and w of the sensors, as 0.8, "U(0.525, 0.975)" or {black = 0.9, white = 0.6}."""
    assumed_accuracy: Annotated[MaybeBeliefs, Key(
        coordinate=Coordinate(
            "text", "assumed accuracy {}", plural="assumed accuracies", always=True,
            of=lambda setting: str(setting.assumed_accuracy or setting.accuracy.start),
        ),
    )] = usual(None)  # fmt: skip
    """The b and w that robots assume; by default the true ones."""
    precision: Annotated[Precisions, Key(
        coordinate=Coordinate("text", "{} precision", "precision", "precisions"),
    )] = usual(["double"])  # fmt: skip
    """The precision of the robots' arithmetic: "double", or "single" as most boards have it."""


class World(TomlTable):
    """Who hears whom, how messages get through, and the floor.

    `density` or `side`, `floor` and `body` are for robots that move (topology "moving"); `message_delay`, in rounds, is
    for fixed networks.
    """

    topology: Annotated[Topologies, Key(
        draws=("losses", "luck"), coordinate=Coordinate("text", "{}", plural="topologies", always=True),
    )]  # fmt: skip
    """Who hears whom: a network, or "moving" for robots that walk in an arena."""
    fill_ratio: Annotated[FillRatios, Key(
        draws=("readings", "floor"),
        coordinate=Coordinate("number", "f = {}", "fill ratio $f$", "fill ratios", always=True),
    )]  # fmt: skip
    """f, the fraction of the floor that is black, or a change as {from = 0.9, to = 0.1, at = 500}; or "U(0.3, 0.7)"."""
    link_success: Annotated[Shares, Key(
        messages=True, draws=("losses",), coordinate=Coordinate("number", "link success {}", always=True, unsaid=1.0),
    )] = usual([1.0])  # fmt: skip
    """The probability that a message gets through."""
    missing_links: Annotated[Shares, Key(
        world="networks",
        instead="bodies in between block the messages of robots that move, by world.body.line_of_sight",
        messages=True, coordinate=Coordinate(
            "number", "{} of links missing", "share of links that are missing", "shares of missing links"
        ),
    )] = usual([0.0])  # fmt: skip
    """The probability that two neighbours on a fixed network never hear each other in a trial."""
    message_delay: Annotated[Delays, Key(
        world="networks",
        instead="how late robots that move hear each other is world.body.message_delay, in ticks",
        field="delay",
        messages=True,
        coordinate=Coordinate("whole number", "delay {:,.0f}", "message delay (rounds)", "message delays"),
    )] = usual([0])  # fmt: skip
    """How many rounds late messages are on fixed networks."""
    message: Annotated[Formats, Key(
        coordinate=Coordinate("text", "messages as {}", "message format", "message formats"),
    )] = usual(["double"])  # fmt: skip
    """How the numbers of a message are sent: "float32", "float16", "ratio16", "ratio8"; "double" rounds nothing."""
    feedback: Annotated[bool, Field(strict=True), Key(spans=False)] = True
    """Whether what rounding takes of a message is added to the next one."""
    density: Annotated[MaybePositives, Key(
        world="moving",
        draws=("readings", "losses", "luck", "floor", "walk"),
        coordinate=Coordinate("number", "D = {}", "density $D$", "densities", counts=True, always=True),
    )] = usual(None)  # fmt: skip
    """D = N π r² / L² of robots that move."""
    side: Annotated[MaybePositives, Key(
        world="moving",
        field="density",
        coordinate=Coordinate(
            "number", "L = {} m", "side of the arena $L$ (m)", "sides of the arena", counts=True, always=True
        ),
    )] = usual(None)  # fmt: skip
    """The side L of the arena in metres, in place of a density."""
    floor: Annotated[MaybeFloors, Key(
        world="moving",
        draws=("floor",), coordinate=Coordinate(
            "text", "floor {}", plural="floors", always=True,
            of=lambda setting: "" if setting.body is None else str(setting.floor or Floor()),
        ),
    )] = usual(None)  # fmt: skip
    """What lies under robots that move: "tiles", {clusters = 0.2}, "half", an image."""
    body: Annotated[BodyTable, Key(world="moving", spans=False)] = usual(Body())
    """The body of robots that move."""


class Schedule(TomlTable):
    """How long trials are."""

    rounds: Annotated[Wholes, Key(
        world="networks",
        instead=HOW_LONG,
        coordinate=Coordinate(
            "whole number", "C = {:,.0f}", "rounds $C$", "numbers of rounds", counts=True, always=True, world="any"
        ),
    )] = usual([1000])  # fmt: skip
    """C, communication rounds on fixed networks."""
    observations_per_round: Annotated[Wholes, Key(
        world="networks",
        instead=HOW_LONG,
        draws=("readings",), coordinate=Coordinate(
            "whole number", "R = {:,.0f}", "observations per round $R$", counts=True, always=True, world="any"
        ),
    )] = usual([10])  # fmt: skip
    """R, observations of each robot before each exchange."""
    ticks: Annotated[Times, Key(world="moving", field="rounds")] = usual([10_000])
    """How long robots move: a number of ticks, or a time such as "17 min"."""


KEYS = keys_of(  # in the order of the dataset's coordinates
    {"swarm": Swarm, "world": World, "schedule": Schedule},
    (
        "brain", "topology", "robots", "density", "side", "accuracy", "assumed_accuracy", "fill_ratio", "floor",
        "link_success", "rounds", "observations_per_round", "message_delay", "precision", "message",
    ),
)  # fmt: skip


@dataclass(frozen=True)
class Setting:
    """One combination of a study's values."""

    brain: Brain
    topology: Topology
    robots: int
    accuracy: Accuracy
    assumed_accuracy: Accuracy | Misjudgement | None  # None: robots know their sensors
    fill_ratio: float  # of the last round
    link_success: float
    rounds: int  # ticks where robots move
    observations_per_round: int
    density: float | None = None  # of robots that move
    body: Body | None = None
    faults: tuple[Fault, ...] = ()
    floor: Floor | None = None  # of robots that move; None: independent tiles
    members: tuple[Member, ...] = ()  # robots that differ from the others
    change: Change | None = None  # of the fill ratio, during a trial
    spread: Distribution | None = None  # of the fill ratio, which is drawn for each trial, and here its mean
    missing_links: float = 0.0  # the share of links, drawn for each trial
    delay: int = 0  # rounds between sending and hearing a message, on fixed networks

    def __str__(self) -> str:
        """The setting in one line, for messages."""
        given = dict(self.brain.overrides)  # all numbers, which other settings may vary, and given vectors
        return _line(self, [(n, v) for n, v in self.brain.parameters.items() if n in given or not isinstance(v, tuple)])

    @property
    def brief(self) -> str:
        """The same with those parameters of the brain only that were given."""
        return _line(self, self.brain.overrides)

    # the swarm

    @functools.cached_property
    def brains(self) -> tuple[Brain, ...]:
        """All brains of the swarm, each once, its own first. An oracle is the only one: it does not hear liars."""
        if self.brain.is_oracle:
            return (self.brain,)
        theirs = (m.brain_in(self.brain).with_numbers(self.brain.numbers) for m in self.members)
        return tuple(dict.fromkeys([self.brain, *theirs]))

    @property
    def world_parameters(self) -> dict[str, Any]:
        """The keys of its topology and floor that span the grid."""
        return self.topology.parameters | (self.floor.parameters if self.floor else {})

    @property
    def precision(self) -> str:
        """The precision of its robots' arithmetic."""
        return self.brain.numbers.precision

    @property
    def message(self) -> str:
        """The format of its messages, as in the dataset."""
        numbers = self.brain.numbers
        return numbers.message + ", no feedback" * (numbers.message != "double" and not numbers.feedback)

    @property
    def honest(self) -> int:
        """The number of honest robots, which metrics count."""
        return self.robots - sum(m.count(self.robots) for m in self.members if not m.honest)

    @property
    def steers(self) -> bool:
        """Whether any of its brains steers the robot."""
        return any(brain.steers for brain in self.brains)

    @property
    def additive(self) -> bool:
        """Whether robots only add up messages. Brains of a mixed swarm may add up different things: False."""
        return len(self.brains) == 1 and bool(self.brain.sums)

    @property
    def use(self) -> str:
        """How the engine calls its brains, one of the uses of `engine.compiler.needs`."""
        if self.body is not None:
            return "moving"
        if self.message_delay:
            return "network"
        if self.additive and self.hears_all and (self.brain.is_oracle or self.topology.is_full):
            return IN_SUMS_OF_ALL
        return IN_SUMS if self.additive and self.link_success == 1.0 and not self.faults else ONE_BY_ONE

    # the world in a trial

    @functools.cached_property
    def course(self) -> np.ndarray:
        """The fill ratio over a trial, in the engine's form (see `Change.course`)."""
        return steady(self.fill_ratio) if self.change is None else self.change.course

    def fill_ratios(self, rounds: ArrayLike) -> np.ndarray:
        """The fill ratio at each of these rounds, or ticks."""
        return along(self.course, rounds)

    @property
    def arena_side(self) -> float:
        """The inner side of the arena in metres, not rounded; only of robots that move."""
        assert self.body is not None
        assert self.density is not None
        return arena.side(self.robots, self.density, self.body)

    @property
    def side(self) -> float:
        """The inner side of the arena in metres, rounded to 12 digits; NaN on fixed networks."""
        return np.nan if self.body is None or self.density is None else float(f"{self.arena_side:.12g}")

    @property
    def fastest_body(self) -> Body:
        """The body with the speed of the fastest robots, which decides how far away neighbours are looked for."""
        assert self.body is not None
        speed = max([self.body.speed, *(m.speed for m in self.members if m.speed is not None)])
        return self.body if speed == self.body.speed else self.body.model_copy(update={"speed": speed})

    @property
    def hears_all(self) -> bool:
        """Whether every message is heard by all neighbours."""
        lossless = self.link_success == 1.0 and not any("talking" in f.stop for f in self.faults)
        return self.brain.is_oracle or (lossless and not self.missing_links)

    @property
    def graphs_vary(self) -> bool:
        """Whether graphs differ from trial to trial."""
        return (self.topology.varies or self.missing_links > 0.0) and not self.brain.is_oracle

    @property
    def message_delay(self) -> int:
        """How old messages are when they are heard, in rounds, or in ticks of robots that move."""
        if self.brain.is_oracle:
            return 0
        return self.delay if self.body is None else self.body.message_delay

    @property
    def loss_threshold(self) -> np.uint64:
        """A message gets through if a uniform uint64 is below this; 0 means always."""
        if self.link_success == 1.0 or self.brain.is_oracle:
            return np.uint64(0)
        return np.uint64(max(1, int(self.link_success * 2.0**64)))


def _line(setting: Setting, parameters: Iterable[tuple[str, Value]]) -> str:
    """The setting in one line, with these parameters. Newer keys appear where they are not at their default."""
    moves = setting.body is not None
    said = [str(setting.topology), f"N = {setting.robots:,}", *([_arena(setting)] if moves else [])]
    said += [f"accuracy {setting.accuracy}"]
    said += [f"assumed accuracy {setting.assumed_accuracy}"] if setting.assumed_accuracy is not None else []
    fill = setting.change or setting.spread or round(setting.fill_ratio, 6)
    said += [f"f = {fill}"] if fill == fill else []  # NaN: a recording does not know it
    said += [f"link success {setting.link_success}"] if setting.link_success < 1.0 else []
    said += [key.coordinate.caption.format(getattr(setting, key.field)) for key in set_apart(setting) if key.coordinate]
    said += [f"{name} = {shown(value)}" for name, value in (*setting.world_parameters.items(), *parameters)]
    said += [member.phrase for member in setting.members]
    if not moves:
        return ", ".join([*said, f"C = {setting.rounds:,}", f"R = {setting.observations_per_round:,}"])
    said += [f"floor {setting.floor}"] if str(setting.floor or Floor()) != "tiles" else []
    return ", ".join([*said, counted(setting.rounds, "tick")])


def set_apart(setting: Setting) -> list[Key]:
    """The newer keys that are not at their default in a setting."""
    return [key for key in KEYS.values() if key.is_new and getattr(setting, key.field) != key.default]


def values_of(setting: Setting) -> dict[str, Any]:
    """The values of all keys that span a grid and have an effect in a setting, by key: objects, or as in a file."""
    own = [key for key in KEYS.values() if key.spans and key.has_effect(setting.body is not None)]
    found = {key.name: getattr(setting, key.name if key.name == "side" else key.field) for key in own}
    if setting.body is not None:
        found.pop("density" if size_key(setting) == "side" else "side")
    change = {"fill_ratio": fill} if (fill := setting.change or setting.spread) else {}
    return found | {"brain": setting.brain.form, "message": setting.brain.numbers.message} | change


def size_key(setting: Setting) -> str:
    """The key with which a study gave the size of the arena: density, or side if that has fewer digits."""
    return min("density", "side", key=lambda key: len(f"{getattr(setting, key):.12g}"))


def _arena(setting: Setting) -> str:
    """The density or side of the arena."""
    return f"L = {setting.side:.12g} m" if size_key(setting) == "side" else f"D = {setting.density:.12g}"


def shown(value: Value) -> float | str:
    """A parameter as a coordinate; a vector becomes a text."""
    return f"({', '.join(f'{number:g}' for number in value)})" if isinstance(value, tuple) else value
