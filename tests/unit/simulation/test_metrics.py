"""The paper's metrics against their definitions, word by word."""

import numpy as np
import pytest
from hypothesis import given, strategies as st
from hypothesis.extra import numpy as hnp

from swarmcensus.simulation import metrics
from swarmcensus.support.bins import right_bin


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
    expected = [by_definition(curve, delta) for curve in curves.T]
    assert metrics.convergence(curves, delta).tolist() == expected


def test_error_at():
    curves = np.array([[0.5, 0.1], [0.6, 0.2]])
    assert metrics.error_at(curves, np.array([1, 0]), 0.55) == pytest.approx([0.05, 0.45])


@pytest.mark.parametrize(
    ("fill_ratio", "estimate", "right"),
    [
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
    ],
)
def test_bins(fill_ratio, estimate, right):
    assert metrics.correct(np.array([estimate]), fill_ratio) == right
    low, high = right_bin(fill_ratio)  # ten bins, as a study has them where it says nothing
    assert (low <= estimate < high) == right


@pytest.mark.parametrize("bins", [1, 2, 7, 10, 100])
def test_every_estimate_has_one_bin(bins):
    edges = np.arange(bins) / bins
    points = np.unique(np.concatenate([np.linspace(0, 1, 1001), edges]))
    hits = sum(metrics.correct(points[:, np.newaxis], centre, bins) for centre in edges + 0.5 / bins)
    assert (hits == 1).all()


def test_consensus_is_a_fraction_of_one():
    assert metrics.correct(np.array([[0.55, 0.51, 0.65, 0.59]]), 0.55) == [0.75]
