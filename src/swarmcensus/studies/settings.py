"""A setting: one point of a study's grid, and the addresses of its random numbers.

Each address holds just what its draws depend on. So two settings that differ only in brain or topology
meet the same tiles and readings, trial by trial, and no setting's numbers depend on its place in a grid.
"""

import functools
import hashlib
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from swarmcensus.basics.formatting import counted
from swarmcensus.brains import Brain, Value
from swarmcensus.engine.addresses import address
from swarmcensus.engine.compiler import IN_SUMS, IN_SUMS_OF_ALL, ONE_BY_ONE
from swarmcensus.engine.layout import Links
from swarmcensus.studies.members import Member, groups
from swarmcensus.worlds import arena
from swarmcensus.worlds.bodies import Body
from swarmcensus.worlds.changes import Change, along, steady
from swarmcensus.worlds.changing_ground import ChangingGround
from swarmcensus.worlds.faults import Fault, as_to_an_oracle, stops
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
    fill_ratio: float  # that of the last round
    link_success: float
    rounds: int  # ticks where robots move
    observations_per_round: int
    density: float | None = None  # of robots that move
    body: Body | None = None
    faults: tuple[Fault, ...] = ()
    floor: Floor | None = None  # of robots that move; None: independent tiles
    members: tuple[Member, ...] = ()  # robots that differ from the others
    change: Change | None = None  # of the fill ratio, while robots look
    delay: int = 0  # rounds from saying to hearing on fixed networks

    def __str__(self) -> str:
        """The setting in a line, for messages."""
        return line(self)

    @property
    def coordinates(self) -> dict[str, object]:
        """What the dataset says of this setting."""
        return coordinates(self)

    @functools.cached_property
    def course(self) -> np.ndarray:
        """The fill ratio in the course of a trial, as the engine takes it."""
        return steady(self.fill_ratio) if self.change is None else self.change.course

    def fill_ratios(self, rounds: ArrayLike) -> np.ndarray:
        """The fill ratios of these rounds, or ticks."""
        return along(self.course, rounds)

    @functools.cached_property
    def crew(self) -> tuple[Brain, ...]:
        """The brains that live in the swarm, each once, its own first; with an oracle no other, as it hears no liar."""
        if self.brain.is_oracle:
            return (self.brain,)
        return tuple(dict.fromkeys([self.brain, *(m.brain_in(self.brain) for m in self.members)]))

    @property
    def steers(self) -> bool:
        """Whether any of its brains says where a robot goes."""
        return any(brain.steers for brain in self.crew)

    @property
    def honest(self) -> int:
        """How many of its robots metrics count."""
        return self.robots - sum(m.count(self.robots) for m in self.members if not m.honest)

    def who(self, seed: int, first_trial: int, trials: int) -> np.ndarray:
        """Who is who (trial, robot): 0, or the number of a table of members, from 1 on."""
        return groups(self.members, seed, first_trial, trials, self.robots)

    @property
    def side(self) -> float:
        """The inner side of the arena in metres, to as many digits as survive its density; NaN on fixed networks."""
        if self.body is None or self.density is None:
            return np.nan
        return float(f"{self.arena_side:.12g}")

    @property
    def arena_side(self) -> float:
        """The inner side of the arena of robots that move, in metres, to the last bit."""
        assert self.body is not None
        assert self.density is not None
        return arena.side(self.robots, self.density, self.body)

    def fingerprint(self, seed: int) -> str:
        """The address of names and of all that a trial's numbers depend on: alike where settings are, in any study."""
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
        if self.editions:
            content = (*content, self.editions)
        return hashlib.blake2b(repr((seed, content)).encode(), digest_size=16).hexdigest()

    @property
    def editions(self) -> list[str]:
        """Hashes of other packages' files that it uses."""
        theirs = (part for m in self.members for part in (m.accuracy, m.assumed_accuracy))
        parts = (self.topology, self.accuracy, self.assumed_accuracy, self.floor, *theirs)
        return [part.edition for part in parts if part is not None and part.edition]

    def readings_key(self, seed: int, purpose: str = "readings") -> np.ndarray:
        """The address of what the robots' sensors say; where the world changes, of one that stays as it begins."""
        return address(
            seed,
            purpose,
            robots=self.robots,
            accuracy=str(self.accuracy.start),
            fill_ratio=float(self.course[0]),
            observations_per_round=self.observations_per_round,
            **self._where,
        )

    @property
    def _where(self) -> dict[str, object]:
        return {} if self.density is None else {"density": self.density}

    @property
    def walk_content(self) -> dict[str, object]:
        """What the random numbers of a walk depend on."""
        assert self.body is not None
        body = self.body.model_dump(exclude={"message_delay"})
        return {"robots": self.robots, "density": self.density, "body": body}

    @property
    def walk_group(self) -> str:
        """Settings alike in this share their walks, trial by trial: those whose brains steer, with no other."""
        if self.steers:
            return self.fingerprint(0)
        paces = [(m.robots, m.speed) for m in self.members] if any(m.speed is not None for m in self.members) else []
        lame = [(n, f.at, f.until, f.robots) for n, f in enumerate(self.faults) if "moving" in f.stop]
        return repr((self.walk_content, self.rounds, lame, *paces))

    def walk_key(self, seed: int) -> np.ndarray:
        """The address of where robots start and how they walk."""
        return address(seed, "walk", **self.walk_content)

    def floor_key(self, seed: int) -> np.ndarray:
        """The address of the floor's tiles: of one that changes, that of the floor as it begins."""
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

    def losses_key(self, seed: int) -> np.ndarray:
        """The address of which messages are lost."""
        return address(
            seed,
            "losses",
            topology=self.topology.content,
            robots=self.robots,
            success=self.link_success,
            **self._where,
        )

    def luck_keys(self, seed: int, alone: bool = False) -> np.ndarray:
        """The addresses of brains' luck, of their own calls and of messages; empty where none asks for it.

        The brain is no part of it: two that ask for luck have the same; nor, of robots that are `alone`, the network,
        for settings that differ in it share their local estimates.
        """
        if not any(brain.uses.luck for brain in self.crew):
            return NO_LUCK
        network = {} if alone else {"topology": self.topology.content}
        content = {"robots": self.robots, **network, **self._where}
        return np.concatenate([address(seed, purpose, **content) for purpose in ("luck", "luck of messages")])

    def accuracies(self, seed: int, first_trial: int, trials: int) -> tuple[np.ndarray, ...]:
        """True b and w, then assumed b and w, each (trial, robot) or (trial, 1)."""
        where = (seed, first_trial, trials, self.robots)
        if any(m.accuracy or m.assumed_accuracy for m in self.members):
            who = self.who(seed, first_trial, trials)
            found = mixed_accuracies(self.accuracy, self.assumed_accuracy, self.members, who, where)
        else:
            found = accuracies(self.accuracy, self.assumed_accuracy, where)
        return found[:2] * 2 if self.brain.is_oracle else found

    def drifts(self, seed: int, first_trial: int, trials: int, start: np.ndarray) -> np.ndarray:
        """How true accuracies drift that `start` as b (trial, robot or 1): see `studies.accuracies`."""
        return drifts(self.accuracy, self.members, lambda: self.who(seed, first_trial, trials), start)

    def paces(self, seed: int, trial: int) -> np.ndarray:
        """How far each robot goes in a tick straight ahead, in metres (robot); nothing on fixed networks."""
        if self.body is None:
            return np.zeros(0)
        speeds = np.full(self.robots, self.body.speed)
        who = self.who(seed, trial, 1)[0] if self.members else None
        for number, member in enumerate(self.members, start=1):
            if member.speed is not None:
                speeds[who == number] = member.speed
        return speeds * self.body.tick

    @property
    def fastest(self) -> Body:
        """The body of the fastest robots: how far one must look for others depends on it."""
        assert self.body is not None
        speed = max([self.body.speed, *(m.speed for m in self.members if m.speed is not None)])
        return self.body if speed == self.body.speed else self.body.model_copy(update={"speed": speed})

    def ground(self, seed: int, trial: int) -> Ground | ChangingGround:
        """The floor of a trial under robots that move."""
        assert self.body is not None
        floor = self.floor or Floor()
        if self.change:
            shares = self.fill_ratios(np.arange(1, min(self.rounds, self.change.end) + 1))
            return ChangingGround(floor, self.body, self.arena_side, shares, self.floor_key(seed), trial)
        return Ground(floor, self.body, self.arena_side, self.fill_ratio, self.floor_key(seed), trial)

    def stops(self, seed: int, trial: int) -> np.ndarray:
        """When parts of robots fail: see `swarmcensus.worlds.faults`."""
        found = stops(self.faults, seed, trial, self.robots)
        lies = np.array([False, *(not m.honest for m in self.members)])
        return as_to_an_oracle(found, lies[self.who(seed, trial, 1)[0]]) if self.brain.is_oracle else found

    def links(self, seed: int, first_trial: int, trials: int) -> Links:
        """Who hears whom in these trials."""
        topology = Topology("full") if self.brain.is_oracle else self.topology
        return topology.links(self.robots, seed, first_trial, trials, self._all_is_heard, self.additive)

    @property
    def _all_is_heard(self) -> bool:
        lossless = self.link_success == 1.0 and not any("talking" in f.stop for f in self.faults)
        return self.brain.is_oracle or lossless

    @property
    def use(self) -> str:
        """What its robots do with their brains, as `engine.compiler.needs` takes it."""
        if self.body is not None:
            return "moving"
        if self.message_delay:
            return "network"
        if self.additive and self._all_is_heard and (self.brain.is_oracle or self.topology.is_full):
            return IN_SUMS_OF_ALL
        return IN_SUMS if self.additive and self.link_success == 1.0 and not self.faults else ONE_BY_ONE

    @property
    def message_delay(self) -> int:
        """How many rounds ago, or ticks where robots move, was said what robots hear."""
        if self.brain.is_oracle:
            return 0
        return self.delay if self.body is None else self.body.message_delay

    @property
    def additive(self) -> bool:
        """Whether robots only add up what they hear: in a mixed swarm the brains' sums may be others."""
        return len(self.crew) == 1 and bool(self.brain.sums)

    @property
    def loss_threshold(self) -> np.uint64:
        """A message gets through where a uniform uint64 is below this; 0 stands for always."""
        if self.link_success == 1.0 or self.brain.is_oracle:
            return np.uint64(0)
        return np.uint64(max(1, int(self.link_success * 2.0**64)))


