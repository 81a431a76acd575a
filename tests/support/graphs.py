"""Networks on which theory is tried."""

import networkx as nx

from swarmcensus import brains
from tests.support.second import brain, changed

# running sums of evidence, mixed and divided, as in the theory of mixing: the shipped commons without its prior
PRIOR = ("min(0.25, 0.0625 / me.v)", "0.0")
COMMONS = brain(changed(PRIOR, source=brains.load("commons").source), "commons.py")


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
