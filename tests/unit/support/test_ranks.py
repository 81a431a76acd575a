"""Tests by ranks, of pairs and of two samples: by hand, by counting all ways, and by SciPy."""

import itertools
import math

import numpy as np
import pytest
from scipy import stats

from swarmcensus.support.rank_sums import (
    EXACT as EXACT_SUMS,
    _newcombe,
    _p_of_unequal,
    ends_of_probability,
    rank_sums,
    shift,
)
from swarmcensus.support.significance import (
    EXACT,
    differences,
    fewest_trials,
    friedman,
    groups,
    holm,
    mean_tests,
    midranks,
    paired_tests,
    signed_ranks,
)
from tests.support.contending import by_every_deal, by_every_sign, with_signs

INF, NAN = math.inf, math.nan


CASES = {
    "all of one sign": [1.0, 2, 3, 4, 5, 6], "by hand": [1.0, -2, 3, 4, 5, 6],
    "ties": [1.0, 1, -1, 2, 2, 2, -3], "zeros": [0.0, 0, 0, 1, 2, -3, 4, 5],
    "infinite": [INF, INF, 1, -INF, 2, 3, 4], "missing": [NAN, 1, 2, NAN, 3, 4, 5, -6],
    "all zero": [0.0, 0, 0], "constant": [0.25] * 8,
    "tied but for rounding": [0.3 - 0.2, 0.2 - 0.1, 0.2 - 0.3, 0.5, 0.6, 0.7], "none": [],
}  # fmt: skip


@pytest.mark.parametrize("off", CASES.values(), ids=CASES)
def test_p_counts_every_sign_pattern(off):
    assert signed_ranks(np.array(off)).p == pytest.approx(by_every_sign(np.round(off, 9)), abs=1e-14)


@pytest.mark.long(but_every=5)
@pytest.mark.long(only=["9-continuous", "9-tied"])
@pytest.mark.parametrize("kind", ["continuous", "tied", "zeros"])
@pytest.mark.parametrize("trials", [6, 9, 13, 30])
def test_random_rows_are_scipys_and_the_counts_of_all_signs(kind, trials):
    off = np.random.default_rng(trials).normal(0.3, 1, (40, trials))
    if kind != "continuous":
        off = np.rint(2 * off)
    if kind == "tied":
        off[off == 0] = 1
    found = signed_ranks(off)
    for row, p, balance in zip(off, found.p, found.balance, strict=True):
        if trials <= 9:
            assert p == pytest.approx(by_every_sign(row), abs=1e-13)
        if kind == "continuous":
            assert p == pytest.approx(stats.wilcoxon(row, method="exact").pvalue, rel=1e-10)
        ranks = stats.rankdata(np.abs(row))
        assert balance == pytest.approx((ranks * np.sign(row)).sum() / max(ranks[row != 0].sum(), 1))


def test_many_trials_are_nearly_the_exact_distribution():
    """On both sides of where p is no longer counted: the normal one is as large, or within a fifth where p is small."""
    off = np.random.default_rng(5).normal(0.35, 1, (300, EXACT + 6))
    close = signed_ranks(off).p
    exact = np.array([stats.wilcoxon(row, method="exact").pvalue for row in off])
    some = exact > 1e-5
    assert some.sum() > 200
    assert (np.abs(close[some] - exact[some]) < 0.2 * exact[some] + 0.002).all()
    assert (close[~some] > exact[~some]).all()  # far out it is cautious
    exact = [stats.wilcoxon(row, method="exact").pvalue for row in off[:, :EXACT]]
    assert signed_ranks(off[:, :EXACT]).p == pytest.approx(exact, rel=1e-9)


