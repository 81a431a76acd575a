"""Readings of floors that change and of sensors that drift, at the level of distributions, against theory.

Each test states its error rate: the chance that a right simulator fails it, were the seed not fixed.
"""

import numpy as np
import pytest
from scipy import stats

from tests.support.small import settings_of
from tests.support.trials import record_trial

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
    (setting,) = settings_of(
        40, accuracy=accuracy, looks=10, rounds=ROUNDS, trials=100, seed=17, topology="line", fill_ratio=change
    )
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
        rare = expected < 5
        pooled = [np.append(v[~rare], v[rare].sum()) for v in (found, expected)]
        pooled = [v[pooled[1] > 0] for v in pooled]
        assert stats.chisquare(*pooled).pvalue > WORST / len(rounds), k
