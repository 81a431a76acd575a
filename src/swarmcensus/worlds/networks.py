"""Static communication topologies: who hears whom, for the whole of a trial.

A topology has a name (see `worlds.topologies`), or is any edge list, or any networkx graph or generator.
"""

import functools
import hashlib
import json
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any

import numpy as np
from pydantic import ConfigDict, Field

from swarmcensus.engine import Links, address
from swarmcensus.engine.constants import FULL, LISTED, PAIRS
from swarmcensus.support.forms import Form, Schema, Text, ValueTable, any_of, name_in, read, says
from swarmcensus.support.hints import did_you_mean, did_you_mean_any
from swarmcensus.support.plugins import Keys
from swarmcensus.worlds import generators, wiring
from swarmcensus.worlds.chance import Chance
from swarmcensus.worlds.edge_lists import edges_of, from_one, read_edges, unlinked
from swarmcensus.worlds.wiring import PLUGINS, Heard, heard

TABLE_KEYS = ("name", "edges", "directed", "file", "networkx")
DIFFERENT = Field(json_schema_extra={"uniqueItems": True})
ARGUMENT = says("should be a number, a text, true or false, or a list")
MOVING = "moving"  # the topology of robots that move, as datasets name it


@dataclass(frozen=True)
class Topology:
    """A communication topology: a named one, a list of edges, or a networkx generator.

    In a directed edge (u, v), v hears u. Graphs of a generator are directed or not by themselves.
    """

    name: str  # as in the dataset
    edges: tuple[tuple[int, int], ...] | None = None
    generator: tuple[str, str] | None = None  # the function's name, its arguments as JSON
    source: str = ""  # the edge list's file, for messages
    directed: bool = False  # whether the edges are
    keys: Keys = ()  # of a named topology
    kind: str = ""  # the plain name of a named topology, if `name` shows its keys too

    def __str__(self) -> str:
        """The name, as in the dataset."""
        return self.name

    def __hash__(self) -> int:
        """A hash that is quick for millions of edges."""
        return hash((self.name, self._digest, self.generator))

    @functools.cached_property
    def named(self) -> str:
        """The plain name of a named topology; empty for edges and generators."""
        return (self.kind or self.name) if self.edges is None and self.generator is None else ""

    @functools.cached_property
    def moves(self) -> bool:
        """Whether robots move, so that there is no fixed network."""
        return bool(self.named) and getattr(PLUGINS.module(self.named), "MOVES", False)

    @functools.cached_property
    def is_full(self) -> bool:
        """Whether every robot hears every other."""
        return bool(self.named) and getattr(PLUGINS.module(self.named), "EVERYONE", False)

    @functools.cached_property
    def varies(self) -> bool:
        """Whether graphs differ from trial to trial."""
        if self.generator is not None:
            return generators.draws(self.generator[0])
        return bool(self.named) and wiring.varies(self.named)

    @property
    def form(self) -> object:
        """As in a study file."""
        if self.generator is not None:
            return {"networkx": self.generator[0], **json.loads(self.generator[1])}
        if self.edges is None:
            return {"name": self.named, **dict(self.keys)} if self.keys else self.name
        return {"name": self.name, "edges": self.edges} | ({"directed": True} if self.directed else {})

    @property
    def content(self) -> object:
        """All that the random numbers of this topology depend on."""
        others = [*(["directed"] if self.directed else []), *([dict(self.keys)] if self.keys else [])]
        return [self.name, self._digest, self.generator, *others]

    @functools.cached_property
    def edition(self) -> str:
        """A hash of its file, if another package provides it: results depend on that too."""
        return PLUGINS.digest(self.named) if self.named else ""

    @functools.cached_property
    def _digest(self) -> str | None:
        """A short hash of the edges, which may be millions and are part of each trial's address."""
        return None if self.edges is None else hashlib.sha256(repr(self.edges).encode()).hexdigest()

    def check(self, robots: int) -> None:
        """Raise ValueError if the topology does not fit a swarm of this size."""
        for i, j in self.edges or ():
            if max(i, j) >= robots:
                where = f"{self.source}: " if self.source else ""
                raise ValueError(
                    f"{where}edge ({i}, {j}) of topology {self.name!r} leads to a robot that is not there: "
                    f"the robots are numbered 0 to {robots - 1}{from_one(np.array(self.edges))}"
                )
        if self.generator:
            generators.check(*self.generator, robots)
        if self.named:
            wiring.check(self.named, self.keys, robots)
            if self.edition:  # tried now, so that errors are found before anything runs
                wiring.check_repeats(self.named, self.keys, robots)

    def links(self, robots: int, seed: int, first_trial: int, trials: int, lossless: bool, sums: bool) -> Links:
        """The links of a batch of trials. `lossless`: no message is lost; `sums`: robots only add up messages."""
        if self.is_full:
            empty = np.zeros(0, np.uint32)
            return Links(FULL if lossless and sums else PAIRS, np.zeros(2, np.int64), empty, empty)
        if self.varies:
            key = address(seed, "topology", topology=self.content, robots=robots)
            graphs = self._drawn(robots, [Chance(key, first_trial + k) for k in range(trials)])
        else:
            receivers, senders = map(np.ascontiguousarray, self._fixed(robots))
            return Links(LISTED, np.array([0, len(receivers)]), receivers, senders)
        starts = np.cumsum([0, *(len(r) for r, _ in graphs)])
        return Links(LISTED, starts, np.concatenate([r for r, _ in graphs]), np.concatenate([s for _, s in graphs]))

    def unlinked(self, robots: int) -> str:
        """A sentence on robots without links in an edge list, or nothing."""
        return unlinked(robots, np.array(self.edges)) if self.edges else ""

    @functools.lru_cache(maxsize=8)  # noqa: B019 (topologies are few, and live as long as their study)
    def _fixed(self, robots: int) -> Heard:
        if self.edges is not None:
            return heard(np.array(self.edges, np.int64).reshape(-1, 2), self.directed)
        if self.generator is not None:
            return heard(*generators.edges_of(*self.generator, robots, 0))
        return wiring.graphs(self.named, self.keys, robots, [None])[0]

    def _drawn(self, robots: int, chances: list[Chance]) -> list[Heard]:
        if self.generator is None:
            return wiring.graphs(self.named, self.keys, robots, chances)
        words = (np.random.SeedSequence([*map(int, key), trial]).generate_state(1) for key, trial in chances)
        return [heard(*generators.edges_of(*self.generator, robots, int(word[0]))) for word in words]


