"""Networks that are not connected are named before a run, and `explain` says so."""

import networkx as nx
import numpy as np
import pytest

import swarmcensus as sc
from swarmcensus.simulation import connections, sampling
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
    assert components(30, links[:, 1], links[:, 0]).tolist() == [count(graph)]
    assert components(1, links[:0, 1], links[:0, 0]).tolist() == [1]
    twice, starts = np.concatenate([links, links[:0], links]), [0, len(links), len(links), 2 * len(links)]
    assert components(30, twice[:, 1], twice[:, 0], starts).tolist() == [count(graph), 30, count(graph)]


@pytest.mark.parametrize(
    ("world", "said"),
    [
        ({"topology": SPARSE, "robots": 40, "trials": 50},
         r"'gnp_random_graph\(p=0.05\)' of 40 robots: 50 of 50 networks are not connected: "
         r"[\d.]+ components on average, and a mean degree of 1.9\d"),
        ({"topology": TWO}, "'two' of 5 robots: its network is not connected: 2 components, and a mean degree of 1.2"),
        ({"topology": {"name": "out", "edges": [[0, 1], [0, 2], [0, 3], [0, 4]], "directed": True}},
         "'out' of 5 robots: its network is not connected: 5 components, and a mean degree of 0.8"),
        ({"topology": "ring", "robots": 20, "missing_links": 0.5, "trials": 9},
         "'ring' of 20 robots with missing_links = 0.5: 9 of 9 networks are not connected"),
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


def networks(seed, setting, trials):
    """The components and the mean degree of each trial's network, by networkx."""
    for trial in range(trials):
        links = sampling.links(setting, seed, trial, 1)
        graph = nx.Graph([*zip(links.senders.tolist(), links.receivers.tolist(), strict=True)])
        graph.add_nodes_from(range(setting.robots))
        yield nx.number_connected_components(graph), 2 * graph.number_of_edges() / setting.robots


@pytest.mark.filterwarnings("ignore:topology")
@pytest.mark.parametrize("more", [{}, {"members": [{"robots": 0.1, "accuracy": 0.5}]}, {"missing_links": 0.5}])
def test_each_trial_says_whether_its_network_is_connected(more):
    study = study_of(topology=[{**SPARSE, "p": 0.14}, "ring"], robots=30, rounds=3, trials=12, **more)
    data = sc.run(study, jobs=1)
    for k, setting in enumerate(study.settings()):
        expected = np.array([*networks(study.seed, setting, 12)])
        np.testing.assert_allclose(data["components"][k], expected[:, 0])
        np.testing.assert_allclose(data["mean_degree"][k], expected[:, 1])
    apart = data["components"].values > 1
    assert apart[0].any()
    assert not apart[0].all()
    assert sc.summary(data)["connected"].tolist() == (~apart).mean(axis=1).tolist()
    assert sc.verify(data).labels == sc.verify(data).differences == []


def test_robots_that_move_and_full_networks_have_no_such_numbers():
    moving = {"topology": ["ring", "moving"], "density": 1.0}
    study = sc.Study(trials=2, swarm={"robots": 5, "accuracy": 0.9}, world={"fill_ratio": 0.6, **moving},
                     schedule={"rounds": 3, "ticks": 3})  # fmt: skip
    data = sc.run(study, jobs=1)
    assert np.isnan(data["components"].values).tolist() == [[False] * 2, [True] * 2]
    assert sc.verify(data).labels == []
    assert "components" not in sc.run(study_of(topology="full", rounds=3), jobs=1)


@pytest.mark.filterwarnings("ignore:topology")
def test_explain_counts_all_networks_if_results_have_them():
    study = study_of(topology={**SPARSE, "p": 0.03}, robots=120, rounds=20, trials=30, accuracy=0.9)
    data = sc.run(study, jobs=1)
    apart = int((data["components"] > 1).sum())
    said = f"{apart} of 30 networks are not connected"
    assert said in str(sc.explain(data, 0).limit)
    assert said not in str(connections(study.settings()[0], study.seed, 30))  # which looks at a few