@pytest.mark.parametrize("trials", [1, 8, 30, EXACT + 6])
def test_a_pair_differs_in_ranks_and_in_the_number_of_trials(trials):
    random = np.random.default_rng(trials)
    off = random.exponential(size=(60, trials)) - math.log(2) + random.choice([0.0, 0.5], (60, 1))
    off[random.uniform(size=off.shape) < 0.1] = 0.0
    off[random.uniform(size=off.shape) < 0.1] = NAN
    ranks, found = signed_ranks(off), paired_tests(off)
    by_hand = [with_signs(row[~np.isnan(row)], p) for row, p in zip(off, ranks.p, strict=True)]
    assert found.p == pytest.approx(by_hand, abs=1e-12 if trials <= EXACT else 0.01)
    assert (found.p > ranks.p).any() or trials == 1
    for one, other in zip(found[:4], ranks[:4], strict=True):
        assert (one == other).all()


@pytest.mark.parametrize(("trials", "ahead"), [(9, 8), (30, 22), (30, 30), (7, 0)])
def test_the_mean_of_signs_is_tested_by_their_likelihood(trials, ahead):
    off, share = np.repeat([[1.0, -1.0]], [ahead, trials - ahead], axis=1), ahead / trials
    ratio = 2 * trials * stats.entropy([share, 1 - share], [0.5, 0.5]) * (0 < share < 1)
    by_hand = 2 * stats.t.sf(math.sqrt(ratio), trials - 1) * (ratio > 0)
    assert mean_tests(off).p == pytest.approx(np.maximum(by_hand, signed_ranks(off).p), rel=0.02)


