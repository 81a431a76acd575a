"""Robots that do not know their sensors: ASDF and BayesCPF, by hand, by brute force and as compiled."""

import math

import numpy as np
import pytest
from scipy import special, stats

from swarmcensus import brains

ASDF, CPF, PAPER = (brains.load(name) for name in ("asdf", "bayes-cpf", "minimalistic"))


def robot(brain, b, w, **given):
    return brain.with_parameters(given).robot(b, w)


@pytest.mark.parametrize("m", [1, 2, 3, 4, 5, 8, 19, 20, 99, 400, 1001])
def test_the_middle_of_students_t_is_that_of_scipy(m):
    """The finite sums, to 2e-14."""
    for t in np.concatenate([np.geomspace(1e-9, 60.0, 200), [0.0]]):
        exact = float(special.betainc(0.5, m / 2, t * t / (m + t * t)))
        assert ASDF.functions.within(float(t), float(m)) == pytest.approx(exact, abs=2e-14)


@pytest.mark.parametrize("p", [0.05, 0.25, 0.9])
def test_the_rule_is_that_of_the_quantile(p):
    """T upper quantile at (1 - p)/2, sd with m - 1: brute force over estimates drawn at random."""
    chance, counts = np.random.default_rng(3), [0, 0]
    for _ in range(400):
        heard = chance.beta(5.0, 3.0, chance.integers(1, 12))
        me = robot(ASDF, 0.8, 0.8, p=p)
        me.x_hat = chance.beta(5.0, 3.0)
        for x in heard:
            ASDF.functions.receive(me, (x, chance.uniform(1.0, 100.0)))
        ASDF.functions.fuse(me)
        m = len(heard)
        apart = False
        if m > 1:
            quantile = stats.t.ppf(1 - (1 - p) / 2, m)
            apart = bool(abs(heard.mean() - me.x_hat) >= heard.std(ddof=1) * (quantile / math.sqrt(m) + 1))
        assert ASDF.functions.is_apart(me) == apart
        counts[apart] += 1
    assert min(counts) > 40


def test_asdf_mends_by_hand():
    """Assumed 0.9, 40 of 100 black, neighbours certain of 0.8: b = w = (0.4 + 0.8 - 1) / 0.6 = 1/3, and x_hat 0.8."""
    me = robot(ASDF, 0.9, 0.9, every=3.0)
    ASDF.functions.observe(me, 40.0, 100.0)
    assert me.x_hat == pytest.approx((0.4 - 0.1) / 0.8)
    for _ in range(3):
        assert me.mended == 0.0
        for x in (0.79, 0.8, 0.81):
            ASDF.functions.receive(me, (x, 50.0))
        ASDF.functions.fuse(me)
    assert me.mended == 1.0
    assert me.accuracy == pytest.approx(1.0 / 3.0)
    assert me.x_hat == pytest.approx(0.8)
    assert me.b == 0.9  # what it was told stays
    n, t, a = 40.0, 100.0, 1.0 / 3.0
    assert me.alpha == pytest.approx((2 * a - 1) ** 2 * t**3 / (n * (t - n)))


def test_the_filters_step_is_that_of_a_numerical_linearisation():
    """C is the derivative of m p, the variance that of a binomial, the gain that of the scalar filter."""
    chance = np.random.default_rng(5)
    for _ in range(50):
        mu, x, variance, m = chance.uniform(0.2, 0.9), chance.random(), 10 ** chance.uniform(-6, -2), 1000.0
        n = m * chance.uniform(0.3, 0.7)
        me = robot(CPF, mu, mu, drift=-1e-4, noise=1e-7, every=5.0, doubt=variance)
        me.t, me.n, me.past_x = m, n, x
        CPF.functions.learn(me)
        before, doubt = mu - 5e-4, variance + 5e-7

        def expected(a, x=x, m=m):
            return m * (x * a + (1 - x) * (1 - a))

        slope = (expected(before + 1e-4) - expected(before - 1e-4)) / 2e-4
        p = expected(before) / m
        spread = m * p * (1 - p)
        sure = 1 / doubt + slope**2 / spread
        exact = (before / doubt + slope * (n - expected(before) + slope * before) / spread) / sure  # of both normals
        assert me.mu == pytest.approx(min(max(exact, 0.0), 1.0), abs=1e-9)
        assert me.variance == pytest.approx(1 / sure, rel=1e-9)
        assert spread == pytest.approx(m * ((2 * before - 1) ** 2 * (x - x * x - 0.25) + 0.25))  # as published


def test_what_is_believed_is_the_mean_of_a_truncated_normal():
    for mu in (0.3, 0.499, 0.5, 0.7, 0.98, 1.0):
        for sd in (0.001, 0.05, 0.4):
            me = robot(CPF, 0.8, 0.8, truncated=1.0)
            me.mu, me.variance = mu, sd * sd
            exact = stats.truncnorm((0.5 - mu) / sd, (1 - mu) / sd, mu, sd).mean()
            near = stats.norm(mu, sd).cdf(1) - stats.norm(mu, sd).cdf(0.5) > 1e-9
            assert CPF.functions.believed(me) == pytest.approx(exact if near else 0.5, abs=1e-6)
            plain = robot(CPF, 0.8, 0.8)
            plain.mu, plain.variance = mu, sd * sd
            assert CPF.functions.believed(plain) == min(max(mu, 0.5), 1.0)


def test_counts_are_forgotten_bit_by_bit():
    """Brute force: each reading, the k-th last, weighs (1 - 1/window)^k."""
    readings = np.random.default_rng(7).integers(0, 2, 300)
    me = robot(CPF, 0.8, 0.7, window=40.0)
    for one in readings:
        CPF.functions.observe(me, float(one), 1.0)
    weights = (1 - 1 / 40) ** np.arange(300)[::-1]
    assert me.t == pytest.approx(weights.sum())
    assert me.n == pytest.approx((weights * readings).sum())
    assert me.x_hat == pytest.approx(min(max((me.n / me.t - 0.3) / 0.5, 0.0), 1.0))


def test_the_older_consensus_is_a_mean_of_means():
    """Brute force: plain means of the first ten, and then a tenth of each that comes, twice."""
    estimates = np.random.default_rng(8).random(60)

    def running(values):
        kept = (1 - 1 / 10) ** np.arange(len(values))
        plain = [np.mean(values[: k + 1]) for k in range(10)]
        parts = ((values[10 : k + 1][::-1] * kept[: k - 9]).sum() / 10 for k in range(10, len(values)))
        later = [plain[-1] * old + part for old, part in zip(kept[1:], parts, strict=False)]
        return np.array(plain + later)

    me = robot(CPF, 0.8, 0.8, past=10.0)
    for x, told in zip(estimates, running(running(estimates)), strict=True):
        me.x = x
        CPF.functions.remember(me)
        assert me.past_x == pytest.approx(told, abs=1e-12)