Sides = tuple[np.ndarray, ...]
Where = tuple[int, int, int, int]  # seed, first trial, trials, robots


def accuracies(true: Accuracy, assumed: Accuracy | Misjudgement | None, where: Where) -> Sides:
    """True b and w, then assumed b and w, each (trial, robot) or (trial, 1); `assumed` None: robots know theirs."""
    had = _drawn(true, "accuracy", where, ())
    return *had, *(had if assumed is None else _drawn(assumed, "assumed", where, had))


def mixed_accuracies(
    true: Accuracy,
    assumed: Accuracy | Misjudgement | None,
    members: Sequence[Member],
    who: np.ndarray,
    where: Where,
) -> Sides:
    """The same where members have their own: what they assume is as for the swarm, but for what they are told.

    `who` (trial, robot) numbers members from 1 on.
    """
    found = [np.broadcast_to(side, who.shape) for side in accuracies(true, assumed, where)]
    had = found[:2]
    for number, member in enumerate(members, start=1):
        if member.accuracy:
            drawn = _drawn(member.accuracy, f"accuracy of members {number}", where, ())
            had = _told(who == number, drawn, had)
    believed = had if assumed is None else found[2:]
    for number, member in enumerate(members, start=1):
        told = member.assumed_accuracy
        if not told and member.accuracy and isinstance(assumed, Misjudgement):
            told = assumed
        if told:
            drawn = _drawn(told, f"assumed by members {number}", where, had)
            believed = _told(who == number, drawn, believed)
    return tuple(np.ascontiguousarray(side) for side in (*had, *believed))


