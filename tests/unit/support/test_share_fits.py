"""Curves of shares through several sizes: on the truth on average, with intervals that hold, and finite."""

import numpy as np
import pytest

from swarmcensus.search.planning.goals import Goal
from swarmcensus.studies import Wanted
from swarmcensus.support.share_fits import fit_shares

SIZES = (42, 50, 60, 72, 86)


def true(size):
    """The share of normal estimates of variance 1 / size within a distance of 0; 0.95 at 60."""
    return Goal(Wanted(error=1.959964 / 60**0.5)).normal_share(size**-0.5, 0.5)


def trials_of(shares, trials):
    return [(np.arange(trials) < round(share * trials)).astype(float) for share in shares]


def test_a_fit_is_on_the_truth_and_its_interval_holds():
    """The mean over 400 fits has a standard error of 0.04 points, and 369 of 400 intervals hold in 99 of 100 cases."""
    rng, values, held = np.random.default_rng(8), [], 0
    for _ in range(400):
        fit = fit_shares(SIZES, [(rng.random(200) < true(size)).astype(float) for size in SIZES])
        value, low, high = fit.at(60)
        values.append(value)
        held += low <= 0.95 <= high
    assert abs(np.mean(values) - 0.95) <= 0.002
    assert np.std(values) <= 0.008  # 200 trials of one size: 0.0154
    assert held >= 369


def test_exact_shares_are_on_the_curve():
    fit = fit_shares(SIZES, trials_of(map(true, SIZES), 1_000_000))
    assert fit.slope == pytest.approx(0.5, abs=1e-3)
    for size in (30, 60, 100):
        assert fit.at(size).value == pytest.approx(true(size), abs=1e-4)


@pytest.mark.parametrize(
    "shares", [[1] * 5, [0] * 5, [0.9, 1, 1, 1, 1], [0, 0, 1, 1, 1], [0.99, 0.98, 0.97, 0.96, 0.95]]
)
def test_fits_are_finite_whatever_the_trials_say(shares):
    fit = fit_shares(SIZES, trials_of(shares, 40))
    for size in (1, *SIZES, 1000):
        value, low, high = fit.at(size)
        assert 0 < low <= value <= high < 1
