"""Intervals over trials, against the formulas of textbooks; and the bootstrap against theory."""

import tracemalloc

import numpy as np
import pytest
from scipy import stats

from swarmcensus.support import intervals
from swarmcensus.support.intervals import estimate

RNG = np.random.default_rng(12)
NORMAL = RNG.normal(size=(30, 1)) + 0.5 * RNG.normal(size=(30, 9))


@pytest.mark.parametrize("level", [0.95, 0.99])
@pytest.mark.parametrize("trials", [6, 30, 200])
def test_interval_of_a_binary_share(trials, level):
    """Clopper and Pearson's, from the quantiles of the beta distribution, to half a trial, or one and a half."""
    tail = (1 - level) / 2
    for hits in range(trials + 1):
        values = (np.arange(trials) < hits)[:, np.newaxis].astype(float)
        share, low, high = estimate(values, "mean", share=True, level=level)
        assert share == pytest.approx(hits / trials)
        exact = stats.beta.ppf(tail, hits, trials - hits + 1), stats.beta.ppf(1 - tail, hits + 1, trials - hits)
        for end, other in ((low, exact[0] if hits else 0.0), (high, exact[1] if hits < trials else 1.0)):
            assert end * trials == pytest.approx(other * trials, abs=0.5 if level == 0.95 else 1.5)


def test_rounding_is_no_spread():
    robots = np.array([0.1, 0.2, 0.3, 0.7, 1e-3, 0.123])
    values = np.array([np.random.default_rng(k).permutation(robots) for k in range(40)])
    assert np.ptp(values.mean(axis=1)) > 0  # sums in another order
    _, low, high = estimate(values, "mean")
    assert high - low > 0.1


@pytest.mark.parametrize("trials", [6, 30, 1000])
@pytest.mark.parametrize("value", [0.0, 0.1, 1 / 3, 1.0, 17.0, -1 / 3])
def test_interval_of_equal_trials(value, trials):
    """Each trial in q may differ by 1 and yet none of n does so with a chance of 5 %: (1 - q)^n = 0.05."""
    values = np.full((trials, 7), value)
    for statistic in ("median", "mean"):
        found, low, high = estimate(values, statistic)
        assert found == pytest.approx(value)
        assert (1 - (high - low) / 2) ** trials == pytest.approx(0.05)
    if 0.0 <= value <= 1.0:
        _, low, high = estimate(values, "mean", share=True)
        assert high - low > 1 / trials


def test_what_is_missing_or_too_little_has_no_interval():
    values = NORMAL.copy()
    values[3, 2] = np.nan
    assert np.isnan(estimate(values, "mean")).all()
    assert np.isnan(estimate(np.empty((0, 3)), "median")).all()
    value, low, high = estimate(NORMAL[:5], "mean")
    assert value == NORMAL[:5].mean()
    assert np.isnan([low, high]).all()
    assert np.isfinite(estimate(NORMAL[:6], "mean")).all()
    with pytest.raises(ValueError, match="should be 'median' or 'mean'"):
        estimate(NORMAL, "mode")


def test_pooled_trials_have_the_robots_of_all_settings():
    values = np.arange(12.0).reshape(2, 3, 2)
    assert intervals.pooled(values).tolist() == [[0, 1, 6, 7], [2, 3, 8, 9], [4, 5, 10, 11]]
    values[:, 2] = values[1, :, 1] = np.nan  # a trial that was not run, and a robot that there is not
    assert intervals.pooled(values).tolist() == [[0, 1, 6], [2, 3, 8]]
    values[0, 1] = np.nan
    assert intervals.pooled(values) is None


def test_memory_of_a_bootstrap_of_medians():
    """400 trials of 250 robots, against each of which were 160 MB."""
    values = np.random.default_rng(4).normal(size=(400, 250))
    counts = intervals.resample(400, 100)
    tracemalloc.start()
    intervals.medians(values, counts)
    _, peak = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    assert peak < 12 * (values.nbytes + counts.nbytes)


# ---- the same formulas, forwards and by brute force
SHARES = {
    "alone": np.random.default_rng(5).binomial(40, 0.7, 25) / 40,
    "together": np.random.default_rng(6).binomial(4, 0.5, 12) / 4,
    "near 1": 1 - np.random.default_rng(7).binomial(20, 0.02, 50) / 20,
    "near 0": np.random.default_rng(7).binomial(20, 0.03, 18) / 20,
    "few bad": np.where(np.arange(30) < 2, 0.3, 1.0),
    "seven": np.array([0.5, 0.6, 0.6, 0.7, 0.55, 0.65, 0.6]),
}


