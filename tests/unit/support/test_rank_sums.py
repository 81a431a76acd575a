"""The rank-sum test, the shift and the probability: by hand, by every way to deal values out, and by SciPy."""

import math

import numpy as np
import pytest
from scipy import stats

from swarmcensus.support.rank_sums import EXACT, _newcombe, _p_of_unequal, ends_of_probability, rank_sums, shift
from swarmcensus.support.significance import fewest_trials
from tests.support.contending import by_every_deal

CASES = {
    "by hand": ([1.0, 2, 3], [4.0, 5, 6, 7]),
    "ties": ([1.0, 1, 2, 2, 3], [1.0, 2, 3, 3]),
    "infinite": ([1.0, math.inf, math.inf], [2.0, math.inf, -math.inf, 0.5]),
    "tied but for rounding": ([0.3, 0.1 + 0.2, 0.5], [0.3, 0.4, 0.1]),
    "equal": ([0.25] * 4, [0.25] * 3),
}


@pytest.mark.parametrize(("first", "second"), CASES.values(), ids=CASES)
def test_p_counts_every_way_to_deal_values_out(first, second):
    exact, unequal = by_every_deal(first, second), _p_of_unequal(np.array(first), np.array(second))
    assert rank_sums(np.array(first), np.array(second)).p == pytest.approx(max(exact, unequal), abs=1e-14)


def test_counts_and_balance_by_hand():
    found = rank_sums(*map(np.array, CASES["by hand"]))
    assert found.p == 2 / 35  # all of three below all of four: one of (7 choose 3) ways
    assert (found.below, found.equal, found.above, found.balance) == (12, 0, 0, -1.0)


@pytest.mark.parametrize("size", [6, 20, 30])
def test_p_is_scipys_exact_one_without_ties(size):
    random = np.random.default_rng(size)
    for _ in range(5):
        one, other = random.normal(0.5, 1, size), random.normal(size=size - 1)
        exact = stats.mannwhitneyu(one, other, method="exact").pvalue
        assert rank_sums(one, other).p == pytest.approx(max(exact, _p_of_unequal(one, other)))


@pytest.mark.parametrize("size", [6, 20, 80])
def test_p_of_unequal_spreads_is_scipys(size):
    random = np.random.default_rng(size)
    one, other = random.normal(0.5, 4, size), random.normal(size=2 * size)
    assert _p_of_unequal(one, other) == pytest.approx(stats.brunnermunzel(one, other).pvalue, rel=0.01)
    assert _p_of_unequal(one, one + 100) == 0.0


def test_p_of_many_values_is_scipys_approximation():
    random = np.random.default_rng(1)
    one, other = (np.rint(3 * random.normal(off, 1, EXACT)) for off in (0.3, 0.0))
    about = stats.mannwhitneyu(one, other, method="asymptotic").pvalue
    assert rank_sums(one, other).p == pytest.approx(max(about, _p_of_unequal(one, other)))


@pytest.mark.parametrize("size", [6, 10, 29])
def test_interval_of_the_shift_holds_what_the_test_does_not_reject(size):
    random = np.random.default_rng(size)
    one, other = random.normal(1, 1, size), random.normal(size=size)
    value, low, high = shift(one, other)
    assert value == pytest.approx(np.median(one[:, None] - other))
    inside, outside = 1e-9 * np.array([1, -1]), 1e-9 * np.array([-1, 1])
    ends = np.array([low, high])
    exact = [
        stats.mannwhitneyu(one - off, other, method="exact").pvalue for off in (*(ends + inside), *(ends + outside))
    ]
    assert [p > 0.05 for p in exact] == [True, True, False, False]


def test_few_or_equal_values_have_no_interval():
    assert np.isnan(shift(np.arange(5.0), np.arange(9.0))[1:]).all()
    assert np.isnan(shift(np.ones(8), np.ones(8))[1:]).all()
    assert np.isnan(ends_of_probability(np.arange(5.0), np.arange(9.0))).all()


def test_ends_of_the_probability_solve_newcombes_equation():
    for probability, first, second in ((0.8, 10, 14), (0.5, 6, 6), (1.0, 20, 20)):
        for at in _newcombe(probability, first, second, 0.95):
            extra = (first + second) / 2 - 1
            spread = at * (1 - at) * (1 + extra * (1 - at) / (2 - at) + extra * at / (1 + at)) / (first * second)
            assert (probability - at) ** 2 == pytest.approx(1.959963984540054**2 * spread, abs=1e-9)
    apart = ends_of_probability(20 + np.arange(20.0), np.arange(20.0))
    assert apart == _newcombe(1.0, 20, 20, 0.95)
    assert apart[0] < 0.95 < apart[1] == 1.0


@pytest.mark.parametrize("tests", [1, 12, 100])
def test_fewest_trials_of_independent_samples(tests):
    least = fewest_trials(tests, 0.05, paired=False)
    p = [float(rank_sums(np.arange(float(n)), n + np.arange(float(n))).p) for n in (least - 1, least)]
    assert p[0] * tests > 0.05 >= p[1] * tests
