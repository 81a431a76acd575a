"""Missions: a study that wants something of its robots, with values that a plan finds."""

import functools
import itertools
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from swarmcensus.brains import Adversary
from swarmcensus.search.planning.areas import capacity, fewest
from swarmcensus.search.planning.goals import Goal
from swarmcensus.studies import (
    KEYS,
    LARGEST,
    OPEN,
    Setting,
    Study,
    Wanted,
    key_of,
    open_values,
    with_values,
)
from swarmcensus.support.errors import StudyError
from swarmcensus.support.texts import read_text
from swarmcensus.support.toml_text import plain, read_toml, to_toml_value
from swarmcensus.worlds import Accuracy, Body, Change, Distribution, Floor, Topology, arena

FEWEST_TRIALS = 40  # of a first look: fewer are too imprecise to help
TRIALS = 200
MOST_ROBOTS = 1_000_000
MOST_TRIED = 1000  # robots of the largest swarm to try, if the mission does not say
COMPARED = ["commons", "minimalistic"]  # brains, if the mission names none
AMONG_LIARS = ["steadfast", "minimalistic"]  # the same if robots lie: one shouting liar controls commons
Range = tuple[Any, Any]


@dataclass(frozen=True)
class Mission:
    """A study with one world, and what is to be found in it.

    The study's robots, fill ratios, accuracies, members' brains and length stand for those that a plan tries.
    """

    study: Study
    tables: Mapping[str, Any]  # of the study
    base: Path | None  # the folder of the files that tables name
    robots: Range | None  # the fewest and the most
    minutes: Range | None
    accuracies: tuple[Accuracy, ...]  # of which the first is planned for
    world: Mapping[str, str]  # the values of its keys in which several worlds differ
    sized_side: float | None = None  # of the arena, where it follows from a density and a number of robots

    @property
    def wanted(self) -> Wanted:
        """What robots should know."""
        return self.study.wanted

    @property
    def goal(self) -> Goal:
        """The goal, which tells which estimates are right."""
        return Goal(self.wanted)

    @functools.cached_property
    def setting(self) -> Setting:
        """One setting of the study: what does not depend on the values that a plan tries."""
        return self.study.settings()[0]

    @property
    def moves(self) -> bool:
        """Whether robots move."""
        return self.setting.topology.moves

    @property
    def body(self) -> Body:
        """The body of robots that move."""
        return self.study.world.body

    @property
    def density(self) -> float | None:
        """The swarm density, if it is given in place of the side."""
        return self.study.world.density[0] if self.moves and self.study.world.density else None

    @property
    def side(self) -> float | None:
        """The inner side of the arena in metres; None on fixed networks, and if it follows from a density."""
        return self.study.world.side[0] if self.moves and self.study.world.side else self.sized_side

    def sized(self, robots: int) -> "Mission":
        """The mission for a swarm of this size; if a density is given, with the side that follows from it."""
        if self.density is None:
            return self
        return replace(self, sized_side=arena.side(robots, self.density, self.body))

    @property
    def accuracy(self) -> Accuracy:
        """The accuracy that is planned for."""
        return self.accuracies[0]

    @property
    def fill_ratios(self) -> tuple[float, float]:
        """The least and the largest fill ratio, of which the worst is planned for."""
        ratios = self.study.world.fill_ratio
        return min(ratios), max(ratios)

    @property
    def on_floor(self) -> bool:
        """Whether the truth is the floor's own share of black."""
        return self.moves and self.study.measure.truth == "floor"

    @property
    def round_minutes(self) -> float:
        """The minutes of a round, or of a tick."""
        return self.wanted.round_minutes(self.setting)

    def rounds(self, minutes: float) -> int:
        """How many whole rounds fit into these minutes."""
        return min(int(minutes / self.round_minutes + 1e-9), LARGEST)

    @property
    def liars(self) -> int | None:
        """Which table of members has adversaries; None if none has."""
        tables = enumerate(self.study.members)
        return next((n for n, table in tables if any(isinstance(one, Adversary) for one in table.brain or ())), None)

    @property
    def lies(self) -> list[Adversary]:
        """What liars may do, of which the worst is used; empty if no member has an adversary."""
        every = [] if self.liars is None else self.study.members[self.liars].brain or []
        return [one for one in every if isinstance(one, Adversary)]

    @property
    def has_liars(self) -> bool:
        """Whether any robot is not honest."""
        return any(not table.honest for table in self.study.members)

    def lying(self, robots: int) -> int:
        """How many of the robots are not honest."""
        return sum(member.count(robots) for member in self.setting.members if not member.honest)

    def failing(self, robots: int) -> int:
        """How many of the robots stop observing for good."""
        lasting = (fault for fault in self.study.faults if "sensing" in fault.stop and fault.until is None)
        return min(sum(fault.count(robots) for fault in lasting), robots - self.lying(robots) - 1)

    @property
    def sizes(self) -> tuple[int, int]:
        """The smallest and the largest swarm."""
        if self.robots is not None:
            return self.robots
        if self.density is not None:
            return fewest(self.density, self.body), MOST_TRIED
        return 1, MOST_TRIED if self.side is None else min(MOST_TRIED, capacity(self.side, self.body))


