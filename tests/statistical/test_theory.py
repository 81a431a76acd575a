"""Random behaviour at the level of distributions, against theory.

Each test states its error rate: the chance that a right simulator fails it, were the seed not fixed.
"""

import itertools
from math import comb

import numpy as np
import pytest
from scipy import stats

import swarmcensus as sc
from swarmcensus import brains
from swarmcensus.simulation.trials import record_readings
from tests.support.small import study_of

FUNCTIONS = brains.load("minimalistic")
NOBODY = {"name": "nobody", "edges": []}


def chi_square(found, expected):
    """p-value over cells that are pooled until each expects five or more."""
    order = np.argsort(-expected)
    found, expected = found[order], expected[order]
    enough = max(2, int((expected >= 5).sum()))
    pooled = [np.append(v[: enough - 1], v[enough - 1 :].sum()) for v in (found, expected)]
    assert found[expected == 0].sum() == 0
    return stats.chisquare(pooled[0], pooled[1]).pvalue


@pytest.mark.parametrize(
    ("t", "b", "w", "f"),
    [(1, 0.675, 0.675, 0.55), (10, 0.525, 0.525, 0.55), (10, 0.975, 0.975, 0.95), (10, 0.9, 0.6, 0.3),
     (15, 1.0, 1.0, 0.55), (37, 0.7, 0.7, 0.55), (10, 0.3, 0.4, 0.8), (100, 0.75, 0.75, 0.05)],
)  # fmt: skip
def test_exact_distribution_of_the_local_estimator(t, b, w, f):
    """Binomial pushed through Eq. 4: chi-square over the estimates that can occur, error rate 0.1 %."""
    sensor = {"black": b, "white": w}
    lonely = study_of(robots=50, accuracy=sensor, rounds=1, looks=t, trials=200, seed=42, topology=NOBODY, fill_ratio=f)
    estimates = sc.run(lonely)["final_estimate"].values.ravel()
    p = b * f + (1 - w) * (1 - f)
    law: dict[float, float] = {}
    for n in range(t + 1):
        me = FUNCTIONS.robot(b, w)
        FUNCTIONS.functions.observe(me, float(n), float(t))
        FUNCTIONS.functions.fuse(me)
        law[me.x] = law.get(me.x, 0.0) + comb(t, n) * p**n * (1 - p) ** (t - n)
    values = np.array(sorted(law))
    assert np.isin(estimates, values).all()
    found = np.bincount(np.searchsorted(values, estimates), minlength=len(values))
    expected = np.array([law[v] for v in values]) * len(estimates)
    if (expected > 0).sum() > 1:
        assert chi_square(found, expected) > 1e-3


@pytest.mark.parametrize("looks", [4, 17])
def test_single_readings_are_coin_flips(looks):
    """One binomial and a random order of it are R independent flips: all patterns of 4 flips occur at their rates.

    Chi-square, error rate 0.1 %; windows cross the round's parts where R is larger than one word serves.
    """
    p = 0.675 * 0.55 + 0.325 * 0.45
    (flips,) = study_of(robots=50, accuracy=0.675, rounds=400, looks=looks).settings()
    readings = record_readings(flips, 3, 0).reshape(400, looks, 50)
    windows = readings[:, :4] if looks == 4 else readings[:, 12:16]
    codes = (windows * np.array([8, 4, 2, 1])[:, np.newaxis]).sum(axis=1).astype(int).ravel()
    expected = [p ** sum(pattern) * (1 - p) ** (4 - sum(pattern)) for pattern in itertools.product((0, 1), repeat=4)]
    assert chi_square(np.bincount(codes, minlength=16), np.array(expected) * len(codes)) > 1e-3


def test_long_runs_converge_at_the_fisher_rate():
    """A lone robot's error over its Fisher standard error is N(0, 1): KS against it, error rate 0.1 %."""
    lonely = study_of(robots=50, accuracy=0.8, rounds=4000, trials=40, seed=42, topology=NOBODY)
    estimates = sc.run(lonely)["final_estimate"].values.ravel()
    p = 0.8 * 0.55 + 0.2 * 0.45
    information = 40_000 * 0.6**2 / (p * (1 - p))
    assert stats.kstest((estimates - 0.55) * np.sqrt(information), "norm").pvalue > 1e-3


def test_heterogeneous_robots_are_weighed_by_their_information():
    """The pooled estimate of robots with known, differing sensors has the variance 1 / (sum of informations)."""
    mixed = study_of(robots=20, accuracy="U(0.525, 0.975)", rounds=200, trials=400, seed=42, topology="full")
    estimates = sc.run(mixed)["final_estimate"].values[0, :, 0]
    b, _ = mixed.settings()[0].accuracy.draw(42, "accuracy", 0, 400, 20)
    p = b * 0.55 + (1 - b) * 0.45
    information = (2000 * (2 * b - 1) ** 2 / (p * (1 - p))).sum(axis=1)
    assert stats.kstest((estimates - 0.55) * np.sqrt(information), "norm").pvalue > 1e-3


def test_readings_of_rounds_and_robots_are_independent():
    """Black counts of consecutive rounds and of two robots are uncorrelated: 4 standard errors, error rate 0.02 %."""
    (trial,) = study_of(robots=2, accuracy=0.675, rounds=2000, trials=1, seed=42).settings()
    blacks = record_readings(trial, 42, 0).reshape(2000, 10, 2).sum(axis=1)
    for one, other in ((blacks[:-1, 0], blacks[1:, 0]), (blacks[:, 0], blacks[:, 1])):
        assert abs(np.corrcoef(one, other)[0, 1]) < 4 / np.sqrt(2000)
