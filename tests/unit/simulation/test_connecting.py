"""Networks that are not connected are named before a run, and `explain` says so."""

import networkx as nx
import numpy as np
import pytest

import swarmcensus as sc
from swarmcensus.simulation import connections
from swarmcensus.worlds import components
from tests.support.small import study_of

SPARSE = {"networkx": "gnp_random_graph", "p": 0.05}
TWO = {"name": "two", "edges": [[0, 1], [1, 2], [3, 4]]}


@pytest.mark.parametrize("seed", range(5))
@pytest.mark.parametrize("directed", [False, True])
def test_components_are_those_of_networkx(seed, directed):
    graph = nx.gnp_random_graph(30, 0.04, seed=seed, directed=directed)
    links = np.array([*graph.edges, *(() if directed else ((b, a) for a, b in graph.edges))]).reshape(-1, 2)
    count = nx.number_strongly_connected_components if directed else nx.number_connected_components
    assert components(30, links[:, 1], links[:, 0]) == count(graph)
    assert components(1, links[:0, 1], links[:0, 0]) == 1


@pytest.mark.parametrize(
    ("world", "said"),
    [
        ({"topology": SPARSE, "robots": 40, "trials": 50},
         r"'gnp_random_graph\(p=0.05\)' of 40 robots: 50 of 50 networks that were looked at are not connected: "
         r"[\d.]+ components on average, and a mean degree of 1.9\d"),
        ({"topology": TWO}, "'two' of 5 robots: its network is not connected: 2 components, and a mean degree of 1.2"),
        ({"topology": {"name": "out", "edges": [[0, 1], [0, 2], [0, 3], [0, 4]], "directed": True}},
         "'out' of 5 robots: its network is not connected: 5 components, and a mean degree of 0.8"),
        ({"topology": "ring", "robots": 20, "missing_links": 0.5, "trials": 9},
         "'ring' of 20 robots with missing_links = 0.5: 9 of 9 networks that were looked at are not connected"),
    ],
)  # fmt: skip
def test_networks_that_are_not_connected_are_named_before_a_run(world, said):
    with pytest.warns(UserWarning, match=said):
        results = sc.run(study_of(accuracy=0.9, rounds=40, **world), jobs=1)
    found = sc.explain(results, 0)
    assert [*found.terms] == ["sensors", "unconnected"]
    if found.terms["unconnected"] > found.terms["sensors"]:
        assert found.limit.startswith("the network: ")
    assert (found.terms["unconnected"] > found.terms["sensors"]) == ("out" not in said)


@pytest.mark.parametrize(
    "world",
    [{"topology": "ring"}, {"topology": "full"}, {"topology": "moving", "density": 1.0, "ticks": 5},
     {"topology": TWO, "brain": "alone"}, {"topology": TWO, "link_success": 0.0}],
)  # fmt: skip
def test_nothing_is_said_of_networks_that_are_connected_or_not_used(world):
    study = study_of(**world)
    assert connections(study.settings()[0], study.seed, study.trials).apart == 0
