"""The rules for opinions as laws: lots, times, who wins, and the fixed points of mean-field theory.

Each test states its error rate: the chance that a right simulator fails it, were the seed not fixed.
"""

from itertools import combinations

import numpy as np
import pytest
from scipy import stats

import swarmcensus as sc
from swarmcensus import brains
from tests.support.small import study_of

P = 1e-3
TIMES = {"explore": 2.0, "disseminate": 4.0}
UNWEIGHTED = TIMES | {"listen": 2.0, "weighted": 0.0}


def run(brain, trials, robots=10, rounds=400, looks=1, fill_ratio=0.55, topology="full", **parameters):
    """One setting of robots with perfect sensors."""
    study = study_of(
        [{"file": brain, **parameters}], robots=robots, accuracy=1.0, rounds=rounds, looks=looks, trials=trials,
        seed=23, measure={"checkpoints": [rounds]}, topology=topology, fill_ratio=fill_ratio,
    )  # fmt: skip
    return sc.run(study, jobs=2).isel(setting=0)


@pytest.mark.long(but_every=3)
@pytest.mark.parametrize("names", [range(9), (0, 1, 2, 10, 20, 30, 100, 10_000, 1_000_000)])
@pytest.mark.parametrize("brain", ["voter", "majority", "direct-comparison"])
def test_lots_are_fair(brain, names):
    """Each of nine senders has the lowest of nine lots as often, and each four the lowest four: chi-square, 0.2 %."""
    used = brains.load(brain)
    me = used.robot(0.9, 0.8)
    lowest, four = np.zeros(9), dict.fromkeys(combinations(range(9), 4), 0)
    for salt in np.random.default_rng(11).random(5000):
        me.salt = float(salt)
        lots = [used.functions.drawn(me, float(name), float(name % 2)) for name in names]
        order = np.argsort(lots)
        lowest[order[0]] += 1
        four[tuple(sorted(order[:4].tolist()))] += 1
    assert stats.chisquare(lowest).pvalue > P
    assert stats.chisquare(list(four.values())).pvalue > P


def test_qualities_decide_among_voters():
    """Perfect sensors and 7 of 10 tiles black: black is told for longer, and wins more often than the half that begins
    with it. That a rule without weights would pass has a chance of 10^-9.
    """
    trials = 300
    given = UNWEIGHTED | {"weighted": 1.0, "disseminate": 20.0, "first": 0.0}
    last = run("voter", trials, fill_ratio=0.7, looks=20, **given)["decision"].values
    black = int((last.mean(axis=1) > 0.5).sum())
    assert stats.binomtest(black, trials, 0.5, alternative="greater").pvalue < 1e-9


def test_the_weighted_voter_copies_dancers_by_their_number():
    """Three dance for bin 2, one for bin 7, six do not dance: the chance of bin 2 is 3/4, two-sided, 0.1 %."""
    used = brains.load("weighted-voter").with_parameters({"every": 1.0})
    said = [(1.0, 2.0)] * 3 + [(1.0, 7.0)] + [(0.0, 5.0)] * 6
    lucks = np.random.default_rng(12).random((2000, len(said)))
    copied = 0
    for lots in lucks:
        me = used.robot(1.0, 1.0)
        me.luck = 0.5
        used.functions.fuse(me)
        me.steps = 0.0
        for message, draws in zip(said, lots, strict=True):
            me.luck = float(draws)
            used.functions.receive(me, message)
        used.functions.fuse(me)
        assert me.site in {2.0, 7.0}
        copied += me.site == 2.0
    assert stats.binomtest(copied, 2000, 0.75).pvalue > P
