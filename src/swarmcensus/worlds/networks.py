"""Static communication topologies: who hears whom, for the whole of a trial.

A topology has a name (see `worlds.topologies`), or is any edge list, or any networkx graph or generator.
"""

import functools
import hashlib
import json
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Annotated, Any, Literal

import numpy as np
from pydantic import ConfigDict, Field

from swarmcensus.engine import Links, address
from swarmcensus.engine.constants import FULL, LISTED, PAIRS
from swarmcensus.support.formatting import counted
from swarmcensus.support.hints import did_you_mean, did_you_mean_any, did_you_mean_file
from swarmcensus.support.plugins import Keys, PluginFile, PluginName, combinations, is_unread, takes
from swarmcensus.support.toml_types import (
    LabelledTable,
    Text,
    label_of,
    read,
    says,
)
from swarmcensus.worlds import generators, graph_files, wiring
from swarmcensus.worlds.chance import Chance
from swarmcensus.worlds.edge_lists import edges_of, from_one, read_edges, unlinked
from swarmcensus.worlds.naming import Titled
from swarmcensus.worlds.wiring import PLUGINS, Heard, heard

TABLE_KEYS = ("name", "edges", "directed", "file", "networkx", "label", "weights", "renumber")
RENUMBER = "; renumber = true numbers them from 0, in their order"
ARGUMENT = says("should be a number, a text, true or false, or a list")
RESERVED = ("full", "line", "moving", "ring", "scale-free")  # shipped names that no edge list may have
MOVING = "moving"  # the topology of robots that move, as datasets name it


@dataclass(frozen=True)
class Topology(Titled):
    """A communication topology: a named one, a list of edges, or a networkx generator.

    In a directed edge (u, v), v hears u. Graphs of a generator are directed or not by themselves.
    """

    name: str  # as in the dataset, unless it has a label
    edges: tuple[tuple[int, int], ...] | None = None
    generator: tuple[str, str] | None = None  # the function's name, its arguments as JSON
    source: str = ""  # the edge list's file, for messages
    directed: bool = False  # whether the edges are
    keys: Keys = ()  # of a named topology
    kind: PluginName = ""  # the plain name of a named topology, if `name` shows its keys too; or its file
    label: str = field(default="", compare=False)  # in place of the name, in datasets
    spanned: tuple[str, ...] = field(default=(), compare=False)  # those of `keys` that span the grid
    nodes: int | None = field(default=None, compare=False)  # of an edge list, if its file says how many

    def name_without(self, keys: tuple[str, ...]) -> str:
        """Its name if some of its keys are not shown."""
        return wiring.text(self.named, [one for one in self.keys if one[0] not in keys]) if keys else self.name

    def __hash__(self) -> int:
        """A hash that is quick for millions of edges."""
        return hash((self.name, self._digest, self.generator))

    @functools.cached_property
    def named(self) -> PluginName:
        """The plain name, or the file, of a named topology; empty for edges and generators."""
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
        label = {"label": self.label} if self.label else {}
        if self.generator is not None:
            return {"networkx": self.generator[0], **json.loads(self.generator[1]), **label}
        directed = {"directed": True} if self.directed else {}
        if self.source:
            return {"file": self.source, **directed, **label} if directed or label else self.source
        if self.edges is None:
            what = "file" if isinstance(self.named, PluginFile) else "name"
            return {what: str(self.named), **dict(self.keys), **label} if self.keys or label else self.name
        return {"name": self.name, "edges": self.edges, **directed, **label}

    @property
    def content(self) -> object:
        """All that the random numbers of this topology depend on."""
        others = [*(["directed"] if self.directed else []), *([dict(self.keys)] if self.keys else [])]
        return [self.name, self._digest, self.generator, *others]

    @functools.cached_property
    def edition(self) -> str:
        """A hash of its file, if it is not shipped: results depend on that too."""
        return PLUGINS.digest(self.named) if self.named else ""

    @functools.cached_property
    def _digest(self) -> str | None:
        """A short hash of the edges, which may be millions and are part of each trial's address."""
        return None if self.edges is None else hashlib.sha256(repr(self.edges).encode()).hexdigest()

    def check(self, robots: int) -> None:
        """Raise ValueError if the topology does not fit a swarm of this size."""
        if self.nodes not in (None, robots):
            raise ValueError(f"{self.source} has {counted(self.nodes, 'node')}: should be as many as robots, {robots}")
        for i, j in self.edges or ():
            if max(i, j) >= robots:
                where, starts = f"{self.source}: " if self.source else "", from_one(np.array(self.edges))
                what = f"{where}edge ({i}, {j}) of topology {self.name!r} leads to a robot that is not there"
                starts += RENUMBER * bool(starts and self.source)
                raise ValueError(f"{what}: the robots are numbered 0 to {robots - 1}{starts}")
        if self.generator:
            generators.check(*self.generator, robots)
        if self.named:
            wiring.check(self.named, self.keys, robots)
            if self.edition and not is_unread(self.named):  # tried now, so that errors are found before anything runs
                wiring.check_repeats(self.named, self.keys, robots)

    def links(self, robots: int, seed: int, first_trial: int, trials: int, lossless: bool, sums: bool) -> Links:
        """The links of a batch of trials. `lossless`: no message is lost; `sums`: robots only add up messages."""
        if self.is_full:
            empty = np.zeros(0, np.uint32)
            return Links(FULL if lossless and sums else PAIRS, np.zeros(2, np.int64), empty, empty)
        if not self.varies:
            receivers, senders = map(np.ascontiguousarray, self._fixed_links(robots))
            return Links(LISTED, np.array([0, len(receivers)]), receivers, senders)
        key = address(seed, "topology", topology=self.content, robots=robots)
        chances = [Chance(key, first_trial + k) for k in range(trials)]
        if self.generator is None:
            graphs = wiring.graphs(self.named, self.keys, robots, chances)
        else:
            words = (np.random.SeedSequence([*map(int, key), one.trial]).generate_state(1) for one in chances)
            graphs = [heard(*generators.edges_of(*self.generator, robots, int(word[0]))) for word in words]
        starts = np.cumsum([0, *(len(r) for r, _ in graphs)])
        return Links(LISTED, starts, np.concatenate([r for r, _ in graphs]), np.concatenate([s for _, s in graphs]))

    def unlinked(self, robots: int) -> str:
        """A sentence on robots without links in an edge list, or nothing."""
        return unlinked(robots, np.array(self.edges)) if self.edges else ""

    @functools.lru_cache(maxsize=8)  # noqa: B019 (topologies are few, and live as long as their study)
    def _fixed_links(self, robots: int) -> Heard:
        if self.edges is not None:
            return heard(np.array(self.edges, np.int64).reshape(-1, 2), self.directed)
        if self.generator is not None:
            return heard(*generators.edges_of(*self.generator, robots, 0))
        return wiring.graphs(self.named, self.keys, robots, [None])[0]