def tables_of(path: str | Path) -> dict[str, Any]:
    """The tables of a study file, not yet checked. Raises InputError."""
    where = f"study file {path}"
    tables = read_toml(read_text(path, where, StudyError, ending=".toml"), where)
    return {"name": Path(path).stem, **tables}


def missions_of(tables: Mapping[str, Any], where: str = "mission", base: Path | None = None) -> list[Mission]:
    """The missions of a study's tables, one for each of its worlds. Raises InputError."""
    try:
        return _missions(_with_usual(plain(dict(tables))), where, base)
    except StudyError as error:
        raise error if str(error).startswith(where) else StudyError.within(where, error) from None


def _with_usual(tables: dict[str, Any]) -> dict[str, Any]:
    """The tables of a mission with values for what it may leave out."""
    parts = {name: tables.get(name, {}) for name in ("swarm", "world", "schedule", "measure", "wanted")}
    for name, part in parts.items():
        if not isinstance(part, Mapping):
            raise StudyError.at(name, to_toml_value(part), "should be a table")
    members = tables.get("members")
    every = members if isinstance(members, list) else []
    lie = any(isinstance(one, Mapping) and one.get("honest") is False for one in every)
    swarm = {"brain": AMONG_LIARS if lie else COMPARED} | dict(parts["swarm"])
    world = {"topology": "moving", "fill_ratio": {"worst": [0.0, 1.0]}} | dict(parts["world"])
    measure = {"truth": "floor"} if "moving" in (world["topology"], *_listed(world["topology"])) else {}
    usual = {"name": "mission", "trials": TRIALS} | tables
    return usual | {"swarm": swarm, "world": world, "measure": measure | dict(parts["measure"])}


def _listed(value: Any) -> list[Any]:
    return value if isinstance(value, list) else [value]


