"""Graphs in GraphML files, as networkx reads them; networkx, Gephi, yEd, Cytoscape and igraph all write them.

What networkx would read as something else is refused: nodes within nodes, ways that yEd draws.
"""

import io
import re
from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

from swarmcensus.support.errors import TableError
from swarmcensus.support.files import content
from swarmcensus.worlds.generators import numbered, refuse_weights

MOST_BYTES = 500_000_000
ENDING = ".graphml"
HEAD = 2000  # bytes in which yEd says that it wrote a file


class FileEdges(NamedTuple):
    """The edges of a file: pairs of robots; of a directed one, the second hears the first."""

    pairs: Sequence[tuple[int, int]]
    directed: bool
    nodes: int | None = None  # how many there are, if the file says


def read_graph(path: Path, ignore_weights: bool, directed: bool | None = None) -> FileEdges:
    """Read a graph. Nodes 0 to n - 1 are the robots of these numbers; others are numbered in the file's order.

    `directed` is what the study says of its edges, if it does. Raises InputError.
    """
    try:
        found = content(path, MOST_BYTES)
        import networkx

        graph = networkx.read_graphml(io.BytesIO(found))
        if len(re.findall(rb"<node\b", found)) != len(graph) or b"foldertype" in found:
            raise ValueError("nodes within nodes, of one id, or missing, where all should be robots")
        if re.search(rb"<edge[^>]*\sdirected=.(?!true|false)", found):
            raise ValueError("directed should be true or false")
        if directed is None and re.search(rb"yFiles|yworks", found[:HEAD]):
            raise ValueError("yEd writes all links as directed, whatever it draws: say directed = true or false")
    except TableError:
        raise
    except Exception as error:  # networkx and what it parses with raise many kinds
        what = getattr(error, "strerror", None) or error
        raise TableError.of(path, f"cannot be read as GraphML: {what}") from None
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
