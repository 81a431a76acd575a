"""The law of lone robots, bounds, floors: by hand, by brute force, by SciPy; what is asked wrongly is refused."""

import itertools

import numpy as np
import pytest
from scipy import stats

from swarmcensus import brains, theory
from swarmcensus.support.errors import InputError
from swarmcensus.theory.local import binomial

SENSORS = [(0.7, 0.7), (0.9, 0.6), (1.0, 0.6), (1.0, 1.0), (0.3, 0.4), (0.0, 0.0), (0.5, 0.5), (0.2, 0.8)]


def listed(readings, f, b, w):
    """Chances by estimate: every sequence of readings, seen by the brain itself in CPython."""
    brain = brains.load("minimalistic")
    q = b * f + (1 - w) * (1 - f)
    found = {}
    for sequence in itertools.product((0.0, 1.0), repeat=readings):
        me = brain.robot(b, w)
        for black in sequence:
            brain.functions.observe(me, black, 1.0)
        n = sum(sequence)
        key = round(me.x_hat, 12)
        found[key] = found.get(key, 0.0) + q**n * (1 - q) ** (readings - n)
    return {value: chance for value, chance in found.items() if chance > 0.0}


@pytest.mark.parametrize(("b", "w"), SENSORS)
@pytest.mark.parametrize("f", [0.0, 0.3, 0.55, 1.0])
def test_it_is_what_all_sequences_of_readings_give(b, w, f):
    law, expected = theory.local_law(5, f, b, w), listed(5, f, b, w)
    assert law.chances.sum() == pytest.approx(1.0, abs=1e-14)
    assert dict(zip(law.values.round(12).tolist(), law.chances, strict=True)) == pytest.approx(expected, abs=1e-14)
    mean = sum(value * chance for value, chance in expected.items())
    assert law.mean == pytest.approx(mean, abs=1e-11)
    assert law.variance == pytest.approx(sum((v - mean) ** 2 * c for v, c in expected.items()), abs=1e-11)


def test_by_hand():
    """Two readings of b = w = 0.75 at f = 0.5: one black of two is 0.5, and all else is cut."""
    law = theory.local_law(2, 0.5, 0.75)
    np.testing.assert_allclose(law.values, [0.0, 0.5, 1.0])
    np.testing.assert_allclose(law.chances, [0.25, 0.5, 0.25])
    assert (law.mean, law.variance) == (0.5, 0.125)
    assert [law.at_most(x) for x in (-0.1, 0.0, 0.49, 0.5, 1.0)] == pytest.approx([0.0, 0.25, 0.25, 0.75, 1.0])
    assert [law.quantile(p) for p in (0.0, 0.25, 0.26, 0.75, 0.76, 1.0)] == [0.0, 0.0, 0.5, 0.5, 1.0, 1.0]
    errors = theory.error_law(law, 0.5)
    np.testing.assert_allclose(errors.values, [0.0, 0.5])
    np.testing.assert_allclose(errors.chances, [0.5, 0.5])


@pytest.mark.parametrize(("readings", "b", "w"), [(0, 0.7, 0.7), (9, 0.5, 0.5), (9, 0.2, 0.8)])
def test_who_has_seen_nothing_believes_in_a_half(readings, b, w):
    assert theory.local_law(readings, 0.3, b, w) == (pytest.approx([0.5]), pytest.approx([1.0]))


@pytest.mark.parametrize(("tries", "chance"), [(1, 0.5), (50, 1e-9), (1000, 0.3), (100_000, 0.55), (7, 0.0), (7, 1.0)])
def test_chances_are_binomial(tries, chance):
    np.testing.assert_allclose(binomial(tries, chance), stats.binom.pmf(np.arange(tries + 1), tries, chance), rtol=1e-7,
                               atol=1e-250)  # fmt: skip


def test_several_sensors_are_mixed():
    laws = [theory.local_law(10, 0.55, 0.9), theory.local_law(10, 0.55, 0.5)]
    both = theory.mixed_law(laws)
    assert both.at_most(0.5) == pytest.approx((laws[0].at_most(0.5) + 1.0) / 2)
    assert both.mean == pytest.approx((laws[0].mean + 0.5) / 2)


@pytest.mark.parametrize("bins", [1, 2, 7, 10])
@pytest.mark.parametrize("f", [0.0, 0.3, 0.55, 0.7, 1.0])
def test_the_right_bin_has_its_share(bins, f):
    law = theory.local_law(20, f, 0.75)
    edges = np.arange(bins + 1) / bins
    mine, *each = np.minimum(np.searchsorted(edges, [f, *law.values], side="right") - 1, bins - 1)
    expected = np.bincount(each, weights=law.chances, minlength=bins)[mine]
    assert theory.right_share(law, f, bins) == pytest.approx(expected, abs=1e-15)


def test_normal_shares_and_medians_are_those_of_scipy():
    sd = np.array([0.001, 0.02, 0.3, 0.0])
    for f, (low, high) in {0.55: (0.5, 0.6), 0.95: (0.9, np.inf), 0.05: (-np.inf, 0.1)}.items():
        expected = stats.norm.cdf(high, f, sd[:3]) - stats.norm.cdf(low, f, sd[:3])
        np.testing.assert_allclose(theory.normal_right_share(sd**2, f), [*expected, 1.0], atol=1e-12)
    assert theory.normal_right_share(0.0, 0.55, bias=0.1) == 0.0
    draws = np.random.default_rng(1).normal(0.95, [[0.01, 0.02, 0.3, 2.0]], (200_000, 4)).clip(0, 1)
    expected = np.median(np.abs(draws - 0.95))
    assert theory.normal_median_error(np.array([0.01, 0.02, 0.3, 2.0]) ** 2, 0.95) == pytest.approx(expected, rel=0.02)
    assert theory.normal_median_error([0.04**2], 0.5) == pytest.approx(0.6744897501960817 * 0.04)
    assert theory.median_error(0.04**2) == pytest.approx(0.6744897501960817 * 0.04)