def tries_of(by_trial, level):
    """The trials over the design effect, which is trusted the more, the more trials make up the variance."""
    trials, share = len(by_trial), by_trial.mean()
    if np.ptp(by_trial) < 1e-12:
        return trials
    design = min(1.0, by_trial.var(ddof=1) / (share * (1 - share)))
    bearing = trials / stats.kurtosis(by_trial, fisher=False)
    fewer = (stats.norm.ppf((1 + level) / 2) / stats.t.ppf((1 + level) / 2, trials - 1)) ** 2
    return trials * max(1.0, fewer / design ** (bearing / (1 + bearing)))


@pytest.mark.parametrize("level", [0.95, 0.99])
@pytest.mark.parametrize("name", SHARES)
def test_ends_of_a_share_are_so_many_standard_errors_away(name, level):
    """Wilson's condition itself: (share - end)^2 = z^2 end (1 - end) / tries, of a share that was moved outwards."""
    by_trial = SHARES[name]
    value, low, high = estimate(by_trial[:, np.newaxis], "mean", share=True, level=level)
    z, tries = stats.norm.ppf((1 + level) / 2), tries_of(by_trial, level)
    lean = (z**2 - 1) / 6 * (2 * value - 1)  # of the binomial distribution, whose skewness is -lean
    for end, side in ((low, -1), (high, 1)):
        moved = value + side * max(0.0, 0.5 + side * lean) / tries
        assert (moved - end) ** 2 == pytest.approx(z**2 * end * (1 - end) / tries, rel=0.01)
        assert (end - moved) * side > 0


@pytest.mark.parametrize("trials", [6, 9, 40])
def test_interval_of_a_mean(trials):
    """The transformation itself takes each end to Student's quantile: x + g x^2 / 3 + g^2 x^3 / 27 + g / 6."""
    for values in (np.exp(NORMAL[:trials]), np.exp(-NORMAL[:trials]), np.tile(NORMAL[:trials], (2, 1)) ** 3):
        by_trial = values.mean(axis=1)
        mean, low, high = estimate(values, "mean")
        g = stats.skew(by_trial) / np.sqrt(len(by_trial))
        beyond = stats.t.ppf(0.975, len(by_trial) - 1)
        for end, quantile in ((low, beyond), (high, -beyond)):
            x = (mean - end) / stats.sem(by_trial)
            assert x + g * x**2 / 3 + g**2 * x**3 / 27 + g / 6 == pytest.approx(quantile, rel=2e-3)


@pytest.mark.parametrize(("trials", "robots"), [(6, 1), (7, 5), (24, 1), (25, 4), (40, 3)])
@pytest.mark.parametrize("ties", [False, True])
def test_ends_of_a_median_are_those_of_trying_every_value(trials, robots, ties):
    rng = np.random.default_rng(trials)
    values = rng.normal(size=(trials, 1)) + rng.normal(size=(trials, robots))
    if ties:
        values = np.round(values)
    z = stats.norm.ppf(0.975)

    def clearly_less_than_half(share):
        tries = tries_of(share.mean(axis=1), 0.95)
        return share.mean(axis=1).mean() < 0.5 - 0.5 / tries - z * np.sqrt(0.25 / tries)

    every = np.unique(values)
    low = min(m for m in every if not clearly_less_than_half(values <= m))
    high = max(m for m in every if not clearly_less_than_half(values >= m))
    if low == high:
        room = min(abs(m - low) for m in every if m != low) / 2
        low, high = low - room, high + room
    assert estimate(values, "median") == (np.median(values), low, high)


def test_an_interval_is_the_middle_of_its_resamples():
    statistic = np.concatenate([[3.0], np.arange(1001.0)])
    assert intervals.interval(statistic) == pytest.approx((3.0, 25.0, 975.0))
    assert intervals.interval(statistic, 0.9) == pytest.approx((3.0, 50.0, 950.0))


# ---- the bootstrap
def test_median_of_a_resample():
    rng = np.random.default_rng(1)
    for trials, robots in ((1, 1), (2, 3), (7, 4), (30, 11)):
        values = rng.integers(0, 9, (trials, robots)) + rng.choice([0.0, 0.5], (trials, 1))  # many ties
        counts = intervals.resample(trials, 50)
        written_out = [np.median(np.repeat(values, row.astype(int), axis=0)) for row in counts]
        np.testing.assert_array_equal(intervals.medians(values, counts), written_out)


def test_resamples_are_repeatable():
    counts = intervals.resample(30)
    assert counts.shape == (1001, 30)
    assert (counts[0] == 1).all()
    assert (counts.sum(axis=1) == 30).all()
    np.testing.assert_array_equal(counts, intervals.resample(30))
    assert np.mean(counts[1:] == 0) == pytest.approx((29 / 30) ** 30, abs=0.01)
    with pytest.raises(ValueError, match="should be 1 or more"):
        intervals.resample(0)


def test_shares_have_wilsons_interval():
    for hits, found in ((30, (1.0, 0.8865, 1.0)), (0, (0.0, 0.0, 0.1135)), (15, (0.5, 0.3315, 0.6685))):
        assert intervals.share_interval(hits, 30) == pytest.approx(found, abs=1e-4)
