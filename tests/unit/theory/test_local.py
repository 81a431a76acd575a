"""The local estimate's exact law: by hand, by listing all readings, against SciPy and against runs.

Tests of runs state their error rate: the chance that a right simulator fails them, were the seed not fixed.
"""

import itertools

import numpy as np
import pytest
from scipy import stats

from swarmcensus import brains, theory
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
    np.testing.assert_allclose(
        binomial(tries, chance), stats.binom.pmf(np.arange(tries + 1), tries, chance), rtol=1e-7, atol=1e-250
    )


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
