"""A setting: one point of a study's grid, what its swarm and world are in a trial, and its random numbers' addresses.

An address contains only what its random numbers depend on. So two settings that differ only in brain or topology have
the same tiles and readings, trial by trial, and a setting's numbers do not depend on its place in a grid.
"""

import functools
import hashlib
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from swarmcensus.basics.formatting import counted
from swarmcensus.brains import Brain, Value
from swarmcensus.brains.packing import PLAIN
from swarmcensus.engine.addresses import address
from swarmcensus.engine.compiler import IN_SUMS, IN_SUMS_OF_ALL, ONE_BY_ONE
from swarmcensus.engine.layout import Links
from swarmcensus.studies.members import Member, member_numbers
from swarmcensus.worlds import arena
from swarmcensus.worlds.bodies import Body
from swarmcensus.worlds.changes import Change, along, steady
from swarmcensus.worlds.changing_ground import ChangingGround
from swarmcensus.worlds.faults import Fault, for_an_oracle, stops
from swarmcensus.worlds.ground import Ground
from swarmcensus.worlds.networks import Topology
from swarmcensus.worlds.patterns import Floor
from swarmcensus.worlds.sensors import Accuracy, Misjudgement

NO_LUCK = np.zeros(0, np.uint64)


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

    def groups(self, seed: int, first_trial: int, trials: int) -> np.ndarray:
        """Which table of members each robot belongs to (trial, robot): counted from 1, and 0 for none."""
        return member_numbers(self.members, seed, first_trial, trials, self.robots)

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
        if self.additive and self._all_is_heard and (self.brain.is_oracle or self.topology.is_full):
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

    def ground(self, seed: int, trial: int) -> Ground | ChangingGround:
        """The floor of a trial; only of robots that move."""
        assert self.body is not None
        floor = self.floor or Floor()
        if self.change:
            shares = self.fill_ratios(np.arange(1, min(self.rounds, self.change.end) + 1))
            return ChangingGround(floor, self.body, self.arena_side, shares, self.floor_key(seed), trial)
        return Ground(floor, self.body, self.arena_side, self.fill_ratio, self.floor_key(seed), trial)

    @property
    def fastest_body(self) -> Body:
        """The body with the speed of the fastest robots, which decides how far away neighbours are looked for."""
        assert self.body is not None
        speed = max([self.body.speed, *(m.speed for m in self.members if m.speed is not None)])
        return self.body if speed == self.body.speed else self.body.model_copy(update={"speed": speed})

    def speeds(self, seed: int, trial: int) -> np.ndarray:
        """The distance that each robot drives straight ahead in a tick, in metres (robot); empty on fixed networks."""
        if self.body is None:
            return np.zeros(0)
        speeds = np.full(self.robots, self.body.speed)
        groups = self.groups(seed, trial, 1)[0] if self.members else None
        for number, member in enumerate(self.members, start=1):
            if member.speed is not None:
                speeds[groups == number] = member.speed
        return speeds * self.body.tick

    def links(self, seed: int, first_trial: int, trials: int) -> Links:
        """The links of these trials: who hears whom."""
        topology = Topology("full") if self.brain.is_oracle else self.topology
        return topology.links(self.robots, seed, first_trial, trials, self._all_is_heard, self.additive)

    @property
    def _all_is_heard(self) -> bool:
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

    def stops(self, seed: int, trial: int) -> np.ndarray:
        """When parts of robots fail, as `swarmcensus.worlds.faults.stops` gives it."""
        times = stops(self.faults, seed, trial, self.robots)
        lies = np.array([False, *(not m.honest for m in self.members)])
        return for_an_oracle(times, lies[self.groups(seed, trial, 1)[0]]) if self.brain.is_oracle else times

    def accuracies(self, seed: int, first_trial: int, trials: int) -> tuple[np.ndarray, ...]:
        """True b and w, then assumed b and w, each (trial, robot) or (trial, 1)."""
        where = (seed, first_trial, trials, self.robots)
        if any(m.accuracy or m.assumed_accuracy for m in self.members):
            groups = self.groups(seed, first_trial, trials)
            drawn = _mixed_accuracies(self.accuracy, self.assumed_accuracy, self.members, groups, where)
        else:
            drawn = _accuracies(self.accuracy, self.assumed_accuracy, where)
        return drawn[:2] * 2 if self.brain.is_oracle else drawn

    def drifts(self, seed: int, first_trial: int, trials: int, start: np.ndarray) -> np.ndarray:
        """How true accuracies drift from `start`, b of round 1 (trial, robot or 1): see `_drifts`."""
        return _drifts(self.accuracy, self.members, lambda: self.groups(seed, first_trial, trials), start)

    # addresses of random numbers

    def fingerprint(self, seed: int) -> str:
        """A hash of the brain's name and all that a trial's numbers depend on: equal settings share it."""
        content: tuple[object, ...] = (
            self.brain.name,
            self.brain.sha256,
            self.topology.content,
            self.robots,
            str(self.accuracy),
            "" if self.assumed_accuracy is None else str(self.assumed_accuracy),
            self.fill_ratio,
            self.link_success,
            self.rounds,
            self.observations_per_round,
            self.density,
            self.body and self.body.model_dump(),
            [fault.content for fault in self.faults],
            self.floor and [str(self.floor), self.floor.content],
        )
        if self.members:
            content = (*content, [member.content for member in self.members])
        if self.brain.parameters:
            content = (*content, [*self.brain.parameters.items()])
        if self.change:
            content = (*content, str(self.change))
        if self.delay:
            content = (*content, "message_delay", self.delay)
        if self.brain.numbers != PLAIN:
            content = (*content, "numbers", *self.brain.numbers)
        if self.editions:
            content = (*content, self.editions)
        return hashlib.blake2b(repr((seed, content)).encode(), digest_size=16).hexdigest()

    @property
    def editions(self) -> list[str]:
        """Hashes of the files of other packages that it uses."""
        theirs = (part for m in self.members for part in (m.accuracy, m.assumed_accuracy))
        parts = (self.topology, self.accuracy, self.assumed_accuracy, self.floor, *theirs)
        return [part.edition for part in parts if part is not None and part.edition]

    def readings_key(self, seed: int, purpose: str = "readings") -> np.ndarray:
        """The address of sensor readings. A change or drift is no part of it: only how the world begins is."""
        return address(
            seed,
            purpose,
            robots=self.robots,
            accuracy=str(self.accuracy.start),
            fill_ratio=float(self.course[0]),
            observations_per_round=self.observations_per_round,
            **self._where,
        )

    def losses_key(self, seed: int) -> np.ndarray:
        """The address of message losses."""
        return address(
            seed,
            "losses",
            topology=self.topology.content,
            robots=self.robots,
            success=self.link_success,
            **self._where,
        )

    def luck_keys(self, seed: int, alone: bool = False) -> np.ndarray:
        """The addresses of random numbers for brains, in their functions and in messages; empty if none asks for any.

        All brains share them. With `alone` all networks do too: settings that differ only in the network share their
        local estimates.
        """
        if not any(brain.uses.luck for brain in self.brains):
            return NO_LUCK
        network = {} if alone else {"topology": self.topology.content}
        content = {"robots": self.robots, **network, **self._where}
        return np.concatenate([address(seed, purpose, **content) for purpose in ("luck", "luck of messages")])

    @property
    def _where(self) -> dict[str, object]:
        return {} if self.density is None else {"density": self.density}

    def floor_key(self, seed: int) -> np.ndarray:
        """The address of the floor's tiles. A change is no part of it: only how the floor begins is."""
        assert self.body is not None
        return address(
            seed,
            "floor",
            robots=self.robots,
            density=self.density,
            tile=self.body.tile,
            fill_ratio=float(self.course[0]),
            **({} if self.floor in (None, Floor()) else {"floor": self.floor.content}),
        )

    def walk_key(self, seed: int) -> np.ndarray:
        """The address of trajectories: where robots start and how they walk."""
        return address(seed, "walk", **self.walk_content)

    @property
    def walk_content(self) -> dict[str, object]:
        """What the random numbers of trajectories depend on."""
        assert self.body is not None
        body = self.body.model_dump(exclude={"message_delay"})
        return {"robots": self.robots, "density": self.density, "body": body}

    @property
    def walk_group(self) -> str:
        """Settings of one group share their trajectories, trial by trial. Where a brain steers, it shares with none."""
        if self.steers:
            return self.fingerprint(0)
        speeds = [(m.robots, m.speed) for m in self.members] if any(m.speed is not None for m in self.members) else []
        lame = [(n, f.at, f.until, f.robots) for n, f in enumerate(self.faults) if "moving" in f.stop]
        return repr((self.walk_content, self.rounds, lame, *speeds))


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