Edges = list[Annotated[list[Annotated[int, Field(ge=0)]], Field(min_length=2, max_length=2), DIFFERENT]]
Directed = Annotated[bool, Field(strict=True)]


class EdgesTable(ValueTable):
    """A list of edges."""

    name: Annotated[Text, Form(lambda text: text() | {"not": {"enum": [*PLUGINS.shipped]}})]
    edges: Annotated[Any, any_of(Edges)]  # read by `edges_of`, for there may be millions
    directed: Directed = False


class EdgeFileTable(ValueTable):
    """A CSV file of edges."""

    file: Text
    directed: Directed = False


class GeneratorTable(ValueTable):
    """A function of networkx that makes graphs, and its arguments."""

    model_config = ConfigDict(extra="allow", json_schema_extra={"not": {"required": ["seed"]}})
    __pydantic_extra__: dict[str, Annotated[bool | int | float | str | list[Any], ARGUMENT]]

    networkx: Annotated[Text, Form(lambda text: text() | {"pattern": "_graph$"})]


def _named_tables(_: Callable[[], Schema]) -> Schema:
    """{name = "ring"}; other packages' topologies may have keys, and are not imported for a schema."""

    def named(names: Iterable[str]) -> Schema:
        return {"type": "object", "properties": {"name": {"enum": [*names]}}, "required": ["name"]}

    alone = named(PLUGINS.shipped) | {"additionalProperties": False}
    return {"anyOf": [alone, named(PLUGINS.outside)] if PLUGINS.outside else [alone]}


