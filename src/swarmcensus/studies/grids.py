"""Grids of settings: all combinations of a study's values, and for each case, of its values in place of some."""

import itertools
import math
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from typing import Any

from swarmcensus.brains import Numbers
from swarmcensus.studies.keys import Key
from swarmcensus.studies.members import Member, Members
from swarmcensus.studies.settings import KEYS, Schedule, Setting, Swarm, World
from swarmcensus.worlds import Change, Distribution, Fault, Floor, Topology, arena

LAST = ("members", "rounds", "observations_per_round", "density", "floor", "ticks")  # vary fastest, in this order
SIZES = {"density", "side"}  # of an arena: a case that gives one replaces the other


@dataclass(frozen=True)
class Grid:
    """The tables that span a grid; for a case also its name, such as "case[0]", and the keys that it gives."""

    swarm: Swarm
    world: World
    schedule: Schedule
    case: str = ""
    given: frozenset[str] = frozenset()
    members: tuple[Members, ...] = ()

    def key(self, name: str) -> str:
        """A key's name in messages: "world.side", "case[0].side" or "case[0]: world.side"."""
        if name in self.given:
            return f"{self.case}.{name}"
        return f"{self.case}: " * bool(self.case) + f"{KEYS[name].table}.{name}"

    @property
    def moves(self) -> bool:
        """Whether some of its robots move."""
        return any(t.moves for t in self.world.topology)

    @property
    def stands(self) -> bool:
        """Whether some of its networks are fixed."""
        return any(not t.moves for t in self.world.topology)

    def uses(self, key: Key) -> bool:
        """Whether a key has an effect in it."""
        return any(key.has_effect(topology.moves) for topology in self.world.topology)

    @property
    def lengths(self) -> set[int]:
        """The numbers of rounds, or ticks, of its settings."""
        return {*(self.schedule.rounds if self.stands else ()), *(self.schedule.ticks if self.moves else ())}

    def densities(self, robots: int) -> list[float]:
        """The swarm densities for this number of robots that move."""
        sides = [arena.density(robots, side, self.world.body) for side in self.world.side or ()]
        return [*(self.world.density or ()), *sides]

    def _mixes(self, robots: int) -> list[tuple[Member, ...]]:
        """The combinations of members in swarms of this size, each once, without members of 0 robots."""
        every = itertools.product(*(list(table.every()) for table in self.members))
        return list(dict.fromkeys(tuple(m for m in members if m.count(robots)) for members in every))

    def _spans(self, topology: Topology, robots: int) -> dict[str, list[Any]]:
        """The lists that span the settings with this topology and size, by key; the last one varies fastest."""
        keys = [key for key in KEYS.values() if key.spans and key.has_effect(topology.moves)]
        values = {key.name: getattr(getattr(self, key.table), key.name) or [key.default] for key in keys}
        values |= {"topology": [topology], "robots": [robots], "members": self._mixes(robots)}
        if topology.moves:
            values |= {"density": self.densities(robots), "floor": self.world.floor or [Floor()]}
        order = [*(name for name in values if name not in LAST), *(name for name in LAST if name in values)]
        return {name: values[name] for name in order if name != "side"}  # densities include it

    @property
    def count(self) -> int:
        """The number of settings."""
        robots = self.swarm.robots  # only the mixes of members may differ in number
        spans = [self._spans(topology, robots[0]) | {"members": [()]} for topology in self.world.topology]
        return sum(math.prod(map(len, span.values())) for span in spans) * sum(len(self._mixes(n)) for n in robots)

    def settings(self, faults: tuple[Fault, ...]) -> Iterator[Setting]:
        """All combinations of the values: brain, topology, robots and accuracy vary slowest."""
        kinds = [(kind[0], self._spans(*kind)) for kind in itertools.product(self.world.topology, self.swarm.robots)]
        formats = itertools.product(self.swarm.precision, self.world.message)
        every = [Numbers(precision, message, self.world.feedback) for precision, message in formats]
        for brain in self.swarm.brain:
            brains = {numbers[:2]: brain.with_numbers(numbers) for numbers in every}
            for topology, lists in kinds:
                fixed = {"observations_per_round": 1, "body": self.world.body} if topology.moves else {}
                fields = [KEYS[name].field if name in KEYS else name for name in lists]
                for values in itertools.product(*(lists | {"brain": [brain]}).values()):
                    chosen = dict(zip(fields, values, strict=True)) | fixed
                    chosen["brain"] = brains[chosen.pop("precision"), chosen.pop("message")]
                    if isinstance(change := chosen["fill_ratio"], Change):
                        chosen |= {"fill_ratio": change.ends_in(chosen["rounds"]), "change": change}
                    elif isinstance(spread := change, Distribution):
                        chosen |= {"fill_ratio": float(f"{spread.moments()[0]:.12g}"), "spread": spread}
                    yield Setting(faults=faults, **chosen)


def grids_of(
    swarm: Swarm, world: World, schedule: Schedule, cases: Iterable[Any], members: tuple[Members, ...] = ()
) -> list[Grid]:
    """The full grid of a study, followed by the grid of each case."""
    grids = [Grid(swarm, world, schedule, members=members)]
    for number, case in enumerate(cases):
        given = {key: values for key, values in case if values is not None}
        instead = given | dict.fromkeys(SIZES - given.keys()) if SIZES & given.keys() else given
        tables: dict[str, Any] = {
            name: table.model_copy(update={k: v for k, v in instead.items() if k in type(table).model_fields})
            for name, table in {"swarm": swarm, "world": world, "schedule": schedule}.items()
        }
        grids.append(Grid(**tables, case=f"case[{number}]", given=frozenset(given), members=members))
    return grids
