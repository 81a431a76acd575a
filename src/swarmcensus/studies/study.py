"""A study: a grid of settings, from a study file or from Python."""

import contextlib
import functools
import itertools
import warnings
from collections.abc import Iterable, Iterator, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any, Self

from pydantic import ValidationError

from swarmcensus import brains
from swarmcensus.brains import Adversary, Brain, adversary, metrics
from swarmcensus.studies.assignments import with_assignments, with_values
from swarmcensus.studies.checks import all_settings, check
from swarmcensus.studies.grids import SIZES, grids_of
from swarmcensus.studies.members import Members
from swarmcensus.studies.precision import Until
from swarmcensus.studies.settings import KEYS, Setting, Swarm, World, values_of
from swarmcensus.studies.tables import Tables
from swarmcensus.studies.wanted import check_open
from swarmcensus.support.errors import StudyError
from swarmcensus.support.formatting import counted
from swarmcensus.support.options import command
from swarmcensus.support.plugins import PluginFile, PluginName, Plugins
from swarmcensus.support.texts import read_text
from swarmcensus.support.toml_text import plain, read_toml, to_toml, to_toml_value
from swarmcensus.support.toml_types import table_error
from swarmcensus.worlds import (
    Distribution,
    FileEdges,
    Floor,
    Picture,
    Topology,
    distributions,
    inlined,
    parse_topology,
    patterns,
    wiring,
)

if TYPE_CHECKING:
    from swarmcensus.studies.settings import Schedule
    from swarmcensus.studies.tables import Measure
    from swarmcensus.studies.wanted import Wanted
    from swarmcensus.worlds import Fault

MOST_VALUES = 2**31  # of each variable in a dataset, all robots of all trials
MOST_SETTINGS = 250_000  # listing them takes some seconds
USUAL_DENSITY = 1.0  # where robots of a fixed network begin to move
MOST_IN_LIST = 10_000  # values, each of which is checked and may be named in an error


