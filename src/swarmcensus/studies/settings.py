"""A setting: one point of a study's grid, what its swarm and world are in a trial, and its random numbers' addresses.

An address contains only what its random numbers depend on. So two settings that differ only in brain or topology have
the same tiles and readings, trial by trial, and a setting's numbers do not depend on its place in a grid.
"""

import functools
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from swarmcensus.basics.formatting import counted
from swarmcensus.brains import Brain, Value
from swarmcensus.engine.compiler import IN_SUMS, IN_SUMS_OF_ALL, ONE_BY_ONE
from swarmcensus.studies.members import Member
from swarmcensus.worlds import arena
from swarmcensus.worlds.bodies import Body
from swarmcensus.worlds.changes import Change, along, steady
from swarmcensus.worlds.faults import Fault
from swarmcensus.worlds.networks import Topology
from swarmcensus.worlds.patterns import Floor
from swarmcensus.worlds.sensors import Accuracy, Misjudgement


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
    delay: int = 0  # rounds between sending and hearing a message, on fixed networks

    def __str__(self) -> str:
        """The setting in one line, for messages."""
        return _line(self)

    @property
    def coordinates(self) -> dict[str, object]:
        """Its coordinates in the dataset."""
        return _coordinates(self)

    # the swarm

    @functools.cached_property
    def brains(self) -> tuple[Brain, ...]:
        """All brains of the swarm, each once, its own first. An oracle is the only one: it does not hear liars."""
        if self.brain.is_oracle:
            return (self.brain,)
        theirs = (m.brain_in(self.brain).with_numbers(self.brain.numbers) for m in self.members)
        return tuple(dict.fromkeys([self.brain, *theirs]))

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
        if self.body is None or self.density is None:
            return np.nan
        return float(f"{self.arena_side:.12g}")

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
        return self.brain.is_oracle or lossless

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


def _line(setting: Setting) -> str:
    """The setting in one line."""
    where, fill_ratio = f"{setting.topology}, N = {setting.robots:,}", setting.change or setting.fill_ratio
    assumed = "" if setting.assumed_accuracy is None else f", assumed accuracy {setting.assumed_accuracy}"
    lossy = "" if setting.link_success == 1.0 else f", link success {setting.link_success}"
    mixed = "".join(f", of them {member}" for member in setting.members)
    late = "" if not setting.delay else f", messages {counted(setting.delay, 'round')} late"
    late += "" if setting.precision == "double" else f", {setting.precision} precision"
    late += "" if setting.message == "double" else f", messages as {setting.message}"
    parameters = "".join(f", {name} = {_shown(value)}" for name, value in _parameters(setting))
    what = f"accuracy {setting.accuracy}{assumed}, f = {fill_ratio}{lossy}{late}{parameters}{mixed}"
    if setting.body is not None:
        floor = f", floor {setting.floor}" if setting.floor not in (None, Floor()) else ""
        return f"{where}, {_arena(setting)}, {what}{floor}, {counted(setting.rounds, 'tick')}"
    return f"{where}, {what}, C = {setting.rounds:,}, R = {setting.observations_per_round:,}"


def _parameters(setting: Setting) -> list[tuple[str, Value]]:
    """The brain's parameters for a title: all numbers, which other settings may vary, and given vectors."""
    given = dict(setting.brain.overrides)
    return [(n, v) for n, v in setting.brain.parameters.items() if n in given or not isinstance(v, tuple)]


def _arena(setting: Setting) -> str:
    """The density or side of the arena: the study gave the one with fewer digits."""
    density, side = f"{setting.density:.12g}", f"{setting.side:.12g}"
    return f"L = {side} m" if len(side) < len(density) else f"D = {density}"


def _coordinates(setting: Setting) -> dict[str, object]:
    """The setting's coordinates in the dataset."""
    return {
        "brain": setting.brain.name,
        "topology": str(setting.topology),
        "robots": setting.robots,
        "density": np.nan if setting.density is None else setting.density,
        "side": setting.side,
        "accuracy": str(setting.accuracy),
        "assumed_accuracy": str(setting.assumed_accuracy or setting.accuracy.start),
        "fill_ratio": setting.fill_ratio,
        "floor": "" if setting.body is None else str(setting.floor or Floor()),
        "link_success": setting.link_success,
        "rounds": setting.rounds,
        "observations_per_round": setting.observations_per_round,
        **{name: _shown(value) for name, value in setting.brain.parameters.items()},
        **_members(setting),
        **({"fill_ratio_change": str(setting.change)} if setting.change else {}),
        **({"message_delay": setting.delay} if setting.delay else {}),
        **({"precision": setting.precision} if setting.precision != "double" else {}),
        **({"message": setting.message} if setting.message != "double" else {}),
    }


def _members(setting: Setting) -> dict[str, object]:
    """The coordinates of a swarm with members: what they are, how many robots lie, and how."""
    if not setting.members:
        return {}
    lying = dict.fromkeys(", ".join(m.traits) for m in setting.members if not m.honest)
    return {
        "members": "; ".join(map(str, setting.members)),
        "liars": setting.robots - setting.honest,
        "adversary": "; ".join(lying),
    }


def _shown(value: Value) -> float | str:
    """A parameter as a coordinate; a vector becomes a text."""
    return f"({', '.join(f'{number:g}' for number in value)})" if isinstance(value, tuple) else value
