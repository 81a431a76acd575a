"""Noise does not fool the evidence of a tuned brain."""

from scipy import stats

import swarmcensus as sc
from tests.support.long import in_two_sizes
from tests.support.tunable import study_of


def called_better(folder, seeds):
    """How often a brain is called better by a parameter that makes other errors of the same distribution."""
    found = [
        sc.tune(
            study_of(folder, "noise = 1.0, shift = 0.5", seed=s, robots=1), ["shift=0:1"], budget=37, trials=20, jobs=1
        )
        for s in range(seeds)
    ]
    assert all(one.brain != one.before for one in found)
    return sum(one.verdict == "better" for one in found)


@in_two_sizes("studies", 10, 100)
def test_false_alarms_of_tuning(tmp_path, studies):
    """More studies than the bound are so with a chance of 0.1 % if 5 % are, and far less if 2.5 % are."""
    assert called_better(tmp_path, studies) <= stats.binom.ppf(0.999, studies, 0.05)  # 4 or 13
