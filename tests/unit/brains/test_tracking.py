"""Tracking: by hand, by brute force, against commons on floors that stay, and in swarms whose floor changes."""

import numpy as np
import pytest

import swarmcensus as sc
from swarmcensus import brains
from tests.support.small import study_of

TRACKING = brains.load("tracking")
RUN = TRACKING.functions
BOTH = ["commons", "tracking"]


def robot(b=1.0, w=1.0, **given):
    return TRACKING.with_parameters(given).robot(b, w)


def test_a_round_by_hand():
    """Sixteen black of twenty, a neighbour with sums of its own; a quarter of V = 84 is 21, and v = 30 is cut to it."""
    me = robot()
    RUN.observe(me, 16.0, 20.0)
    assert (me.s, me.v, me.long_s, me.long_v) == (16.0, 20.0, 16.0, 20.0)
    RUN.receive(me, (32.0, 40.0, 120.0, 148.0))
    RUN.fuse(me)
    assert (me.long_s, me.long_v) == (68.0, 84.0)
    assert me.s / me.v == pytest.approx(24.0 / 30.0)
    assert me.v == pytest.approx(21.0)
    assert RUN.estimate(me) == pytest.approx((68.0 + 0.03125 / 84.0) / (84.0 + 0.0625 / 84.0))


@pytest.mark.parametrize(("off", "anew"), [(0.9999, False), (1.0001, True)])
def test_it_restarts_where_the_sums_differ(off, anew):
    """z^2 (1/v - 1/V) / (4 n) with v = 25, V = 100, n = 2 and z = 2.5."""
    me = robot()
    gap = off * 2.5 * ((1.0 / 25.0 - 1.0 / 100.0) / 8.0) ** 0.5
    sums = (25.0 * (0.5 + gap), 25.0, 50.0, 100.0)
    me.s, me.v, me.long_s, me.long_v = sums
    RUN.receive(me, sums)
    RUN.fuse(me)
    if anew:
        assert me.v == me.long_v == 1.0
        assert me.s == me.long_s == pytest.approx(0.5 + gap)
    else:
        assert (me.long_s, me.long_v) == (50.0, 100.0)


def test_the_short_sums_hold_what_is_fresh():
    """Brute force: short sums are weights times readings, and no weight is above 1, which the bound needs."""
    chance = np.random.default_rng(2)
    me, weights, readings = robot(z=1e9, memory=30.0), np.zeros(0), np.zeros(0)
    for _ in range(120):
        fresh = (chance.random(3) < 0.6).astype(float)
        RUN.observe(me, fresh.sum(), 3.0)
        RUN.fuse(me)
        weights, readings = np.append(weights, np.ones(3)), np.append(readings, fresh)
        most = min(30.0, max(10.0, 0.25 * len(readings)))
        weights *= min(1.0, most / weights.sum())
        assert me.v == pytest.approx(weights.sum())
        assert me.s == pytest.approx((weights * readings).sum())
        assert (weights**2).sum() <= me.v
    assert (me.long_s, me.long_v) == (readings.sum(), 360.0)
    assert me.v == pytest.approx(30.0)


def test_after_a_change_it_is_right_within_few_rounds():
    """Nine of ten robots within 40 rounds, where commons needs more than the 200 that are left."""
    changes, measure = {"from": 0.85, "to": 0.25, "at": 201}, {"metrics": ["recovery-time"]}
    results = sc.run(
        study_of(BOTH, robots=20, accuracy=0.8, rounds=400, trials=20, seed=4, fill_ratio=changes, measure=measure)
    )
    recovery = results["recovery_time"].values.reshape(2, -1)
    assert np.isinf(recovery[0]).all()
    assert np.quantile(recovery[1], 0.9) < 40
    assert np.median(abs(results["final_estimate"].values[1] - 0.25)) < 0.01
