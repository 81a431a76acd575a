"""Links: missing for a whole trial, late by rounds, and networks that are not connected."""

import networkx as nx
import numpy as np
import pytest

import swarmcensus as sc
from swarmcensus.engine.constants import HEARD, SENT
from swarmcensus.simulation import connections, sampling
from swarmcensus.simulation.trials import Metrics, run_batch
from swarmcensus.studies import addresses
from swarmcensus.studies.coordinates import coordinates_of
from swarmcensus.summaries.replaying import recording
from swarmcensus.worlds import components
from tests.support.small import GO, MOVING, RING, SEED, settings_of, study_of

WHOLE = {
    "ring": "ring",
    "full": "full",
    "tree": "scale-free",
    "directed": {"name": "loop", "edges": [[i, (i + step) % 12] for i in range(12) for step in (1, 5)],
                 "directed": True},
}  # fmt: skip


def pairs_in(setting, trial):
    """The links of a trial, as pairs of receiver and sender."""
    links = sampling.links(setting, SEED, trial, 1)
    return set(zip(links.receivers.tolist(), links.senders.tolist(), strict=True))


@pytest.mark.parametrize(("key", "some"), [("missing_links", 0.25), ("message_delay", 2)])
def test_without_missing_or_late_ones_all_is_as_before(key, some):
    """To the bit, and to the fingerprint by which finished trials are found."""
    (plain,), (said,), (other,) = settings_of(), settings_of(**{key: 0 * some}), settings_of(**{key: some})
    assert plain == said
    assert addresses.fingerprint(plain, 1) == addresses.fingerprint(said, 1) != addresses.fingerprint(other, 1)
    assert coordinates_of(other) == coordinates_of(plain) | {key: some} != coordinates_of(plain)
    for draws in ("readings_key", "losses_key"):
        assert (getattr(addresses, draws)(plain, SEED) == getattr(addresses, draws)(other, SEED)).all()


@pytest.mark.parametrize("topology", WHOLE)
def test_both_directions_of_a_link_are_missing_together(topology):
    whole, few, many, all_of_them = settings_of(12, topology=WHOLE[topology], missing_links=[0.0, 0.2, 0.6, 1.0])
    everyone = {(i, j) for i in range(12) for j in range(12) if i != j}
    for trial in (0, 2):
        there = everyone if topology == "full" else pairs_in(whole, trial)
        assert pairs_in(many, trial) <= pairs_in(few, trial) <= there
        assert not pairs_in(all_of_them, trial)
        kept = pairs_in(many, trial)
        assert all(((j, i) in kept) == ((i, j) in kept) for i, j in there if (j, i) in there)
    assert pairs_in(many, 0) != pairs_in(many, 2)
    batch = sampling.links(many, SEED, 0, 3)
    second = slice(*batch.starts[1:3])
    pairs = zip(batch.receivers[second].tolist(), batch.senders[second].tolist(), strict=True)
    assert set(pairs) == pairs_in(many, 1)
    assert (np.diff(batch.receivers[second].astype(int)) >= 0).all()


def test_the_share_of_missing_links_is_the_one_that_is_given():
    """With another seed a correct simulator fails with a chance of 6e-5: four standard errors."""
    (setting,) = settings_of(80, topology="full", missing_links=0.3)
    share = np.mean([1.0 - len(pairs_in(setting, trial)) / (80 * 79) for trial in range(5)])
    assert abs(share - 0.3) < 4.0 * (0.3 * 0.7 / (5 * 80 * 79 / 2)) ** 0.5


@pytest.mark.parametrize("topology", WHOLE)
@pytest.mark.parametrize("brain", ["minimalistic", "commons"])
@pytest.mark.parametrize("delay", [0, 2])
def test_a_trial_is_that_of_the_network_without_these_links(topology, brain, delay):
    world = {"message_delay": delay, "rounds": 20, "looks": 3}
    (setting,) = settings_of(12, brain, topology=WHOLE[topology], missing_links=0.4, **world)
    for trial in (0, 2):
        edges = [[sender, receiver] for receiver, sender in sorted(pairs_in(setting, trial))]
        (same,) = settings_of(12, brain, topology={"name": "rest", "edges": edges, "directed": True}, **world)
        found, expected = (run_batch(one, SEED, trial, 1, Metrics(0.01, 10, (5,)), GO) for one in (setting, same))
        assert (found.final == expected.final).all()
        assert (found.counts == expected.counts).all()
    assert (run_batch(setting, SEED, 0, 3, Metrics(0.01, 10, (5,)), GO).final[2] == found.final[0]).all()


def test_results_say_how_many_links_are_missing():
    data = sc.run(study_of("commons", robots=8, rounds=40, trials=6, missing_links=[0, 0.5, 1]), jobs=1)
    assert data["missing_links"].values.tolist() == [0.0, 0.5, 1.0]
    heard = data["messages_heard"].values[:3].mean(axis=(1, 2))
    assert heard[0] == 80 > heard[1] > heard[2] == 0
    variances = [sc.explain(data, setting).theory["mixed"].variance[-1] for setting in range(3)]
    assert variances == sorted(variances)  # theory knows each trial's links
    assert "0.5 of links missing" in sc.replay(data, 1, 2).attrs["title"]


def test_a_full_network_that_is_too_large_is_refused():
    with pytest.raises(sc.InputError, match=r"world.missing_links = 0.5: a full network has 2,000 robots at the most"):
        settings_of(2001, topology="full", missing_links=0.5)


