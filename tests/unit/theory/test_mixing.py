"""Mixing: by hand, spectrum against powers, against brute force, and against runs of the brain that it is about.

Tests of draws state their error rate: the chance that what is right fails them, were the seed not fixed.
"""

import networkx as nx
import numpy as np
import pytest
from scipy import stats

import swarmcensus as sc
from swarmcensus import brains, theory
from swarmcensus.theory.matrices import spectrum_of
from swarmcensus.theory.mixing import by_powers, moments
from tests.support.second import brain, changed
from tests.support.small import study_of

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


def test_matrices_are_means_over_oneself_and_whom_one_hears():
    np.testing.assert_allclose(theory.mixing_matrix("line", 3), [[1 / 2, 1 / 2, 0], [1 / 3] * 3, [0, 1 / 2, 1 / 2]])
    np.testing.assert_allclose(theory.mixing_matrix([(0, 1)], 3, directed=True), [[1, 0, 0], [0.5, 0.5, 0], [0, 0, 1]])
    np.testing.assert_allclose(theory.mixing_matrix("full", 4), np.full((4, 4), 0.25))
    np.testing.assert_allclose(theory.mixing_matrix(DIRECTED)[1], [1 / 3, 1 / 3, 0, 0, 1 / 3])


@pytest.mark.parametrize("graph", GRAPHS.values(), ids=GRAPHS)
def test_spectrum_against_matrix_powers(graph):
    matrix, rng = theory.mixing_matrix(graph), np.random.default_rng(3)
    squared, summed = rng.random((2, len(matrix)))
    at = np.array([1, 2, 9, 200])
    powers = [np.linalg.matrix_power(matrix, m) for m in range(1, 201)]
    expected = [
        np.cumsum(of, axis=0)[at - 1] for of in ([p**2 @ squared for p in powers], [p @ summed for p in powers])
    ]
    for way in (moments, by_powers):
        np.testing.assert_allclose(way(matrix, at.tolist(), squared, summed), expected, rtol=1e-10)
    assert (spectrum_of(matrix) is None) == graph.is_directed()


def test_by_hand():
    """Two robots: each reading is at once worth half to both. Nobody: each robot has its own."""
    np.testing.assert_allclose(theory.variance_factors(theory.mixing_matrix("line", 2), [1, 10]),
                               [[0.5] * 2, [0.05] * 2])  # fmt: skip
    np.testing.assert_allclose(theory.variance_factors(np.eye(3), 4), [0.25] * 3)
    np.testing.assert_allclose(theory.variance_factors(theory.mixing_matrix("full", 20), 5), [0.01] * 20)
    np.testing.assert_allclose(theory.variance_factors(theory.mixing_matrix("line", 3), 1), [1 / 2, 1 / 3, 1 / 2])


@pytest.mark.parametrize("graph", ["star", "directed"])
def test_variances_are_those_of_brute_force(graph):
    """Sums mixed in NumPy, 20,000 times: each robot's variance within 5 sd; error rate below 0.001 %."""
    matrix, rng, draws = theory.mixing_matrix(GRAPHS[graph]), np.random.default_rng(8), 20_000
    n, looks, f = len(matrix), 3, 0.3
    b, w = rng.uniform(0.6, 1.0, (2, n))
    b[1], w[1] = 0.5, 0.5
    k = b + w - 1.0
    s, v, seen = np.zeros((draws, n)), np.zeros(n), {}
    for t in range(1, 13):
        blacks = rng.binomial(looks, k * f + 1 - w, (draws, n))
        s = (s + k * (blacks - looks * (1 - w))) @ matrix.T
        v = matrix @ (v + k**2 * looks)
        seen[t] = (s / v).var(axis=0), (s / v).mean(axis=0)
    expected = theory.mixed_sums(matrix, [1, 4, 12], looks, f, b, w).variance
    for t, variance in zip((1, 4, 12), expected, strict=True):
        np.testing.assert_allclose(seen[t][0] / variance, 1.0, atol=5 * np.sqrt(2 / draws))
        assert (np.abs(seen[t][1] - f) < 5 * np.sqrt(variance / draws)).all()


def test_a_robot_that_knows_only_blind_ones_knows_nothing():
    variance = theory.mixed_sums(np.eye(2), 5, 10, 0.5, [0.5, 0.8]).variance
    assert variance[0] == np.inf
    assert variance[1] == pytest.approx(float(theory.swarm_bound(50, 0.5, 0.8)))


# ---- how fast
def test_relaxation_times_are_known_ones():
    rings = [theory.relaxation_time(theory.mixing_matrix("ring", robots)) for robots in (20, 50, 100)]
    assert rings == pytest.approx([30.1, 189.7, 759.7], abs=0.1)
    assert theory.relaxation_time(theory.mixing_matrix("full", 9)) == theory.relaxation_time(np.eye(1)) == 0.0


def test_the_stationary_law_counts_neighbours():
    graph = nx.barabasi_albert_graph(50, 2, seed=1)
    degrees = np.array([d for _, d in graph.degree]) + 1
    matrix = theory.mixing_matrix(graph)
    np.testing.assert_allclose(theory.stationary_law(matrix), degrees / degrees.sum(), atol=1e-12)
    assert theory.stationary_efficiency(matrix) == pytest.approx(degrees.sum() ** 2 / (50 * (degrees**2).sum()))
    assert theory.stationary_efficiency(theory.mixing_matrix("ring", 9)) == pytest.approx(1.0)
    law = theory.stationary_law(theory.mixing_matrix(DIRECTED))
    np.testing.assert_allclose(law @ theory.mixing_matrix(DIRECTED), law, atol=1e-12)


# ---- against runs
ARROWS = [*DIRECTED.edges, (4, 5), (5, 6), (6, 7), (7, 0)]
PLACES = {
    **{name: name for name in ("ring", "line", "full")},
    "star": {"name": "star", "edges": [[0, k] for k in range(1, 8)]},
    "arrows": {"name": "arrows", "edges": [[*pair] for pair in ARROWS], "directed": True},
}


def test_measured_and_theory_agree_in_every_cell():
    """Mean squared errors over their variances, by trial: z-tests of 20 cells, 0.005 % each two-sided."""
    sensors = {"0.8": (0.8, 0.8), "black=0.95 white=0.7": (0.95, 0.7)}
    results = sc.run(study_of(COMMONS, robots=8, accuracy=[0.8, {"black": 0.95, "white": 0.7}], rounds=40, looks=20,
                              trials=300, seed=21, measure={"checkpoints": [5, 40], "estimates": True},
                              topology=list(PLACES.values()), fill_ratio=0.45))  # fmt: skip
    for k in range(results.sizes["setting"]):
        topology = str(results["topology"].values[k])
        given = PLACES[topology]
        edges = given["edges"] if isinstance(given, dict) else given
        matrix = theory.mixing_matrix(edges, 8, directed=topology == "arrows")
        sensor = sensors[str(results["accuracy"].values[k])]
        expected = theory.mixed_sums(matrix, [5, 40], 20, 0.45, *sensor).variance
        for at in (0, 1):
            ratio = ((results["estimates"].values[k, at] - 0.45) ** 2 / expected[at]).mean(axis=1)
            z = (ratio.mean() - 1.0) / (ratio.std(ddof=1) / np.sqrt(len(ratio)))
            assert 2 * stats.norm.sf(abs(z)) > 5e-5, (topology, sensor, at)
            assert ratio.std(ddof=1) / np.sqrt(len(ratio)) < 0.1  # what is off by a half would be seen