def _missions(tables: dict[str, Any], where: str, base: Path | None) -> list[Mission]:
    opened = _opened(tables)
    closed = _closed(tables, opened)
    chosen = {str(place[-1]): (values[0], values[1]) for place, (word, values) in opened.items() if word == "choose"}
    swarm, wanted = closed["swarm"], closed["wanted"]

    def worlds_of(tables: Mapping[str, Any]) -> list[Mission]:
        def study_of(tables: Mapping[str, Any]) -> Study:
            return Study.changed(tables, {}, where=where, context={"base": base or Path(), "warned": True})

        whole = study_of(tables)
        _check_study(whole, opened)
        missions = []
        for world in _worlds(whole, opened):
            in_world = _in_world(tables, world, whole)
            study = study_of(in_world)
            names = {key.partition(".")[2]: _title(value) for key, value in world.items()}
            missions.append(Mission(study, in_world, base, None, None, tuple(study.swarm.accuracy), names))
        return missions

    if "robots" not in swarm:  # as many as all worlds have room for stand for them
        try:
            sizes = [
                one.sizes for one in worlds_of(closed | {"members": [], "faults": [], "swarm": swarm | {"robots": 1}})
            ]
        except StudyError as error:
            if error.key is not None and "topology" not in error.key:
                raise
            raise StudyError(f"{error}: say how many robots there are, as swarm.robots", key=error.key) from None
        closed["swarm"] = swarm | {"robots": min(most for _, most in sizes)}
    missions = []
    for one in worlds_of(closed):
        robots = one.study.swarm.robots[0]
        minutes: Range | None = chosen.get("minutes") or (wanted.get("minutes"),) * 2
        if minutes == (None, None):
            length = "ticks" if one.moves else "rounds"
            minutes = None
            if length in closed.get("schedule", {}):  # how long it may take at most
                minutes = one.round_minutes, one.setting.rounds * one.round_minutes
        given = chosen.get("robots", (robots, robots)) if "robots" in swarm else None
        missions.append(replace(one, robots=given, minutes=minutes))
    return missions


def _title(value: Any) -> str:
    return value.title if isinstance(value, Topology | Floor) else str(value)


def _opened(tables: Mapping[str, Any]) -> dict[tuple[str | int, ...], tuple[str, Any]]:
    """What a plan finds, by place. Raises StudyError for what no plan finds."""
    opened = open_values(tables)
    for place, (word, values) in opened.items():
        key, kind, text = key_of(place), f"{place[0]}.{place[-1]}", to_toml_value({word: values})
        if kind not in OPEN[word]:
            others = [f"{{{other} = ...}}" for other, keys in OPEN.items() if kind in keys]
            every = "; ".join(f"{{{other} = ...}} goes with {', '.join(keys)}" for other, keys in OPEN.items())
            raise StudyError.at(key, text, f"should be {others[0]}" if others else every)
        numbers = isinstance(values, list) and all(isinstance(one, int | float) for one in values)
        if word == "choose" or kind == "world.fill_ratio":
            if not numbers or len(values) != 2 or values[0] > values[1]:
                raise StudyError.at(key, text, "should have two numbers, the lower one first")
        elif not isinstance(values, list) or not values:
            raise StudyError.at(key, text, "should have a list of values")
    return opened


def _closed(tables: Mapping[str, Any], opened: Mapping[tuple[str | int, ...], tuple[str, Any]]) -> dict[str, Any]:
    """The tables with the largest of what is chosen, and lists of what the worst is of."""
    closed = {**tables} | {"wanted": dict(tables.get("wanted", {}))}
    for (name, *inner), (word, values) in opened.items():
        table: Any = closed
        for part in (name, *inner[:-1]):
            table[part] = table = [*table[part]] if isinstance(table[part], list) else dict(table[part])
        table[inner[-1]] = values if word == "worst" else values[1]
    return closed


def _worlds(study: Study, opened: Mapping[tuple[str | int, ...], Any]) -> Iterator[dict[str, Any]]:
    """The values of each world, by key; empty if there is one world."""
    for topology in study.world.topology:
        lists = {"world.topology": [topology]} if len(study.world.topology) > 1 else {}
        for key in KEYS.values():
            values, place = getattr(getattr(study, key.table), key.name), (key.table, key.name)
            is_free = isinstance(values, list) and len(values) > 1 and key.has_effect(topology.moves)
            if is_free and key.name not in ("brain", "topology") and place not in opened:
                lists[".".join(place)] = values
        for values in itertools.product(*lists.values()):
            yield dict(zip(lists, values, strict=True))


