"""Static communication topologies: who hears whom, for the whole of a trial.

Full, ring, line and scale-free are the paper's (Sec. IV-B); any edge list and any networkx graph or
generator will do as well.
"""

import csv
import functools
import hashlib
import json
import operator
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from swarmcensus.basics.errors import InputError
from swarmcensus.basics.hints import did_you_mean
from swarmcensus.engine.compiler import compile_world
from swarmcensus.engine.modes import FULL, LISTED, PAIRS
from swarmcensus.engine.random import address
from swarmcensus.worlds import generators
from swarmcensus.worlds.generators import WEIGHTS

MOVING = "moving"  # robots that move hear whom they meet: see arena.py
NAMED = ("full", "ring", "line", "scale-free", MOVING)
DIGITS = 18  # of a number in an edge list: more would not fit 64 bits
FORMS = (
    f'one of {", ".join(NAMED)}, the path of an edge-list CSV file, {{name = "...", edges = [[0, 1], ...]}} '
    'or {networkx = "watts_strogatz_graph", k = 4, p = 0.1}'
)


@dataclass(frozen=True)
class Links:
    """Directed links of the graphs of a batch: graph g holds links starts[g] to starts[g + 1]."""

    mode: int
    starts: np.ndarray
    receivers: np.ndarray
    senders: np.ndarray


@dataclass(frozen=True)
class Topology:
    """A communication topology: a name of the paper's, a list of edges, or a networkx generator.

    Of a directed edge (u, v), v hears u. A generator's graphs say themselves whether they are directed.
    """

    name: str
    edges: tuple[tuple[int, int], ...] | None = None
    generator: tuple[str, str] | None = None  # the function's name, its arguments as JSON
    source: str = ""  # the edge list's file, for messages
    directed: bool = False  # the edges

    def __str__(self) -> str:
        """The name, as in the dataset."""
        return self.name

    def __hash__(self) -> int:
        """Quick for lists of millions of edges."""
        return hash((self.name, self._digest, self.generator))

    @property
    def form(self) -> object:
        """As in a study file."""
        if self.generator is not None:
            return {"networkx": self.generator[0], **json.loads(self.generator[1])}
        if self.edges is None:
            return self.name
        return {"name": self.name, "edges": self.edges} | ({"directed": True} if self.directed else {})

    @property
    def content(self) -> object:
        """What the random numbers of this topology depend on."""
        return [self.name, self._digest, self.generator, *(["directed"] if self.directed else [])]

    @functools.cached_property
    def _digest(self) -> str | None:
        """The edges in a few letters: lists of millions are addressed for each trial."""
        return None if self.edges is None else hashlib.sha256(repr(self.edges).encode()).hexdigest()

    def check(self, robots: int) -> None:
        """Raise ValueError where the topology does not fit a swarm of this size."""
        for i, j in self.edges or ():
            if max(i, j) >= robots:
                where = f"{self.source}: " if self.source else ""
                raise ValueError(
                    f"{where}edge ({i}, {j}) of topology {self.name!r} leads to a robot that is not there: "
                    f"{robots} robots are numbered 0 to {robots - 1}"
                )
        if self.generator:
            generators.check(*self.generator, robots)

    def links(self, robots: int, seed: int, first_trial: int, trials: int, lossless: bool, sums: bool) -> Links:
        """The links for a batch of trials. `lossless`: no message is lost; `sums`: messages add up."""
        built_in = self.edges is None and self.generator is None
        if self.name == "full" and built_in:
            empty = np.zeros(0, np.uint32)
            return Links(FULL if lossless and sums else PAIRS, np.zeros(2, np.int64), empty, empty)
        if (self.name == "scale-free" and built_in) or self.generator:
            key = address(seed, "topology", topology=self.content, robots=robots)
            graphs = [self._random(robots, key, first_trial + k) for k in range(trials)]
        else:
            graphs = [self._links(robots)]
        starts = np.cumsum([0, *(len(r) for r, _ in graphs)])
        return Links(LISTED, starts, np.concatenate([r for r, _ in graphs]), np.concatenate([s for _, s in graphs]))

    @functools.lru_cache(maxsize=8)  # noqa: B019 (topologies are few, and live as long as their study)
    def _links(self, robots: int) -> tuple[np.ndarray, np.ndarray]:
        return _heard(self._fixed(robots), self.directed)

    def _fixed(self, robots: int) -> np.ndarray:
        if self.edges is not None:
            return np.array(self.edges, np.int64).reshape(-1, 2)
        line = np.stack([np.arange(robots - 1), np.arange(1, robots)], axis=1)
        return np.concatenate([line, [[0, robots - 1]]]) if self.name == "ring" and robots > 2 else line

    def _random(self, robots: int, key: np.ndarray, trial: int) -> tuple[np.ndarray, np.ndarray]:
        if self.generator:
            number = int(np.random.SeedSequence([*map(int, key), trial]).generate_state(1)[0])
            edges, directed = generators.edges_of(*self.generator, robots, number)
            return _heard(edges, directed)
        return compile_world().random_tree(key, trial, robots)  # type: ignore[no-any-return]