Directed = Annotated[bool, Field(strict=True)]


class EdgesTable(LabelledTable):
    """A list of edges."""

    name: Text
    edges: Any  # read by `edges_of`, for there may be millions
    directed: Directed = False


class EdgeFileTable(LabelledTable):
    """A file of edges: a table, or a graph."""

    file: Text
    directed: Directed | None = None
    weights: Annotated[Literal["ignore"], says('should be "ignore"')] | None = None
    renumber: Annotated[bool, Field(strict=True)] = False


class GeneratorTable(LabelledTable):
    """A function of networkx that makes graphs, and its arguments."""

    model_config = ConfigDict(extra="allow")
    __pydantic_extra__: dict[str, Annotated[bool | int | float | str | list[Any], ARGUMENT]]

    networkx: Text


def parse_topology(value: object, base: Path | None, known: Mapping[str, Any]) -> Topology:
    """The only topology of a value, as `parse_topologies` reads it."""
    (topology,) = parse_topologies(value, base, known)
    return topology


def parse_topologies(value: object, base: Path | None, known: Mapping[str, Any]) -> list[Topology]:
    """Read any form of topology that a study may contain; a table with lists spans several.

    Raises ValueError with what would be right.

    Files are looked for in `known` (path to `FileEdges` or `PluginFile`) first, then in the folder `base`; None: no
    file is opened.
    """
    if isinstance(value, str | Path):
        name = str(value)
        is_file = name in known or (base is not None and (base / name).is_file()) or name not in PLUGINS
        value = {"file": name} if is_file and name not in RESERVED else {"name": name}
    if isinstance(value, Mapping):
        if str(value.get("file", "")).lower().endswith(".py") and not {"edges", "networkx"} & value.keys():
            return _spanned(PLUGINS.from_file(str(value["file"]), base, known), value)
        if isinstance(value.get("name"), str) and not {"edges", "networkx", "file"} & value.keys():
            return _spanned(value["name"], value)
    return [_single(value, base, known)]


