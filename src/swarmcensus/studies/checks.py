"""Checks of a study's values against each other, which no table alone can do."""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import Any

from swarmcensus.brains import Brain
from swarmcensus.brains.library import namesakes
from swarmcensus.studies import members
from swarmcensus.studies.coordinates import is_taken
from swarmcensus.studies.fields import LARGEST, plain_text
from swarmcensus.studies.grids import SIZES, Grid
from swarmcensus.studies.precision import Until
from swarmcensus.studies.settings import KEYS, Setting
from swarmcensus.studies.tables import Tables
from swarmcensus.support.errors import StudyError
from swarmcensus.support.formatting import counted
from swarmcensus.support.hints import did_you_mean
from swarmcensus.support.toml_text import to_toml_value
from swarmcensus.worlds import MOVING, Change, Fault, Floor, Named, Topology, arena, patterns, wiring

MOST_LISTED = 2000  # robots of a full network of which links are missing: each link is then kept
MOST_TILES = 2**30  # from wall to wall: the position of a tile is two 32-bit numbers
SAFE = 0.9995  # so that limits in messages, which have four digits, are within the limits


def check(tables: Tables, grids: Sequence[Grid], all_used: bool) -> None:
    """Raise StudyError, naming the key, if values contradict each other, or with `all_used` if a key has no effect."""
    for grid in grids:
        for key, values in (("brain", grid.swarm.brain), ("topology", grid.world.topology)):
            names = [v.label if isinstance(v, Brain) else v.name for v in values]
            if len(set(names)) < len(names):
                named = all(isinstance(v, Topology) and v.named for v in values)
                hint = "" if named else NAMES[key]
                two = f"two entries of {grid.key(key)} have one name: {', '.join(names)}{hint}"
                raise StudyError(two, key=grid.key(key))
    lists = [*(grid.swarm.brain for grid in grids), *(table.brain or [] for table in tables.members)]
    _one_name("swarm.brain", "brains", (brain.as_written for brains in lists for brain in brains))
    _check_labels(tables.labels, list(dict.fromkeys(brain.name for brains in lists for brain in brains)))
    metrics = [metric.variable for metric in tables.measure.metrics]
    for brain in dict.fromkeys(b.as_written for grid in grids for b in grid.swarm.brain):
        if name := taken_in_results(brain, metrics):
            taken = f"a parameter {name!r}, a name that is taken in the results: rename it"
            raise StudyError.within("swarm.brain", f"the brain {brain.name!r} has {taken}", "swarm.brain", brain.name)
    for grid in grids:
        others = {*metrics, *(name for brain in grid.swarm.brain for name in brain.parameters)}
        parts = [("topology", one.spanned) for one in grid.world.topology]
        for key, spanned in [*parts, *(("floor", one.spanned) for one in grid.world.floor or ())]:
            if name := next((name for name in spanned if name in others or is_taken(name)), ""):
                why = f"{name} cannot have a list here, as it is the name of something else: list tables instead"
                raise StudyError.within(grid.key(key), why, grid.key(key), name)
    _one_name("world.topology", "topologies", (t for grid in grids for t in grid.world.topology))
    _check_texts("world.topology", "topologies", (t for grid in grids for t in grid.world.topology))
    _check_texts("world.floor", "floors", (f for grid in grids if grid.moves for f in grid.world.floor or ()))
    sizes = ((topology, robots) for g in grids for topology in g.world.topology for robots in g.swarm.robots)
    for topology, robots in dict.fromkeys(sizes):
        topology.check(robots)
    for grid in grids:
        robots, missing = max(grid.swarm.robots), max(grid.world.missing_links)
        full = any(topology.is_full for topology in grid.world.topology)
        if full and missing and robots > MOST_LISTED and not all(brain.is_oracle for brain in grid.swarm.brain):
            most = f"a full network has {MOST_LISTED:,} robots at the most then, and there are {robots:,}"
            raise StudyError.at(grid.key("missing_links"), f"{missing:g}", most)
    if all_used:
        _check_used(tables, grids)
    _check_measure(tables, grids)
    for grid in (grid for grid in grids if grid.moves):
        _check_moving(grid)
    _check_faults(tables, grids, all_used)
    for grid in grids:
        _check_changes(grid, all_used)
    honest = list(dict.fromkeys(brain for grid in grids for brain in grid.swarm.brain))
    swarms = sorted({robots for grid in grids for robots in grid.swarm.robots})
    members.check(tables.members, honest, swarms, any(grid.moves for grid in grids))
    sources: dict[str, str] = {}
    for picture in (p for grid in grids if grid.moves for floor in grid.world.floor or () for p in floor.pictures):
        if sources.setdefault(picture.name, picture.source) != picture.source:
            two = f"two images of world.floor have one name: {picture.name}"
            raise StudyError(two, key="world.floor", value=picture.name)


