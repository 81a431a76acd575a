"""r-robustness and (r, s)-robustness against known graphs and against their definitions, told by sets of Python."""

import itertools

import networkx as nx
import numpy as np
import pytest

from swarmcensus.worlds import is_rs_robust, networks, r_robustness


def pairs_of_sets(graph):
    """Every two disjoint sets of nodes, neither empty."""
    for sides in itertools.product((0, 1, 2), repeat=len(graph)):
        found = [{node for node, side in zip(graph, sides, strict=True) if side == k} for k in (1, 2)]
        if all(found):
            yield found


def hears(graph, node):
    return set(graph.predecessors(node) if graph.is_directed() else graph[node]) - {node}


def reaching(graph, some, r):
    """How many of a set hear r nodes or more outside it."""
    return sum(len(hears(graph, node) - some) >= r for node in some)


def robust(graph, r, s):
    return all(
        reaching(graph, one, r) == len(one)
        or reaching(graph, other, r) == len(other)
        or reaching(graph, one, r) + reaching(graph, other, r) >= s
        for one, other in pairs_of_sets(graph)
    )


def largest_r(graph):
    """By the definition of r-robust itself, which does not speak of s."""
    r = 0
    while all(reaching(graph, one, r + 1) or reaching(graph, other, r + 1) for one, other in pairs_of_sets(graph)):
        r += 1
    return r


def some_graphs():
    random = np.random.default_rng(3)
    for n in (2, 3, 4, 5, 6):
        for directed in (False, True):
            for _ in range(4):
                seed, p = int(random.integers(1000)), float(random.uniform(0.3, 0.95))
                yield nx.gnp_random_graph(n, p, seed=seed, directed=directed)


@pytest.mark.parametrize("graph", some_graphs(), ids=str)
def test_both_are_what_their_definitions_say(graph):
    assert r_robustness(graph) == largest_r(graph)
    for r, s in itertools.product(range(len(graph)), range(1, len(graph) + 1)):
        assert is_rs_robust(graph, r, s) == robust(graph, r, s), (r, s)


@pytest.mark.parametrize("n", range(1, 13))
def test_complete_graphs(n):
    most = (n + 1) // 2
    assert r_robustness(nx.complete_graph(n)) == r_robustness("full", n) == most
    assert is_rs_robust("full", most, n, n)
    assert n == 1 or not is_rs_robust("full", most + 1, 1, n)


def test_of_a_directed_edge_the_second_hears_the_first():
    """All hear robot 0, and it hears nobody: a set with it and one without, of which one hears."""
    out = [(0, k) for k in range(1, 5)]
    assert r_robustness(out, directed=True) == r_robustness(nx.DiGraph(out)) == 1
    back = [(k, 0) for k in range(1, 5)]
    assert r_robustness(back, directed=True) == 0  # robots 1 and 2 hear nobody
    assert r_robustness(out) == r_robustness(back) == 1


def test_every_form_of_a_graph():
    edges = [(0, 1), (1, 2), (2, 0), (2, 3), (3, 0)]
    forms = [
        edges,
        np.array(edges),
        nx.Graph(edges),
        nx.relabel_nodes(nx.Graph(edges), dict(enumerate("abcd"))),
        nx.relabel_nodes(nx.Graph(edges), {0: 7, 1: 3, 2: 20, 3: 5}),
        {"name": "square", "edges": edges},
        networks.parse_topology({"name": "square", "edges": edges}, None, {}),
        nx.Graph([*edges, (1, 1)]),
    ]
    assert [r_robustness(form) for form in forms] == [2] * len(forms)
    assert r_robustness(edges, 5) == 0  # and a robot that hears nobody


@pytest.mark.parametrize(
    ("ask", "said"),
    [
        (lambda: r_robustness("ring", 13), "13 robots: should be 1 to 12"),
        (lambda: r_robustness(nx.Graph()), "0 robots: should be 1 to 12"),
        (lambda: r_robustness("ring"), "say how many robots"),
        (lambda: r_robustness("scale-free", 8), "'scale-free' differs from trial to trial"),
        (lambda: r_robustness([(0, 4)], 3), "leads to a robot that is not there"),
        (lambda: is_rs_robust("full", 2, 0, 5), "s from 1 to the number of robots, 5"),
        (lambda: is_rs_robust("full", -1, 1, 5), "r is from 0 on"),
        (lambda: r_robustness([(0, 1)], True), "robots = True: should be a whole number"),
        (lambda: is_rs_robust("full", True, 1, 4), "r = True: should be a whole number"),
        (lambda: is_rs_robust("full", 1, "1", 4), "s = '1': should be a whole number"),
        (lambda: r_robustness([(0, 1)], directed="yes"), "directed = 'yes': should be True or False"),
        (lambda: r_robustness(5), "graph = 5: should be a networkx graph"),
        (lambda: r_robustness([1, 2]), "edges are pairs of robot numbers"),
        (lambda: r_robustness(nx.path_graph(3), 7), "robots = 7: the graph has 3 nodes: should be 3, or left out"),
        (lambda: r_robustness({"networkx": "star_graph", "n": 4}, 4), "gives 5 robots instead of 4"),
        (lambda: r_robustness({"networkx": "gnp_random_graph", "p": 0.5}, 4), "differs from trial to trial"),
    ],
)
def test_errors_say_what_is_right(ask, said):
    with pytest.raises(ValueError, match=said.replace("(", r"\(")) as caught:
        ask()
    assert "\n" not in str(caught.value)