# ---- messages that are rounds late on fixed networks: held against the reference and sums by hand, and what is told
def test_late_messages_have_the_same_draws_and_losses():
    """Settings that differ in the delay alone see the same tiles, and lose the messages of the same rounds."""
    now, late = settings_of(robots=8, rounds=60, link_success=0.5, message_delay=[0, 5])
    for key in ("readings_key", "losses_key"):
        assert (getattr(addresses, key)(now, SEED) == getattr(addresses, key)(late, SEED)).all()
    counts = [run_batch(one, SEED, 0, 1, Metrics(0.01, 10, ()), GO).counts[0] for one in (now, late)]
    first = [run_batch(one, SEED, 0, 1, Metrics(0.01, 10, ()), GO).counts[0]
             for one in settings_of(robots=8, rounds=5, link_success=0.5)]  # fmt: skip
    assert (counts[0][SENT] == counts[1][SENT]).all()
    assert (counts[0][HEARD] - counts[1][HEARD] == first[0][HEARD]).all()


@pytest.mark.parametrize(("world", "tables", "said"), [
    (RING | {"missing_links": 1.5}, {}, "world.missing_links = 1.5"),
    (RING | {"missing_links": [0.5, 0.5]}, {}, "a value is twice"),
    (MOVING | {"missing_links": 0.5}, {}, "world.missing_links"),
    (RING | {"message_delay": 1000}, {}, "world.message_delay = 1000"),
    (RING, {"case": [{"rounds": 9, "message_delay": [0, 9]}]}, "case[0].message_delay = 9"),
    (RING | {"message_delay": -1}, {}, "world.message_delay = -1"),
    (MOVING | {"message_delay": 2}, {}, "is world.body.message_delay, in ticks"),
    (RING | {"message_delay": [2, 2]}, {}, "a value is twice"),
])  # fmt: skip
def test_wrong_values_are_named(world, tables, said):
    with pytest.raises(sc.InputError) as caught:
        sc.Study(**{"trials": 1, "swarm": {"robots": 5, "accuracy": 0.7}, "world": world} | tables)
    assert said in str(caught.value)


def test_results_say_how_late_messages_were():
    brains = ["minimalistic", "commons"]
    data = sc.run(study_of(brains, robots=6, accuracy=0.8, rounds=40, message_delay=[0, 1, 4]), jobs=1)
    assert data["message_delay"].values.tolist() == [0, 1, 4] * 2
    assert (data["messages_heard"][0, 0] == 80).all()
    assert (data["messages_heard"][2, 0] == 72).all()
    assert (data["messages_sent"] == 40).all()
    trace = sc.replay(data, 5, 2)
    assert "delay 4, C = 40" in trace.attrs["title"]
    assert (trace["estimate"].values[-1] == data["final_estimate"].values[5, 2]).all()
    with pytest.raises(sc.InputError, match="no lost messages, no delays"):
        recording(data, 2, 0)
    assert recording(data, 0, 0)[0].shape == (400, 6)


# ---- networks that are not connected are named before a run, and `explain` says so
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


@pytest.mark.parametrize(("world", "said"), [
    ({"topology": SPARSE, "robots": 40, "trials": 20},
     r"'gnp_random_graph\(p=0.05\)' of 40 robots: 20 of 20 networks are not connected: "
     r"[\d.]+ components on average, and a mean degree of 2$"),
    ({"topology": TWO}, "'two' of 5 robots: its network is not connected: 2 components, and a mean degree of 1.2"),
    ({"topology": {"name": "out", "edges": [[0, 1], [0, 2], [0, 3], [0, 4]], "directed": True}},
     "'out' of 5 robots: its network is not connected: 5 components, and a mean degree of 0.8"),
    ({"topology": "ring", "robots": 20, "missing_links": 0.5, "trials": 9},
     "'ring' of 20 robots with missing_links = 0.5: 9 of 9 networks are not connected"),
])  # fmt: skip
def test_networks_that_are_not_connected_are_named_before_a_run(world, said):
    with pytest.warns(UserWarning, match=said):
        results = sc.run(study_of(accuracy=0.9, rounds=40, **world), jobs=1)
    found = sc.explain(results, 0)
    assert [*found.terms] == ["sensors", "unconnected"]
    if found.terms["unconnected"] > found.terms["sensors"]:
        assert found.limit.startswith("the network: ")
    assert (found.terms["unconnected"] > found.terms["sensors"]) == ("out" not in said)


@pytest.mark.parametrize("world", [
    {"topology": "ring"}, {"topology": "full"}, {"topology": "moving", "density": 1.0, "ticks": 5},
    {"topology": TWO, "brain": "alone"}, {"topology": TWO, "link_success": 0.0},
])  # fmt: skip
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


@pytest.mark.long
@pytest.mark.filterwarnings("ignore:topology")
def test_explain_counts_all_networks_if_results_have_them():
    study = study_of(topology={**SPARSE, "p": 0.04}, robots=85, rounds=20, trials=30, accuracy=0.9)
    data = sc.run(study, jobs=1)
    apart = int((data["components"] > 1).sum())
    said = f"{apart} of 30 networks are not connected"
    assert said in str(sc.explain(data, 0).limit)
    assert said not in str(connections(study.settings()[0], study.seed, 30))  # which looks at a few