def drifts(true: Accuracy, members: Sequence[Member], who: Callable[[], np.ndarray], start: np.ndarray) -> np.ndarray:
    """What robots' accuracies gain a round, and their least and greatest: (trial, 3, robot), or alike (trial, 3, 1).

    (trial, 3, 0) where nobody's drift. `who` tells the numbers of members, from 1 on; `start` are the accuracies b of
    round 1, (trial, robot) or (trial, 1). One that starts beyond its bound stays.
    """
    every = [true, *(member.accuracy or true for member in members)]
    if all(one.drift is None for one in every):
        return np.zeros((len(start), 3, 0))
    apart = any(member.accuracy for member in members)
    sides = np.array([(0.0, 0.0, 1.0) if one.drift is None else one.drift.numbers for one in every])
    slope, least, most = np.moveaxis(sides[who() if apart else np.zeros(start.shape, int)], -1, 0)
    return np.ascontiguousarray(np.stack([slope, np.minimum(least, start), np.maximum(most, start)], axis=1))


def _drawn(what: Accuracy | Misjudgement, purpose: str, where: Where, had: Sequence[np.ndarray]) -> Sides:
    seed, first, trials, robots = where
    if isinstance(what, Misjudgement):
        return what.draw(seed, first, trials, robots, (had[0], had[1]))
    return what.draw(seed, purpose, first, trials, robots)