def _heard(edges: np.ndarray, directed: bool) -> tuple[np.ndarray, np.ndarray]:
    """Edges as links (receivers, senders), each once, sorted by receiver and sender."""
    if not edges.size:
        return np.zeros(0, np.uint32), np.zeros(0, np.uint32)
    n = np.int64(edges.max()) + 1
    heard = edges @ [1, n]  # receiver n + sender, of (sender, receiver)
    links = np.sort(heard if directed else np.concatenate([edges @ [n, 1], heard]))
    links = links[np.append(True, links[1:] != links[:-1])]
    return (links // n).astype(np.uint32), (links % n).astype(np.uint32)


def parse_topology(value: object, base: Path | None, known: Mapping[str, Any]) -> Topology:
    """Read any form of topology that a study may hold. Raises ValueError with what would be right.

    Edge-list files are looked for in `known` (path to edges) first, then below `base`; without it none is opened.
    """
    if isinstance(value, Topology):
        return value
    if isinstance(value, str):
        if value in NAMED:
            return Topology(value)
        return _of_file(value, False, base, known)
    if isinstance(value, Mapping):
        if "networkx" in value:
            arguments = {k: v for k, v in sorted(value.items()) if k != "networkx"}
            if "seed" in arguments:
                raise ValueError("seed is the study's: each trial's graph has an address of its own")
            if any(not isinstance(v, str | int | float | list) for v in arguments.values()):
                raise ValueError("a generator's arguments are numbers, texts and lists")
            text = ",".join(f"{k}={v}" for k, v in arguments.items())
            return Topology(f"{value['networkx']}({text})", generator=(str(value["networkx"]), json.dumps(arguments)))
        directed = value.get("directed", False)
        if not isinstance(directed, bool):
            raise ValueError("directed is true or false")
        if set(value) - {"directed"} == {"name", "edges"}:
            if value["name"] in NAMED:
                raise ValueError(f"the name {value['name']!r} is taken: call an edge list otherwise")
            return Topology(str(value["name"]), _edges(value["edges"], directed), directed=directed)
        if set(value) - {"directed"} == {"file"} and isinstance(value["file"], str):
            return _of_file(value["file"], directed, base, known)
    if hasattr(value, "nodes") and hasattr(value, "is_directed"):
        name, directed = str(getattr(value, "name", "") or "graph"), value.is_directed()
        name = f"{name} graph" if name in NAMED else name
        return Topology(name, _edges(generators.numbered(value, own=True), directed), directed=directed)
    raise ValueError(f"a topology is {FORMS}")


def _of_file(path: str, directed: bool, base: Path | None, known: Mapping[str, Any]) -> Topology:
    if path in known:
        pairs = known[path]
    elif base is None:
        raise ValueError("these edges are not here, and no file is opened that is only named here")
    elif not (base / path).is_file():
        raise ValueError(f"{did_you_mean(path, NAMED)}a topology is {FORMS}; there is no file {base / path}")
    else:
        pairs = read_edges(base / path, weights=False)
        if not pairs:
            raise ValueError(f"{base / path} holds no edge: write edges = [] for robots without links")
    return Topology(_file_name(path), _edges(pairs, directed), source=path, directed=directed)


def _file_name(path: str) -> str:
    return Path(path).name if Path(path).stem in NAMED else Path(path).stem


def _edges(pairs: Iterable[Any], directed: bool) -> tuple[tuple[int, int], ...]:
    try:
        rows = [_pair(row) for row in pairs]
    except TypeError:
        raise ValueError("edges are pairs of robot numbers, from 0: [[0, 1], [1, 2]]") from None
    loops = [i for i, j in rows if i == j]
    if loops:
        raise ValueError(f"edge ({loops[0]}, {loops[0]}) joins a robot to itself")
    return tuple(sorted(set(rows if directed else [(min(row), max(row)) for row in rows])))


def _pair(row: Any) -> tuple[int, int]:
    if len(row) == 3:
        raise ValueError(f"edge {list(row)} has three numbers: {WEIGHTS}")
    i, j = row if len(row) == 2 else (-1, -1)
    if isinstance(i, bool) or isinstance(j, bool) or min(i, j) < 0:
        raise TypeError
    return operator.index(i), operator.index(j)


def read_edges(path: Path, weights: bool = True) -> list[tuple[int, ...]]:
    """Read rows of whole numbers from a CSV file, with or without a header. Raises InputError.

    Without `weights`, a third column is refused.
    """
    rows: list[tuple[int, ...]] = []
    try:
        with path.open(newline="", encoding="utf-8-sig") as file:
            for number, row in enumerate(csv.reader(file), start=1):
                if not row or (number == 1 and is_header(row)):
                    continue
                if len(row) == 3 and not weights:
                    raise InputError(f"{path}, line {number}: {','.join(row)!r} has a third column: {WEIGHTS}")
                if not all(_is_whole(cell) for cell in row) or (rows and len(row) != len(rows[0])):
                    raise InputError(f"{path}, line {number}: {','.join(row)!r}: not a row of whole numbers >= 0")
                rows.append(tuple(int(cell) for cell in row))
    except (OSError, UnicodeDecodeError, csv.Error) as error:
        raise InputError(f"{path}: cannot be read as CSV: {error}") from error
    return rows


def is_header(row: list[str]) -> bool:
    """Whether a first row names its columns: each begins with a letter."""
    return all(cell.strip()[:1].isalpha() for cell in row)


def _is_whole(cell: str) -> bool:
    return cell.strip().isascii() and cell.strip().isdigit() and len(cell.strip()) <= DIGITS