class Study:
    """A grid of settings, and those of its cases, each run for several trials."""

    if TYPE_CHECKING:

        def __init__(
            self,
            *,
            trials: int | Until | Mapping[str, Any],
            swarm: Swarm | Mapping[str, Any],
            world: World | Mapping[str, Any],
            schedule: Schedule | Mapping[str, Any] = ...,
            measure: Measure | Mapping[str, Any] = ...,
            wanted: Wanted | Mapping[str, Any] = ...,
            faults: Iterable[Fault | Mapping[str, Any]] = ...,
            members: Iterable[Members | Mapping[str, Any]] = ...,
            case: Iterable[Mapping[str, Any]] = ...,
            name: str = ...,
            seed: int = ...,
            labels: Mapping[str, str] = ...,
            groups: Mapping[str, str] = ...,
        ) -> None:
            """Build a study from the study file's tables. Raises InputError, naming key and value."""
    else:

        def __init__(self, **tables: Any) -> None:
            """Build a study from the study file's tables. Raises InputError, naming key and value."""
            self._fill(_with_topologies(plain(tables)), None, "study", {})

    def _fill(self, tables: dict[str, Any], text: str | None, where: str, context: Mapping[str, Any]) -> None:
        lists = {name: value for name, value in tables.items() if isinstance(value, list)}
        lists |= {f"{t}.{k}": v for t, keys in tables.items() if isinstance(keys, dict) for k, v in keys.items()}
        for name, value in lists.items():
            if isinstance(value, list) and len(value) > MOST_IN_LIST:
                many = f"{name} has {counted(len(value), 'value')}; {MOST_IN_LIST:,} is the most"
                raise StudyError.within(where, many)
        check_open(tables, where)
        if (base := context.get("base", Path())) is not None and (known := inlined(tables, base, where)) != tables:
            tables, text = known, None
        try:
            checked = Tables.model_validate(tables, context=dict(context))
        except ValidationError as error:
            found = table_error(error, where, Tables, tables)
            if tables.get("wanted") and str(found).endswith("is missing"):
                hint = "; a mission for swarmcensus plan may leave it out"
                found = StudyError(f"{found}{hint}", file=found.file, key=found.key, value=found.value)
            raise found from None
        except OSError as error:  # of what can be no path here
            why = f"{str(error.filename)[:40]!r}, as a path: {error.strerror}"
            raise StudyError.within(where, why, value=error.filename) from None
        self._kept = bool(context.get("kept"))
        self.name, self.seed = checked.name, checked.seed
        self.until = checked.trials if isinstance(checked.trials, Until) else None
        self.trials: int = checked.trials.at_most if isinstance(checked.trials, Until) else checked.trials
        self.swarm, self.world = checked.swarm, checked.world
        self.schedule, self.measure, self.wanted = checked.schedule, checked.measure, checked.wanted
        self.faults, self.case, self.members = checked.faults, checked.case, checked.members
        self.labels, self.groups = checked.labels, checked.groups
        self.text = text if text is not None else to_toml(tables)
        self.grids = grids_of(self.swarm, self.world, self.schedule, self.case, self.members)
        try:
            check(checked, self.grids, all_used=not self._kept)
            counts = [grid.count for grid in self.grids]
            if sum(counts) > MOST_SETTINGS:
                raise StudyError(f"its lists span {counted(sum(counts), 'setting')}; {MOST_SETTINGS:,} is the most")
        except ValueError as error:
            raise StudyError.within(where, error) from None
        self._check_size(where, max(counts), 1)
        try:
            settings = all_settings(self.grids, self.faults)
        except ValueError as error:
            raise StudyError.within(where, error) from None
        self._check_size(where, len(settings), 1)
        if not (self._kept or context.get("warned")):
            self._warn(where)

    def _warn(self, where: str) -> None:
        sizes = ((t, robots) for grid in self.grids for t in grid.world.topology for robots in grid.swarm.robots)
        for topology, robots in dict.fromkeys(sizes):
            if said := topology.unlinked(robots):
                of = f"{where}: topology {topology.name!r} of {counted(robots, 'robot')}"
                warnings.warn(f"{of}: {said}", stacklevel=4)
        for accuracy in dict.fromkeys(a for grid in self.grids for a in grid.swarm.accuracy if a.is_blind):
            blind = "carries no information: such a sensor says the same of black and white"
            warnings.warn(f"{where}: accuracy {accuracy} {blind}", stacklevel=4)
        for grid in self.grids:
            known = {len(s.numbers) // 2 for a in grid.swarm.accuracy for s in a.distributions if s.kind == "measured"}
            if known and known != {*grid.swarm.robots}:
                few = f"accuracy has {max(known)} measured robots, and robots = {[*grid.swarm.robots]}"
                warnings.warn(f"{where}: {few}: the first ones are taken, or they come again", stacklevel=4)

    def __repr__(self) -> str:
        """The study in a line."""
        return f"<Study {self.name!r}: {self._size}>"

    @property
    def _size(self) -> str:
        """The numbers of settings and of trials as a text."""
        settings = len(self.settings()) if self.case else self.grids[0].count
        trials = "at most " * bool(self.until) + counted(self.trials, "trial")
        return f"{counted(settings, 'setting')} of {trials}"

    @classmethod
    def load(cls, path: str | Path, values: Mapping[str, Any] = {}) -> Self:
        """Read a study file. Brain and metric files, edge lists and images are looked for in its folder.

        `values` replace those of its keys, each named in full or by its last part: {"density": 2}. If it has no `name`,
        it gets the name of its file, as a new first line of its text. Raises InputError.
        """
        where, name = f"study file {path}", Path(path).stem
        if Path(path).suffix.lower() == ".nc" and Path(path).is_file():
            see = command("swarmcensus", "show", path)
            raise StudyError(f"{path} holds results, not a study: see them with {see}", file=path)
        text = read_text(path, where, StudyError, ending=".toml")
        tables = read_toml(text, where)
        if "name" not in tables and name.isprintable():
            text, tables = f"name = {to_toml_value(name)}\n{text}", {"name": name} | tables
        context = {"base": Path(path).parent}
        if values:
            return cls.changed(tables, values, where=where, context=context)
        return cls._made(tables, text, where, context)

    @classmethod
    def _made(cls, tables: dict[str, Any], text: str | None, where: str, context: Mapping[str, Any]) -> Self:
        study = cls.__new__(cls)
        study._fill(tables, text, where, context)
        return study

    @classmethod
    def changed(
        cls, tables: Mapping[str, Any], values: Mapping[str, Any], *, where: str = "study",
        context: Mapping[str, Any] = {},
    ) -> Self:  # fmt: skip
        """A study of these tables, with other values of some keys; `context` is as for `parse`. Raises InputError."""
        try:
            return cls._made(_with_topologies(with_values(tables, plain(values))), None, where, context)
        except StudyError as error:
            file, what = where.partition(" file ")[2] or None, str(error).removeprefix(f"{where}: ")
            raise StudyError.of(file, what, error.key, error.value, where=with_assignments(where, values)) from None

    @classmethod
    def parse(cls, text: str, *, where: str = "study", context: Mapping[str, Any] = {}) -> Self:
        """Read a study from TOML text.

        `context` may have `base` (the folder of brain and metric files, edge lists and images; None: no file is
        opened), `brains`, `adversaries`, `metrics`, `edges` and `images` (by name, in place of files), `plugins` (files
        of topologies, floors and spreads), and `kept` (the text is from results: keys without effect are allowed).

        Raises InputError, naming file, key and value.
        """
        return cls._made(read_toml(text, where), text, where, context)

    def with_(self, **changes: Any) -> Self:
        """This study with other values of keys, such as seed, robots or a whole table; None keeps a value."""
        given = {k: v for k, v in changes.items() if v is not None}
        context = self.context | {"kept": self._kept, "warned": True}
        return self.changed(read_toml(self.text, "study"), given, context=context) if given else self

    def with_setting(
        self, setting: Setting, values: Mapping[str, Any], *, where: str = "study", context: Mapping[str, Any] = {}
    ) -> Self:  # fmt: skip
        """A study of one of its settings, with other values of some keys; `context` is as for `parse`.

        Keys that have no effect where these values lead, such as a density on a network, go if `values` do not name
        them. Raises InputError.
        """
        tables = self._tables_of(setting)
        world, measure, moves = tables["world"], tables["measure"], setting.body is not None
        changed = with_values(tables, plain(values))["world"]
        with contextlib.suppress(ValidationError, OSError):  # a wrong world is refused below
            moves = World.model_validate(changed, context=dict(context)).topology[0].moves
        for key in KEYS.values():
            if not key.has_effect(moves) or (key.name == "feedback" and world.get("message", "double") == "double"):
                tables[key.table].pop(key.name, None)
        if moves and not SIZES & world.keys():
            world["density"] = USUAL_DENSITY
        if not moves:
            measure.pop("truth", None)
        return self._made(_with_topologies(with_values(tables, plain(values))), None, where, context)

    def _tables_of(self, setting: Setting) -> dict[str, Any]:
        """Its tables with the values of one of its settings in place of lists and cases."""
        given, own = read_toml(self.text, "study"), values_of(setting)
        tables: dict[str, Any] = {name: dict(given.get(name, {})) for name in ("swarm", "world", "schedule")}
        varied = {"brain", *(name for case in given.get("case", ()) for name in case)}
        if SIZES & varied:  # of which the setting may have another one than the tables
            varied |= SIZES
            tables["world"] = {key: value for key, value in tables["world"].items() if key not in SIZES}
        for name, key in KEYS.items():
            value = tables[key.table].get(name)
            if isinstance(value, list) or (name in varied and name in own):
                tables[key.table][name] = own[name] if name in own else value[0]
        vary = any(len([*table.every()]) > 1 for table in self.members)
        members = [member.form for member in setting.members] if vary else given.get("members", [])
        measured = {key: value for key, value in given.get("measure", {}).items() if key in ("delta", "bins", "truth")}
        of_all = {"name": self.name, "seed": self.seed, "trials": self.trials, "faults": given.get("faults", [])}
        return tables | of_all | {"members": members, "measure": measured}

    @functools.cached_property
    def stored(self) -> frozenset[str]:
        """The groups of quantities that its results have, and those of other studies may lack."""
        worlds = [grid.world for grid in self.grids]
        networks = ((topology, any(world.missing_links)) for world in worlds for topology in world.topology)
        asks = {
            "local": self.measure.local, "estimates": self.measure.estimates,
            "decisions": any(brain.decides for brain in self.brains),
            "endings": any(brain.ends for brain in self.brains),
            "intervals": any(brain.has_interval for brain in self.brains),
            "formats": any(format != "double" for world in worlds for format in world.message),
            "drawn": any(isinstance(fill, Distribution) for world in worlds for fill in world.fill_ratio),
            "networks": any(not topology.moves and (missing or not topology.is_full) for topology, missing in networks),
        }  # fmt: skip
        return frozenset(name for name, holds in asks.items() if holds)

    @property
    def context(self) -> dict[str, Any]:
        """The context with which `parse` reads the study's text again without its files."""
        return {
            "brains": {b.name: b for b in self.brains},
            "adversaries": {a.name: a for a in self.adversaries},
            "edges": {t.source: FileEdges(t.edges or (), t.directed) for t in self.topologies if t.source},
            "plugins": self.plugin_files,
            "images": {p.source: p.grey for p in self.pictures},
            "metrics": {m.name: m for m in self.measure.metrics},
            "kept": True,
        }

    def check_trials(self) -> None:
        """Raise InputError if no simulation has such trials, or the results of all would be too large."""
        self.check_faults()
        for setting in self.settings() if self.wanted.minutes else ():
            self.wanted.check_time(setting)
        self._check_size(f"study {self.name}", len(self.settings()), self.trials)

    def check_faults(self) -> None:
        """Raise InputError if faults are of processes, which no simulation has."""
        for n, fault in enumerate(self.faults):
            if fault.do:
                key, why = f"faults[{n}].do", "this happens to processes (swarmcensus swarm): simulated robots stop"
                raise StudyError.within(f"study {self.name}", f'{key} = "{fault.do}": {why}', key, fault.do)

    def _check_size(self, where: str, settings: int, trials: int) -> None:
        kept = len(self.checkpoints) if self.measure.estimates else 1
        values = settings * trials * max(max(grid.swarm.robots) for grid in self.grids) * kept
        if values > MOST_VALUES:
            made = f"{counted(settings, 'setting')} of {counted(trials, 'trial')} make {values:,} values to keep"
            fewer = f"fewer trials, settings{', checkpoints' * (kept > 1)} or robots"
            raise StudyError.within(where, f"{made}; {MOST_VALUES:,} is the most: {fewer}", "trials", trials)

    def stages(self) -> Iterator[int]:
        """The numbers of trials after which a setting may end: one, or several with a rule."""
        return self.until.stages() if self.until else iter([self.trials])

    @property
    def brains(self) -> list[Brain]:
        """The brains of all settings, each once, with the parameters of their files."""
        theirs = [brain for table in self.members for brain in table.brain or () if isinstance(brain, Brain)]
        own = (brain for grid in self.grids for brain in grid.swarm.brain)
        return list({brain.name: brain.as_written for brain in (*own, *theirs)}.values())

    @property
    def adversaries(self) -> list[Adversary]:
        """The adversaries of all settings, each once, with the parameters of their files."""
        every = [one for table in self.members for one in table.brain or () if isinstance(one, Adversary)]
        return list({one.name: one.as_written for one in every}.values())

    @functools.cached_property
    def additions(self) -> dict[str, dict[str, str]]:
        """Additions of other packages that its settings use, as "topology torus": package, version and hash."""
        kinds = {Brain: brains.PLUGINS, Adversary: adversary.PLUGINS, metrics.Metric: metrics.PLUGINS}
        code: list[Brain | Adversary | metrics.Metric] = [*self.brains, *self.adversaries, *self.measure.metrics]
        files = [(kinds[type(one)], one) for one in code]
        # a file of a user's may have the name of an addition
        used = [(kind, one.name) for kind, one in files if one.name in kind and kind.path(one.name) == one.path]
        used += [(kind, name) for kind, name in self._of_worlds if not isinstance(name, PluginFile)]
        others = {(p.kind, name): p for p, name in used if name not in p.shipped and name in p}
        return {f"{kind} {name}": plugins.origin(name) for (kind, name), plugins in others.items()}

    @property
    def plugin_files(self) -> list[PluginFile]:
        """The files of topologies, floors and spreads that its settings use, each once."""
        return list(dict.fromkeys(name for _, name in self._of_worlds if isinstance(name, PluginFile)))

    @property
    def _of_worlds(self) -> list[tuple[Plugins, PluginName]]:
        """The topologies, floors and spreads of all settings."""
        robots: list[Swarm | Members] = [*(grid.swarm for grid in self.grids), *self.members]
        sensors = [a for table in robots for a in (*(table.accuracy or ()), *(table.assumed_accuracy or ()))]
        return [
            *((wiring.PLUGINS, topology.named) for topology in self.topologies if topology.named),
            *((patterns.PLUGINS, floor.kind) for floor in self.floors),
            *((distributions.PLUGINS, one.kind) for a in sensors for one in a.distributions if one.kind),
        ]

    @property
    def floors(self) -> list[Floor]:
        """The floors of all settings in which robots move."""
        return [floor for grid in self.grids if grid.moves for floor in grid.world.floor or ()]

    @property
    def topologies(self) -> list[Topology]:
        """The topologies of all settings, each once."""
        return list({t.name: t for grid in self.grids for t in grid.world.topology}.values())

    @property
    def pictures(self) -> list[Picture]:
        """The images of all settings' floors, each file once."""
        return list({p.source: p for floor in self.floors for p in floor.pictures}.values())

    @property
    def checkpoints(self) -> list[int]:
        """The rounds at which decisions are recorded: by default 1, 2, 5, 10, 20, 50 ... and the last."""
        if self.measure.checkpoints is not None:
            return sorted(set(self.measure.checkpoints))
        lengths = {length for grid in self.grids for length in grid.lengths}
        steps = {m * 10**k for k in range(10) for m in (1, 2, 5)}
        in_rule = {self.until.checkpoint} if self.until and self.until.checkpoint else set()
        return sorted({s for s in steps if s < max(lengths)} | lengths | in_rule)

    def settings(self) -> list[Setting]:
        """The settings of the full grid, where brain, topology, robots and accuracy vary slowest; then of each case."""
        every = itertools.chain.from_iterable(grid.settings(self.faults) for grid in self.grids)
        return list(dict.fromkeys(every) if self.case else every)


def _with_topologies(value: Any) -> Any:
    """Tables with topologies, which have a text, in place of graphs of networkx; a wrong one stays."""
    if hasattr(value, "nodes"):
        with contextlib.suppress(ValueError):
            return parse_topology(value, Path(), {})
    if isinstance(value, dict):
        return {key: _with_topologies(inner) for key, inner in value.items()}
    return [_with_topologies(inner) for inner in value] if isinstance(value, list) else value
