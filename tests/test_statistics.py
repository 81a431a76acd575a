"""Intervals over trials, against the formulas of textbooks."""

import tracemalloc

import numpy as np
import pytest
from scipy import stats

from swarmcensus import statistics
from swarmcensus.statistics import interval_of

RNG = np.random.default_rng(12)
NORMAL = RNG.normal(size=(30, 1)) + 0.5 * RNG.normal(size=(30, 9))


@pytest.mark.parametrize("level", [0.95, 0.99])
@pytest.mark.parametrize("trials", [6, 30, 200])
def test_trials_that_are_right_or_wrong_have_nearly_the_exact_interval(trials, level):
    """Clopper and Pearson's, from the quantiles of the beta distribution, to half a trial, or one and a half."""
    tail = (1 - level) / 2
    for hits in range(trials + 1):
        values = (np.arange(trials) < hits)[:, np.newaxis].astype(float)
        share, low, high = interval_of(values, "mean", share=True, level=level)
        assert share == pytest.approx(hits / trials)
        exact = stats.beta.ppf(tail, hits, trials - hits + 1), stats.beta.ppf(1 - tail, hits + 1, trials - hits)
        for end, other in ((low, exact[0] if hits else 0.0), (high, exact[1] if hits < trials else 1.0)):
            assert end * trials == pytest.approx(other * trials, abs=0.5 if level == 0.95 else 1.5)


def test_all_right_is_nearly_wilsons():
    for value in (0, 1):
        found = interval_of(np.full((30, 1), float(value)), "mean", share=True)
        assert found == pytest.approx(statistics.share_interval(30 * value, 30), abs=2e-3)


def test_robots_that_err_alone_say_more_than_robots_that_err_together():
    alone = RNG.binomial(100, 0.9, (100, 1)) / 100
    together = (RNG.random((100, 1)) < 0.9).astype(float)
    half = [np.ptp(interval_of(values, "mean", share=True)[1:]) / 2 for values in (alone, together)]
    assert half[0] == pytest.approx(1.96 * np.sqrt(0.09 / 10_000), rel=0.25)
    assert half[1] == pytest.approx(1.96 * np.sqrt(0.09 / 100), rel=0.25)


def test_the_mean_of_what_is_symmetric_has_students_interval():
    for trials in (8, 30, 300):
        values = np.concatenate([NORMAL[: trials // 2, 0], -NORMAL[: trials // 2, 0]])[:, np.newaxis]
        _, low, high = interval_of(values, "mean")
        exact = stats.t.interval(0.95, len(values) - 1, 0.0, stats.sem(values[:, 0]))
        assert (low, high) == pytest.approx(exact, rel=1e-3)


def test_the_interval_of_a_skewed_mean_reaches_to_where_the_tail_is():
    values = np.exp(NORMAL)
    mean, low, high = interval_of(values, "mean")
    assert high - mean > 1.2 * (mean - low)
    assert interval_of(-values, "mean") == pytest.approx((-mean, -high, -low))


def test_the_median_of_lone_robots_has_the_interval_of_the_sign_test():
    """The 10th to the 21st of 30 values hold the median in 95.7 % of cases, the 11th to the 20th in 90.1 %."""
    values = RNG.permutation(30).astype(float)[:, np.newaxis]
    assert interval_of(values, "median") == (14.5, 9.0, 20.0)
    assert interval_of(values[values[:, 0] < 8], "median") == (3.5, 0.0, 7.0)


def test_the_interval_of_a_median_is_that_of_any_scale():
    low_and_high = interval_of(NORMAL[:, :5], "median")[1:]
    assert interval_of(np.exp(NORMAL[:, :5]), "median")[1:] == tuple(np.exp(low_and_high))
    assert interval_of(-NORMAL[:, :5], "median")[1:] == (-low_and_high[1], -low_and_high[0])


@pytest.mark.parametrize("statistic", ["median", "mean"])
def test_robots_that_repeat_one_another_add_no_certainty(statistic):
    alone = interval_of(NORMAL[:, :1], statistic)
    assert interval_of(np.repeat(NORMAL[:, :1], 50, axis=1), statistic) == pytest.approx(alone, rel=1e-9)
    right = NORMAL[:, :1] > -1
    assert interval_of(np.repeat(right, 50, axis=1), "mean", share=True) == interval_of(right, "mean", share=True)


@pytest.mark.parametrize("trials", [6, 30, 1000])
@pytest.mark.parametrize("value", [0.0, 0.1, 1 / 3, 1.0, 17.0])
def test_equal_trials_have_an_interval_of_what_may_not_have_been_seen(value, trials):
    """Each trial in q may differ by 1 and yet none of n does so with a chance of 5 %: (1 - q)^n = 0.05."""
    values = np.full((trials, 7), value)
    for statistic in ("median", "mean"):
        found, low, high = interval_of(values, statistic)
        assert found == pytest.approx(value)
        assert (1 - (high - low) / 2) ** trials == pytest.approx(0.05)
    if value <= 1.0:
        _, low, high = interval_of(values, "mean", share=True)
        assert high - low > 1 / trials


def test_rounding_is_no_spread():
    robots = np.array([0.1, 0.2, 0.3, 0.7, 1e-3, 0.123])
    values = np.array([np.random.default_rng(k).permutation(robots) for k in range(40)])
    assert np.ptp(values.mean(axis=1)) > 0  # sums in another order
    _, low, high = interval_of(values, "mean")
    assert high - low > 0.1


def test_a_median_on_equal_values_is_known_to_half_way_to_the_next_ones():
    values = np.full((30, 4), 12.0)
    values[:3, 0], values[3:6, 0] = 10.0, 13.0
    assert interval_of(values, "median") == (12.0, 11.5, 12.5)


def test_what_is_missing_or_too_little_has_no_interval():
    values = NORMAL.copy()
    values[3, 2] = np.nan
    assert np.isnan(interval_of(values, "mean")).all()
    assert np.isnan(interval_of(np.empty((0, 3)), "median")).all()
    value, low, high = interval_of(NORMAL[:5], "mean")
    assert value == NORMAL[:5].mean()
    assert np.isnan([low, high]).all()
    assert np.isfinite(interval_of(NORMAL[:6], "mean")).all()
    with pytest.raises(ValueError, match="should be 'median' or 'mean'"):
        interval_of(NORMAL, "mode")


def test_a_bootstrap_of_medians_needs_memory_of_the_order_of_its_values_and_its_draws():
    """400 trials of 250 robots, against each of which were 160 MB."""
    values = np.random.default_rng(4).normal(size=(400, 250))
    counts = statistics.resample(400, 100)
    tracemalloc.start()
    statistics.medians(values, counts)
    _, peak = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    assert peak < 12 * (values.nbytes + counts.nbytes)