NAMED = Annotated[Any, Form(_named_tables)]
TOPOLOGY = any_of(Annotated[str, name_in(PLUGINS)], EdgesTable, EdgeFileTable, GeneratorTable, NAMED)


def parse_topology(value: object, base: Path | None, known: Mapping[str, Any]) -> Topology:
    """Read any form of topology that a study may contain. Raises ValueError with what would be right.

    Edge-list files are looked for in `known` (path to edges) first, then in the folder `base`; None: no file is opened.
    """
    if isinstance(value, Topology):
        return value
    if isinstance(value, str):
        if value in PLUGINS.shipped:
            return _named(value, {})
        if value in known or (base is not None and (base / value).is_file()) or value not in PLUGINS:
            return _of_file(value, False, base, known)
        return _named(value, {})
    if isinstance(value, Mapping):
        if "networkx" in value:
            return _generated(read(GeneratorTable, value, _right))
        if "edges" in value:
            return _listed(read(EdgesTable, value, _right, TABLE_KEYS))
        if "file" in value:
            table = read(EdgeFileTable, value, _right, TABLE_KEYS)
            return _of_file(table.file, table.directed, base, known)
        if isinstance(value.get("name"), str):
            return _named(value["name"], {k: v for k, v in value.items() if k != "name"})
    if hasattr(value, "nodes") and hasattr(value, "is_directed"):
        name, directed = str(getattr(value, "name", "") or "graph"), value.is_directed()
        name = f"{name} graph" if name in PLUGINS.shipped else name
        return Topology(name, edges_of(generators.numbered(value, own=True), directed), directed=directed)
    keys = value if isinstance(value, Mapping) else ()
    raise ValueError(f"{did_you_mean_any(keys, TABLE_KEYS)}{_right()}")


def _generated(table: GeneratorTable) -> Topology:
    arguments = dict(sorted(table.__pydantic_extra__.items()))
    if "seed" in arguments:
        raise ValueError("the study's seed gives each trial its graph: leave out seed")
    text = ",".join(f"{key}={value}" for key, value in arguments.items())
    return Topology(f"{table.networkx}({text})", generator=(table.networkx, json.dumps(arguments)))


def _listed(table: EdgesTable) -> Topology:
    if table.name in PLUGINS.shipped:
        raise ValueError(f"the name {table.name!r} is taken: call an edge list otherwise")
    return Topology(table.name, edges_of(table.edges, table.directed), directed=table.directed)


def _named(name: str, given: dict[str, Any]) -> Topology:
    if name not in PLUGINS:
        hint = did_you_mean(name, PLUGINS.names) or did_you_mean_any(given, TABLE_KEYS)
        raise ValueError(f"{hint}{_right()}")
    text, keys = wiring.read(name, given)
    return Topology(text, keys=keys, kind="" if text == name else name)


def _right() -> str:
    return (
        f"a topology is one of {', '.join(PLUGINS.names)}, the path of an edge-list CSV file, "
        '{name = "...", edges = [[0, 1], ...]} or {networkx = "watts_strogatz_graph", k = 4, p = 0.1}'
    )


def _of_file(path: str, directed: bool, base: Path | None, known: Mapping[str, Any]) -> Topology:
    if path in known:
        pairs = known[path]
    elif base is None:
        raise ValueError(
            "these edges are not stored here, and no file is opened here; nor is there a topology of this name"
        )
    elif not (base / path).is_file():
        raise ValueError(f"{did_you_mean(path, PLUGINS.names)}{_right()}; there is no file {base / path}")
    else:
        pairs = read_edges(base / path, directed)
    return Topology(_file_name(path), edges_of(pairs, directed), source=path, directed=directed)


def _file_name(path: str) -> str:
    return Path(path).name if Path(path).stem in PLUGINS.shipped else Path(path).stem
