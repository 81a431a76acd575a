"""Sure: its quantile, interval and looks by hand, its coverage and its stops over trials, and that it needs a spread.

Tests of draws state their error rate: the chance that what is right fails them, were the seed not fixed.
"""

import math
from types import SimpleNamespace

import numpy as np
import pytest
from scipy import stats

import swarmcensus as sc
from swarmcensus import brains

SURE = brains.load("sure").functions


def mind(b=0.9, w=0.8, **given):
    """A robot, with what is given in place of the defaults."""
    fields = {k: list(v) if isinstance(v, tuple) else v for k, v in {**SURE.MEMORY, **SURE.PARAMETERS}.items()}
    return SimpleNamespace(**fields | given, b=b, w=w)


@pytest.mark.parametrize("alpha", [0.5, 0.2, 0.05, 0.001, 1e-6])
def test_the_quantile_is_student_s(alpha):
    assert SURE.quantile(alpha) == pytest.approx(stats.t.ppf(1.0 - alpha / 2.0, 7), rel=1e-9)


def test_streams_alike_give_the_interval_of_a_mean():
    """Equal weights: Student's interval of eight ratios, by SciPy."""
    ratios = np.random.default_rng(4).normal(0.5, 0.1, 8)
    me = mind(s=list(2.0 * ratios), v=[2.0] * 8, looks=10**6, voices=3.0, rounds=1.0)
    low, high = stats.t.interval(0.95, 7, ratios.mean(), stats.sem(ratios))
    assert SURE.interval(me) == pytest.approx((low, high))
    assert SURE.half(me, 0.2) == pytest.approx(stats.t.ppf(0.9, 7) * stats.sem(ratios))


def test_readings_all_alike_are_no_certainty():
    """A perfect sensor that saw only black: what share of white would not have shown, with 95 %."""
    me = mind(b=1.0, w=1.0)
    for _ in range(8):
        SURE.observe(me, 10.0, 10.0)
        SURE.fuse(me)
    low, high = SURE.interval(me)
    assert (low, high) == (pytest.approx(1.0 - math.log(20.0) / 80.0), 1.0)
    assert low**80 == pytest.approx(0.05, rel=0.1)


def test_a_robot_without_evidence_in_some_stream_cannot_tell():
    me = mind()
    for _ in range(7):
        assert SURE.interval(me) == (0.0, 1.0)
        SURE.observe(me, 3.0, 5.0)
        SURE.fuse(me)
    assert SURE.interval(me) == (0.0, 1.0)
    nobody = mind(b=0.5, w=0.5)
    for _ in range(40):
        SURE.observe(nobody, 3.0, 5.0)
        SURE.fuse(nobody)
    assert SURE.interval(nobody) == (0.0, 1.0)
    assert not SURE.done(nobody)


def test_who_must_never_miss_says_all():
    """Where all streams have evidence, it divided by alpha."""
    me = mind(alpha=0.0)
    for _ in range(16):
        SURE.observe(me, 3.0, 5.0)
        SURE.fuse(me)
    assert SURE.interval(me) == (0.0, 1.0)
    assert not SURE.done(me)


def test_blocks_double_and_a_look_follows_every_eighth():
    me, looks, lengths = mind(within=0.0), [], []
    for round in range(1, 121):
        stream = me.stream
        SURE.fuse(me)
        lengths.append(stream)
        if me.look > len(looks):
            looks.append(round)
    assert looks == [8, 24, 56, 120]
    assert lengths[:8] == list(range(8))
    assert lengths[8:24] == [float(k // 2) for k in range(16)]


def test_all_looks_together_spend_alpha():
    spent = sum(4.0 * 0.05 / ((j + 3.0) * (j + 4.0)) for j in range(1, 10**5))
    assert spent == pytest.approx(0.05, rel=1e-4)
    assert spent < 0.05


def covered(alpha, trials, robots, **world):
    """Each trial's share of robots whose interval holds f, at each checkpoint."""
    brain = {"file": "sure", "alpha": alpha, "within": 1e-9}
    study = sc.Study(
        trials=trials, seed=21,
        swarm={"brain": brain, "robots": robots, "accuracy": [0.7, "U(0.525, 0.975)"]},
        world={"topology": "ring", "fill_ratio": [0.55, 0.95]} | world,
        schedule={"rounds": 120, "observations_per_round": 10}, measure={"checkpoints": [40, 120]},
    )  # fmt: skip
    return sc.run(study)["coverage"].values


@pytest.mark.long
@pytest.mark.parametrize("alpha", [0.05, 0.2])
@pytest.mark.parametrize(
    "world", [{}, {"topology": "scale-free", "link_success": 0.3}], ids=["ring", "tree and losses"]
)
def test_intervals_hold_as_often_as_they_say(alpha, world):
    """Over 150 trials, within 4 standard errors and 1.5 points: fails in 1 of 1,000 for the 16 together."""
    shares = covered(alpha, 150, 16, **world)
    off = shares.mean(axis=-1) - (1.0 - alpha)
    assert np.all(np.abs(off) < 4.0 * shares.std(axis=-1) / 150**0.5 + 0.015)


def test_few_robots_stop_on_a_wrong_answer_and_all_stop():
    """At most alpha of them in each of eight cells, by 4 standard errors over 60 trials."""
    study = sc.Study(
        trials=60, seed=22,
        swarm={"brain": {"file": "sure", "within": [0.03, 0.06]}, "robots": 16, "accuracy": [0.8, 1.0]},
        world={"topology": "ring", "fill_ratio": [0.05, 0.55]},
        schedule={"rounds": 1016, "observations_per_round": 10}, measure={"checkpoints": [1016]},
    )  # fmt: skip
    found = sc.run(study)
    truth, within = found["fill_ratio"].values[:, None, None], found["within"].values[:, None, None]
    stopped = np.isfinite(found["done_estimate"].values)
    wrong = (stopped & (np.abs(found["done_estimate"].values - truth) > within)).mean(axis=2)
    assert stopped.all()
    assert np.all(wrong.mean(axis=1) <= 0.05 + 4.0 * wrong.std(axis=1) / 60**0.5)
    assert np.all(wrong.mean(axis=1) < 0.05)
    at = found["done_round"].median(("trial", "robot")).values.reshape(2, 2, 2)
    assert np.all(found["done_round"].values % 8 == 0)
    assert at.min() >= 8
