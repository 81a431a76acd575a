"""Grids of settings: all combinations of a study's values, and for each case, of its values in place of some."""

import itertools
import math
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from typing import Any

from swarmcensus.brains.packing import Numbers
from swarmcensus.studies.members import Member, Members
from swarmcensus.studies.settings import Setting
from swarmcensus.studies.tables import Case, Schedule, Swarm, World
from swarmcensus.worlds import arena
from swarmcensus.worlds.changes import Change
from swarmcensus.worlds.faults import Fault
from swarmcensus.worlds.patterns import Floor

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
        table = next(t for t in ("swarm", "world", "schedule") if name in type(getattr(self, t)).model_fields)
        return f"{self.case}: {table}.{name}" if self.case else f"{table}.{name}"

    @property
    def moves(self) -> bool:
        """Whether some of its robots move."""
        return any(t.moves for t in self.world.topology)

    @property
    def stands(self) -> bool:
        """Whether some of its networks are fixed."""
        return any(not t.moves for t in self.world.topology)

    @property
    def lengths(self) -> set[int]:
        """The numbers of rounds, or ticks, of its settings."""
        return {*(self.schedule.rounds if self.stands else ()), *(self.schedule.ticks if self.moves else ())}

    def densities(self, robots: int) -> list[float]:
        """The swarm densities for this number of robots that move."""
        sides = [arena.density(robots, side, self.world.body) for side in self.world.side or ()]
        return [*(self.world.density or ()), *sides]

    @property
    def _lists(self) -> list[list[Any]]:
        swarm, world = self.swarm, self.world
        return [
            swarm.brain, world.topology, swarm.robots, swarm.accuracy, [*(swarm.assumed_accuracy or (None,))],
            world.fill_ratio, world.link_success, world.message_delay, self._numbers,
        ]  # fmt: skip

    @property
    def _numbers(self) -> list[Numbers]:
        """The number formats of its robots."""
        every = itertools.product(self.swarm.precision, self.world.message)
        return [Numbers(precision, message, self.world.feedback) for precision, message in every]

    def _mixes(self, robots: int) -> list[tuple[Member, ...]]:
        """The combinations of members in swarms of this size, each once, without members of 0 robots."""
        every = itertools.product(*(list(table.every()) for table in self.members))
        return list(dict.fromkeys(tuple(m for m in members if m.count(robots)) for members in every))

    @property
    def count(self) -> int:
        """The number of settings."""
        world, schedule = self.world, self.schedule
        moving = sum(t.moves for t in world.topology)
        fixed = len(world.topology) - moving
        return (
            max(len(self._mixes(n)) for n in self.swarm.robots)
            * math.prod(len(values) for values in self._lists if values is not world.topology)
            * (
                fixed * len(schedule.rounds) * len(schedule.observations_per_round)
                + moving * len(self.densities(1)) * len(world.floor or [None]) * len(schedule.ticks)
            )
        )

    def settings(self, faults: tuple[Fault, ...]) -> Iterator[Setting]:
        """All combinations of the values: brain, topology, robots and accuracy vary slowest."""
        world, schedule = self.world, self.schedule
        fixed = [(c, r, None, None, faults) for c in schedule.rounds for r in schedule.observations_per_round]
        moving = {
            robots: [
                (ticks, 1, density, world.body, faults, floor)
                for density in self.densities(robots)
                for floor in world.floor or [Floor()]
                for ticks in schedule.ticks
            ]
            for robots in self.swarm.robots
        }
        mixes = {robots: self._mixes(robots) for robots in self.swarm.robots}
        brains = {(b, numbers): b.with_numbers(numbers) for b in self.swarm.brain for numbers in self._numbers}
        for named, topology, robots, *sensors, fill, success, delay, numbers in itertools.product(*self._lists):
            brain = brains[named, numbers]
            lengths = moving[robots] if topology.moves else fixed
            change = fill if isinstance(fill, Change) else None
            for mix, (rounds, *length) in itertools.product(mixes[robots], lengths):
                end = change.ends_in(rounds) if change else fill  # type: ignore[arg-type]
                of_world = (end, success, rounds, *length)
                yield Setting(  # type: ignore[misc]
                    brain, topology, robots, *sensors, *of_world, members=mix, change=change, delay=delay
                )


def grids_of(
    swarm: Swarm, world: World, schedule: Schedule, cases: Iterable[Case], members: tuple[Members, ...] = ()
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