def _check_texts(key: str, what: str, values: Iterable[Topology | Floor]) -> None:
    """Raise StudyError if tables would call two topologies or floors by one name, or one by two."""
    by_text: dict[str, Topology | Floor] = {}
    for value in values:
        text = plain_text(value.title)
        if value.label in RESERVED and value.label != value.name:
            raise StudyError.at(key, f'"{value.label}"', "this label is the name of another topology or floor")
        if by_text.setdefault(text, value) != value:
            both = f"{by_text[text].name} and {value.name}"
            raise StudyError.at(key, f'"{text}"', f"two {what} have this label or name: {both}")


def _check_labels(labels: Mapping[str, str], brains: Sequence[str]) -> None:
    """Raise StudyError for a label of no brain, and for brains that would have one name."""
    for name in (label for label in labels if label not in brains):
        known = f"{did_you_mean(name, brains)}there are {', '.join(brains)}"
        raise StudyError(f"labels: no brain is called {name!r}: {known}", key="labels", value=name)
    if same := namesakes(brains, labels):
        raise StudyError("labels: {} and {} would both be called {!r}".format(*same), key="labels", value=same[2])


def taken_in_results(brain: Brain, also: Sequence[str] = ()) -> str:
    """The first parameter of a brain with a name that is taken in datasets; empty if there is none."""
    return next((name for name in brain.parameters if name in also or is_taken(name)), "")


RESERVED = {MOVING, *wiring.PLUGINS.shipped, *patterns.PLUGINS.shipped}  # names that no label may be
NAMES = {
    "brain": "",
    "topology": ': name a graph by graph.name = "office", an edge list by {name = "office", edges = ...}',
}


def _one_name(key: str, what: str, values: Iterable[Any]) -> None:
    known: dict[str, Any] = {}
    for value in values:
        if known.setdefault(value.name, value) != value:
            two = f"two {what} of {key} and of cases have one name: {value.name}{NAMES[key.split('.')[1]]}"
            raise StudyError(two, key=key, value=value.name)


def _check_used(tables: Tables, grids: Sequence[Grid]) -> None:
    """Raise StudyError for a given key that has no effect in any grid."""
    several = (tables.swarm, tables.world, tables.schedule)
    base = {key for table in several for key in table.model_fields_set if getattr(table, key) is not None}
    for key in KEYS.values():
        replaced_by = SIZES if key.name in SIZES else {key.name}
        users = [grid for grid in grids if grid.uses(key) and not (grid.given & replaced_by)]
        useless = [grids[0]] if key.name in base and not users else []
        useless += [grid for grid in grids if key.name in grid.given and not grid.uses(key)]
        for grid in useless:
            instead = f": {key.instead}" if key.instead else ""
            raise StudyError(f"{grid.key(key.name)} is of {MEANING[key.world]}{instead}", key=grid.key(key.name))
    _check_late(grids)
    if "feedback" in tables.world.model_fields_set and all(grid.world.message == ["double"] for grid in grids):
        formats = "world.feedback is of messages with a number format: world.message says which"
        raise StudyError(formats, key="world.feedback", value=tables.world.feedback)
    if tables.measure.truth == "floor" and not any(grid.moves for grid in grids):
        raise StudyError(f'measure.truth = "floor" is of {MEANING["moving"]}', key="measure.truth", value="floor")


