"""Graphs in files of other programs, read through networkx: GraphML, GML, GEXF, Pajek."""

import re
from collections.abc import Sequence
from pathlib import Path
from typing import Any, NamedTuple

from swarmcensus.support.errors import TableError
from swarmcensus.support.formatting import counted
from swarmcensus.support.texts import read_text
from swarmcensus.worlds.generators import numbered

FORMATS = {".graphml": "GraphML", ".gml": "GML", ".gexf": "GEXF", ".net": "Pajek"}
LISTS = re.compile(r"^\s*\*(arcs|edges)list\b", re.IGNORECASE | re.MULTILINE)
SECTIONS = re.compile(r"^\s*\*(arcs|edges)\b", re.IGNORECASE | re.MULTILINE)
VERTICES = re.compile(r"^\s*\*vertices\s+(\d+)", re.IGNORECASE | re.MULTILINE)
NAMELESS = re.compile(r"^\s*\*vertices\s+(\d+)\s*\n(?=\s*\*)", re.IGNORECASE | re.MULTILINE)


class FileEdges(NamedTuple):
    """The edges of a file: pairs of robots; of a directed one, the second hears the first."""

    pairs: Sequence[tuple[int, int]]
    directed: bool
    nodes: int | None = None  # how many there are, if the file says


def is_graph(path: str | Path) -> bool:
    """Whether a file has the ending of one of these formats."""
    return Path(path).suffix.lower() in FORMATS


def read_graph(path: Path, ignore_weights: bool) -> FileEdges:
    """Read a graph. Nodes 0 to n - 1 are the robots of these numbers; others are numbered in the file's order.

    Raises InputError.
    """
    kind = FORMATS[path.suffix.lower()]
    try:
        graph = _read(path, kind)
    except TableError:
        raise
    except Exception as error:  # networkx raises whatever its parsers meet
        why = " ".join(f"{error}".split()) or type(error).__name__
        raise TableError.of(path, f"cannot be read as {kind} by networkx: {why}") from error
    names = list(map(str, graph.nodes))
    if {*names} == {*map(str, range(len(names)))}:
        graph = _relabelled(graph, map(int, names))
    else:
        graph = _relabelled(graph, range(len(names)))
    if ignore_weights:
        for *_, attributes in graph.edges(data=True):
            attributes.clear()
    try:
        pairs = numbered(graph, own=True, parallel=True)
    except ValueError as error:
        raise TableError.of(path, f'{error}; weights = "ignore" reads the file without them') from None
    return FileEdges(pairs, graph.is_directed(), len(names))


def _read(path: Path, kind: str) -> Any:
    import networkx  # imported only for graphs

    if kind == "GML":
        text = read_text(path, kind=TableError, most=None)
        try:
            return networkx.parse_gml(text)
        except networkx.NetworkXError:  # nodes without labels, or with equal ones: their ids are unique
            return networkx.parse_gml(text, label="id")
    if kind == "Pajek":
        text = NAMELESS.sub(_named_vertices, read_text(path, kind=TableError, most=None))
        if LISTS.search(text) or len({section.lower() for section in SECTIONS.findall(text)}) > 1:
            raise TableError.of(path, "should have its links in one section, *Edges or *Arcs, a pair in each line")
        graph = networkx.parse_pajek(text)
        said = VERTICES.search(text)
        if said and int(said[1]) != graph.number_of_nodes():
            there = counted(graph.number_of_nodes(), "name")
            raise TableError.of(
                path, f"*Vertices {said[1]} has {there}: each vertex should have a line and its own name"
            )
        return graph
    return (networkx.read_graphml if kind == "GraphML" else networkx.read_gexf)(path)


def _named_vertices(section: re.Match[str]) -> str:
    """A section of Pajek's vertices that only says how many there are, with a name for each."""
    return section[0] + "".join(f'{number} "{number}"\n' for number in range(1, int(section[1]) + 1))


def _relabelled(graph: Any, numbers: Any) -> Any:
    import networkx

    return networkx.relabel_nodes(graph, dict(zip(graph.nodes, numbers, strict=True)))
