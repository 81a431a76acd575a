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


@pytest.mark.long
@pytest.mark.parametrize("share", [0.2, 0.5, 0.7])
def test_the_voters_exit_probability_is_the_first_share(share):
    """Without qualities, all in reach: each robot's first opinion is as likely to be everybody's last. 0.1 %."""
    trials = 1500
    last = run("voter", trials, black_first=share, **UNWEIGHTED)["decision"].values
    assert (last.min(axis=1) == last.max(axis=1)).mean() > 0.99
    black = int((last.mean(axis=1) > 0.5).sum())
    assert stats.binomtest(black, trials, share).pvalue > P


def mean_of(time):
    """Of ceil(Exp(time)), which is geometric."""
    return -1.0 / np.expm1(-1.0 / time)


def fixed_point(wrong, quiet):
    """Cross-inhibition at f = 0.5 in the mean field: the majority's share of opinions, and the share that has none.

    With r robots of the majority for one of the minority, and p = ((1 - wrong) r + wrong) / (1 + r) of what is heard
    saying the majority's, opinions are lost and won at equal rates where r = (p / (1 - p))^2, so that s^2 = r with
    wrong s^2 - (1 - 2 wrong) s + wrong = 0. `quiet` is how long robots have none for, in times of having one.
    """
    s = (1.0 - 2.0 * wrong + np.sqrt(1.0 - 4.0 * wrong)) / (2.0 * wrong)
    p = s / (1.0 + s)
    majority = s * s / (1.0 + s * s)
    lost = (majority * (1.0 - p) + (1.0 - majority) * p) * quiet
    return majority, lost / (1.0 + lost)


@pytest.mark.long
def test_cross_inhibition_with_wrong_messages():
    """15 of 100 messages are of the other opinion: within 4 standard errors and what a finite swarm loses, 0.02 %.

    Direct switching stays near one half.
    """
    given = TIMES | {"miscommunication": 0.15, "weighted": 0.0, "disseminate": 4.0, "explore": 4.0}
    opinions = run("cross-inhibition", 40, 200, 600, 1, 0.5, uncommitted=2.0, **given)["decision"].values
    majority, none = fixed_point(0.15, mean_of(2.0) / mean_of(4.0))
    assert majority == pytest.approx(0.9518, abs=1e-4)
    has = (opinions >= 0).sum(axis=1)
    black = (opinions == 1).sum(axis=1)
    for found, expected in ((np.maximum(black, has - black) / has, majority), (1.0 - has / 200, none)):
        assert abs(found.mean() - expected) < 4.0 * found.std(ddof=1) / np.sqrt(len(found)) + 1.0 / 200
    switched = run("direct-switching", 40, 200, 600, 1, 0.5, **given)["decision"].values.mean(axis=1)
    assert abs(switched.mean() - 0.5) < 4.0 * switched.std(ddof=1) / np.sqrt(40)
    assert np.maximum(switched, 1.0 - switched).max() < 0.75


@pytest.mark.long
def test_cross_inhibition_breaks_the_deadlock():
    """At f = 0.5 all agree in a time that grows as log N; direct switching's grows as N: 4 standard errors, 0.02 %.

    From 10 robots to 40 the mean logarithm of the time grows by less than log 2.2, and by more than that.
    """
    given = TIMES | {"explore": 4.0, "weighted": 0.0, "fill_ratio": 0.5}
    for brain, rounds, side, more in (
        ("cross-inhibition", 600, -1.0, {"uncommitted": 2.0}),
        ("direct-switching", 3000, 1.0, {}),
    ):
        few, many = (run(brain, 100, n, rounds, **given, **more)["consensus_round"].values for n in (10, 40))
        assert np.isfinite([few, many]).all()
        grown = np.log(many).mean() - np.log(few).mean()
        error = np.sqrt((np.log(many).var(ddof=1) + np.log(few).var(ddof=1)) / 100)
        assert side * (grown - np.log(2.2)) > 4.0 * error
