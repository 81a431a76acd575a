"""Mixing of late messages: by hand, against brute force, against mixing without a delay, and against runs.

Tests of draws state their error rate: the chance that what is right fails them, were the seed not fixed.
"""

import numpy as np
import pytest
from scipy import stats

import swarmcensus as sc
from swarmcensus import theory
from swarmcensus.support.errors import InputError
from swarmcensus.theory.late_mixing import fits, late_moments
from swarmcensus.theory.mixing import moments
from tests.support.graphs import COMMONS, GRAPHS
from tests.support.small import study_of


def by_brute_force(matrix, delay, last):
    """The weights of readings in s (round of the reading, robot, its robot), one reading at a time."""
    robots = len(matrix)
    own, others = np.diag(np.diag(matrix)), matrix - np.diag(np.diag(matrix))
    weights = np.zeros((last, robots, robots))
    for r in range(1, last + 1):
        said, s = {}, np.zeros((robots, robots))
        for t in range(1, last + 1):
            said[t] = s + (np.eye(robots) if t == r else 0.0)
            s = own @ said[t] + others @ said[t - delay] if t > delay else said[t]
        weights[r - 1] = s
    return weights


@pytest.mark.parametrize("delay", [0, 1, 3, 8])
@pytest.mark.parametrize("graph", ["one", "star", "apart", "full", "directed", "sparse and directed"])
def test_weights_are_those_of_brute_force(graph, delay):
    matrix, rng = theory.mixing_matrix(GRAPHS[graph]), np.random.default_rng(5)
    squared, summed = rng.random((2, len(matrix)))
    at = [1, 2, 3, 4, 9, 14]
    squares, sums = late_moments(matrix, delay, at, squared, summed)
    for k, t in enumerate(at):
        weights = by_brute_force(matrix, delay, t)
        np.testing.assert_allclose(squares[k], (weights**2 @ squared).sum(axis=0), rtol=1e-12)
        np.testing.assert_allclose(sums[k], (weights @ summed).sum(axis=0), rtol=1e-12)
    if not delay:
        np.testing.assert_allclose((squares, sums), moments(matrix, at, squared, summed), rtol=1e-10)


def test_two_robots_by_hand():
    """With a delay of 1: s(1) = u, s(2) = (u1 + u2 + u1') / 2, so that weights are 1/2 each, of 3/2."""
    pair = theory.mixing_matrix([(0, 1)])
    variance = theory.mixing_variance(pair, [1, 2], 10, 0.5, 0.8, delay=1)
    one = theory.reading_variance(0.5, 0.8) / 10
    np.testing.assert_allclose(variance, [[one] * 2, [one * (3 / 4) / (9 / 4)] * 2], rtol=1e-12)


WORLDS = {"ring": "ring", "full": "full", "star": {"name": "star", "edges": [[0, k] for k in range(1, 8)]}}


@pytest.fixture(scope="module")
def runs():
    study = study_of(
        str(COMMONS), robots=8, accuracy=[0.8, {"black": 0.95, "white": 0.7}], rounds=40, looks=20, trials=300,
        seed=21, measure={"checkpoints": [5, 40], "estimates": True}, topology=list(WORLDS.values()), fill_ratio=0.45,
        message_delay=[2, 10],
    )  # fmt: skip
    return sc.run(study)


def test_measured_and_theory_agree_in_every_cell(runs):
    """Mean squared errors over their variances, by trial: z-tests of 24 cells, 0.005 % each two-sided."""
    sensors = {"0.8": (0.8, 0.8), "black=0.95 white=0.7": (0.95, 0.7)}
    for k in range(runs.sizes["setting"]):
        topology, delay = str(runs["topology"].values[k]), int(runs["message_delay"].values[k])
        given = WORLDS[topology]
        matrix = theory.mixing_matrix(given["edges"] if isinstance(given, dict) else given, 8)
        sensor = sensors[str(runs["accuracy"].values[k])]
        expected = theory.mixing_variance(matrix, [5, 40], 20, 0.45, *sensor, delay=delay)
        for at in (0, 1):
            ratio = ((runs["estimates"].values[k, at, :, :8] - 0.45) ** 2 / expected[at]).mean(axis=1)
            z = (ratio.mean() - 1.0) / (ratio.std(ddof=1) / np.sqrt(len(ratio)))
            assert 2 * stats.norm.sf(abs(z)) > 5e-5, (topology, delay, sensor, at)
            assert ratio.std(ddof=1) / np.sqrt(len(ratio)) < 0.1  # what is off by a half would be seen


def test_what_cannot_be_held_is_refused():
    assert fits(100, 1000)
    assert not fits(1000, 20)
    with pytest.raises(InputError, match="1,000 robots with messages 20 rounds late: the weights do not fit in memory"):
        theory.mixing_variance(theory.mixing_matrix("ring", 1000), 5, 10, 0.5, 0.8, delay=20)
    with pytest.raises(InputError, match="delay = -1: should be from 0"):
        theory.mixing_variance(np.eye(2), 5, 10, 0.5, 0.8, delay=-1)
    data = sc.run(study_of(robots=1000, accuracy=0.8, rounds=30, trials=6, fill_ratio=0.45, message_delay=25))
    assert sc.explain(data, 0).absent == {"mixed": "messages are late, in too large a network"}
