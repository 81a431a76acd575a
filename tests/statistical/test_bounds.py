"""The bounds on both ends, and robots that mend their sensors, at the level of distributions.

Each test states its error rate: the chance that a right simulator fails it, were the seed not fixed.
"""

import numpy as np
import pytest
from scipy import stats

import swarmcensus as sc
from swarmcensus import brains
from swarmcensus.simulation import sampling
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


def test_a_robot_alone_is_a_binomial():
    """Its estimate is Eq. 4 of a binomial count, whatever the others do: chi-square over all counts at 0.1 %."""
    study = study_of(
        "alone", robots=40, accuracy={"black": 0.9, "white": 0.7}, rounds=4, looks=3, trials=100, seed=13,
        topology="full", fill_ratio=0.6,
    )  # fmt: skip
    results = sc.run(study)
    assert (results["messages_sent"].values == 0).all()
    assert (results["messages_heard"].values == 0).all()
    values, found = np.unique(results["final_estimate"].values.round(12), return_counts=True)
    n = np.arange(13)
    told = np.clip((n / 12 - 0.3) / 0.6, 0, 1).round(12)
    chances = stats.binom(12, 0.9 * 0.6 + 0.3 * 0.4).pmf(n)
    expected = np.array([chances[told == one].sum() for one in values]) * 4000
    assert expected.sum() == pytest.approx(4000, rel=1e-3)
    many = expected >= 5
    pooled = [np.append(v[many], v[~many].sum()) for v in (found, expected)]
    pooled[1] *= pooled[0].sum() / pooled[1].sum()
    assert stats.chisquare(*(v[pooled[1] > 0] for v in pooled)).pvalue > 1e-3


def mended(wrong, seed, trials=40):
    """Final errors of asdf and the paper's brain (brain, trial), robots of accuracy 0.75 of which some believe 0.95."""
    study = study_of(
        ["minimalistic", {"file": "asdf", "every": 100}], robots=20, accuracy=0.75, rounds=500, trials=trials,
        seed=seed, members=[{"robots": wrong, "assumed_accuracy": 0.95}], topology="full", fill_ratio=0.85,
    )  # fmt: skip
    results = sc.run(study)
    return study, results, np.median(abs(results["final_estimate"].values - 0.85), axis=2)


@pytest.mark.long
def test_asdf_mends_a_minority():
    """Two of twenty are wrong: it is nearer than the paper's brain in most trials (a sign test at 0.1 %), and the
    accuracies that the two mend are near to theirs.

    What they mend is told by 5,000 readings and by x_bar, of which 18 right robots know 90,000 readings: a standard
    deviation of sqrt(0.219/5000) / 0.7 = 0.0095, and 4.5 of these in 80 cases fail with 0.06 %.
    """
    study, results, errors = mended(2, seed=14)
    wins = int((errors[1] < errors[0]).sum())
    assert stats.binomtest(wins, errors.shape[1], 0.5, alternative="greater").pvalue < 1e-3
    setting = study.settings()[1]
    assert setting.brain.name == "asdf"
    off = []
    for trial in range(40):
        who = sampling.groups(setting, 14, trial, 1)[0] == 1
        trace = sc.replay(results, 1, trial)
        assert (trace["mended"].values[-1, who] > 0).all()
        off += list(trace["accuracy"].values[-1, who] - 0.75)
    assert np.abs(off).max() < 0.1
    assert np.median(np.abs(off)) < 0.02


@pytest.mark.long
def test_asdf_makes_a_wrong_majority_no_better():
    """Fourteen of twenty are wrong, and the six that are right come to agree with them: no nearer, at 0.1 %."""
    _, _, errors = mended(14, seed=15)
    worse = int((errors[1] > errors[0]).sum())
    assert stats.binomtest(worse, errors.shape[1], 0.5, alternative="greater").pvalue < 1e-3
    assert brains.load("asdf").parameters["p"] == 0.05


def test_bayes_cpf_follows_sensors_that_are_worse_than_told():
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
