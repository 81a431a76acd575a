"""The paper's metrics against their definitions, word by word."""

import numpy as np
import pytest
from hypothesis import given, strategies as st
from hypothesis.extra import numpy as hnp

from swarmcensus.engine import agreement
from swarmcensus.simulation import metrics
from swarmcensus.support.bins import right_bin
from swarmcensus.support.quantities import half_width
from tests.support.small import called


def by_definition(curve, delta):
    for k in range(len(curve)):
        if all(abs(curve[k] - later) < delta for later in curve[k:]):
            return k
    return len(curve) - 1


@given(
    hnp.arrays(
        float, st.tuples(st.integers(1, 12), st.integers(1, 3)), elements=st.integers(0, 6).map(lambda v: v / 10)
    ),
    st.sampled_from([0.05, 0.1, 0.15, 0.31]),
)
def test_convergence_is_the_first_index_near_to_all_later_ones(curves, delta):
    assert metrics.convergence(curves, delta).tolist() == [by_definition(curve, delta) for curve in curves.T]


@pytest.mark.interpreted
@pytest.mark.parametrize(("estimates", "expected"), [
    ([0.4], 0.0),
    ([0.4, 0.6], (0.59 - 0.41) / 2),  # 5 % and 95 % of the way
    ([0.1, 0.5, 0.5, 0.5, 0.9], (0.82 - 0.18) / 2),  # a fifth of a step from each end
    ([*np.arange(100) / 100, 1.0], 0.45),
])  # fmt: skip
def test_disagreement_is_half_the_width_of_the_middle_nine_tenths(estimates, expected):
    for order in (estimates, estimates[::-1]):
        assert half_width(np.array(order)) == pytest.approx(expected)
        rows, nobody = np.array([order]), np.zeros(0, np.bool_)
        assert called(agreement.half_width)(rows[0], nobody, np.empty(len(order))) == half_width(rows[0])


@pytest.mark.parametrize(("widths", "expected"), [
    ([0, 0, 0], 0), ([3, 0, 0], 1), ([0, 3, 2], 2), ([0, 0, 3], np.inf), ([2], 0), ([3], np.inf),
])  # fmt: skip
def test_agreement_is_within_delta_to_the_end(widths, expected):
    """Exactly delta is within."""
    curves = 0.5 + np.outer(widths, [-1.0] * 10 + [0.0] + [1.0] * 10) / 32
    assert metrics.agreement(curves, 2 / 32) == expected


@pytest.mark.interpreted
@pytest.mark.parametrize("robots", [2, 3, 6, 21, 22, 45])
@pytest.mark.parametrize("lying", [0, 2])
def test_a_row_that_is_just_too_wide_is_found(robots, lying):
    """Rows differ from the last one, which is just within delta, in the few estimates that a quantile lies between."""
    chance, agreed_from = np.random.default_rng(robots), called(agreement.agreed_from)
    honest = np.arange(robots + lying) < robots if lying else np.zeros(0, np.bool_)
    found = set()
    for _ in range(60):
        last = np.sort(chance.normal(0.5, 0.01, robots))
        delta = half_width(last) * (1 + 1e-9)
        other, moved = last.copy(), chance.integers(0, max(robots // 8, 1) + 1, 2)
        other[: moved[0] + 1] -= chance.choice([0.0, 1e-6, 0.01])
        other[robots - 1 - moved[1] :] += chance.choice([0.0, 1e-6, 0.01])
        if chance.random() < 0.5:  # only the upper one of the two around the lower quantile
            below = int(0.05 * (robots - 1))
            other = np.concatenate([last[: below + 1], last[below : below + 1], last[below + 2 :]])
        rows = np.full((2, robots + lying), 0.99)
        rows[:, :robots] = other, last
        expected = metrics.agreement(rows[:, :robots], delta)
        assert agreed_from(rows, 0, honest, delta, np.empty(robots + lying), 0.0) == expected
        found.add(expected)
    assert found == {0.0, 1.0}


@pytest.mark.parametrize(("fill_ratio", "estimate", "right"), [
    (0.55, 0.5, True),
    (0.55, 0.59999, True),
    (0.55, 0.6, False),
    (0.55, 0.49999, False),
    (0.95, 0.9, True),
    (0.95, 1.0, True),  # the last bin is closed
    (1.0, 0.93, True),
    (0.0, 0.0, True),
    (0.0, -0.1, True),  # the first and the last are open to what no fill ratio is
    (1.0, 1.1, True),
    (0.0, 0.1, False),
    (0.3, 0.3, True),
    (0.3, 0.29999, False),
    (0.7, 0.7, True),
    (0.75, 0.81, False),  # the paper's own example
    (0.75, 0.73, True),
])  # fmt: skip
def test_bins(fill_ratio, estimate, right):
    assert metrics.correct(np.array([estimate]), fill_ratio) == right
    low, high = right_bin(fill_ratio)  # ten bins, as a study has them where it says nothing
    assert (low <= estimate < high) == right
