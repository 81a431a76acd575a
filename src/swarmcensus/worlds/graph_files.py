"""Graphs in files of other programs, as networkx reads them: GraphML, GML, GEXF.

What networkx would read as something else is refused: nodes within nodes, links that come and go, ways that yEd draws.
"""

import io
import re
from collections.abc import Sequence
from pathlib import Path
from typing import Any, NamedTuple

from swarmcensus.support.errors import TableError
from swarmcensus.support.files import content
from swarmcensus.support.texts import read_text
from swarmcensus.worlds.generators import numbered, refuse_weights

MOST_BYTES = 500_000_000
FORMATS = {".graphml": "GraphML", ".gml": "GML", ".gexf": "GEXF"}
TIMES = rb"<spell\b|<(node|edge)\b[^>]*\s(start|end|timestamp|intervals)"  # in GEXF
HEAD = 2000  # bytes in which yEd says that it wrote a file
TABLE = "a table source,target has what is right"


class FileEdges(NamedTuple):
    """The edges of a file: pairs of robots; of a directed one, the second hears the first."""

    pairs: Sequence[tuple[int, int]]
    directed: bool
    nodes: int | None = None  # how many there are, if the file says


def is_graph(path: str | Path) -> bool:
    """Whether a file has the ending of one of these formats."""
    return Path(path).suffix.lower() in FORMATS


def read_graph(path: Path, ignore_weights: bool, directed: bool | None = None) -> FileEdges:
    """Read a graph. Nodes 0 to n - 1 are the robots of these numbers; others are numbered in the file's order.

    `directed` is what the study says of its edges, if it does. Raises InputError.
    """
    kind = FORMATS[path.suffix.lower()]
    try:
        found = content(path, MOST_BYTES)
        graph = _gml(read_text(path, kind=TableError, most=MOST_BYTES)) if kind == "GML" else _xml(found, kind)
        if directed is None and re.search(rb"yFiles|yworks", found[:HEAD]):
            raise ValueError("yEd writes all links as directed, whatever it draws: say directed = true or false")
    except TableError:
        raise
    except Exception as error:  # networkx and what it parses with raise many kinds
        what = getattr(error, "strerror", None) or error
        raise TableError.of(path, f"cannot be read as {kind}: {what}") from None
    for *_, keys in graph.edges(data=True) if ignore_weights else ():
        keys.clear()
    try:
        refuse_weights(() if ignore_weights else graph.graph.get("edge_default", {}).items())
        pairs = numbered(graph, parallel=True)
    except ValueError as error:
        raise TableError.of(path, f'{error}; weights = "ignore" reads the file without them') from None
    names = [str(node) for node in graph]
    if {*names} == {*map(str, range(len(names)))}:
        pairs = [(int(names[a]), int(names[b])) for a, b in pairs]
    return FileEdges(pairs, graph.is_directed(), len(names))


def _xml(found: bytes, kind: str) -> Any:
    """The graph in GraphML or GEXF."""
    if kind == "GEXF" and re.search(TIMES, found):
        raise ValueError(f"its nodes or links have times, and links are there all the time: {TABLE}")
    import networkx

    read = networkx.read_graphml if kind == "GraphML" else networkx.read_gexf
    graph = read(io.BytesIO(found))
    nodes = len(re.findall(rb"<node\b", found))
    if nodes != len(graph) or b"foldertype" in found or any("pid" in keys for _, keys in graph.nodes(data=True)):
        raise ValueError(f"nodes within nodes, of one id, or missing, where all should be robots, or else {TABLE}")
    if re.search(rb"<edge[^>]*\sdirected=.(?!true|false)", found):
        raise ValueError("directed should be true or false")
    return graph


def _gml(text: str) -> Any:
    """The graph, in which a link may be there twice. Nodes are called by their labels, if all differ."""
    import networkx

    graph = networkx.parse_gml(re.sub(r"^\s*graph\s*\[", r"\g<0> multigraph 1 ", text, flags=re.MULTILINE), "id")
    if groups := [node for node, keys in graph.nodes(data=True) if keys.get("isGroup") == 1]:
        raise ValueError(f"node {groups[0]} is a group of nodes: all nodes should be robots, or else {TABLE}")
    labels = {node: str(keys.get("label", node)) for node, keys in graph.nodes(data=True)}
    return networkx.relabel_nodes(graph, labels) if len({*labels.values()}) == len(labels) else graph