def _check_late(grids: Sequence[Grid]) -> None:
    for grid in grids:
        body, delay = grid.world.body, max(grid.world.message_delay)
        of_body = grid.moves and "message_delay" in body.model_fields_set
        every = [("world.body.message_delay", body.message_delay, max(grid.schedule.ticks), "tick")] * of_body
        every += [(grid.key("message_delay"), delay, max(grid.schedule.rounds), "round")] * grid.stands
        for key, longest, last, unit in every:
            if longest >= last:
                raise StudyError.at(key, longest, f"no message is heard within {counted(last, unit)}")


MEANING = {"moving": 'robots that move: it goes with topology = "moving"', "networks": "fixed networks"}


def _check_measure(tables: Tables, grids: Sequence[Grid]) -> None:
    last, until, known = last_round(grids), tables.trials, tables.measure.checkpoints
    if isinstance(until, Until) and until.checkpoint is not None:
        if known is not None and until.checkpoint not in known:
            raise StudyError.at("trials.until", until.until, f"{until.checkpoint} is no checkpoint")
        if until.checkpoint > (shortest := min(length for grid in grids for length in grid.lengths)):
            which = "the last round" + f" of settings of {counted(shortest, 'round')}" * (shortest != last)
            raise StudyError.at("trials.until", until.until, f"that comes after {which}")
    if late := [c for c in known or () if c > last]:
        after = f"measure.checkpoints = {late[0]} comes after the last round, {last}"
        raise StudyError(after, key="measure.checkpoints", value=late[0])
    variables = [metric.variable for metric in tables.measure.metrics]
    for metric in tables.measure.metrics:
        if variables.count(metric.variable) > 1:
            two = f"measure.metrics: two of them would be called {metric.variable!r} in the results"
            raise StudyError(two, key="measure.metrics", value=metric.name)
        if is_taken(metric.variable):
            used = f"metric file {metric.name}: the name {metric.variable!r} is used in the results"
            why = f"measure.metrics: {used}: give the file another name"
            raise StudyError(why, key="measure.metrics", value=metric.name)
    if tables.measure.local:
        steps = max(max(g.schedule.rounds) * max(g.schedule.observations_per_round) for g in grids)
        follows = f"{counted(steps, 'observation')}: {LARGEST:,} at the most" if steps > LARGEST else ""
        if any(grid.moves for grid in grids):
            follows = "robots on fixed networks, not robots that move"
        if follows:
            raise StudyError(f"measure.local = true follows {follows}", key="measure.local")


def last_round(grids: Sequence[Grid]) -> int:
    """The last round, or tick, of the longest setting."""
    return max(length for grid in grids for length in grid.lengths)


def _check_moving(grid: Grid) -> None:
    world = grid.world
    if world.density is not None and world.side is not None:
        both = f"{grid.key('density')} and {grid.key('side')} both say how large the arena is: give one of them"
        raise StudyError(both, key=grid.key("side"))
    if world.density is None and world.side is None:
        need = "robots that move need a swarm density, such as 1, or the side of their arena in metres (side)"
        raise StudyError(f"{grid.key('density')} is missing: {need}", key=grid.key("density"))
    arenas = []
    for robots, (key, value, density) in _sizes(grid):
        if density > (largest := arena.largest_density(robots, world.body)):
            limit = f"the largest that can is {largest * SAFE:.4g}"
            if key == "side":
                limit = f"the smallest that can has {arena.smallest_side(robots, world.body) / SAFE:.4g} m"
            raise StudyError.at(grid.key(key), value, f"the arena cannot hold {counted(robots, 'robot')}; {limit}")
        side = arena.side(robots, density, world.body)
        if side / world.body.tile > MOST_TILES:
            wide = f"the arena is {side / world.body.tile:.2g} tiles wide; {MOST_TILES:,} is the most"
            raise StudyError.at(grid.key(key), value, wide)
        arenas.append(arena.Arena(side, world.body.tile))
    for floor in world.floor or ():
        try:
            for one in dict.fromkeys(arenas):
                floor.check(one)
        except ValueError as error:
            raise StudyError.at(grid.key("floor"), to_toml_value(floor.form), error) from None