Sides = tuple[np.ndarray, ...]
Where = tuple[int, int, int, int]  # seed, first trial, trials, robots


def _accuracies(true: Accuracy, assumed: Accuracy | Misjudgement | None, where: Where) -> Sides:
    """True b and w, then assumed b and w, each (trial, robot) or (trial, 1). Without `assumed`, robots know theirs."""
    own = _drawn(true, "accuracy", where, ())
    return *own, *(own if assumed is None else _drawn(assumed, "assumed", where, own))


def _mixed_accuracies(
    true: Accuracy,
    assumed: Accuracy | Misjudgement | None,
    members: Sequence[Member],
    groups: np.ndarray,
    where: Where,
) -> Sides:
    """True b and w, then assumed b and w, each (trial, robot), where members have accuracies of their own.

    A member assumes what its table says, else what the swarm assumes. `groups` (trial, robot) is from `Setting.groups`.
    """
    of_swarm = [np.broadcast_to(side, groups.shape) for side in _accuracies(true, assumed, where)]
    own = of_swarm[:2]
    for number, member in enumerate(members, start=1):
        if member.accuracy:
            drawn = _drawn(member.accuracy, f"accuracy of members {number}", where, ())
            own = _replaced(groups == number, drawn, own)
    believed = own if assumed is None else of_swarm[2:]
    for number, member in enumerate(members, start=1):
        belief = member.assumed_accuracy
        if not belief and member.accuracy and isinstance(assumed, Misjudgement):
            belief = assumed
        if belief:
            drawn = _drawn(belief, f"assumed by members {number}", where, own)
            believed = _replaced(groups == number, drawn, believed)
    return tuple(np.ascontiguousarray(side) for side in (*own, *believed))


