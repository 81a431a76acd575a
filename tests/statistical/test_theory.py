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
from tests.support.small import settings_of, study_of
from tests.support.trials import record_trial

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


@pytest.mark.parametrize(("t", "b", "w", "f"), [
    (1, 0.675, 0.675, 0.55), (10, 0.525, 0.525, 0.55), (10, 0.975, 0.975, 0.95), (10, 0.9, 0.6, 0.3),
    (15, 1.0, 1.0, 0.55), (37, 0.7, 0.7, 0.55), (10, 0.3, 0.4, 0.8), (100, 0.75, 0.75, 0.05),
])  # fmt: skip
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


# ---- the bounds on both ends, and robots that mend their sensors, at the level of distributions
@pytest.mark.long(but=["ring"])
@pytest.mark.parametrize("topology", ["ring", "scale-free"])
def test_the_oracles_error_is_as_small_as_can_be(topology):
    """The Cramer-Rao bound 1 / sqrt(sum I), sensors unequal: chi-square of the variance and z of the mean.

    Two-sided at 0.05 % each, so 0.1 % for both; of 3,000 readings the estimate is as good as normal, at the bound.
    """
    trials, robots, rounds, f = 400, 20, 150, 0.4
    b = w = np.random.default_rng(1).uniform(0.55, 0.95, robots)
    members = [{"robots": 1, "accuracy": float(one)} for one in b[1:]]
    world = {"members": members, "topology": topology, "fill_ratio": f, "link_success": 0.5, "assumed_accuracy": 0.9}
    study = study_of("oracle", robots, float(b[0]), rounds, looks=1, trials=trials, seed=12, **world)
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


# ---- readings of floors that change and of sensors that drift, at the level of distributions, against theory
SWITCH = {"from": 0.9, "to": 0.2, "at": 13}
SLOW = {"from": 0.1, "to": 0.7, "at": 6, "until": 25}
WEARS = {"start": 0.9, "drift": -0.02, "least": 0.6}
WARMS = {"start": "U(0.55, 0.75)", "drift": 0.01, "most": 0.85}
ROUNDS = 30
WORST = 1e-3  # the error rate of a test, of all its rounds together


def of_rounds(change, k):
    """The fill ratio of round k, from the words of the docs."""
    if k < change["at"]:
        return change["from"]
    steps = change.get("until", change["at"]) - change["at"] + 1
    return change["from"] + (change["to"] - change["from"]) * min((k - change["at"] + 1) / steps, 1.0)


def of_sensors(accuracy, k):
    """The accuracies of round k over the swarm: of a spread, its quantiles."""
    start = 0.55 + 0.2 * (np.arange(10_000) + 0.5) / 10_000 if accuracy is WARMS else np.array([accuracy["start"]])
    least, most = accuracy.get("least", 0.0), accuracy.get("most", 1.0)
    return np.clip(start + accuracy["drift"] * (k - 1), least, most)


def setting_of(change, accuracy):
    world = {"topology": "line", "fill_ratio": change}
    (setting,) = settings_of(40, accuracy=accuracy, looks=10, rounds=ROUNDS, trials=100, seed=17, **world)
    return setting


CASES = [(SWITCH, WEARS), (SLOW, WEARS), (SWITCH, WARMS), (SLOW, WARMS)]


@pytest.mark.parametrize(("change", "accuracy"), CASES, ids=["switch wears", "drift wears", "switch warms", "all warm"])
def test_share_of_black_readings_on_networks(change, accuracy):
    """Each round's black readings of 4000 robots, by a two-sided normal p-value; error rate 0.1 % for all rounds.

    A robot's ten readings share its accuracy: their sum varies as those of coins do, and by what accuracies differ.
    """
    setting = setting_of(change, accuracy)
    blacks = sum(record_trial(setting, 17, trial)[2] for trial in range(100))
    for k in range(1, ROUNDS + 1):
        f, p = of_rounds(change, k), of_sensors(accuracy, k)
        law = p * f + (1 - p) * (1 - f)
        spread = 10 * (law * (1 - law)).mean() + 100 * law.var()
        z = (blacks[k].sum() - 40_000 * law.mean()) / np.sqrt(4000 * spread)
        assert 2 * stats.norm.sf(abs(z)) > WORST / ROUNDS, k


@pytest.mark.parametrize(("change", "accuracy"), CASES[:2], ids=["switch", "drifts"])
def test_a_count_of_a_round_is_binomial(change, accuracy):
    """Robots' counts in single rounds, before, in and after the change: chi-square, error rate 0.1 % for all."""
    setting = setting_of(change, accuracy)
    counts = np.array([record_trial(setting, 17, trial)[2] for trial in range(100)])
    rounds = (change["at"] - 1, change["at"], change["at"] + 7, ROUNDS)
    for k in rounds:
        f, p = of_rounds(change, k), of_sensors(accuracy, k)[0]
        expected = 4000 * stats.binom.pmf(np.arange(11), 10, p * f + (1 - p) * (1 - f))
        found = np.bincount(counts[:, k].astype(int).ravel(), minlength=11)
        assert chi_square(found, expected) > WORST / len(rounds), k
