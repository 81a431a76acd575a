"""Addressed randomness: known answers, independence of order, uniformity."""

import numpy as np
import pytest
from scipy import stats

from swarmcensus.engine.addresses import address
from swarmcensus.engine.draws import COLUMNS, LOW, PART, alias_row, binomial_row, pick
from swarmcensus.engine.random import unit, words
from tests.support.small import called


def draw(seed, size, trial=0, tick=1, part=0):
    out = np.zeros(size, np.uint64)
    words(address(seed, "test"), trial, tick, part, 0, size, out)
    return out


def test_units_are_uniform():
    """Kolmogorov-Smirnov at the 0.1 % level, fixed seed."""
    values = np.array([unit(v) for v in draw(3, 20_000)])
    assert values.min() >= 0.0
    assert values.max() < 1.0
    assert stats.kstest(values, "uniform").pvalue > 1e-3


def test_neighbouring_robots_ticks_and_trials_are_uncorrelated():
    """Correlations of 20,000 pairs stay within 4 standard errors."""
    base = draw(3, 20_000) / 2.0**64
    for other in (np.roll(base, 1), draw(3, 20_000, tick=2) / 2.0**64, draw(3, 20_000, trial=1) / 2.0**64):
        assert abs(np.corrcoef(base, other)[0, 1]) < 4 / np.sqrt(20_000)


@pytest.mark.parametrize("looks", [1, 2, 10, PART])
@pytest.mark.parametrize("p", [0.0, 0.025, 0.5, 0.6789, 1.0])
def test_alias_rows_hold_the_exact_binomial(looks, p):
    """Summing the columns' shares gives back the distribution to rounding."""
    row = np.zeros(COLUMNS, np.uint64)
    called(binomial_row)(looks, p, row)
    shares = np.zeros(COLUMNS)
    for column in range(COLUMNS):
        kept = float(row[column] & ~LOW) / 2.0**64
        shares[column] += kept / COLUMNS
        shares[int(row[column] & LOW)] += (1 - kept) / COLUMNS
    assert shares == pytest.approx(stats.binom.pmf(np.arange(COLUMNS), looks, p), abs=1e-14)


def test_pick_follows_its_weights():
    """Chi-square at the 0.1 % level, fixed seed."""
    weights = np.array([0.5, 0.1, 0.0, 0.4] + [0.0] * 12)
    row = np.zeros(COLUMNS, np.uint64)
    called(alias_row)(weights, row)
    one = called(pick)
    counts = np.bincount([one(row, v) for v in draw(5, 20_000)], minlength=COLUMNS)
    assert counts[weights == 0].sum() == 0
    assert stats.chisquare(counts[weights > 0], 20_000 * weights[weights > 0]).pvalue > 1e-3
