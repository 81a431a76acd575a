"""Networks for functions of theory: a networkx graph, a study's topology, or pairs of robots, as links."""

import operator
from collections.abc import Iterable, Mapping
from typing import Any, NamedTuple

import numpy as np

from swarmcensus.engine.constants import LISTED
from swarmcensus.support.formatting import counted
from swarmcensus.support.hints import did_you_mean
from swarmcensus.worlds import generators
from swarmcensus.worlds.networks import Topology, parse_topology
from swarmcensus.worlds.wiring import PLUGINS


class Network(NamedTuple):
    """Who hears whom: `receivers[k]` hears `senders[k]`, sorted by both; no robot hears itself."""

    robots: int
    receivers: np.ndarray
    senders: np.ndarray


def whole(name: str, value: Any) -> int:
    """A whole number. Raises ValueError for anything else."""
    try:
        if isinstance(value, bool):
            raise TypeError
        return operator.index(value)
    except TypeError:
        raise ValueError(f"{name} = {value!r}: should be a whole number") from None


def network(graph: Any, robots: int | None, directed: bool, most: int, why: str) -> Network:
    """Read a network of 1 to `most` robots; `why` explains that limit in messages.

    `graph` is a networkx graph, any topology of a study file, or pairs of robot numbers from 0; in a directed pair
    (u, v), v hears u. `robots` is their number, if the graph does not give it. Raises ValueError.
    """
    robots = None if robots is None else whole("robots", robots)
    if not isinstance(directed, bool):
        raise ValueError(f"directed = {directed!r}: should be True or False")
    known: bool = isinstance(graph, Topology | Iterable) and not isinstance(graph, type)
    if not known:
        right = "a networkx graph, a topology as in a study file, or pairs of robot numbers, such as [(0, 1), (1, 2)]"
        raise ValueError(f"graph = {graph!r}: should be {right}")
    if hasattr(graph, "nodes") and hasattr(graph, "is_directed"):  # nodes may have any names
        nodes = graph.number_of_nodes()
        if robots not in (None, nodes):
            raise ValueError(f"robots = {robots}: the graph has {nodes} nodes: should be {nodes}, or left out")
        pairs = [(u, v) for u, v in generators.numbered(graph) if u != v]
        robots, directed = nodes, graph.is_directed()
        graph = {"name": "graph", "edges": pairs, "directed": directed}
    elif not isinstance(graph, Topology | str | Mapping):
        graph = {"name": "graph", "edges": graph, "directed": directed}
    if isinstance(graph, str) and graph not in PLUGINS:
        known_names = f"{did_you_mean(graph, PLUGINS.names)}topologies with a name are {', '.join(PLUGINS.names)}"
        raise ValueError(f"graph = {graph!r}: {known_names}")
    topology = parse_topology(graph, None, {})
    if robots is None and topology.edges is not None:
        robots = 1 + max((max(pair) for pair in topology.edges), default=0)
    if robots is None:
        raise ValueError(f"topology {topology.name!r} has no size of its own: say how many robots")
    if not 1 <= robots <= most:
        raise ValueError(f"{counted(robots, 'robot')}: should be 1 to {most:,}, {why}")
    if topology.moves or topology.varies:
        raise ValueError(f"topology {topology.name!r} differs from trial to trial: give the edges of one of its graphs")
    topology.check(robots)
    links = topology.links(robots, 0, 0, 1, lossless=False, sums=False)
    if links.mode == LISTED:
        return Network(robots, links.receivers, links.senders)
    return Network(robots, *np.nonzero(~np.eye(robots, dtype=np.bool_)))
