"""The bounds on both ends, and robots that mend their sensors, at the level of distributions.

Each test states its error rate: the chance that a right simulator fails it, were the seed not fixed.
"""

import numpy as np
import pytest
from scipy import stats

import swarmcensus as sc
from swarmcensus import brains
from tests.support.small import study_of


@pytest.mark.long(but=["ring"])
@pytest.mark.parametrize("topology", ["ring", "scale-free"])
def test_the_oracles_error_is_as_small_as_can_be(topology):
    """The Cramer-Rao bound 1 / sqrt(sum I), sensors unequal: chi-square of the variance and z of the mean.

    Two-sided at 0.05 % each, so 0.1 % for both. With 3,000 readings the estimate is normal, its variance at the bound,
    to far less than what 400 trials tell.
    """
    trials, robots, rounds, f = 400, 20, 150, 0.4
    rng = np.random.default_rng(1)
    b = w = rng.uniform(0.55, 0.95, robots)
    members = [{"robots": 1, "accuracy": float(one)} for one in b[1:]]
    study = study_of(
        "oracle", robots=robots, accuracy=float(b[0]), assumed_accuracy=0.9, rounds=rounds, looks=1, trials=trials,
        seed=12, members=members, topology=topology, fill_ratio=f, link_success=0.5,
    )  # fmt: skip
    final = sc.run(study)["final_estimate"].values[0, :, 0]
    p = b * f + (1 - w) * (1 - f)
    bound = 1 / (rounds * ((b + w - 1) ** 2 / (p * (1 - p))).sum())
    z = (final.mean() - f) / np.sqrt(bound / trials)
    assert 2 * stats.norm.sf(abs(z)) > 5e-4
    ratio = trials * final.var() / bound
    assert 2 * min(stats.chi2.cdf(ratio, trials), stats.chi2.sf(ratio, trials)) > 5e-4


def test_bayes_cpf_follows_sensors_worse_than_assumed():
    """True 0.75, told 0.8, and the floor known by others: the filter's mean and variance, against theory.

    Of one robot that hears the truth with endless confidence, the update is a Kalman filter on mu: after T updates that
    each use m fresh readings it is within 4 standard deviations of its own variance around 0.75. Error rate 0.01 %.
    """
    brain = brains.load("bayes-cpf").with_parameters({"drift": 0.0, "noise": 0.0, "every": 1.0, "doubt": 0.01})
    functions, chance = brain.functions, np.random.default_rng(16)
    ends = []
    for _ in range(200):
        me = brain.robot(0.8, 0.8)
        for _ in range(20):
            me.t, me.n = 500.0, float(chance.binomial(500, 0.75 * 0.9 + 0.25 * 0.1))
            me.past_x = 0.9
            functions.learn(me)
        ends.append((me.mu - 0.75) / np.sqrt(me.variance))
    assert abs(np.mean(ends)) < 4 / np.sqrt(200) + 0.1  # 0.1: the prior's pull, 0.05 with a variance of 0.01
    ratio = 200 * np.var(ends)
    assert 2 * min(stats.chi2.cdf(ratio, 199), stats.chi2.sf(ratio, 199)) > 1e-4
