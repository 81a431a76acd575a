"""Cramer-Rao bounds: by hand, from the likelihood's own curvature, and against what estimates reach."""

import numpy as np
import pytest

from swarmcensus import theory


@pytest.mark.parametrize(("b", "w", "f"), [(0.7, 0.7, 0.55), (0.9, 0.6, 0.2), (0.3, 0.3, 0.95), (1.0, 0.8, 0.5)])
def test_information_is_expected_curvature(b, w, f):
    def q(x):
        return b * x + (1 - w) * (1 - x)

    h = 1e-4
    curvature = 0.0
    for chance, likelihood in ((q(f), q), (1 - q(f), lambda x: 1 - q(x))):
        logs = [np.log(likelihood(x)) for x in (f - h, f, f + h)]
        curvature -= chance * (logs[0] - 2 * logs[1] + logs[2]) / h**2
    assert theory.information(f, b, w) == pytest.approx(curvature, rel=1e-4)
    assert theory.reading_variance(f, b, w) == pytest.approx(1 / curvature, rel=1e-4)


def test_by_hand():
    """b = w = 0.75 at f = 0.5: q = 1/2, k = 1/2, so a reading tells 1."""
    assert theory.information(0.5, 0.75) == 1.0
    assert theory.robot_bound(100, 0.5, 0.75) == 0.01
    np.testing.assert_allclose(theory.swarm_bound([1, 100], 0.5, 0.75, robots=4), [0.25, 0.0025])
    hears = [[1, 1, 0], [1, 1, 1], [0, 1, 0]]  # a robot hears itself, whatever the matrix says
    np.testing.assert_allclose(theory.neighbourhood_bound(hears, 10, 0.5, 0.75), [1 / 20, 1 / 30, 1 / 20])


def test_unequal_sensors_add_up_what_they_tell():
    b, w = np.array([0.9, 0.5, 0.8]), np.array([0.6, 0.5, 0.9])
    told = theory.information(0.3, b, w)
    assert told[1] == 0.0
    assert theory.swarm_bound(7, 0.3, b, w) == pytest.approx(1 / (7 * told.sum()))
    line = theory.mixing_matrix("line", 3)
    expected = 1 / (np.array([[2], [4]]) * [told[0], told.sum(), told[2]])
    np.testing.assert_allclose(theory.neighbourhood_bound(line, [2, 4], 0.3, b, w), expected)
    two_trials = theory.swarm_bound([1, 2], 0.3, np.stack([b, b]), np.stack([w, w]))
    np.testing.assert_allclose(two_trials, np.outer([1, 0.5], [1, 1]) / told.sum())


def test_perfect_sensors_and_blind_ones():
    assert theory.information(0.0, 1.0) == np.inf
    assert theory.robot_bound(5, 0.0, 1.0) == 0.0
    assert theory.robot_bound(5, 0.4, 1.0) == pytest.approx(0.4 * 0.6 / 5)
    assert theory.robot_bound(5, 0.4, 0.5) == np.inf
    assert theory.swarm_bound(5, 0.4, [0.5, 0.5]) == np.inf
