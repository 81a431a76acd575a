"""What theory is asked wrongly is refused in one line, which names the argument."""

import numpy as np
import pytest

from swarmcensus import theory
from swarmcensus.support.errors import InputError

LAW = theory.local_law(5, 0.5, 0.7)
TWO = [0.1, 0.2]
WRONG = [
    (lambda: theory.robot_bound(0, 0.5, 0.7), "readings = 0"),
    (lambda: theory.robot_bound([1, 2, 3], TWO, 0.7), "readings has the shape (3,), fill_ratio (2,), b (), w ()"),
    (lambda: theory.information(0.5, "good"), "b = 'good'"),
    (lambda: theory.information(0.5, 10**400), "should be a number"),
    (lambda: theory.information(0.5, [0.7, 0.8], [0.7] * 3), "b has the shape (2,), w (3,)"),
    (lambda: theory.swarm_bound(5, 0.5, [0.7, 0.8], robots=3), "robots = 3"),
    (lambda: theory.neighbourhood_bound([1, 0], 5, 0.5, 0.7), "should be a square"),
    (lambda: theory.neighbourhood_bound(np.eye(2), 5, 0.5, [0.7] * 3), "should be one number, or 2, one a robot"),
    (lambda: theory.median_error(-1), "variance = -1"),
    (lambda: theory.sensing_variance(10, 0.5, 0.5), "b + w = 1"),
    (lambda: theory.even_concentration(0.5, 10), "readings = 0.5"),
    (lambda: theory.tiles_variance(0.01, 0.5, 10), "concentration = 0.01"),
    (lambda: theory.tiles_variance(0.5, 0.5, 4, drawn="twice"), "should be 'exactly' or 'one by one'"),
    (lambda: theory.concentration([1, -1]), "visits"),
    (lambda: theory.local_law(2.5, 0.5, 0.7), "readings = 2.5"),
    (lambda: theory.local_law(5, 0.5, 0.7, np.nan), "w = nan: should have no NaN in it"),
    (lambda: theory.local_law(5, 0.5, [0.7, 0.8]), "b has several numbers: should be one"),
    (lambda: theory.local_law(5, 0.5, [[0.7], [0.7, 0.8]]), "b = [[0.7], [0.7, 0.8]]: should be a number"),
    (lambda: LAW.quantile(2), "share = 2: should be from 0 to 1"),
    (lambda: theory.mixed_law([]), "should contain a law"),
    (lambda: theory.mixed_law(LAW), "laws: should be a list of laws"),
    (lambda: theory.right_share(LAW, 0.5, 0), "bins = 0: should be from 1"),
    (lambda: theory.cut_off(np.inf, 0.5), "variance: should be finite"),
    (lambda: theory.normal_median_error(1.0, 0.5), "variances: should be numbers from 0 on, one a robot"),
    (lambda: theory.relaxation_time(np.eye(2)), "the network is not connected"),
    (lambda: theory.stationary_law(theory.mixing_matrix([(0, 1)], directed=True)), "nothing from robot 1 ever reaches"),
    (lambda: theory.variance_factors([[0.5, 0.6], [0.5, 0.5]], 3), "the weights of row 0 sum to 1.1"),
    (lambda: theory.variance_factors([[1.5, -0.5], [0, 1]], 3), "matrix has a negative weight"),
    (lambda: theory.variance_factors([[1.0, 0.0]], 3), "should be a square"),
    (lambda: theory.variance_factors(np.eye(2), []), "rounds = []: should hold a number"),
    (lambda: theory.mixing_variance(np.eye(2), 5, 10, 0.5, 0.5), "b + w = 1 for all robots"),
    (lambda: theory.mixing_variance(np.eye(2), 5, 10, 0.5, 0.8, delay=-1), "delay = -1: should be from 0"),
    (lambda: theory.mixing_matrix("scale-free", 10), "differs from trial to trial"),
    (lambda: theory.mixing_matrix("rign", 10), "did you mean 'ring'?"),
    (lambda: theory.mixing_matrix("ring"), "has no size of its own"),
    (lambda: theory.mixing_matrix("ring", 10_000), "10,000 robots: should be 1 to 4,096"),
    (lambda: theory.relaxation_of([1, 1.5]), "spectrum: should be the eigenvalues of W, one a robot, from -1 to 1"),
]


@pytest.mark.parametrize(("call", "said"), WRONG)
def test_bad_input_is_named(call, said):
    with pytest.raises(InputError) as error:
        call()
    assert said in str(error.value)
    assert "\n" not in str(error.value)
