"""Adversaries that draw lots, in the engine: the laws of what they say. Error rate 0.1 % for each comparison."""

import numpy as np
import pytest
from scipy import stats

from swarmcensus.engine.constants import HEARD
from swarmcensus.simulation.trials import Metrics, run_batch
from tests.support.long import in_two_sizes
from tests.support.small import GO, settings_of
from tests.support.trials import record_trial

pytestmark = pytest.mark.interpreted
SEED = 11


def setting(name, robots, rounds, topology="ring", **parameters):
    liars = {"robots": robots - 1, "brain": {"file": name, **parameters}, "honest": False}
    (found,) = settings_of(
        robots, rounds=rounds, trials=1, seed=SEED, members=[liars], topology=topology, fill_ratio=0.5
    )
    return found


def tosses(name, field, rounds=40, robots=200, **parameters):
    """What each liar drew after each round (round, liar)."""
    fields, *_ = record_trial(setting(name, robots, rounds, **parameters), SEED, 0)
    drawn = fields[field][1:]
    return drawn[:, ~np.isnan(drawn[0])]


@pytest.mark.long
def test_the_coin_is_fair_and_each_toss_its_own():
    drawn = tosses("random", "liar_said")
    assert set(np.unique(drawn)) == {0.0, 1.0}
    assert stats.binomtest(int(drawn.sum()), drawn.size, 0.5).pvalue > 1e-3
    pairs = (2 * drawn[1:] + drawn[:-1]).astype(int).ravel()  # of one robot, round after round
    assert stats.chisquare(np.bincount(pairs, minlength=4)).pvalue > 1e-3
    beside = (2 * drawn[:, 1:] + drawn[:, :-1]).astype(int).ravel()
    assert stats.chisquare(np.bincount(beside, minlength=4)).pvalue > 1e-3


@pytest.mark.long
def test_any_number_is_as_likely():
    assert stats.kstest(tosses("random", "liar_said", uniform=1.0).ravel(), "uniform").pvalue > 1e-3


@pytest.mark.long
def test_each_name_is_as_likely():
    drawn = tosses("forger", "liar_alias", names=20)
    assert stats.chisquare(np.bincount(drawn.astype(int).ravel(), minlength=20)).pvalue > 1e-3


@pytest.mark.long(but=["0.75-quick"])
@in_two_sizes("rounds", 1000, 4000)
@pytest.mark.parametrize("often", [0.2, 0.75])
def test_noise_is_as_frequent_as_its_parameter_says(often, rounds):
    """Of a pair the honest one hears the other but for the noise: binomial, in all rounds after the first."""
    batch = run_batch(setting("jammer", 2, rounds, "line", often=often), SEED, 0, 1, Metrics(0.01, 10, ()), GO)
    heard = int(batch.counts[0, HEARD, 0])
    assert stats.binomtest(heard, rounds - 1, 1.0 - often).pvalue > 1e-3
