"""Numbers as people read them."""

import numpy as np
import pytest

from swarmcensus.support.formatting import counted, grouped


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
