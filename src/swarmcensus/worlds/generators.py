"""Graphs from generators of networkx: one for each trial, with a node for each robot."""

import inspect
import json
from collections.abc import Iterable
from typing import Any

import numpy as np

from swarmcensus.support.formatting import counted
from swarmcensus.support.hints import did_you_mean

MOST_GENERATED = 1_000_000  # robots: a larger graph of networkx would not fit in memory
TRIED = 24  # small sizes that are tried first, before the graph for all robots
WEIGHTS = "links have no weights: a message is heard or not (see link_success), and all links count the same"
# numbers that tell edges apart, as programs call them
IDS = {"id", "suid", "uid", "edgeid", "edge_id", "edge id", "key", "networkx_key", "label", "name", "root_index"}


def check(name: str, arguments: str, robots: int) -> None:
    """Raise ValueError if this generator makes no graph for `robots` robots.

    For some generators `n` is not the number of nodes, but a hypercube's dimensions, for example, and they would never
    end. So small sizes are tried first.
    """
    if robots > MOST_GENERATED:
        raise ValueError(f"{name}: networkx makes graphs of {MOST_GENERATED:,} robots at the most")
    given = json.loads(arguments).get("n")
    largest = given if isinstance(given, int) else robots
    sizes = list(range(1, min(TRIED, largest)))
    while given is not None and sizes and 2 * sizes[-1] < largest:
        sizes.append(2 * sizes[-1])
    for n in sizes:
        try:
            nodes = _make_graph(name, arguments, n, 0).number_of_nodes()
        except ValueError:
            continue  # too small for the other arguments
        if nodes > (4 * n + 16 if given is None else robots):
            what = f"networkx.{name} gives {nodes:,} robots for n = {n} already"
            raise ValueError(f"{what}: give an n for {robots:,} robots")
    edges_of(name, arguments, robots, 0)


def draws(name: str) -> bool:
    """Whether a generator of networkx makes random graphs: it then takes a seed."""
    import networkx

    function = getattr(networkx, name, None)
    return callable(function) and "seed" in inspect.signature(function).parameters


def edges_of(name: str, arguments: str, robots: int, seed: int) -> tuple[np.ndarray, bool]:
    """A graph's edges (edge, 2), and whether they are directed. Raises ValueError if there is no such graph."""
    graph = _make_graph(name, arguments, json.loads(arguments).get("n", robots), seed)
    if graph.number_of_nodes() != robots:
        raise ValueError(f"networkx.{name} gives {counted(graph.number_of_nodes(), 'robot')} instead of {robots}")
    edges = [(a, b) for a, b in numbered(graph, parallel=True) if a != b]  # no robot hears itself
    return np.array(edges, np.int64).reshape(-1, 2), bool(graph.is_directed())


def refuse_weights(attributes: Iterable[tuple[str, Any]]) -> None:
    """Raise ValueError if an edge has a number as an attribute that may be a weight."""
    for name, value in attributes:
        is_number = isinstance(value, int | float | np.number) and not isinstance(value, bool)
        if is_number and value != 1 and name.lower() not in IDS:
            raise ValueError(f"the graph's edges have numbers, {name} = {value}: {WEIGHTS}")


def numbered(graph: Any, own: bool = False, parallel: bool = False) -> list[tuple[int, int]]:
    """A graph's edges as pairs of node numbers, in the order of its nodes.

    With `own`, nodes that are all whole numbers from 0 on keep their own numbers. Raises ValueError if edges have
    numbers as attributes, which may be weights, or unless `parallel` if several edges join the same nodes.
    """
    for *_, attributes in graph.edges(data=True):
        refuse_weights((str(name), value) for name, value in attributes.items())
    if graph.is_multigraph() and not parallel and len({*graph.edges(keys=False)}) < graph.number_of_edges():
        kind = "DiGraph" if graph.is_directed() else "Graph"
        raise ValueError(f"the graph has parallel edges, and a link counts once: give networkx.{kind}(graph)")
    number = {node: k for k, node in enumerate(graph.nodes)}
    if own and all(isinstance(node, int | np.integer) and not isinstance(node, bool) and node >= 0 for node in number):
        number = {node: int(node) for node in number}
    return [(number[a], number[b]) for a, b, *_ in graph.edges]


def _make_graph(name: str, arguments: str, n: int, seed: int) -> Any:
    import networkx

    function = getattr(networkx, name, None)
    if not name.endswith("_graph") or not callable(function):
        meant = did_you_mean(name, (known for known in dir(networkx) if known.endswith("_graph")))
        raise ValueError(f"networkx has no graph generator {name!r}{': ' * bool(meant)}{meant.rstrip()}")
    keywords: dict[str, Any] = {**json.loads(arguments), "n": n}
    try:
        if draws(name):
            keywords["seed"] = seed
        return function(**keywords)
    except Exception as error:
        is_list = any(isinstance(value, list) for value in keywords.values())
        hint = "; the generator gets a list whole: several networks are a list of tables" if is_list else ""
        raise ValueError(f"networkx.{name} with n = {n} and {arguments} fails: {error}{hint}") from error
