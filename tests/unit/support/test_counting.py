"""Numbers as people read them."""

import numpy as np
import pytest

from swarmcensus.support.formatting import counted, distinct_texts, fixed, grouped, rounded


@pytest.mark.parametrize(
    ("count", "said"),
    [(0, "0 settings"), (1, "1 setting"), (np.int64(1), "1 setting"), (np.int64(1000), "1,000 settings")],
)
def test_one_is_singular_and_thousands_have_commas(count, said):
    assert counted(count, "setting") == said


@pytest.mark.parametrize(
    ("value", "said"),
    [(10000, "10,000"), (np.int64(1000), "1,000"), (0.55, "0.55"), (np.float64(2), "2.0"), ("ring", "ring")],
)
def test_whole_numbers_have_commas_and_nothing_else_changes(value, said):
    assert grouped(value) == said


def test_medians_of_whole_numbers_keep_their_halves():
    """Two medians that differ never look the same, and none is rounded to an even number."""
    assert [fixed(value) for value in (142.5, 719.5, 720.0, 1441.3)] == ["142.5", "719.5", "720", "1,441"]
    assert rounded(142.5, 140.0, 144.5, 0) == ("142.5", "[140, 144.5]")


def test_numbers_have_as_many_digits_as_tell_them_apart():
    assert distinct_texts(["0.7999999999999999", "0.6", "U(0.5499999999999999,0.95)"]) == ["0.8", "0.6", "U(0.55,0.95)"]
    assert distinct_texts([0.12345671, 0.12345672, 1.0]) == ["0.12345671", "0.12345672", "1"]
    assert distinct_texts(["0.500", "b=0.6"]) == ["0.5", "b=0.6"]
    assert distinct_texts([0.1, 0.1]) == ["0.1", "0.1"]
    assert distinct_texts([0.3, 0.1 + 0.2]) == ["0.29999999999999999", "0.30000000000000004"]
    assert distinct_texts([]) == []
