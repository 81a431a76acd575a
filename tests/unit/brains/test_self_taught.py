"""Self-taught: by hand, against the random-effects mean by brute force, and in swarms of which some are wrong."""

import numpy as np
import pytest

import swarmcensus as sc
from swarmcensus import brains
from tests.support.small import study_of

TAUGHT = brains.load("self-taught")
RUN = TAUGHT.functions
ALL_FIT = {"z": 1e6, "apart": 1e12}


def robot(b=0.8, w=0.8, **given):
    return TAUGHT.with_parameters(given).robot(b, w)


def talk(states, rounds, hears):
    """So many rounds without new readings; `hears(k)` are those that robot k hears."""
    for _ in range(rounds):
        said = [RUN.broadcast(me) for me in states]
        for k, me in enumerate(states):
            for j in hears(k):
                RUN.receive(me, said[j])
        for me in states:
            RUN.fuse(me)


def everyone(robots):
    return lambda k: [j for j in range(robots) if j != k]


def test_a_first_round_by_hand():
    """Told 0.8: 50 of 98 black give x = (50/98 - 0.2)/0.6 and e = 1/(4 0.36 98); d is 0 yet."""
    me = robot()
    RUN.observe(me, 50.0, 98.0)
    RUN.fuse(me)
    x, e = (50 / 98 - 0.2) / 0.6, 0.25 / (0.36 * 98)
    assert (me.v, me.s, me.m) == pytest.approx((1 / e, x / e, (x * x - e) / e))
    assert (me.given_v, me.given_s, me.given_m) == (me.v, me.s, me.m)
    assert RUN.estimate(me) == pytest.approx((x / e + e / 2) / (1 / e + e))
    RUN.receive(me, (5.0, 10.0, 3.0))
    RUN.fuse(me)
    s, v, m = (0.999 / 2 * (own / e + expected) for own, expected in ((x, 5.0), (1.0, 10.0), (x * x - e, 3.0)))
    d = 0.02 * max(m / v - (s / v) ** 2, 0.0)
    assert me.spread == pytest.approx(d)
    assert me.v == pytest.approx(v + 1 / (e + d) - 0.999 / e)
    assert me.s == pytest.approx(s + x / (e + d) - 0.999 * x / e)


@pytest.mark.parametrize("graph", ["ring", "full"])
def test_self_taught_reaches_the_random_effects_mean(graph):
    """Brute force: f, d and the weights as they determine one another, of sensors of all kinds and any readings."""
    chance, robots = np.random.default_rng(4), 8
    b = chance.uniform(0.6, 0.95, robots)
    t = chance.integers(200, 900, robots).astype(float)
    n = np.floor(t * chance.uniform(0.4, 0.6, robots))
    states = [robot(a, a, memory=1e5, **ALL_FIT) for a in b]
    for me, black, looks in zip(states, n, t, strict=True):
        RUN.observe(me, black, looks)
    hears = everyone(robots) if graph == "full" else lambda k: ((k - 1) % robots, (k + 1) % robots)
    talk(states, 1500, hears)
    x, d = (n / t - 1 + b) / (2 * b - 1), 0.0
    e = 0.25 / ((2 * b - 1) ** 2 * t)
    for _ in range(2000):
        g = 1 / (e + d)
        f = (g * x).sum() / g.sum()
        d += 0.1 * (max((g * (x * x - e)).sum() / g.sum() - f * f, 0.0) - d)
    assert d > 0.005
    for me in states:
        assert me.s / me.v == pytest.approx(f, abs=2e-4)
        assert me.spread == pytest.approx(d, rel=0.02)


@pytest.mark.long(but=["0", "5", "8"])
@pytest.mark.parametrize("wrong", range(12))
def test_majority_keeps_its_evidence(wrong):
    """Eleven robots without noise, of which some read 0.7 where the others read 0.3; 5 against 6 is the limit."""
    states = [robot(1.0, 1.0) for _ in range(11)]
    for k, me in enumerate(states):
        RUN.observe(me, 7e3 if k < wrong else 3e3, 1e4)
    talk(states, 1500, everyone(11))
    out = np.array([me.out for me in states])
    f = {me.s / me.v for me in states}
    if min(wrong, 11 - wrong) in (1, 2, 3, 4):
        assert (out == [(k < wrong) == (wrong < 6) for k in range(11)]).all()
        assert max(abs(x - (0.3 if wrong < 6 else 0.7)) for x in f) < 1e-3
        assert all(me.given_v < 1e-3 * me.v for me in states if me.out)
    elif wrong in (0, 11):
        assert not out.any()


def swarm_of(wrong, expected, truth, fill, brain="self-taught", trials=10, topology="full", rounds=600):
    return sc.run(
        study_of(
            brain, robots=20, accuracy=truth, assumed_accuracy=truth, rounds=rounds, trials=trials, seed=8,
            members=[{"robots": wrong, "assumed_accuracy": expected}], topology=topology, fill_ratio=fill,
        )
    )  # fmt: skip


@pytest.mark.parametrize(("expected", "truth", "fill"), [(0.95, 0.75, 0.75), (0.95, 0.75, 0.95), (0.75, 0.95, 0.75)])
def test_six_of_twenty_that_are_wrong_do_no_harm(expected, truth, fill):
    """All robots of ten swarms are right within 0.05, and their median error is a third of commons' at the most."""
    error = abs(swarm_of(6, expected, truth, fill)["final_estimate"].values - fill)
    plain = abs(swarm_of(6, expected, truth, fill, "commons")["final_estimate"].values - fill)
    assert error.max() < 0.05
    assert np.median(error) < 0.01
    assert np.median(plain) > 3.0 * np.median(error)