@pytest.mark.parametrize("trials", [6, 9, 12])
@pytest.mark.parametrize("sizes", [lambda k: k, lambda k: (k + 2) // 3, lambda k: k**0])
def test_both_together_seldom_err(trials, sizes):
    """Of all signs of differences without ties, with some, and of one size, few have a small p."""
    signs = np.array(list(itertools.product((-1.0, 1.0), repeat=trials)))
    found = paired_tests(signs * sizes(np.arange(1.0, trials + 1))).p
    assert all((found <= level).mean() <= 1.1 * level for level in (0.05, 0.05 / 3, 0.05 / 10))
    assert found.min() == 2 / 2**trials


def test_differences_know_rounding_and_infinity():
    one = np.array([0.1 + 0.2, INF, INF, 1.0, -INF, NAN, 0.99, 1.0])
    found = differences(one, np.array([0.3, INF, 1.0, INF, INF, 1.0, 0.98, 0.99]))
    assert found.tolist() == pytest.approx([0, 0, INF, -INF, -INF, NAN, 0.01, 0.01], rel=1e-13, abs=0, nan_ok=True)


def test_ranks_share_ties_and_leave_out_what_is_missing():
    found = midranks(np.array([[3.0, 1, 3, NAN, 2], [INF, 1, INF, 2, -INF]]))
    np.testing.assert_array_equal(found, [[3.5, 1, 3.5, NAN, 2], [4.5, 2, 4.5, 3, 1]])
    random = np.random.default_rng(2).integers(0, 5, (50, 12)).astype(float)
    assert (midranks(random) == stats.rankdata(random, axis=1)).all()


def test_holm_by_hand_and_missing_tests_do_not_count():
    assert holm(np.array([0.01, 0.04, 0.03, NAN])).tolist()[:3] == pytest.approx([0.03, 0.06, 0.06])
    assert math.isnan(holm(np.array([0.01, NAN]))[1])
    p = np.random.default_rng(3).uniform(size=(3, 4)) ** 3
    ordered = np.sort(p.ravel())
    by_hand = [min(1, max(ordered[j] * (12 - j) for j in range(12) if ordered[j] <= one)) for one in p.ravel()]
    assert holm(p).ravel() == pytest.approx(by_hand)


CLEAREST = {  # the smallest p of so many trials
    True: lambda n: signed_ranks(np.arange(1.0, n + 1)).p,
    False: lambda n: rank_sums(np.arange(float(n)), n + np.arange(float(n))).p,
}


@pytest.mark.parametrize("paired", CLEAREST)
@pytest.mark.parametrize("tests", [1, 2, 7, 12, 40, 100])
def test_fewest_trials(tests, paired):
    least = fewest_trials(tests, 0.05, paired=paired)
    p = [float(CLEAREST[paired](trials)) for trials in (least - 1, least)]
    assert p[0] * tests > 0.05 >= p[1] * tests


@pytest.mark.parametrize("tied", [False, True])
def test_friedman_against_scipy_and_permutations(tied):
    values = np.random.default_rng(4).normal(size=(5, 3)) + 0.5 * np.arange(3)
    values = np.rint(values) if tied else values
    ranks = midranks(values)
    statistic, p = friedman(ranks)
    assert statistic == pytest.approx(stats.friedmanchisquare(*values.T).statistic)
    off = ranks - ranks.mean(axis=1, keepdims=True)
    every = [[list(one) for one in itertools.permutations(row)] for row in off.tolist()]
    sums = [(np.array(one).sum(axis=0) ** 2).sum() for one in itertools.product(*every)]
    exact = np.mean(np.array(sums) >= (off.sum(axis=0) ** 2).sum() - 1e-9)
    assert p == pytest.approx(exact, abs=4 * math.sqrt(exact * (1 - exact) / 9999) + 1e-3)
    assert friedman(np.full((4, 3), 2.0))[1] == 1.0


def test_groups_are_the_longest_runs():
    apart = np.zeros((4, 4), bool)
    apart[0, 2] = apart[2, 0] = apart[0, 3] = apart[3, 0] = True
    assert groups([0, 1, 2, 3], apart) == [[0, 1], [1, 2, 3]]
    assert (groups([0, 1, 2, 3], ~np.eye(4, dtype=bool)), groups([3, 2], apart)) == ([], [[3, 2]])


# ---- the rank-sum test, the shift and the probability: by hand, by every way to deal values out, and by SciPy
DEALS = {
    "by hand": ([1.0, 2, 3], [4.0, 5, 6, 7]), "ties": ([1.0, 1, 2, 2, 3], [1.0, 2, 3, 3]),
    "infinite": ([1.0, INF, INF], [2.0, INF, -INF, 0.5]), "equal": ([0.25] * 4, [0.25] * 3),
    "tied but for rounding": ([0.3, 0.1 + 0.2, 0.5], [0.3, 0.4, 0.1]),
}  # fmt: skip


@pytest.mark.parametrize(("first", "second"), DEALS.values(), ids=DEALS)
def test_p_counts_every_way_to_deal_values_out(first, second):
    exact, unequal = by_every_deal(first, second), _p_of_unequal(np.array(first), np.array(second))
    assert rank_sums(np.array(first), np.array(second)).p == pytest.approx(max(exact, unequal), abs=1e-14)


def test_counts_and_balance_by_hand():
    found = rank_sums(*map(np.array, DEALS["by hand"]))
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
    one, other = (np.rint(3 * random.normal(off, 1, EXACT_SUMS)) for off in (0.3, 0.0))
    about = stats.mannwhitneyu(one, other, method="asymptotic").pvalue
    assert rank_sums(one, other).p == pytest.approx(max(about, _p_of_unequal(one, other)))


@pytest.mark.parametrize("size", [6, 10, 29])
def test_interval_of_the_shift_holds_what_the_test_does_not_reject(size):
    random = np.random.default_rng(size)
    one, other = random.normal(1, 1, size), random.normal(size=size)
    value, low, high = shift(one, other)
    assert value == pytest.approx(np.median(one[:, None] - other))
    points = (low + 1e-9, high - 1e-9, low - 1e-9, high + 1e-9)  # within, and outside
    exact = [stats.mannwhitneyu(one - off, other, method="exact").pvalue for off in points]
    assert [p > 0.05 for p in exact] == [True, True, False, False]


def test_few_or_equal_values_have_no_interval():
    for one, other in ((np.arange(5.0), np.arange(9.0)), (np.ones(8), np.ones(8))):
        assert np.isnan(shift(one, other)[1:]).all()
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