def _in_world(tables: Mapping[str, Any], world: Mapping[str, Any], study: Study) -> dict[str, Any]:
    """The tables of a study with the values of one of its worlds, and without keys that have no effect there."""
    values = {key: [value] for key, value in world.items()}
    changed = with_values(tables, values)
    moves = world.get("world.topology", study.world.topology[0]).moves
    for key in KEYS.values():
        if key.name in changed.get(key.table, ()) and not key.has_effect(moves):
            changed[key.table] = {name: value for name, value in changed[key.table].items() if name != key.name}
    if "world.topology" in world and not moves:  # where nothing moves, no floor is drawn
        changed["measure"] = changed["measure"] | {"truth": "nominal"}
    return changed


def _check_study(study: Study, opened: Mapping[tuple[str | int, ...], Any]) -> None:
    """Raise StudyError if a study has what no plan is for, or if its goal can never be reached."""
    wanted, brains = study.wanted, study.swarm.brain
    if wanted.goal is None:
        raise StudyError(
            'wanted: should have an error, such as 0.02, or right, such as "majority" or 10 bins', key="wanted"
        )
    if study.case:
        raise StudyError("case: a plan has no cases: give keys lists, or plan for each alone", key="case")
    if study.until or study.trials < FEWEST_TRIALS:
        trials = to_toml_value(study.until) if study.until else study.trials
        raise StudyError.at("trials", trials, f"a plan needs a whole number from {FEWEST_TRIALS:,}")
    for n, table in enumerate(study.members):
        for key, values in table:
            if key == "brain" and ("members", n, key) in opened:
                brains_there = [one.name for one in values if not isinstance(one, Adversary)]
                if brains_there:
                    what = "that is a brain, and not an adversary, such as shouter"
                    raise StudyError.at(f"members[{n}].brain", brains_there[0], what)
            elif isinstance(values, list) and len(values) > 1:
                why = "a plan has one value, or of brains {worst = [...]} in place of a list"
                raise StudyError(f"members[{n}].{key}: {why}", key=f"members[{n}].{key}")
    study.check_faults()
    for ratio in study.world.fill_ratio:
        if isinstance(ratio, Change | Distribution):
            right = "a plan is for a floor that stays, and for the worst of a range: {worst = [low, high]}"
            raise StudyError.at("world.fill_ratio", ratio, right)
    for accuracy in study.swarm.accuracy:
        if accuracy.drift is not None:
            raise StudyError("swarm.accuracy: a plan is for sensors that do not drift", key="swarm.accuracy")
        if accuracy.is_blind:
            why = f"an accuracy of {accuracy} says the same of black and white"
            raise StudyError(f"the goal cannot be reached, because {why}", key="swarm.accuracy", value=accuracy)
    for brain in brains if wanted.error is not None else ():
        if brain.is_opinion:
            raise StudyError.at("swarm.brain", brain.name, "its robots have opinions of 0 or 1, so wanted needs right")
    if max(study.swarm.robots) > MOST_ROBOTS:
        raise StudyError.at("swarm.robots", max(study.swarm.robots), f"a plan has at most {MOST_ROBOTS:,} robots")
    low, high = min(study.world.fill_ratio), max(study.world.fill_ratio)
    if not Goal(wanted).candidates(low, high).size:
        none = f"wanted.margin = {wanted.margin:g} leaves no fill ratio from {low:g} to {high:g} for {wanted.right!r}"
        raise StudyError(none, key="wanted.margin", value=wanted.margin)
    on_edges = [k / wanted.bins for k in range(1, wanted.bins) if low <= k / wanted.bins <= high] if wanted.bins else []
    if on_edges and wanted.margin == 0.0:
        why = f"f may be {on_edges[0]:g}, on the edge between two bins: say how far off it is (wanted.margin)"
        raise StudyError(f"the goal cannot be reached, because {why}, or narrow world.fill_ratio", key="wanted.margin")