def _drifts(
    true: Accuracy, members: Sequence[Member], groups: Callable[[], np.ndarray], start: np.ndarray
) -> np.ndarray:
    """How robots' accuracies drift: their gain a round, their least and their greatest, (trial, 3, robot).

    (trial, 3, 1) where all robots drift alike, (trial, 3, 0) where none drifts. `groups` is as
    `Setting.groups`. `start` is b of round 1, (trial, robot) or (trial, 1). An accuracy that starts
    beyond its bound stays.
    """
    kinds = [true, *(member.accuracy or true for member in members)]
    if all(accuracy.drift is None for accuracy in kinds):
        return np.zeros((len(start), 3, 0))
    differ = any(member.accuracy for member in members)
    numbers = np.array([(0.0, 0.0, 1.0) if a.drift is None else a.drift.numbers for a in kinds])
    slope, least, most = np.moveaxis(numbers[groups() if differ else np.zeros(start.shape, int)], -1, 0)
    return np.ascontiguousarray(np.stack([slope, np.minimum(least, start), np.maximum(most, start)], axis=1))


def _drawn(what: Accuracy | Misjudgement, purpose: str, where: Where, true: Sequence[np.ndarray]) -> Sides:
    seed, first, trials, robots = where
    if isinstance(what, Misjudgement):
        return what.draw(seed, first, trials, robots, (true[0], true[1]))
    return what.draw(seed, purpose, first, trials, robots)


def _replaced(which: np.ndarray, new: Sequence[np.ndarray], old: Sequence[np.ndarray]) -> list[np.ndarray]:
    return [np.where(which, after, before) for after, before in zip(new, old, strict=True)]