def _single(value: object, base: Path | None, known: Mapping[str, Any]) -> Topology:
    """A topology of edges or a generator, or as it is."""
    if isinstance(value, Topology):
        return value
    if isinstance(value, Mapping):
        if "networkx" in value:
            return _of_generator(read(GeneratorTable, value, _right))
        if "edges" in value:
            table = read(EdgesTable, value, _right, TABLE_KEYS)
            if table.name in RESERVED:
                raise ValueError(f"the name {table.name!r} is taken: call an edge list otherwise")
            edges = edges_of(table.edges, table.directed)
            return Topology(table.name, edges, directed=table.directed, label=table.label or "")
        if "file" in value:
            return _of_file(read(EdgeFileTable, value, _right, TABLE_KEYS), base, known)
    if hasattr(value, "nodes") and hasattr(value, "is_directed"):
        name, directed = str(getattr(value, "name", "") or "graph"), value.is_directed()
        name = f"{name} graph" if name in RESERVED else name
        return Topology(name, edges_of(generators.numbered(value, own=True), directed), directed=directed)
    keys = value if isinstance(value, Mapping) else ()
    raise ValueError(f"{did_you_mean_any(keys, TABLE_KEYS)}{_right()}")


def _of_generator(table: GeneratorTable) -> Topology:
    arguments = dict(sorted((table.__pydantic_extra__ or {}).items()))
    if "seed" in arguments:
        raise ValueError("the study's seed gives each trial its graph: leave out seed")
    text = ",".join(f"{key}={value}" for key, value in arguments.items())
    name = f"{table.networkx}({text})"
    return Topology(name, generator=(table.networkx, json.dumps(arguments)), label=table.label or "")


def _spanned(name: PluginName, table: Mapping[str, Any]) -> list[Topology]:
    """The topologies of a table with keys; each list of values spans several."""
    given, label = {key: one for key, one in table.items() if key not in ("name", "file", "label")}, label_of(table)
    if name not in PLUGINS and not isinstance(name, PluginFile):
        hint = did_you_mean(name, PLUGINS.names) or did_you_mean_any(given, TABLE_KEYS)
        raise ValueError(f"{hint}{_right()}")
    function = wiring.function_of(name)
    every, lists = combinations(given, lambda key, one: takes(function, key, one))
    found = [
        Topology(text, keys=keys, kind="" if text == name else name, label=label, spanned=tuple(lists))
        for text, keys in (wiring.read(name, dict(one)) for one in every)
    ]
    if label and found[0].moves:
        raise ValueError('robots that move are always called "moving": leave out label')
    return found


def _right() -> str:
    files = f"the path of a table of edges, of a graph ({', '.join(graph_files.FORMATS)}) or of a .py file"
    tables = '{name = "...", edges = [[0, 1], ...]} or {networkx = "watts_strogatz_graph", k = 4, p = 0.1}'
    return f"a topology is one of {', '.join(PLUGINS.names)}, {files}, {tables}"


def _of_file(table: EdgeFileTable, base: Path | None, known: Mapping[str, Any]) -> Topology:
    path, ignore = table.file, table.weights is not None
    if path in known:
        found = known[path]
    elif base is None:
        what = f"{did_you_mean(path, PLUGINS.names)}these edges are not stored here, and no file is opened here"
        raise ValueError(f"{what}; nor is there a topology of this name")
    elif not (base / path).is_file():
        if Path(path).suffix:
            raise ValueError(f"there is no such file: {did_you_mean_file(base / path) or base / path}".strip())
        raise ValueError(f"{did_you_mean(path, PLUGINS.names)}{_right()}; there is no file {base / path}")
    elif graph_files.is_graph(path):
        if table.renumber:
            raise ValueError("renumber is for tables: the nodes of a graph file are numbered in its order")
        found = graph_files.read_graph(base / path, ignore, table.directed)
        if table.directed and not found.directed:
            raise ValueError(f"{path} is an undirected graph: leave out directed")
    else:
        found = read_edges(base / path, bool(table.directed), ignore, table.renumber)
    directed = found.directed if table.directed is None else table.directed
    name = Path(path).name if Path(path).stem in RESERVED else Path(path).stem
    edges = edges_of(found.pairs, directed)
    return Topology(name, edges, source=path, directed=directed, label=table.label or "", nodes=found.nodes)
