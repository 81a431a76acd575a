"""Networks on which theory is tried."""

import networkx as nx

from tests.support.places import ROOT

COMMONS = ROOT / "tests" / "support" / "commons.py"


DIRECTED = nx.DiGraph([(0, 1), (1, 2), (2, 3), (3, 0), (0, 2), (4, 1), (2, 4)])


GRAPHS = {
    "one": nx.empty_graph(1),
    "pair": nx.path_graph(2),
    "star": nx.star_graph(7),
    "line": nx.path_graph(9),
    "apart": nx.disjoint_union(nx.path_graph(3), nx.star_graph(4)),
    "tree": nx.barabasi_albert_graph(40, 1, seed=2),
    "full": nx.complete_graph(6),
    "directed": DIRECTED,
    "sparse and directed": nx.DiGraph([(i, (i + 1) % 60) for i in range(60)]),
}