def _told(whose: np.ndarray, theirs: Sequence[np.ndarray], others: Sequence[np.ndarray]) -> list[np.ndarray]:
    return [np.where(whose, side, other) for side, other in zip(theirs, others, strict=True)]


def line(of: Any) -> str:
    """A setting in a line, for messages."""
    where = f"{of.topology}, N = {of.robots:,}"
    assumed = "" if of.assumed_accuracy is None else f", assumed accuracy {of.assumed_accuracy}"
    lossy = "" if of.link_success == 1.0 else f", link success {of.link_success}"
    mixed = "".join(f", of them {member}" for member in of.members)
    late = "" if not of.delay else f", messages {counted(of.delay, 'round')} late"
    told = "".join(f", {name} = {_shown(value)}" for name, value in _parameters(of))
    what = f"accuracy {of.accuracy}{assumed}, f = {of.change or of.fill_ratio}{lossy}{late}{told}{mixed}"
    if of.body is not None:
        floor = f", floor {of.floor}" if of.floor not in (None, Floor()) else ""
        return f"{where}, {_room(of)}, {what}{floor}, {counted(of.rounds, 'tick')}"
    return f"{where}, {what}, C = {of.rounds:,}, R = {of.observations_per_round:,}"


def _parameters(of: Any) -> list[tuple[str, Value]]:
    """What a title tells of its brain: all numbers, for others may vary what this one leaves, and given vectors."""
    given = dict(of.brain.overrides)
    return [(n, v) for n, v in of.brain.parameters.items() if n in given or not isinstance(v, tuple)]


def _room(of: Any) -> str:
    """Density or side of the arena: which has fewer digits is what the study gave."""
    density, side = float(f"{of.density:.12g}"), of.side
    return f"L = {side} m" if len(str(side)) < len(str(density)) else f"D = {density}"


def coordinates(of: Any) -> dict[str, object]:
    """What the dataset says of a setting."""
    return {
        "brain": of.brain.name,
        "topology": str(of.topology),
        "robots": of.robots,
        "density": np.nan if of.density is None else of.density,
        "side": of.side,
        "accuracy": str(of.accuracy),
        "assumed_accuracy": str(of.assumed_accuracy or of.accuracy.start),
        "fill_ratio": of.fill_ratio,
        "floor": "" if of.body is None else str(of.floor or Floor()),
        "link_success": of.link_success,
        "rounds": of.rounds,
        "observations_per_round": of.observations_per_round,
        **{name: _shown(value) for name, value in of.brain.parameters.items()},
        **_mixed(of),
        **({"fill_ratio_change": str(of.change)} if of.change else {}),
        **({"message_delay": of.delay} if of.delay else {}),
    }


def _mixed(of: Any) -> dict[str, object]:
    """What the dataset says of members: who they are, how many of them lie, and who these are."""
    if not of.members:
        return {}
    lying = dict.fromkeys(", ".join(m.traits) for m in of.members if not m.honest)
    return {
        "members": "; ".join(map(str, of.members)),
        "liars": of.robots - of.honest,
        "adversary": "; ".join(lying),
    }


def _shown(value: Value) -> float | str:
    """A parameter as a coordinate: a vector as text."""
    return f"({', '.join(f'{one:g}' for one in value)})" if isinstance(value, tuple) else value