def _sizes(grid: Grid) -> Iterator[tuple[int, tuple[str, float, float]]]:
    """For each number of robots and size of the arena: the robots, the size's key and value, and the density."""
    key, values = ("density", grid.world.density) if grid.world.density is not None else ("side", grid.world.side)
    for robots in grid.swarm.robots:
        for value, density in zip(values or (), grid.densities(robots), strict=True):
            yield robots, (key, value, density)


def _check_faults(tables: Tables, grids: Sequence[Grid], all_used: bool) -> None:
    sizes = [robots for grid in grids for robots in grid.swarm.robots]
    for n, fault in enumerate(tables.faults):
        if isinstance(fault.robots, int) and fault.robots > min(sizes):
            raise StudyError.at(f"faults[{n}].robots", fault.robots, f"there are {counted(min(sizes), 'robot')}")
        if isinstance(fault.robots, Named) and fault.robots.named[-1] >= min(sizes):
            there = f"there are {counted(min(sizes), 'robot')}, numbered from 0"
            raise StudyError.at(f"faults[{n}].robots.named", [*fault.robots.named], there)
        if "moving" in fault.stop and not any(grid.moves for grid in grids):
            never = 'these robots never move: topology "moving" is not here'
            raise StudyError.at(f"faults[{n}].stop", '"moving"', never)
        if fault.until is not None and fault.until <= fault.at:
            raise StudyError.at(f"faults[{n}].until", fault.until, f"should come after at = {fault.at}")
        if all_used and fault.at > last_round(grids):
            after = f"faults[{n}].at = {fault.at} comes after the last round, {last_round(grids)}"
            raise StudyError(after, key=f"faults[{n}].at", value=fault.at)
        if all_used and fault.robots and not any(fault.count(robots) for robots in sizes):
            less = f"that is less than one of {counted(max(sizes), 'robot')}: none would fail"
            raise StudyError.at(f"faults[{n}].robots", fault.robots, less)


def _check_changes(grid: Grid, all_used: bool) -> None:
    """Raise StudyError if a change comes after the last round, or the floor cannot change."""
    changes = [fill for fill in grid.world.fill_ratio if isinstance(fill, Change)]
    last = max(grid.lengths)
    for change in changes if all_used else ():
        if isinstance(change.at, int) and change.at >= last:
            should = f"should be before the last round, {last}, so that rounds follow it"
            shown = to_toml_value(change.given or change)
            raise StudyError.at(grid.key("fill_ratio"), shown, f"at = {change.label('at')} {should}")
    for floor in (grid.world.floor or ()) if changes and grid.moves else ():
        if not floor.can_change:
            fixed = "this floor does not tell which tiles turn first, so its fill ratio cannot change"
            should = f"{grid.key('fill_ratio')} should be a number here"
            raise StudyError.at(grid.key("floor"), to_toml_value(floor.form), f"{fixed}: {should}")


def all_settings(grids: Sequence[Grid], faults: tuple[Fault, ...]) -> list[Setting]:
    """The settings of all grids, each once. Raises StudyError if a grid has a setting twice, or adds none."""
    found: dict[Setting, None] = {}
    for grid in grids:
        settings, before = list(grid.settings(faults)), len(found)
        own = dict.fromkeys(settings)
        if len(own) < len(settings):
            twice = next(s for s in settings if own.pop(s, s) is not None)
            raise StudyError(f"a value is twice in a list, so that this setting is there twice: {twice}")
        found.update(own)
        if len(found) == before:
            raise StudyError(f"{grid.case} adds no setting: all of its settings are there already", key=grid.case)
    return list(found)