# ---- cramer-Rao bounds: by hand, from the likelihood's own curvature, and against what estimates reach
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


def test_bounds_by_hand():
    """b = w = 0.75 at f = 0.5: q = 1/2, k = 1/2, so a reading tells 1."""
    assert (theory.information(0.5, 0.75), theory.swarm_bound(100, 0.5, 0.75)) == (1.0, 0.01)
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
    assert (theory.information(0.0, 1.0), theory.swarm_bound(5, 0.0, 1.0)) == (np.inf, 0.0)
    assert theory.swarm_bound(5, 0.4, 1.0) == pytest.approx(0.4 * 0.6 / 5)
    assert theory.swarm_bound(5, 0.4, 0.5) == np.inf
    assert theory.swarm_bound(5, 0.4, [0.5, 0.5]) == np.inf


# ---- what theory is asked wrongly is refused in one line, which names the argument
LAW = theory.local_law(5, 0.5, 0.7)
WRONG = [
    (lambda: theory.swarm_bound(0, 0.5, 0.7), "readings = 0"),
    (lambda: theory.information(0.5, "good"), "b = 'good'"),
    (lambda: theory.information(0.5, 10**400), "should be a number"),
    (lambda: theory.information(0.5, [0.7, 0.8], [0.7] * 3), "b has the shape (2,), w (3,)"),
    (lambda: theory.swarm_bound(5, 0.5, [0.7, 0.8], robots=3), "robots = 3"),
    (lambda: theory.neighbourhood_bound([1, 0], 5, 0.5, 0.7), "should be a square"),
    (lambda: theory.neighbourhood_bound(np.eye(2), 5, 0.5, [0.7] * 3), "should be one number, or 2, one a robot"),
    (lambda: theory.median_error(-1), "variance = -1"),
    (lambda: theory.even_concentration(0.5, 10), "readings = 0.5"),
    (lambda: theory.tiles_variance(0.01, 0.5, 10), "concentration = 0.01"),
    (lambda: theory.tiles_variance(0.5, 0.5, 4, drawn="twice"), "should be 'exactly' or 'one by one'"),
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
    (lambda: theory.mixed_sums(np.eye(2), 5, 10, 0.5, 0.5).variance, "b + w = 1 for all robots"),
    (lambda: theory.mixing_matrix("scale-free", 10), "differs from trial to trial"),
    (lambda: theory.mixing_matrix("rign", 10), "did you mean 'ring'?"),
    (lambda: theory.mixing_matrix("ring"), "has no size of its own"),
    (lambda: theory.mixing_matrix("ring", 10_000), "10,000 robots: should be 1 to 4,096"),
]


@pytest.mark.parametrize(("call", "said"), WRONG)
def test_bad_input_is_named(call, said):
    with pytest.raises(InputError) as error:
        call()
    assert said in str(error.value)
    assert "\n" not in str(error.value)


# ---- the finite floor: by hand, by listing all floors, by brute force, and against SciPy's bivariate normal
B, W = 0.9, 0.7
K = B + W - 1


def exactly(visits, floors, truth):
    """The mean of (estimate - truth)^2 over equally likely floors, and over all readings: none is drawn."""
    total, readings = 0.0, sum(visits)
    for colours in floors:
        shown = np.repeat(colours, visits)
        told = np.where(shown, B, 1 - W)  # the chance of black
        mean, variance = (told.mean() - 1 + W) / K, (told * (1 - told)).sum() / readings**2 / K**2
        target = np.mean(colours) if truth == "floor" else truth
        total += variance + (mean - target) ** 2
    return total / len(floors)


def of_sensors(readings, f):
    """The sensors' part of the variance."""
    return (f * B * (1 - B) + (1 - f) * W * (1 - W)) / K**2 / readings


def test_floors_with_so_many_black_tiles():
    """All floors of 6 tiles with 2 black ones."""
    visits, pairs = [3, 1, 0, 2, 0, 1], itertools.combinations(range(6), 2)
    floors = [[m in black for m in range(6)] for black in pairs]
    found = theory.tiles_variance((9 + 1 + 4 + 1) / 49, 2 / 6, 6, drawn="exactly") + of_sensors(7, 2 / 6)
    assert found == pytest.approx(exactly(visits, floors, "floor"), rel=1e-12)
    assert found == pytest.approx(exactly(visits, floors, 2 / 6), rel=1e-12)


def test_floors_of_tiles_drawn_one_by_one():
    """All floors of 5 tiles, each as likely: f = 1/2."""
    visits, floors = [3, 1, 0, 2, 1], list(itertools.product([False, True], repeat=5))
    for truth, target in (("floor", "floor"), ("nominal", 0.5)):
        found = theory.tiles_variance((9 + 1 + 4 + 1) / 49, 0.5, 5, truth=truth) + of_sensors(7, 0.5)
        assert found == pytest.approx(exactly(visits, floors, target), rel=1e-12)
    assert theory.tiles_variance(1 / 40, 0.3, 40, truth="floor") == 0.0
    assert theory.tiles_variance(1.0, 0.3, 1, drawn="exactly") == 0.0


def test_readings_that_fall_anywhere():
    """The concentration of 30 readings on 12 tiles, 20,000 times: within 5 sd."""
    rng = np.random.default_rng(2)
    found = [((np.bincount(rng.integers(12, size=30)) / 30) ** 2).sum() for _ in range(20_000)]
    assert np.mean(found) == pytest.approx(float(theory.even_concentration(30, 12)), abs=5 * np.std(found) / 141)
